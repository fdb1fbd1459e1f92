type Child = Node | string | undefined;
type Properties<Tag extends keyof HTMLElementTagNameMap> = Partial<
  Omit<HTMLElementTagNameMap[Tag], "style" | "dataset" | "children">
> & { aria?: Record<string, string>; data?: Record<string, string> };

/** Builds an element: properties, `aria-*` and `data-*` attributes, children. */
export function make<Tag extends keyof HTMLElementTagNameMap>(
  tag: Tag,
  properties: Properties<Tag> = {},
  ...children: Child[]
): HTMLElementTagNameMap[Tag] {
  const { aria, data, ...rest } = properties;
  const element = document.createElement(tag);
  Object.assign(element, rest);
  for (const [name, value] of Object.entries(aria ?? {})) element.setAttribute(`aria-${name}`, value);
  for (const [name, value] of Object.entries(data ?? {})) element.dataset[name] = value;
  element.append(...children.filter((child) => child !== undefined));
  return element;
}

const ICONS = {
  play: "M8 5.5v13l10.5-6.5z",
  pause: "M7.5 5.5h3v13h-3zM13.5 5.5h3v13h-3z",
  close: "M6.4 5 12 10.6 17.6 5 19 6.4 13.4 12l5.6 5.6-1.4 1.4L12 13.4 6.4 19 5 17.6 10.6 12 5 6.4z",
  upload: "M11 16V7.8L7.9 10.9 6.5 9.5 12 4l5.5 5.5-1.4 1.4L13 7.8V16zM5 18h14v2H5z",
  trash: "M9 4h6l1 2h4v2H4V6h4zM6 9h12l-1 11H7zm4 2v7h1.5v-7zm3.5 0v7H14v-7z",
} as const;

export function icon(name: keyof typeof ICONS): SVGSVGElement {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  svg.classList.add("icon");
  path.setAttribute("d", ICONS[name]);
  svg.append(path);
  return svg;
}

/** A row of choices of which one is pressed. */
export function choiceButtons<Value extends string>(
  label: string,
  choices: readonly { value: Value; label: string }[],
  initial: Value,
  onChoose: (value: Value) => void,
): { element: HTMLElement; select: (value: Value) => void } {
  const buttons = choices.map((choice) => {
    const button = make("button", { type: "button", textContent: choice.label, data: { value: choice.value } });
    button.addEventListener("click", () => {
      select(choice.value);
      onChoose(choice.value);
    });
    return button;
  });
  const select = (value: Value): void => {
    for (const button of buttons) button.setAttribute("aria-pressed", String(button.dataset.value === value));
  };
  select(initial);
  const element = make("div", { className: "segmented", role: "group", aria: { label } }, ...buttons);
  return { element, select };
}

export function count(number: number, noun: string): string {
  return `${number.toLocaleString("en")} ${noun}${number === 1 ? "" : "s"}`;
}
