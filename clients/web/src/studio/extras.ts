// Streams that only some pages need: parameters for colours, queries, meshes with textures.
import type { Contents, FrameOf, Kind, Simulation } from "espalier";
import { nextFrame } from "../view/frames.js";
import { freeObject, readObject } from "../view/objects.js";
import { hasTextures } from "./document.js";
import { paletteFile } from "./palette.js";
import type { Studio } from "./studio.js";

type QueryTexts = Contents["queries"]["queries"];
type ReplyTexts = Contents["queries"]["replies"];

/** Places of the queries of a step, each with the first number of its answer. */
function answered(queries: QueryTexts, replies: ReplyTexts): Array<{ position: number[]; answer: number }> {
  const answers = new Map((replies ?? []).map(({ id, parameters }) => [id, parameters?.find((value) => typeof value === "number")]));
  return (queries ?? []).filter(({ position }) => position?.length === 3).map(({ id, position }) => ({ position: position!, answer: answers.get(id) ?? NaN }));
}

const MESH_MILLISECONDS = 20_000;

export class Extras {
  areQueriesShown = false;
  areMaterialsShown = false;
  private simulation: Simulation | null = null;
  private open = new Map<Kind, { close(): Promise<void> }>();
  private readonly wishes = new Map<Kind, boolean>();
  private turn: Promise<unknown> = Promise.resolve(); // streams are opened and closed one after the other

  constructor(private readonly studio: Studio) {}

  /** Another simulation is shown. */
  async follow(simulation: Simulation): Promise<void> {
    await this.inTurn(async () => {
      await Promise.all([...this.open.values()].map((stream) => stream.close()));
      this.open.clear();
      this.simulation = simulation;
    });
    const { view } = this.studio;
    view?.showObject(null);
    view?.showQueries(null);
    // a stream that the server refuses keeps nobody from the plant
    for (const want of [() => this.setTableWanted(view?.settings.mode.startsWith("parameter") ?? false), () => this.setQueriesShown(this.areQueriesShown), () => this.wantMesh()]) {
      await want().catch((error) => this.studio.fail(error));
    }
  }

  /** Whether the folder has materials, and no textures with which they are shown anyway. */
  get hasMaterials(): boolean {
    const { document } = this.studio;
    return (paletteFile(document)?.endsWith(".mat") ?? false) && !hasTextures(document);
  }

  /** Shows highlights, glow and transparency. Such pictures take longer. */
  async setMaterialsShown(isShown: boolean): Promise<void> {
    this.areMaterialsShown = isShown;
    await this.wantMesh();
    if (!this.open.has("glb")) {
      this.studio.view?.showObject(null);
    }
    this.studio.changed();
  }

  /** Columns have neither textures nor materials: the plant comes as a mesh too. */
  private wantMesh(): Promise<void> {
    const isWanted = hasTextures(this.studio.document) || (this.areMaterialsShown && this.hasMaterials);
    return this.want("glb", isWanted, (frame) => this.showMesh(frame));
  }

  /** Colours by parameter need the parameters of the modules. */
  setTableWanted(isWanted: boolean): Promise<void> {
    return this.want("turtle", isWanted, ({ turtle }) => this.studio.view?.setTable(turtle));
  }

  /** Shows where the last step asked, and the answers. */
  async setQueriesShown(isShown: boolean): Promise<void> {
    this.areQueriesShown = isShown;
    await this.want("queries", isShown, ({ queries, replies }) => {
      if (this.areQueriesShown) {
        this.studio.view?.showQueries(answered(queries, replies));
      }
    });
    if (!this.areQueriesShown) {
      this.studio.view?.showQueries(null);
    }
    this.studio.changed();
  }

  /** Waits, but not for ever, until the view shows the mesh of a step, where one is wanted. */
  async meshOf(step: number, isOver: () => boolean = () => false): Promise<void> {
    const until = performance.now() + MESH_MILLISECONDS;
    const { element } = this.studio.view!;
    while (this.open.has("glb") && element.dataset.textured !== String(step) && !isOver() && performance.now() < until) {
      await nextFrame();
    }
  }

  private inTurn(work: () => Promise<void>): Promise<void> {
    const mine = this.turn.then(work);
    this.turn = mine.catch(() => {});
    return mine;
  }

  /** Opens or closes a stream; the newest wish counts. */
  private want<K extends Kind>(kind: K, isWanted: boolean, show: (frame: FrameOf<K>) => void | Promise<void>): Promise<void> {
    this.wishes.set(kind, isWanted);
    return this.inTurn(async () => {
      const open = this.open.get(kind);
      if (this.wishes.get(kind) && !open && this.simulation) {
        const stream = await this.simulation.stream(kind, { credits: 1 });
        this.open.set(kind, stream);
        void (async () => {
          for await (const frame of stream) {
            await show(frame);
            this.studio.changed();
          }
        })()
          .catch((error) => this.studio.fail(error))
          .finally(() => this.open.get(kind) === stream && this.open.delete(kind));
      } else if (!this.wishes.get(kind) && open) {
        this.open.delete(kind);
        await open.close();
      }
    });
  }

  private async showMesh({ glb, step, simulation }: FrameOf<"glb">): Promise<void> {
    const object = await readObject(glb.slice().buffer);
    const { studio } = this;
    await Promise.all([studio.frames.held, studio.frames.isStaged]);
    // not a state on the way to the wanted one
    if (this.open.has("glb") && simulation === this.simulation?.id && (studio.isRunning || step === studio.step)) {
      studio.view?.showObject(object, step);
    } else {
      freeObject(object);
    }
  }
}
