// The middle: the view of the plants with its legend and scale.
import { useEffect, useRef, useState } from "preact/hooks";
import type { Studio } from "../studio/studio.js";
import { View } from "../view/scene.js";
import type { ColourMode } from "../view/colours.js";
import { withMoved } from "../view/surroundings.js";
import { IconButton } from "./icons.js";
import { BesideStage } from "./beside.js";
import { usePhotograph } from "./photograph.js";

export const MODES: Array<[ColourMode, string]> = [
  ["model", "colours of the model"],
  ["order", "branch order"],
  ["age", "age"],
  ["plant", "plant"],
  ["symbol", "module"],
  ["parameter 1", "parameter 1"],
  ["parameter 2", "parameter 2"],
  ["parameter 3", "parameter 3"],
];

export function setMode(studio: Studio, mode: ColourMode): void {
  studio.view?.apply({ ...studio.view.settings, mode });
  void studio.extras.setTableWanted(mode.startsWith("parameter"));
  studio.changed();
}

const shortNumber = (value: number): string => String(Number(value.toPrecision(3)));

function ScaleBar({ studio }: { studio: Studio }) {
  const perPixel = studio.view?.unitsPerPixel() ?? 0;
  if (!perPixel || !studio.simulation) {
    return null;
  }
  // the largest of 1, 2, 5 · 10^k that is at most 120 pixels long
  const most = 120 * perPixel;
  const power = 10 ** Math.floor(Math.log10(most));
  const length = [5, 2, 1].find((factor) => factor * power <= most)! * power;
  return (
    <div class="scale" aria-label={`Scale: ${shortNumber(length)} units`}>
      <span style={{ width: `${length / perPixel}px` }} />
      {shortNumber(length)}
    </div>
  );
}

/** The server sends the queries of a step when it happens: the last step happens again. */
async function showQueries(studio: Studio, isShown: boolean): Promise<void> {
  await studio.extras.setQueriesShown(isShown);
  const { step } = studio;
  if (isShown && studio.isOwn && step > 0 && !studio.isRunning) {
    await studio.goTo(step - 1);
    await studio.goTo(step);
  }
}

/** A solid of the environment follows the mouse; the plant grows again around it. */
function dragSolids(studio: Studio, view: View): void {
  view.element.addEventListener("pointerdown", (event) => {
    const found = event.button === 0 && studio.isOwn && studio.simulation ? view.solidAt(event.clientX, event.clientY) : null;
    if (!found) {
      return;
    }
    // before the camera's own listener
    view.controls.enabled = false;
    const processes = studio.document.environment ?? [];
    const move = ({ clientX, clientY }: PointerEvent) => void studio.act(() => studio.setProcesses(withMoved(processes, found.solid, found.wayTo(clientX, clientY))));
    const end = () => {
      view.controls.enabled = true;
      removeEventListener("pointermove", move);
    };
    addEventListener("pointermove", move);
    addEventListener("pointerup", end, { once: true });
  }, true);
}

const AXES = ["x", "y", "z"];

/** A field of the environment: which one, where the slice is, and the surface of one value. */
function FieldChoice({ studio }: { studio: Studio }) {
  const { entries, shown, look } = studio.fields;
  if (entries.length === 0) {
    return null;
  }
  return (
    <>
      <select id="field" aria-label="Field of the environment" value={shown} onChange={(event) => { const { value } = event.currentTarget; void studio.act(() => studio.fields.choose(value)); }}>
        <option value="">no field</option>
        {entries.map(({ name, unit }) => <option key={name} value={name}>{name}{unit && unit !== "1" ? ` (${unit})` : ""}</option>)}
      </select>
      {shown && (
        <>
          <label class="chip">slice
            <select id="field-axis" aria-label="Across the slice" value={look.axis} onChange={(event) => studio.fields.change({ axis: Number(event.currentTarget.value) as 0 })}>
              {AXES.map((name, axis) => <option key={name} value={axis}>{name}</option>)}
            </select>
            <input id="field-place" type="range" min={0} max={1} step={0.01} aria-label="Place of the slice" value={look.place} onInput={(event) => studio.fields.change({ place: event.currentTarget.valueAsNumber })} />
          </label>
          {studio.fields.hasDepth && <label class="chip" title="The surface on which the field has one value"><input id="field-surface" type="checkbox" checked={look.level !== null} onChange={(event) => studio.fields.change({ level: event.currentTarget.checked ? 0.5 : null })} />surface
            {look.level !== null && <input id="field-level" type="range" min={0.02} max={0.98} step={0.02} aria-label="Value of the surface" value={look.level} onInput={(event) => studio.fields.change({ level: event.currentTarget.valueAsNumber })} />}
          </label>}
        </>
      )}
    </>
  );
}

function LegendBox({ studio }: { studio: Studio }) {
  const legend = studio.view?.legend ?? (studio.extras.areQueriesShown ? studio.view?.surroundings.legend : null) ?? studio.view?.fieldView.legend;
  if (!legend) {
    return null;
  }
  return (
    <div class="legend" id="legend">
      <b>{legend.title}</b>
      {legend.swatches?.map(({ colour, name }) => <div key={name}><i style={{ background: colour }} /> {name}</div>)}
      {legend.scale && (
        <div class="gradient">
          <i style={{ background: `linear-gradient(90deg, ${legend.scale.colours.join(", ")})` }} />
          <span>{shortNumber(legend.scale.low)}</span>
          <span>{shortNumber(legend.scale.high)}</span>
        </div>
      )}
    </div>
  );
}

/** The view of the plant, with what a person does in it. */
function makeView(studio: Studio, element: HTMLElement, canvas: HTMLCanvasElement, onPick: () => void, onTurned: () => void): View {
  const isDark = document.documentElement.dataset.theme === "dark";
  const view = new View(element, { mode: "model", hasGround: true, hasShadows: true, hasSurroundings: true, isDark }, canvas);
  view.onFitted = () => studio.changed();
  let down = [0, 0];
  dragSolids(studio, view);
  canvas.addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]));
  canvas.addEventListener("pointerup", (event) => {
    if (event.button === 0 && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 4) {
      const found = view.pickAt(event.clientX, event.clientY);
      void studio.act(() => studio.pick(found));
      if (found) {
        onPick();
      }
    }
  });
  view.controls.addEventListener("end", onTurned);
  canvas.addEventListener("wheel", onTurned, { passive: true });
  return view;
}

export function Stage({ studio, canvas, onPick }: { studio: Studio; canvas: HTMLCanvasElement; onPick: () => void }) {
  const place = useRef<HTMLDivElement>(null);
  const [, turned] = useState(0);
  const [problem, setProblem] = useState("");
  useEffect(() => {
    try {
      studio.frames.stage(makeView(studio, place.current!, canvas, onPick, () => turned((count) => count + 1)));
    } catch (error) {
      setProblem(`This page cannot draw: WebGL is not available (${(error as Error).message}).`);
      studio.frames.stage(null);
    }
  }, []);
  const { environment } = studio.document;
  useEffect(() => studio.view?.surround(environment ?? []), [environment]);
  const { overlay, tools, isUsed } = usePhotograph(studio);
  const settings = studio.view?.settings;
  const figures = studio.view?.surroundings.figures();
  return (
    <div class={`viewing ${isUsed ? "used" : ""}`}>
    <div class={`stage ${studio.beside.growth ? "two" : ""}`}>
      <div id="plant" ref={place} role="img" aria-label={`The plant at step ${studio.step}`} />
      {problem && <p class="cover">{problem}</p>}
      {settings && (
        <div class="look">
          <select id="mode" aria-label="Colours" value={settings.mode} onChange={(event) => setMode(studio, event.currentTarget.value as ColourMode)}>
            {MODES.map(([mode, name]) => <option key={mode} value={mode}>{name}</option>)}
          </select>
          <label class="chip"><input type="checkbox" checked={settings.hasShadows} onChange={(event) => { studio.view!.apply({ ...settings, hasShadows: event.currentTarget.checked }); studio.changed(); }} />shadows</label>
          <label class="chip"><input type="checkbox" checked={settings.hasGround} onChange={(event) => { studio.view!.apply({ ...settings, hasGround: event.currentTarget.checked }); studio.changed(); }} />ground</label>
          {studio.extras.hasMaterials && (
            <label class="chip" title="Highlights, glow and transparency of the materials, in slower pictures"><input id="show-materials" type="checkbox" checked={studio.extras.areMaterialsShown} onChange={(event) => { const { checked } = event.currentTarget; void studio.act(() => studio.extras.setMaterialsShown(checked)); }} />materials</label>
          )}
          {figures && figures.solids > 0 && (
            <label class="chip" title="What surrounds the plant. Drag a solid to move it."><input type="checkbox" checked={settings.hasSurroundings} onChange={(event) => { studio.view!.apply({ ...settings, hasSurroundings: event.currentTarget.checked }); studio.changed(); }} />surroundings</label>
          )}
          {studio.statistics.some(({ queries }) => queries > 0) && (
            <label class="chip" title="Where the last step asked the environment, coloured by the answer"><input id="show-queries" type="checkbox" checked={studio.extras.areQueriesShown} onChange={(event) => { const { checked } = event.currentTarget; void studio.act(() => showQueries(studio, checked)); }} />queries</label>
          )}
          <FieldChoice studio={studio} />
          <IconButton icon="fit" label="Show the whole plant (F)" onClick={() => studio.view!.fit()} />
        </div>
      )}
      {studio.beside.growth && <BesideStage studio={studio} />}
      {overlay}
      <LegendBox studio={studio} />
      <ScaleBar studio={studio} />
    </div>
    {tools}
    </div>
  );
}
