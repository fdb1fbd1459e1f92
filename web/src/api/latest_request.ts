import { isAbort } from "./problem";

export type Work = (signal: AbortSignal) => Promise<void>;

/**
 * Runs one piece of work at a time; of those that arrive meanwhile only the newest is kept.
 *
 * Work in flight is left to finish while it is young. Aborting it on every movement of a slider would mean that
 * nothing is shown until the finger rests; letting it finish shows every answer that the service can give in time.
 */
export class LatestRequest {
  private running: { controller: AbortController; since: number } | undefined;
  private waiting: Work | undefined;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly onError: (error: unknown) => void,
    private readonly debounce = 0,
    private readonly patience = 600,
  ) {}

  get busy(): boolean {
    return this.running !== undefined || this.waiting !== undefined;
  }

  /** Runs `work` after the debounce. `replace` aborts what is in flight: its answer would be of no use. */
  submit(work: Work, replace = false): void {
    this.waiting = work;
    const old = this.running !== undefined && performance.now() - this.running.since > this.patience;
    if (replace || old) this.abortRunning();
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.next(), this.debounce);
  }

  cancel(): void {
    clearTimeout(this.timer);
    this.waiting = undefined;
    this.abortRunning();
  }

  private abortRunning(): void {
    this.running?.controller.abort();
    this.running = undefined;
  }

  private next(): void {
    const work = this.waiting;
    if (this.running || !work) return;
    this.waiting = undefined;
    const run = { controller: new AbortController(), since: performance.now() };
    this.running = run;
    void this.settle(work, run);
  }

  private async settle(work: Work, run: { controller: AbortController; since: number }): Promise<void> {
    try {
      await work(run.controller.signal);
    } catch (error) {
      if (!run.controller.signal.aborted && !isAbort(error)) this.onError(error);
    }
    if (this.running === run) this.running = undefined;
    this.next();
  }
}
