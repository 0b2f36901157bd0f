// The server's frames of the shown simulation after each step: figures, and the plant as columns.
import type { FrameOf, Simulation, Stream } from "espalier";
import { nextFrame } from "../view/frames.js";
import type { View } from "../view/scene.js";
import { directionToViewer } from "./document.js";
import type { Studio } from "./studio.js";

// of frames that are not shown
const PATIENCE_MILLISECONDS = 800;
// for which the page waits for its plant
const TOGETHER_MILLISECONDS = 100;

export class Frames {
  /** Ends when frames are shown again, true: the work that held them is done; null: they are shown. */
  held: Promise<boolean> | null = null;
  private seen: () => void = () => {};
  private next: Promise<void> | null = null; // ends with the next frame that is shown
  private statistics: Stream<"statistics"> | null = null;
  private columns: Stream<"columns"> | null = null;
  private made: () => void = () => {};
  /** The page has made its view, or knows that the browser cannot draw. */
  readonly isStaged = new Promise<void>((done) => (this.made = done));

  constructor(private readonly studio: Studio) {}

  /** The page is made: it has a view, or null where the browser cannot draw. The connection may be older. */
  stage(view: View | null): void {
    const { studio } = this;
    studio.view = view;
    view?.setPalette(studio.palette);
    view?.forgetFit(directionToViewer(studio.document));
    this.made();
    studio.changed();
  }

  /** Opens the streams of a simulation. */
  async open(simulation: Simulation): Promise<void> {
    // the view has single precision, too
    [this.statistics, this.columns] = await Promise.all([simulation.stream("statistics", { credits: undefined }), simulation.stream("columns", { credits: 1, precision: "single" })]);
  }

  /** Shows what comes from now on. */
  read(): void {
    void this.readStatistics(this.statistics!);
    void this.readColumns(this.columns!);
  }

  async close(): Promise<void> {
    await Promise.all([this.statistics?.close(), this.columns?.close()]);
    this.statistics = this.columns = null;
  }

  /** While it works, frames are not shown, but no longer than a person waits gladly. */
  async hold(work: () => Promise<void>): Promise<void> {
    let release: (isDone: boolean) => void = () => {};
    this.held = new Promise((done) => (release = done));
    const end = (isDone: boolean) => {
      this.held = null;
      release(isDone);
    };
    const patience = setTimeout(() => end(false), PATIENCE_MILLISECONDS);
    try {
      await work();
    } finally {
      clearTimeout(patience);
      end(true);
    }
  }

  /** While frames are held the page changes together with the plant: each picture of the page costs a browser as much as the plant. */
  async withPlant(): Promise<void> {
    if (this.held) {
      this.next ??= new Promise((done) => (this.seen = done));
      await Promise.race([this.next, new Promise((done) => setTimeout(done, TOGETHER_MILLISECONDS))]);
    }
  }

  private async readStatistics(stream: Stream<"statistics">): Promise<void> {
    for await (const frame of stream) {
      this.studio.stepped(frame);
    }
    this.ended(stream);
  }

  private async readColumns(stream: Stream<"columns">): Promise<void> {
    const { studio } = this;
    let isSkipped = false;
    for await (const frame of stream) {
      if (this.held) {
        // a state on the way to the wanted one is left out where another frame is sure to follow: the answer of the work tells a later
        // step. Where patience has ended, this may be the last frame, and the page does not know its step yet
        if ((await this.held) && frame.step < studio.answeredStep) {
          isSkipped = true;
          continue;
        }
      }
      if (!studio.view) {
        // this frame is shown, even if it is not the newest: no other may follow it
        await this.isStaged;
      }
      this.show(frame, isSkipped);
      isSkipped = false;
      // one picture, then the next frame; while a slider's plant is made no frame is asked for
      await nextFrame();
    }
    this.ended(stream);
  }

  /** `isLater`: frames before it were not shown. */
  private show({ geometry, change, step, finished }: FrameOf<"columns">, isLater: boolean): void {
    const { view } = this.studio;
    if (view) {
      view.update(geometry, isLater ? { ...change, isWhole: true } : change, step, finished);
      view.element.dataset.step = String(step);
    }
    this.next = null;
    this.seen();
  }

  private ended(stream: Stream<"statistics"> | Stream<"columns">): void {
    const { studio } = this;
    if (stream.reason && studio.connection === "connected" && stream.simulation === studio.simulation?.id) {
      studio.simulation = null;
      studio.say(`The simulation is gone: ${stream.reason.replace(/\.$/, "")}. ${studio.isOwn ? "" : "This page shows it again when it is there."}`.trim(), true);
      studio.view?.clear();
    }
  }
}
