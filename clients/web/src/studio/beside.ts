// A second plant beside the first: a fork of it, from the step in which it was made. The first one goes its own way from there.
import type { Simulation, Statistics, Stream } from "espalier";
import type { ModelPalette } from "../view/colours.js";
import { nextFrame } from "../view/frames.js";
import type { View } from "../view/scene.js";
import type { Document } from "./document.js";
import { History } from "./history.js";
import { createPlant, keptOf, restored } from "./plants.js";
import type { Kept } from "./plants.js";
import type { Studio } from "./studio.js";

/** A plant with its past. */
export interface Growth {
  simulation: Simulation;
  document: Document;
  isChanged: boolean;
  seed: number;
  step: number;
  length: number;
  isFinished: boolean;
  statistics: Statistics[];
  history: History;
  palette: ModelPalette | null;
}

export class Beside {
  growth: Growth | null = null;
  /** The step in which the two parted. */
  forkStep = 0;
  /** Whether it makes the steps that the first plant makes. */
  isTogether = true;
  modules = 0;

  private view: View | null = null;
  private stream: Stream<"columns"> | null = null;

  constructor(private readonly studio: Studio) {}

  /** Forks the plant as it is now. */
  async fork(): Promise<void> {
    const { studio } = this;
    await this.close();
    await studio.inTurn(async () => {
      const first = studio.growth();
      const simulation = await first.simulation.fork(`${first.document.title}, fork of step ${first.step}`);
      this.forkStep = first.step;
      this.put({ ...first, simulation, history: first.history.copy() });
    });
    await this.watch();
  }

  /** The view that shows it, when the page has made one. */
  async attach(view: View | null): Promise<void> {
    this.view?.pairWith(null);
    this.view = view;
    if (view && this.studio.view) {
      view.setPalette(this.growth?.palette ?? null);
      this.studio.view.pairWith(view);
    }
    await this.watch();
  }

  private put(growth: Growth): void {
    this.growth = growth;
    this.modules = growth.statistics.at(-1)?.modules ?? 0;
    this.studio.changed();
  }

  private async watch(): Promise<void> {
    await this.stream?.close();
    this.stream = null;
    const { view, growth } = this;
    if (!view || !growth) {
      return;
    }
    const stream = await growth.simulation.stream("columns", { credits: 1, precision: "single" });
    this.stream = stream;
    void (async () => {
      for await (const { geometry, change, step, finished } of stream) {
        if (this.view !== view) {
          return;
        }
        view.update(geometry, change, step, finished);
        view.element.dataset.step = String(step);
        await nextFrame();
      }
      if (stream.reason && this.growth === growth) {
        this.studio.say(`The plant beside is gone: ${stream.reason}.`, true);
        this.growth = null;
        this.studio.changed();
      }
    })().catch((error) => this.studio.fail(error));
  }

  /** Goes to the step of the first plant, inside the first plant's turn. */
  async follow(step: number): Promise<void> {
    const { growth } = this;
    if (!growth || !this.isTogether || step === growth.step) {
      return;
    }
    const { simulation, history } = growth;
    let result: { step: number; finished: boolean; statistics?: Statistics } | null = null;
    if (step < growth.step) {
      const state = history.before(step);
      result = state ? await simulation.restore(state.snapshot) : await simulation.reset(growth.seed);
    }
    if ((result?.step ?? growth.step) < step) {
      result = await simulation.stepUntil(step);
    }
    Object.assign(growth, { step: result!.step, isFinished: result!.finished });
    if (!history.has(growth.step)) {
      history.add(growth.step, await simulation.save());
    }
    this.modules = (await simulation.get("statistics")).statistics!.modules;
    this.studio.changed();
  }

  /**
   * The plant beside becomes the first one, and the first one stands beside. The two simulations exchange their states: pages that watch
   * the first one follow.
   */
  async swap(): Promise<void> {
    const { studio } = this;
    await studio.inTurn(async () => {
      const [first, second] = [studio.growth(), this.growth];
      if (second) {
        const [left, right] = await Promise.all([first, second].map(({ simulation, document }) => keptOf(simulation, document)));
        await studio.take({ ...second, simulation: await this.become(first.simulation.id, second, right) });
        this.view?.setPalette(first.palette);
        this.put({ ...first, simulation: await this.become(second.simulation.id, first, left) });
      }
    });
    await this.watch();
  }

  /** Makes the plant of `growth` in the place of a simulation. */
  private async become(id: string, growth: Growth, kept: Kept): Promise<Simulation> {
    const simulation = await createPlant(this.studio.client, kept.document, growth.seed, id, kept.parameters);
    if (!(await restored(simulation, kept))) {
      growth.history.clear();
      await simulation.stepUntil(growth.step);
      this.studio.say("A plant could not take its state along: it is grown again from its seed, without what was cut or bent by hand.", true);
    }
    return simulation;
  }

  /** Deletes it. */
  async close(): Promise<void> {
    const { growth, stream } = this;
    this.growth = null;
    this.stream = null;
    this.studio.changed();
    await stream?.close();
    await growth?.simulation.delete().catch(() => {});
  }
}
