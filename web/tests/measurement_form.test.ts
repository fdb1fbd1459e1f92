import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { ToileApi } from "../src/api/client";
import type { Body, BodyParameters } from "../src/api/types";
import { MeasurementForm } from "../src/page/measurement_form";

const parameters: BodyParameters = {
  phenotypes: [{ name: "gender", label: "Gender", min: 0, max: 1, default: 0.5, low: "male", high: "female" }],
  measurements: [
    { name: "height", label: "Height", unit: "cm", min: 140, max: 205, default: 171.2, description: "" },
    { name: "waist", label: "Waist", unit: "cm", min: 55, max: 140, default: 79, description: "" },
  ],
};

const solved = {
  phenotypes: {},
  local_changes: {},
  measurements: {
    height: { requested: 168, achieved: 167.6, residual: -0.4 },
    waist: { requested: null, achieved: 77.5, residual: null },
  },
  shape: { kind: "phenotypes", values: { height: 0.4 } },
};

describe("MeasurementForm", () => {
  const shapes: (Body | null)[] = [];
  let form: MeasurementForm;
  const input = (name: string): HTMLInputElement => {
    const found = form.element.querySelector<HTMLInputElement>(`#measure-${name}`);
    if (!found) throw new Error(`no field ${name}`);
    return found;
  };
  const type = async (name: string, text: string): Promise<void> => {
    input(name).value = text;
    input(name).dispatchEvent(new Event("change"));
    await vi.advanceTimersByTimeAsync(100);
  };

  beforeEach(() => {
    vi.useFakeTimers();
    shapes.length = 0;
    form = new MeasurementForm(new ToileApi(), parameters, (shape) => shapes.push(shape));
    document.body.replaceChildren(form.element);
  });
  afterEach(() => {
    vi.unstubAllGlobals();
    vi.useRealTimers();
  });

  it("sends only what was given, and shows what the body achieves", async () => {
    const fetch = vi.fn().mockImplementation(async () => new Response(JSON.stringify(solved)));
    vi.stubGlobal("fetch", fetch);
    await type("height", "168");
    expect(JSON.parse((fetch.mock.calls[0]?.[1] as { body: string }).body)).toEqual({ measurements: { height: 168 } });
    expect(shapes).toEqual([solved.shape]);
    expect(form.element.querySelector("#measure-height-note")?.textContent).toBe("Closest body: 167.6 cm (−0.4)");
    expect(input("waist").placeholder).toBe("77.5");
    expect(input("waist").value).toBe("");
  });

  it("puts an error next to the field that it points to, and takes it away when the field changes", async () => {
    const document_ = { title: "Wrong unit", detail: "Did you mean 168 cm?", pointer: "/measurements/height" };
    vi.stubGlobal("fetch", vi.fn().mockResolvedValueOnce(new Response(JSON.stringify(document_), { status: 422 })));
    await type("height", "1.68");
    const error = form.element.querySelector<HTMLElement>("#measure-height-error");
    expect(error?.textContent).toBe("Did you mean 168 cm?");
    expect(input("height").getAttribute("aria-invalid")).toBe("true");
    expect(shapes).toEqual([]);
    vi.stubGlobal("fetch", vi.fn().mockResolvedValueOnce(new Response(JSON.stringify(solved))));
    await type("height", "168");
    expect(error?.hidden).toBe(true);
  });

  it("shows an error about the whole form above the fields", async () => {
    const document_ = { title: "Unreachable", detail: "No body has both.", pointer: "/measurements" };
    vi.stubGlobal("fetch", vi.fn().mockResolvedValueOnce(new Response(JSON.stringify(document_), { status: 422 })));
    await type("waist", "56");
    expect(form.element.querySelector(".form-error")?.textContent).toBe("Unreachable: No body has both.");
  });

  it("refuses what is not a number without asking the service", async () => {
    const fetch = vi.fn();
    vi.stubGlobal("fetch", fetch);
    await type("height", "tall");
    expect(fetch).not.toHaveBeenCalled();
    expect(form.element.querySelector("#measure-height-error")?.textContent).toBe("Enter a number.");
  });

  it("goes back to the reference body when everything is cleared", async () => {
    vi.stubGlobal("fetch", vi.fn().mockResolvedValueOnce(new Response(JSON.stringify(solved))));
    await type("height", "168");
    await type("height", "");
    expect(shapes).toEqual([solved.shape, null]);
  });
});
