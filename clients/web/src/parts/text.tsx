// The left side: the files of the model, the text, the problems.
import { useEffect, useRef, useState } from "preact/hooks";
import type { Diagnostic } from "espalier";
import type { Studio } from "../studio/studio.js";
import { orderedFiles } from "../studio/document.js";
import { parseCurves } from "../studio/curve.js";
import { parseSurface } from "../studio/surface.js";
import { Editor, remedyOf } from "./editor.js";
import { Graphs } from "./graph.js";
import { IconButton } from "./icons.js";
import { LanguageHelp } from "./language_help.js";
import { SurfaceBoard } from "./surface_board.js";

const LENS_MILLISECONDS = 150;

export function TextPane({ studio }: { studio: Studio }) {
  const place = useRef<HTMLDivElement>(null);
  const editor = useRef<Editor | null>(null);
  const help = useRef<LanguageHelp | null>(null);
  const areLensesDue = useRef(false);
  const [isNaming, setNaming] = useState(false);
  const { document, openFile, diagnostics } = studio;
  useEffect(() => {
    const served = new LanguageHelp({
      files: () => studio.document.files,
      edit: (file, text) => studio.edit(file, text),
      show: (file) => {
        studio.openFile = file;
        studio.changed();
        return editor.current!.show(studio.document.title, file, studio.document.files[file]);
      },
      send: (message) => studio.editorMessage(message),
    });
    studio.onConnected = () => !studio.isReadOnly && served.connect();
    if (studio.connection === "connected") {
      studio.onConnected();
    }
    studio.onUndo = (isRedo) => editor.current?.undo(isRedo);
    editor.current = new Editor(
      place.current!,
      (file, text) => studio.edit(file, text),
      () => void studio.act(() => studio.build(studio.isFinished ? undefined : studio.step)),
      studio.isReadOnly ? null : served,
    );
    help.current = studio.isReadOnly ? null : served;
    (place.current as unknown as { editor: Editor }).editor = editor.current;
  }, []);
  // the newest text, not the drawn one: letters that were typed since stay
  useEffect(() => {
    const { document: { title, files }, openFile: file } = studio;
    editor.current?.show(title, file, files[file] ?? "");
  }, [document, openFile]);
  useEffect(() => editor.current?.mark(diagnostics), [diagnostics, openFile]);
  // a run may make many steps a second: the counts follow at a pace that can be read
  const { simulation, step } = studio;
  useEffect(() => {
    if (areLensesDue.current) {
      return;
    }
    areLensesDue.current = true;
    setTimeout(function look() {
      if (studio.isSliding) {
        setTimeout(look, LENS_MILLISECONDS);
        return;
      }
      areLensesDue.current = false;
      const file = studio.openFile;
      void help.current?.lenses(file).then((lenses) => editor.current?.showLenses(file, lenses)).catch(() => {});
    }, LENS_MILLISECONDS);
  }, [document, openFile, simulation, step]);
  const curves = parseCurves(openFile, document.files[openFile] ?? "");
  const surface = parseSurface(openFile, document.files[openFile] ?? "");
  const fileOfProblem = (one: Diagnostic) => (one.file ?? "").split("/").pop()!;
  // the editor shows the file of a problem first
  const atProblem = (one: Diagnostic, act: () => void) => {
    const name = fileOfProblem(one);
    if (name in document.files) {
      studio.openFile = name;
      studio.changed();
      editor.current?.show(document.title, name, document.files[name]);
    }
    act();
  };
  const count = (severity: string) => diagnostics.filter((one) => one.severity === severity).length;
  return (
    <section class="text" aria-label="Text of the model">
      <div class="tabs files">
        <div role="tablist" aria-label="Files">
          {orderedFiles(studio.document).map((name) => (
          <button type="button" role="tab" key={name} aria-selected={name === openFile} onClick={() => { studio.openFile = name; studio.changed(); }}>{name}</button>
          ))}
        </div>
        {isNaming ? (
          <input class="name" aria-label="Name of the new file" placeholder="leaf.s" autofocus
            onKeyDown={(event) => { if (event.key === "Enter") { studio.addFile(event.currentTarget.value.trim()); setNaming(false); } else if (event.key === "Escape") { setNaming(false); } }}
            onBlur={() => setNaming(false)} />
        ) : !studio.isReadOnly && (
          <IconButton icon="plus" label="New file" onClick={() => setNaming(true)} />
        )}
      </div>
      <div class="editor">
        {curves.length > 0 && <Graphs key={openFile} studio={studio} file={openFile} curves={curves} />}
        {surface && <SurfaceBoard key={openFile} studio={studio} file={openFile} surface={surface} />}
        <div class="code" ref={place} />
      </div>
      <div class="problems" aria-label="Problems">
        <h2>
          Problems
          {count("error") > 0 && <span class="badge error">{count("error")}</span>}
          {count("warning") > 0 && <span class="badge warning">{count("warning")}</span>}
        </h2>
        <ul id="problems">
          {diagnostics.map((one, i) => (
            <li key={i} class={one.severity}>
              <button type="button" class="link" onClick={() => atProblem(one, () => one.range && editor.current?.goTo(one.range.begin.line, one.range.begin.column))}>
                <b>{one.range ? `${fileOfProblem(one)}:${one.range.begin.line}:${one.range.begin.column}` : one.severity}</b> {one.message}
                {one.hint && <small>{one.hint}</small>}
              </button>
              {one.range && remedyOf(one.hint) && fileOfProblem(one) in document.files && (
                <button type="button" class="remedy" onClick={() => atProblem(one, () => editor.current?.replace(one.range!.begin, one.range!.end, remedyOf(one.hint)!))}>
                  Change to '{remedyOf(one.hint)}'
                </button>
              )}
            </li>
          ))}
          {diagnostics.length === 0 && <li class="quiet">none</li>}
        </ul>
      </div>
    </section>
  );
}
