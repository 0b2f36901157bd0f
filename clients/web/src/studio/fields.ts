// The environment's quantities in space: the names of its fields, and the values of the one that is shown.
import { readVti } from "../view/fields.js";
import type { FieldLook } from "../view/fields.js";
import type { Simulation } from "espalier";
import type { Studio } from "./studio.js";

interface Entry {
  name: string;
  unit: string;
  cells: [number, number, number];
}

export class Fields {
  entries: Entry[] = [];
  shown = ""; // name; empty: none
  look: FieldLook = { axis: 0, place: 0.5, level: null };

  private simulation: Simulation | null = null; // whose entries these are: another model may come under the same identifier
  private isReading = false;
  private isNewer = false;

  constructor(private readonly studio: Studio) {}

  private get entry(): Entry | undefined {
    return this.entries.find(({ name }) => name === this.shown);
  }

  /** A field of one layer has no surfaces. */
  get hasDepth(): boolean {
    return Math.min(...(this.entry?.cells ?? [1])) > 1;
  }

  /** The plant has another state, or is another one. One request at a time, for the newest state. */
  async refresh(): Promise<void> {
    this.isNewer = true;
    if (this.isReading) {
      return;
    }
    this.isReading = true;
    try {
      while (this.isNewer) {
        this.isNewer = false;
        await this.read();
      }
    } finally {
      this.isReading = false;
    }
  }

  /** The simulation may have another model by now. */
  forget(): void {
    this.simulation = null;
  }

  private async read(): Promise<void> {
    const { studio } = this;
    const { simulation } = studio;
    const id = simulation?.id ?? "";
    const hasEnvironment = studio.statistics.some(({ queries }) => queries > 0) || (studio.document.environment?.length ?? 0) > 0;
    if (!id || !hasEnvironment) {
      this.entries = [];
    } else if (this.simulation !== simulation) {
      const list = await studio.fetchFile(`/simulations/${id}/fields`);
      this.entries = (JSON.parse(await list.text()) as { fields: Entry[] }).fields;
      this.simulation = simulation;
    }
    const { entry } = this;
    if (!entry) {
      studio.view?.showField(null, this.look);
    } else {
      const file = await studio.fetchFile(`/simulations/${id}/fields/${encodeURIComponent(entry.name)}.vti`);
      const field = readVti(entry.name, entry.unit, await file.text());
      if (studio.simulation === simulation && this.shown === entry.name) {
        studio.view?.showField(field, this.look);
      }
    }
    studio.changed();
  }

  choose(name: string): Promise<void> {
    this.shown = name;
    // across the side with the fewest cells: the slice has most of the field
    const cells = this.entry?.cells ?? [1, 1, 1];
    const axis = cells.indexOf(Math.min(...cells)) as 0 | 1 | 2;
    this.look = { ...this.look, axis, level: this.hasDepth ? this.look.level : null };
    return this.refresh();
  }

  change(look: Partial<FieldLook>): void {
    this.look = { ...this.look, ...look };
    this.studio.view?.lookAtField(this.look);
    this.studio.changed();
  }
}
