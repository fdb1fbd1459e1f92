import type { Problem } from "../api/problem";
import { make } from "./dom";

export function loading(text: string): HTMLElement {
  return make("p", { className: "placeholder", role: "status" }, make("span", { className: "spinner" }), text);
}

export function empty(title: string, detail: string): HTMLElement {
  const heading = make("strong", { textContent: title });
  return make("div", { className: "placeholder placeholder--empty" }, heading, make("span", { textContent: detail }));
}

/** A problem in place of what could not be loaded, with a way to try again. */
export function failure(problem: Problem, onRetry: () => void): HTMLElement {
  const retry = make("button", { type: "button", className: "quiet-button", textContent: "Try again", onclick: onRetry });
  return make(
    "div",
    { className: "placeholder placeholder--error", role: "alert" },
    make("strong", { textContent: problem.title }),
    problem.detail ? make("span", { textContent: problem.detail }) : undefined,
    retry,
  );
}
