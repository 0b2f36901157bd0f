// Models on the disk of the server (`espalier serve --models FOLDER`): opened, saved, and kept apart when two people
// change one.
import { Code, ServerError } from "espalier";
import { environmentFileOf, processesOf } from "./document.js";
import type { Document } from "./document.js";
import type { Studio } from "./studio.js";

/** Asks again for the names; null: the server keeps no models. */
export async function listSaved(studio: Studio): Promise<void> {
  studio.saved = (await studio.client.gallery()).saved ?? null;
  studio.changed();
}

export async function openSaved(studio: Studio, name: string): Promise<void> {
  const { main, files, binaryFiles, revision } = await studio.client.call("model.read", { saved: name });
  const document: Document = { title: name, main, files, binary: binaryFiles, environment: null, gallery: null, saved: { name, revision: revision!, files: Object.keys(files) } };
  await studio.openDocument({ ...document, environment: processesOf(files[environmentFileOf(document)] ?? "") });
}

/** A name that a folder of the server can have. */
export const nameFor = ({ saved, title }: Document): string => saved?.name ?? title.replace(/[/\\:*?"<>|]/g, "-").replace(/^[. ]+|[ ]+$/g, "");

/**
 * Writes the files of the page into the model `name` of the server. False: somebody has changed the model since this page
 * read it, or it is another one of this name; nothing is written then, unless `isOver`.
 */
export async function saveOnServer(studio: Studio, name: string, isOver = false): Promise<boolean> {
  const { files, binary, saved } = studio.document;
  const params = { name, files, binaryFiles: binary, remove: [] as string[] };
  const known = saved?.name === name ? { revision: saved.revision, remove: saved.files.filter((file) => !(file in files)) } : {};
  try {
    const { revision } = await studio.client.call("model.save", { ...params, ...known }).catch((error) => {
      const present = changedRevision(error);
      if (!isOver || !present) {
        throw error;
      }
      return studio.client.call("model.save", { ...params, ...known, revision: present });
    });
    // text that was written in the meantime is still to be saved
    const isSame = studio.document.files === files && studio.document.binary === binary;
    studio.shownTitle = studio.shownTitle === studio.document.title ? name : studio.shownTitle; // it is still the same plant
    studio.document = { ...studio.document, title: name, saved: { name, revision, files: Object.keys(files) } };
    studio.isChanged = !isSame;
    studio.say(`Saved on the server as “${name}”.`);
    studio.saved = [...new Set([...(studio.saved ?? []), name])].sort();
    return true;
  } catch (error) {
    if (changedRevision(error) === null) {
      throw error;
    }
    return false;
  }
}

/** The present revision that a refused save names; null: another trouble. */
function changedRevision(error: unknown): string | null {
  return error instanceof ServerError && error.code === Code.modelChanged ? String(error.data.revision) : null;
}
