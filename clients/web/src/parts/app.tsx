// The whole page.
import { useEffect, useState } from "preact/hooks";
import type { Studio } from "../studio/studio.js";
import { useChanges } from "./changes.js";
import { Divider, useTextWidth } from "./divider.js";
import { ExportDialog, GalleryDialog, HelpDialog, ShareDialog } from "./dialogs.js";
import { IconButton } from "./icons.js";
import { Side } from "./side.js";
import type { Tab } from "./side.js";
import { saveOnServer } from "../studio/saved.js";
import { MODES, Stage, setMode } from "./stage.js";
import { TextPane } from "./text.js";
import { Timeline } from "./timeline.js";
import { VariationsDialog } from "./variations.js";

type Window = "gallery" | "share" | "export" | "help" | "variations" | null;

export function setTheme(studio: Studio, isDark: boolean): void {
  document.documentElement.dataset.theme = isDark ? "dark" : "light";
  try {
    localStorage.setItem("theme", isDark ? "dark" : "light");
  } catch {
    // a page without storage forgets the choice
  }
  studio.view?.apply({ ...studio.view.settings, isDark });
  studio.changed();
}

export function App({ studio, canvas }: { studio: Studio; canvas: HTMLCanvasElement }) {
  const [open, setOpen] = useState<Window>(null);
  const [tab, setTab] = useState<Tab>("Parameters");
  const [isTextShown, setTextShown] = useState(true);
  const [textWidth, setTextWidth] = useTextWidth();
  useChanges(studio, true);
  useEffect(() => {
    const pressed = (event: KeyboardEvent) => keyPressed(event, studio, setOpen);
    addEventListener("keydown", pressed);
    document.addEventListener("click", leaveButton, true);
    return () => {
      removeEventListener("keydown", pressed);
      document.removeEventListener("click", leaveButton, true);
    };
  }, []);
  useEffect(() => {
    document.body.dataset.state = studio.connection;
    document.title = `${studio.isChanged ? "• " : ""}${studio.document.title} – Espalier`;
  });
  const isDark = document.documentElement.dataset.theme === "dark";
  return (
    <div class={`app ${isTextShown ? "" : "wide"} ${studio.isReadOnly ? "watching" : ""}`}>
      <header class="bar">
        <h1><Leaf /> Espalier</h1>
        <IconButton icon="gallery" label="Gallery (G)" text="Gallery" id="open-gallery" onClick={() => setOpen("gallery")} />
        <div class="title">{studio.isChanged && <span title="changed">●</span>} {studio.document.title}</div>
        <p id="message" role="status" class={studio.message?.isError && studio.connection !== "lost" ? "error" : ""}>{studio.connection === "lost" ? "The server has stopped or cannot be reached. Trying again …" : studio.message?.text}</p>
        <IconButton icon="share" label="Share a link to this model (L)" text="Share" onClick={() => setOpen("share")} />
        <IconButton icon="save" label="Save (S)" text="Save" id="open-export" onClick={() => setOpen("export")} />
        <IconButton icon={isDark ? "sun" : "moon"} label="Dark, light (D)" onClick={() => setTheme(studio, !isDark)} />
        <IconButton icon="help" label="Keyboard (?)" onClick={() => setOpen("help")} />
        <span class={`lamp ${studio.connection}`} title={studio.connection} />
      </header>
      <main style={textWidth === null ? {} : { "--text-width": `min(${textWidth}px, 70vw)` }}>
        <TextPane studio={studio} />
        <Divider isTextShown={isTextShown} onFold={() => setTextShown(!isTextShown)} onWidth={setTextWidth} />
        <section class="middle" aria-label="Plant">
          <Stage studio={studio} canvas={canvas} onPick={() => setTab("Module")} />
          <Timeline studio={studio} />
        </section>
        <Side studio={studio} tab={tab} onTab={setTab} onVariations={() => setOpen("variations")} />
      </main>
      {(studio.connection === "token" || studio.connection === "failed") && <Door studio={studio} />}
      {open === "gallery" && <GalleryDialog studio={studio} onClose={() => setOpen(null)} />}
      {open === "share" && <ShareDialog studio={studio} onClose={() => setOpen(null)} />}
      {open === "export" && <ExportDialog studio={studio} onClose={() => setOpen(null)} />}
      {open === "variations" && <VariationsDialog studio={studio} onClose={() => setOpen(null)} />}
      {open === "help" && <HelpDialog onClose={() => setOpen(null)} />}
    </div>
  );
}

function Leaf() {
  return (
    <svg class="icon leaf" viewBox="0 0 24 24" aria-hidden="true">
      <path d="M4 20C4 9 11 3.500 20.500 3.500 20.500 13 15 19.500 6 18.500" fill="currentColor" opacity=".35" />
      <path d="M4 21C6 15 10 11 15 8M9.500 12.700V8.500M8 14.800h5" fill="none" stroke="currentColor" stroke-width="1.800" stroke-linecap="round" />
    </svg>
  );
}

/** Asks for the token of a server that wants one. */
function Door({ studio }: { studio: Studio }) {
  const [token, setToken] = useState("");
  return (
    <form id="token-form" class="door" onSubmit={(event) => { event.preventDefault(); void studio.start(token); }}>
      <h2>{studio.connection === "token" ? "Token of this server" : "The server cannot be reached"}</h2>
      {studio.connection === "token" && <input id="token" type="password" aria-label="Token" autocomplete="off" value={token} onInput={(event) => setToken(event.currentTarget.value)} autofocus />}
      <p class="error">{studio.message?.text}</p>
      <button class="primary">Connect</button>
    </form>
  );
}

/** A button that the mouse pressed gives the keyboard back to the page: Space runs the plant, and no button again. */
function leaveButton(event: MouseEvent): void {
  const button = (event.target as Element).closest<HTMLElement>("button, label, summary");
  // a keyboard's click has no count
  if (event.detail > 0 && button && !button.closest("dialog, form")) {
    const focused = document.activeElement as HTMLElement | null;
    if (focused?.matches("button, summary, input[type=checkbox]")) {
      focused.blur();
    }
  }
}

/** Saves under the name that the model has on the server; a new one, and one that changed there, ask for a name. */
function saveAgain(studio: Studio, setOpen: (open: Window) => void): void {
  const { saved } = studio.document;
  void studio.act(async () => {
    if (!document.querySelector("dialog[open]") && !(saved && (await saveOnServer(studio, saved.name)))) {
      setOpen("export");
    }
  });
}

function keyPressed(event: KeyboardEvent, studio: Studio, setOpen: (open: Window) => void): void {
  const target = event.target as HTMLElement;
  if (event.defaultPrevented) {
    return; // the editor has used the key: Escape closes its list
  }
  if (event.key === "Escape" && target.closest(".cm-editor")) {
    target.blur();
    return;
  }
  if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "s" && studio.saved && !studio.isReadOnly) {
    event.preventDefault();
    saveAgain(studio, setOpen);
    return;
  }
  const isWriting = target.closest(".cm-editor, textarea, select, input:not([type=range]):not([type=checkbox])");
  if (isWriting || event.altKey || document.querySelector("dialog[open]")) {
    return;
  }
  if (event.ctrlKey || event.metaKey) {
    const key = event.key.toLowerCase();
    if (key === "z" || key === "y") {
      event.preventDefault();
      studio.undo(key === "y" || event.shiftKey);
    }
    return;
  }
  const isSlider = target.matches("input[type=range]");
  const act = (action: () => unknown) => {
    event.preventDefault();
    void studio.act(action);
  };
  const modes = MODES.map(([mode]) => mode);
  const actions: Record<string, () => unknown> = {
    " ": () => (studio.isRunning ? studio.pause() : studio.run()),
    ArrowRight: () => studio.stepOnce(),
    ArrowLeft: () => studio.goTo(Math.max(studio.step - 1, 0)),
    Home: () => studio.goTo(0),
    End: () => studio.goTo(Math.max(studio.length, studio.step)),
    f: () => studio.view?.fit(),
    1: () => studio.view?.look("front"),
    2: () => studio.view?.look("right"),
    3: () => studio.view?.look("top"),
    c: () => setMode(studio, modes[(modes.indexOf(studio.view!.settings.mode) + 1) % modes.length]),
    g: () => setOpen("gallery"),
    b: () => (studio.beside.growth ? studio.beside.close() : studio.beside.fork()),
    v: () => setOpen("variations"),
    m: () => document.getElementById("measure")?.click(),
    s: () => setOpen("export"),
    l: () => setOpen("share"),
    r: () => studio.setSeed(Math.floor(Math.random() * 1e6)),
    d: () => setTheme(studio, document.documentElement.dataset.theme !== "dark"),
    e: () => document.querySelector<HTMLElement>(".cm-content")?.focus(),
    "?": () => setOpen("help"),
    Escape: () => studio.pick(null),
  };
  const action = actions[event.key] ?? actions[event.key.toLowerCase()];
  const isOfSlider = isSlider && /^(Arrow|Home|End)/.test(event.key);
  const isOfButton = event.key === " " && target.closest("button, summary, a, input:not([type=range])");
  const needsPlant = /^( |Arrow|Home|End|[brv]$)/.test(event.key);
  if (action && !isOfSlider && !isOfButton && !(needsPlant && (!studio.simulation || studio.isReadOnly))) {
    act(action);
  }
}
