// Changes of colours and materials, so that they can be taken back: the editor knows only those of texts.

type Files = Record<string, string>;

interface Recolour {
  file: string;
  before: string;
  after: string;
  texts: Files; // as they were then
  time: number; // of its last part
}

const TOGETHER_MILLISECONDS = 800; // between parts of one change, as of a drag

const isEqual = (a: Files, b: Files): boolean => a === b || (Object.keys(a).length === Object.keys(b).length && Object.keys(a).every((name) => a[name] === b[name]));

export class Recolours {
  private done: Recolour[] = [];
  private undone: Recolour[] = [];

  /** Another model is opened. */
  clear(): void {
    this.done = [];
    this.undone = [];
  }

  /** A file has changed beside `texts`. */
  add(file: string, before: string, after: string, texts: Files): void {
    const last = this.done.at(-1);
    const time = performance.now();
    if (last?.file === file && last.after === before && isEqual(last.texts, texts) && time - last.time < TOGETHER_MILLISECONDS) {
      Object.assign(last, { after, time });
    } else {
      this.done.push({ file, before, after, texts, time });
    }
    this.undone = [];
  }

  /** The file that takes the last change back, or makes it again; nothing while the texts are others: a text was changed since. */
  take(isRedo: boolean, texts: Files): { file: string; bytes: string } | null {
    const [from, to] = isRedo ? [this.undone, this.done] : [this.done, this.undone];
    const change = from.at(-1);
    if (!change || !isEqual(change.texts, texts)) {
      return null;
    }
    from.pop();
    to.push(change);
    return { file: change.file, bytes: isRedo ? change.after : change.before };
  }
}
