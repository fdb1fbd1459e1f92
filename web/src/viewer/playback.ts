import { type AnimationAction, AnimationMixer, LoopRepeat } from "three";
import type { Figure } from "./figure";

export interface PlaybackState {
  playing: boolean;
  /** Seconds. */
  time: number;
  duration: number;
}

/** Plays the animation of a draped sequence: play, pause, scrub. */
export class Playback {
  private readonly mixer: AnimationMixer;
  private readonly actions: AnimationAction[];
  private readonly duration: number;
  private last: number | undefined;
  playing = true;

  constructor(
    figure: Figure,
    private readonly onChange: (state: PlaybackState) => void,
  ) {
    this.mixer = new AnimationMixer(figure.group);
    this.actions = figure.animations.map((clip) => this.mixer.clipAction(clip).setLoop(LoopRepeat, Infinity).play());
    this.duration = Math.max(...figure.animations.map((clip) => clip.duration), 0.001);
    this.mixer.setTime(0);
  }

  get state(): PlaybackState {
    return { playing: this.playing, time: this.mixer.time % this.duration, duration: this.duration };
  }

  /** Moves on to the time of a frame, in seconds; true while playing. */
  advance(now: number): boolean {
    const step = this.last === undefined ? 0 : Math.min(now - this.last, 0.1);
    this.last = this.playing ? now : undefined;
    if (!this.playing) return false;
    this.mixer.update(step);
    this.onChange(this.state);
    return true;
  }

  toggle(playing = !this.playing): void {
    this.playing = playing;
    this.last = undefined;
    this.onChange(this.state);
  }

  /** `share` is 0 at the first frame and 1 at the last. */
  seek(share: number): void {
    this.mixer.setTime(Math.min(Math.max(share, 0), 0.9999) * this.duration);
    this.onChange(this.state);
  }

  dispose(): void {
    for (const action of this.actions) action.stop();
    this.mixer.uncacheRoot(this.mixer.getRoot());
  }
}
