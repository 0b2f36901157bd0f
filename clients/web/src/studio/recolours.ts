// Changes of colours and materials, so that they can be taken back: the editor knows only those of texts.

interface Recolour {
  file: string;
  before: string;
  after: string;
  time: number; // of its last part
}

const TOGETHER_MILLISECONDS = 800; // between parts of one change, as of a drag

export class Recolours {
  /** No text was changed since the last of them was made or taken back. */
  isLast = false;
  private done: Recolour[] = [];
  private undone: Recolour[] = [];

  /** Another model is opened. */
  clear(): void {
    Object.assign(this, { isLast: false, done: [], undone: [] });
  }

  /** A file has changed. */
  add(file: string, before: string, after: string): void {
    const last = this.done.at(-1);
    const time = performance.now();
    if (this.isLast && last?.file === file && last.after === before && time - last.time < TOGETHER_MILLISECONDS) {
      Object.assign(last, { after, time });
    } else {
      this.done.push({ file, before, after, time });
    }
    this.undone = [];
    this.isLast = true;
  }

  /** The file that takes the last change back, or makes it again; nothing when a text was changed last. */
  take(isRedo: boolean): { file: string; bytes: string } | null {
    const [from, to] = isRedo ? [this.undone, this.done] : [this.done, this.undone];
    const change = this.isLast ? from.pop() : undefined;
    if (!change) {
      return null;
    }
    to.push(change);
    return { file: change.file, bytes: isRedo ? change.after : change.before };
  }
}
