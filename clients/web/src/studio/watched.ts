// A simulation that another page or program made, as a document that follows it.
import type { Information, Simulation } from "espalier";
import { besides, definesOf, directionToViewer, fileOf, withForest } from "./document.js";
import type { Document } from "./document.js";
import type { Shared } from "./share.js";
import type { Studio } from "./studio.js";

// between two looks at a simulation that begins anew again and again, as with a slider
const LOOK_MILLISECONDS = 300;

const LENGTH = /^([ \t]*derivation length:[ \t]*)[^\r\n/]*?(?=[ \t]*(?:\/[*/].*)?\r?$)/m;

/** The text with the values that count: those of `parameters` instead of its own. */
export function withValues(file: string, text: string, parameters: Record<string, string>): string {
  const changed = definesOf(file, text).filter(({ name }) => name in parameters);
  return changed.reverse().reduce((all, { name, from, to }) => all.slice(0, from) + parameters[name] + all.slice(to), text);
}

async function documentOf(simulation: Simulation): Promise<{ document: Document; information: Information; derivationLength?: number }> {
  const { model } = await simulation.get("model");
  const { main, files, parameters, derivationLength, forest } = model!;
  const short = (name: string) => name.split("/").pop()!;
  const { environment } = await simulation.get("environment");
  const information = (await simulation.get("information")).information!;
  const texts = Object.fromEntries(Object.entries(files).map(([name, text]) => [short(name), withValues(name, text, parameters)]));
  const processes = environment!.length > 0 ? environment! : null;
  const document: Document = { title: information.name, main: short(main), files: texts, binary: {}, environment: processes, gallery: null };
  return { document: forest ? withForest(document, forest) : document, information, derivationLength: forest ? undefined : derivationLength };
}

export class Watched {
  id = "";
  private isReading = false;
  private isNewer = false;

  constructor(private readonly studio: Studio) {}

  /** An error when this page may only watch. */
  requireController(): void {
    if (this.studio.isReadOnly) {
      throw new Error("This page only watches: choose a plant under Server. To grow one of your own, open the page without #watch, or with a token of the role controller.");
    }
  }

  isAmong(simulations: Information[]): boolean {
    return this.id !== "" && simulations.some(({ simulation }) => simulation === this.id);
  }

  /** Takes over what the simulation says about itself. */
  async read(simulation: Simulation): Promise<Information> {
    const { studio } = this;
    this.id = simulation.id;
    const { document, information } = await documentOf(simulation);
    const isAnother = studio.document.title !== document.title;
    studio.seed = information.seed;
    studio.document = document;
    studio.isChanged = false;
    studio.diagnostics = [];
    studio.openFile = !isAnother && studio.openFile in document.files ? studio.openFile : fileOf(document.main);
    return information;
  }

  /** A plant of one's own in the same state: with the colours and the length that its texts did not say. */
  async copy(): Promise<Shared> {
    const { studio } = this;
    const simulation = studio.simulation!;
    const { document, information, derivationLength } = await documentOf(simulation);
    const { colours, isOfModel } = await simulation.get("palette");
    const binary = isOfModel ? { [besides(document, ".map")]: btoa(String.fromCharCode(...colours!.flat())) } : {};
    const main = fileOf(document.main);
    const text = document.files[main];
    const files = { ...document.files, [main]: derivationLength === undefined ? text : text.replace(LENGTH, `$1${derivationLength}`) };
    return { document: { ...document, files, binary }, seed: information.seed, step: information.step };
  }

  /** It began anew: one look at a time, and one after the last change. */
  async refresh(): Promise<void> {
    const { studio } = this;
    this.isNewer = true;
    if (this.isReading) {
      return;
    }
    this.isReading = true;
    try {
      while (this.isNewer && !studio.isOwn && studio.simulation) {
        this.isNewer = false;
        const { simulation, document } = studio;
        const { derivationLength } = await this.read(simulation);
        if (simulation !== studio.simulation) {
          return;
        }
        studio.length = Math.max(derivationLength, studio.step);
        await studio.takePalette(simulation);
        studio.fields.forget();
        await studio.fields.refresh();
        if (studio.document.title !== document.title) {
          studio.view?.forgetFit(directionToViewer(studio.document));
        }
        studio.changed();
        await new Promise((done) => setTimeout(done, LOOK_MILLISECONDS));
      }
    } finally {
      this.isReading = false;
    }
  }
}
