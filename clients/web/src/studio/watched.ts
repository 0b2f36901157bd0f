// A simulation that another program made, as a document.
import type { Information, Simulation } from "espalier";
import type { Document } from "./document.js";

export async function readWatched(simulation: Simulation): Promise<{ document: Document; information: Information }> {
  const { model } = await simulation.get("model");
  const { main, files } = model as { main: string; files: Record<string, string> };
  const short = (name: string) => name.split("/").pop()!;
  const { environment } = await simulation.get("environment");
  const information = (await simulation.get("information")).information!;
  const texts = Object.fromEntries(Object.entries(files).map(([name, text]) => [short(name), text]));
  const processes = environment!.length > 0 ? environment! : null;
  return { document: { title: information.name, main: short(main), files: texts, binary: {}, environment: processes, gallery: null }, information };
}
