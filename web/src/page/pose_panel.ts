import type { ToileApi } from "../api/client";
import { Problem } from "../api/problem";
import type { MotionPreset, PosePreset } from "../api/types";
import { icon, make } from "./dom";
import { failure, loading } from "./placeholders";

export type PoseChoice = { kind: "pose"; id: string } | { kind: "motion"; id: string };

/** Pose presets by group, and motions. */
export class PosePanel {
  readonly element = make("div", { className: "stack" });
  private readonly buttons: { button: HTMLButtonElement; choice: PoseChoice }[] = [];

  constructor(
    private readonly api: ToileApi,
    private readonly onChoose: (choice: PoseChoice) => void,
  ) {
    void this.load();
  }

  select(choice: PoseChoice): void {
    for (const { button, choice: own } of this.buttons) {
      button.setAttribute("aria-pressed", String(own.kind === choice.kind && own.id === choice.id));
    }
  }

  private async load(): Promise<void> {
    this.element.replaceChildren(loading("Loading poses…"));
    try {
      const [poses, motions] = await Promise.all([this.api.poses(), this.api.motions()]);
      this.show(poses, motions);
    } catch (error) {
      this.element.replaceChildren(failure(Problem.from(error), () => void this.load()));
    }
  }

  private show(poses: PosePreset[], motions: MotionPreset[]): void {
    const groups = new Map<string, PosePreset[]>();
    for (const pose of poses) groups.set(pose.group, [...(groups.get(pose.group) ?? []), pose]);
    const sections = [...groups].map(([name, members]) =>
      group(groupTitle(name), members.map((pose) => this.chip({ kind: "pose", id: pose.id }, pose.label))),
    );
    const moving = motions.map((motion) => this.chip({ kind: "motion", id: motion.id }, motion.label));
    if (moving.length > 0) sections.unshift(group("In motion", moving));
    this.element.replaceChildren(...sections);
    this.select({ kind: "pose", id: "a-pose" });
  }

  private chip(choice: PoseChoice, label: string): HTMLButtonElement {
    const button = make(
      "button",
      { type: "button", className: "chip", data: { [choice.kind]: choice.id } },
      choice.kind === "motion" ? icon("play") : undefined,
      label,
    );
    button.addEventListener("click", () => {
      this.select(choice);
      this.onChoose(choice);
    });
    this.buttons.push({ button, choice });
    return button;
  }
}

function group(title: string, chips: HTMLElement[]): HTMLElement {
  const heading = make("h3", { className: "eyebrow", textContent: title });
  return make("section", {}, heading, make("div", { className: "chips" }, ...chips));
}

function groupTitle(name: string): string {
  return name === "walk" ? "Walk, step by step" : name.charAt(0).toUpperCase() + name.slice(1);
}
