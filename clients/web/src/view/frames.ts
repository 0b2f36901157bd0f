// Pictures of the browser. A hidden page gets none, and a busy browser few: nothing waits for one longer than a moment.

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
