// Pictures of the browser. A hidden page gets none, and a busy browser few: nothing waits for one longer than a moment.
// A browser without a graphics card may need seconds for a large plant.

const PATIENCE_MILLISECONDS = 250;

/** Calls `work` with the next picture, or a moment later when there is none. */
export function onNextFrame(work: () => void): void {
  const frame = requestAnimationFrame(() => {
    clearTimeout(timer);
    work();
  });
  const timer = setTimeout(() => {
    cancelAnimationFrame(frame);
    work();
  }, PATIENCE_MILLISECONDS);
}

export const nextFrame = (): Promise<void> => new Promise(onNextFrame);

const SLOW_MILLISECONDS = 60;
const SLOW_PICTURES = 2; // in a row
const LOOK_MILLISECONDS = 8;
const LOST_MILLISECONDS = 10_000;

/** Knows whether the graphics card still draws, and when its pictures take long. */
export class GpuClock {
  private sync: WebGLSync | null = null;
  private slow = -Infinity; // slow pictures in a row

  constructor(
    private readonly context: WebGL2RenderingContext,
    private readonly onSlow: () => void,
    private readonly onReady: (milliseconds: number) => void,
  ) {}

  /** Whether the last picture is not ready yet. */
  get isBusy(): boolean {
    return this.sync !== null;
  }

  /** Pictures from now on make no programs: they say how fast the card is. */
  start(): void {
    this.slow = 0;
  }

  /** The commands of a picture have been given. */
  begin(): void {
    this.forget();
    this.sync = this.context.fenceSync(this.context.SYNC_GPU_COMMANDS_COMPLETE, 0);
    this.context.flush();
    if (this.sync) {
      this.look(this.sync, performance.now());
    }
  }

  /** `known`: for how long it was surely not ready. A busy page looks late, and late looks say nothing about the card. */
  private look(sync: WebGLSync, begun: number, known = 0): void {
    setTimeout(() => {
      const { context } = this;
      const time = performance.now() - begun;
      if (sync !== this.sync) {
        return; // there is a newer picture
      }
      if (!context.isContextLost() && context.getSyncParameter(sync, context.SYNC_STATUS) !== context.SIGNALED && time < LOST_MILLISECONDS) {
        this.look(sync, begun, time);
        return;
      }
      this.forget();
      // the timers of a hidden page are slow
      this.slow = known > SLOW_MILLISECONDS && !document.hidden ? this.slow + 1 : Math.min(this.slow, 0);
      if (this.slow === SLOW_PICTURES) {
        this.onSlow();
      }
      this.onReady(known);
    }, LOOK_MILLISECONDS);
  }

  private forget(): void {
    if (this.sync) {
      this.context.deleteSync(this.sync);
      this.sync = null;
    }
  }
}
