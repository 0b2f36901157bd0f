// Windows above the page: gallery, share, export, keyboard.
import { useEffect, useRef, useState } from "preact/hooks";
import type { ComponentChildren } from "preact";
import type { Studio } from "../studio/studio.js";
import { download, linkTo } from "../studio/share.js";
import { filmGrowth, filmTurn } from "../studio/film.js";
import { MOST_PLANTS, standOf } from "../studio/stand.js";
import { archiveOf } from "../studio/archive.js";
import { bytesOf } from "../studio/palette.js";
import { newDocument, orderedFiles, publishedFileOf } from "../studio/document.js";
import { listSaved, nameFor, openSaved, saveOnServer } from "../studio/saved.js";
import { IconButton } from "./icons.js";

export function Dialog(props: { title: string; onClose: () => void; class?: string; children: ComponentChildren }) {
  const place = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    place.current?.showModal();
  }, []);
  return (
    <dialog ref={place} class={props.class} onClose={props.onClose} aria-label={props.title}
      onClick={(event) => event.target === place.current && place.current?.close()}>
      <header>
        <h2>{props.title}</h2>
        <IconButton icon="close" label="Close" onClick={() => place.current?.close()} />
      </header>
      {props.children}
    </dialog>
  );
}

const NAMES: Record<string, string> = {
  classic: "Classics",
  "chapter-graphical-models": "Graphical modeling chapter",
  "chapter-open-l-systems": "Open L-systems chapter",
  "chapter-lsystem-viewer": "Viewer chapter",
  "chapter-fractint": "Fractint",
  "chapter-turtle-painter": "Turtle painter",
  "chapter-forest": "Forest chapter",
};

function groupOf(name: string): string {
  const folder = name.split("/")[0];
  return NAMES[folder] ?? (folder.startsWith("classic") ? NAMES.classic : name.includes("/") ? folder : "Models with their environments");
}

const titleOf = (name: string): string => name.split("/").pop()!.replace(/\.(l|txt|lsv|ls|lpy)(:|$)/, "$2").replace(/^classic-/, "").replace(/[-_]/g, " ").replace(":", ": ");

/** A picture of the server; a token goes in the request's header, so it cannot be a plain image. */
function Picture({ studio, path }: { studio: Studio; path: string }) {
  const place = useRef<HTMLImageElement>(null);
  useEffect(() => {
    let isThere = true;
    const seen = new IntersectionObserver(([entry]) => {
      if (entry.isIntersecting) {
        seen.disconnect();
        void studio.fetchFile(path).then((blob) => isThere && place.current && (place.current.src = URL.createObjectURL(blob)), () => {});
      }
    });
    seen.observe(place.current!);
    return () => {
      isThere = false;
      seen.disconnect();
    };
  }, [path]);
  return <img ref={place} alt="" />;
}

export function GalleryDialog({ studio, onClose }: { studio: Studio; onClose: () => void }) {
  const [sought, setSought] = useState("");
  const hits = useRef<HTMLDivElement>(null);
  useEffect(() => void studio.act(() => listSaved(studio)), []);
  const saved = (studio.saved ?? []).filter((name) => name.toLowerCase().includes(sought.toLowerCase()));
  const found = studio.gallery.filter(({ name }) => name.toLowerCase().includes(sought.toLowerCase().replace(/ /g, "-")));
  const groups = new Map<string, typeof found>();
  found.forEach((entry) => groups.set(groupOf(entry.name), [...(groups.get(groupOf(entry.name)) ?? []), entry]));
  const order = [...groups.keys()].sort((a, b) => Number(b.startsWith("Models")) - Number(a.startsWith("Models")) || a.localeCompare(b));
  const open = (action: () => Promise<void>) => {
    onClose();
    history.replaceState(null, "", location.pathname);
    void studio.act(action);
  };
  return (
    <Dialog title="Gallery" class="gallery" onClose={onClose}>
      <div class="row">
        <input type="search" placeholder="Find a model" aria-label="Find a model" value={sought} onInput={(event) => setSought(event.currentTarget.value)} autofocus
          onKeyDown={(event) => event.key === "Enter" && sought && hits.current!.querySelector("button")?.click()} />
        <button type="button" onClick={() => open(() => studio.openDocument(newDocument()))}>New model</button>
        <label class="button">
          Open files …
          <input type="file" multiple class="hidden" onChange={(event) => open(() => openFiles(studio, event.currentTarget.files!))} />
        </label>
      </div>
      <div class="scroll" ref={hits}>
        {saved.length > 0 && (
          <section>
            <h3>Saved on this server</h3>
            <div class="list">
              {saved.map((name) => (
                <button type="button" key={name} data-saved={name} onClick={() => open(() => openSaved(studio, name))}>{name}</button>
              ))}
            </div>
          </section>
        )}
        {order.map((group) => (
          <section key={group}>
            <h3>{group}</h3>
            <div class="grid">
              {groups.get(group)!.map(({ name, picture }) => (
                <button type="button" class="card" key={name} data-model={name} onClick={() => open(() => studio.openGallery(name))}>
                  <div class="picture">{picture && <Picture studio={studio} path={picture} />}</div>
                  <span>{titleOf(name)}</span>
                </button>
              ))}
            </div>
          </section>
        ))}
        {found.length + saved.length === 0 && <p class="quiet">No model has this name.</p>}
      </div>
    </Dialog>
  );
}

const MODEL_SUFFIX = /\.(l|lpy|ls|lsv|lpfg)$/i;

/** Opens files of this machine as a model. */
export async function openFiles(studio: Studio, list: FileList): Promise<void> {
  const files: Record<string, string> = {};
  const binary: Record<string, string> = {};
  for (const file of list) {
    const bytes = new Uint8Array(await file.arrayBuffer());
    try {
      // a small colour map may look like a text
      if (bytes.includes(0) || /\.(map|mat)$/.test(file.name)) {
        throw new Error("not a text");
      }
      files[file.name] = new TextDecoder("utf-8", { fatal: true }).decode(bytes);
    } catch {
      let text = "";
      bytes.forEach((byte) => (text += String.fromCharCode(byte)));
      binary[file.name] = btoa(text);
    }
  }
  const names = Object.keys(files);
  const main = names.find((name) => MODEL_SUFFIX.test(name) && !/^panel/.test(name)) ?? names.find((name) => /\.txt$/.test(name));
  if (!main) {
    throw new Error("No model is among these files. Choose also the file that ends in .l.");
  }
  await studio.openDocument({ title: main.replace(MODEL_SUFFIX, ""), main, files, binary, environment: null, gallery: null });
}

// names that mean the computer that reads them
const LOOPBACK = /^(localhost|127\..*|\[::1\])$/;

export function ShareDialog({ studio, onClose }: { studio: Studio; onClose: () => void }) {
  const [link, setLink] = useState("");
  const [copied, setCopied] = useState(""); // the link that was copied last
  useEffect(() => {
    void linkTo(studio).then(setLink);
  }, []);
  const copy = async (text: string) => {
    await navigator.clipboard?.writeText(text).catch(() => {});
    setCopied(text);
  };
  const running = `${location.origin}${location.pathname}#watch=${studio.simulation?.id ?? ""}`;
  return (
    <Dialog title="Share" onClose={onClose}>
      <p>This link holds the model with its files, the seed and the step. It grows the same plant at every Espalier server.</p>
      <textarea id="share-link" readOnly rows={4} aria-label="Link to the model" value={link} onFocus={(event) => event.currentTarget.select()} />
      <div class="row">
        <button type="button" class="primary" onClick={() => void copy(link)} autofocus>{link && copied === link ? "Copied" : "Copy the link"}</button>
        <span class="quiet">{link.length.toLocaleString("en")} characters</span>
      </div>
      <p>This link only watches this page's plant, with everything that happens to it, also when you change the text or open another model. It is for a
        class: any number of pages may open it, and none can change the plant. With <code>simulation=</code> instead of <code>watch=</code> a page can.</p>
      <input readOnly aria-label="Link to the simulation" value={running} onFocus={(event) => event.currentTarget.select()} />
      <div class="row">
        <button type="button" id="copy-watch" disabled={!studio.simulation} onClick={() => void copy(running)}>{copied === running ? "Copied" : "Copy the link to watch"}</button>
      </div>
      {LOOPBACK.test(location.hostname) && <p class="quiet" id="only-here">This page came from {location.host}, an address of this computer that no other reaches. For a class, start the server at the computer's
        address, with a token and a certificate (docs/howto/in-a-class.md), and share the links from there.</p>}
    </Dialog>
  );
}

/** Work that takes a while and that a person may stop; then its result is what there is so far. */
async function longWork(studio: Studio, name: string, work: (signal: AbortSignal) => Promise<Blob>, file: string): Promise<void> {
  const stop = new AbortController();
  studio.longWork = { stop, name };
  studio.changed();
  try {
    download(file, await work(stop.signal));
  } finally {
    studio.longWork = null;
    studio.changed();
  }
}

const EXPORTS = [
  ["svg", "SVG: a drawing of lines"],
  ["png", "PNG: a picture by the server"],
  ["glb", "GLB: a mesh for 3-D programs"],
  ["obj", "OBJ: a mesh"],
  ["usda", "USD: a mesh"],
  ["ply", "PLY: points and triangles"],
  ["stl", "STL: for printing"],
  ["mtg", "MTG: the architecture of the plant"],
  ["csv", "CSV: the turtle's records"],
  ["snapshot", "Snapshot: the complete state"],
];

export function ExportDialog({ studio, onClose }: { studio: Studio; onClose: () => void }) {
  const film = (suffix: string, make: typeof filmGrowth) => {
    onClose();
    void studio.act(() => longWork(studio, "recording", (signal) => make(studio, signal), `${name}${suffix}.webm`));
  };
  const name = studio.document.title.replace(/[^\w.-]+/g, "-").replace(/\.\w+$/, "");
  const { files, binary } = studio.document;
  const all = new Map([
    ...orderedFiles(studio.document).map((file) => [file, new TextEncoder().encode(files[file])] as const),
    ...Object.entries(binary).map(([file, base64]) => [file, bytesOf(base64) as Uint8Array<ArrayBuffer>] as const),
  ]);
  const save = (suffix: string) =>
    studio.act(async () => download(`${name}.${suffix}`, await studio.fetchFile(`/simulations/${studio.simulation!.id}/${name}.${suffix}`)));
  return (
    <Dialog title="Save" onClose={onClose}>
      {studio.saved && !studio.isReadOnly && <SaveOnServer studio={studio} onDone={onClose} />}
      <h3>The model</h3>
      <div class="list">
        {orderedFiles(studio.document).map((file) => (
          <button type="button" key={file} onClick={() => download(file, studio.document.files[file])}>{file}</button>
        ))}
        {Object.entries(studio.document.binary).map(([file, base64]) => (
          <button type="button" key={file} onClick={() => download(file, new Blob([bytesOf(base64) as Uint8Array<ArrayBuffer>]))}>{file}</button>
        ))}
        {all.size > 1 && <button type="button" id="save-all" onClick={() => download(`${name}.zip`, archiveOf(all))}>All as ZIP</button>}
      </div>
      <h3>The plant at step {studio.step}</h3>
      <div class="list">
        <button type="button" id="save-view" disabled={!studio.view} onClick={() => void studio.act(async () => (await studio.extras.meshOf(studio.step), download(`${name}-view.png`, await studio.view!.picture())))}>The view as a picture</button>
        <button type="button" id="film" disabled={!studio.simulation || !studio.isOwn || studio.step === 0} onClick={() => film("", filmGrowth)}>WebM: a film of the growth</button>
        <button type="button" id="film-turn" disabled={!studio.simulation} onClick={() => film("-turn", filmTurn)}>WebM: a turn around the plant</button>
        {EXPORTS.map(([suffix, label]) => (
          <button type="button" key={suffix} disabled={!studio.simulation} data-format={suffix} onClick={() => void save(suffix)}>{label}</button>
        ))}
        <button type="button" disabled={!studio.simulation} onClick={() => void studio.act(async () => download(`${name}.txt`, await studio.simulation!.string()))}>The string</button>
      </div>
      {studio.isOwn && studio.simulation && <ManyPlants studio={studio} name={name} onDone={onClose} />}
    </Dialog>
  );
}

/** Plants of many seeds in one archive. */
function ManyPlants({ studio, name, onDone }: { studio: Studio; name: string; onDone: () => void }) {
  const [count, setCount] = useState(40);
  const [suffix, setSuffix] = useState("glb");
  const save = () => {
    onDone();
    const { seed } = studio;
    const told = (made: number) => studio.say(`${made} of ${count} plants`);
    void studio.act(async () => {
      await longWork(studio, "growing", (signal) => standOf(studio, name, seed, count, suffix, told, signal), `${name}-seeds.zip`);
      studio.say(`${name}-seeds.zip is saved.`);
    });
  };
  return (
    <form id="many-plants" onSubmit={(event) => { event.preventDefault(); save(); }}>
      <h3>Many plants, each with a seed of its own</h3>
      <div class="row">
        <input id="many-count" type="number" min={1} max={MOST_PLANTS} step={1} required aria-label="Number of plants" value={count} onInput={(event) => setCount(event.currentTarget.valueAsNumber)} />
        <span>plants, seeds from {studio.seed}, as</span>
        <select aria-label="Format of the plants" value={suffix} onChange={(event) => setSuffix(event.currentTarget.value)}>
          {EXPORTS.map(([one]) => <option key={one} value={one}>{one.toUpperCase()}</option>)}
        </select>
        <button disabled={studio.connection !== "connected" || studio.longWork !== null}>Save as ZIP</button>
      </div>
    </form>
  );
}

function SaveOnServer({ studio, onDone }: { studio: Studio; onDone: () => void }) {
  const [name, setName] = useState(nameFor(studio.document));
  const [isOther, setOther] = useState(false); // the server has another model of this name
  const save = (isOver: boolean) => void studio.act(async () => ((await saveOnServer(studio, name.trim(), isOver)) ? onDone() : setOther(true)));
  const published = publishedFileOf(studio.document);
  return (
    <form id="save-on-server" onSubmit={(event) => { event.preventDefault(); save(false); }}>
      <h3>On the server</h3>
      <div class="row">
        <input id="saved-name" aria-label="Name of the model on the server" value={name} required onInput={(event) => { setName(event.currentTarget.value); setOther(false); }} />
        <button class="primary" disabled={studio.connection !== "connected"}>Save on the server</button>
      </div>
      {isOther && (
        <p role="alert">
          <span class="error">The server has another “{name}”: somebody saved it, or it was changed there since this page read it. Save under another name, or replace it.</span>{" "}
          <button type="button" id="save-over" onClick={() => save(true)}>Replace it</button>
        </p>
      )}
      {studio.document.environment && published in studio.document.files && studio.document.environment.some((one) => (one as { type?: string }).type !== "gallery") &&
        <p class="quiet">The environment chosen at the side is not saved: the file {published} says it.</p>}
    </form>
  );
}

export const KEYS: Array<[string, string]> = [
  ["Space", "run, pause"],
  ["→", "one step"],
  ["←", "one step back"],
  ["Home, End", "first, last step"],
  ["F", "show the whole plant"],
  ["1, 2, 3", "look from the front, the right, the top"],
  ["C", "next way to colour"],
  ["G", "gallery"],
  ["B", "a second plant beside, from this step; without it"],
  ["V", "table of variations"],
  ["M", "ruler and protractor"],
  ["S", "save"],
  ["Ctrl S", "save on the server"],
  ["L", "link to this model"],
  ["R", "another seed"],
  ["D", "dark, light"],
  ["E", "edit the text"],
  ["Esc", "leave the text; forget the chosen module"],
  ["Ctrl Enter", "grow the text"],
  ["Ctrl Z, Ctrl Y", "undo, redo: text and sliders"],
  ["Ctrl F", "find in the text"],
  ["Ctrl Space, Tab", "words that fit; take one"],
  ["F2", "rename everywhere"],
  ["F12, Ctrl click", "go to the definition"],
  ["Shift F12", "all uses of a name"],
  ["Alt Shift F", "lay the text out"],
  ["F8", "next problem"],
  ["?", "this list"],
];

export function HelpDialog({ onClose }: { onClose: () => void }) {
  return (
    <Dialog title="Keyboard and mouse" onClose={onClose}>
      <dl class="keys">
        {KEYS.map(([key, does]) => (
          <div key={key}>
            <dt><kbd>{key}</kbd></dt>
            <dd>{does}</dd>
          </div>
        ))}
      </dl>
      <p class="quiet">Drag turns the plant, scroll zooms, right drag moves. A click on a part of the plant explains its module.</p>
    </Dialog>
  );
}
