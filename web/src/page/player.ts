import type { PlaybackState } from "../viewer/playback";
import { icon, make } from "./dom";

export interface PlayerActions {
  toggle: () => void;
  seek: (share: number) => void;
  close: () => void;
}

/** Play, pause and scrub a motion. */
export class Player {
  readonly element: HTMLElement;
  private readonly toggle: HTMLButtonElement;
  private readonly scrub: HTMLInputElement;
  private readonly clock = make("span", { className: "player__clock" });
  private playing: boolean | undefined;

  constructor(actions: PlayerActions) {
    this.toggle = make("button", { type: "button", className: "icon-button", onclick: actions.toggle });
    this.scrub = make("input", { type: "range", min: "0", max: "1", step: "0.001", aria: { label: "Position in the motion" } });
    this.scrub.addEventListener("input", () => actions.seek(this.scrub.valueAsNumber));
    const close = make(
      "button",
      { type: "button", className: "icon-button", title: "Back to a still pose", aria: { label: "Back to a still pose" }, onclick: actions.close },
      icon("close"),
    );
    this.element = make("div", { className: "player", role: "group", hidden: true, aria: { label: "Motion" } }, this.toggle, this.scrub, this.clock, close);
  }

  show(state: PlaybackState | undefined): void {
    this.element.hidden = !state;
    if (!state) return;
    this.scrub.value = String(state.time / state.duration);
    this.clock.textContent = `${state.time.toFixed(1)} / ${state.duration.toFixed(1)} s`;
    if (this.playing === state.playing) return;
    this.playing = state.playing;
    this.toggle.replaceChildren(icon(state.playing ? "pause" : "play"));
    this.toggle.setAttribute("aria-label", state.playing ? "Pause" : "Play");
  }
}
