// The middle: the view of the plants with its legend and scale.
import { useEffect, useRef, useState } from "preact/hooks";
import type { Studio } from "../studio/studio.js";
import { View } from "../view/scene.js";
import type { ColourMode } from "../view/colours.js";
import { withMoved } from "../view/surroundings.js";
import { IconButton } from "./icons.js";
import { BesideStage } from "./beside.js";
import { Photograph } from "./photograph.js";

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

function LegendBox({ studio }: { studio: Studio }) {
  const legend = studio.view?.legend ?? (studio.extras.areQueriesShown ? studio.view?.surroundings.legend : null);
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

export function Stage({ studio, onPick }: { studio: Studio; onPick: () => void }) {
  const place = useRef<HTMLDivElement>(null);
  const [, turned] = useState(0);
  const [problem, setProblem] = useState("");
  useEffect(() => {
    try {
      const isDark = document.documentElement.dataset.theme === "dark";
      const view = new View(place.current!, { mode: "model", hasGround: true, hasShadows: true, hasSurroundings: true, isDark });
      studio.view = view;
      // a person may switch them on again
      view.onSlow = () => {
        view.apply({ ...view.settings, hasShadows: false });
        studio.changed();
      };
      let down = [0, 0];
      const canvas = view.renderer.domElement;
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
      view.controls.addEventListener("end", () => turned((count) => count + 1));
      canvas.addEventListener("wheel", () => turned((count) => count + 1), { passive: true });
    } catch (error) {
      setProblem(`This page cannot draw: WebGL is not available (${(error as Error).message}).`);
    }
  }, []);
  const { environment } = studio.document;
  useEffect(() => studio.view?.surround(studio.isOwn ? (environment ?? []) : []), [environment, studio.isOwn]);
  const settings = studio.view?.settings;
  const figures = studio.view?.surroundings.figures();
  return (
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
          {figures && figures.solids > 0 && (
            <label class="chip" title="What surrounds the plant. Drag a solid to move it."><input type="checkbox" checked={settings.hasSurroundings} onChange={(event) => { studio.view!.apply({ ...settings, hasSurroundings: event.currentTarget.checked }); studio.changed(); }} />surroundings</label>
          )}
          {studio.statistics.some(({ queries }) => queries > 0) && (
            <label class="chip" title="Where the last step asked the environment, coloured by the answer"><input id="show-queries" type="checkbox" checked={studio.extras.areQueriesShown} onChange={(event) => { const { checked } = event.currentTarget; void studio.act(() => showQueries(studio, checked)); }} />queries</label>
          )}
          <IconButton icon="fit" label="Show the whole plant (F)" onClick={() => studio.view!.fit()} />
        </div>
      )}
      {studio.beside.growth && <BesideStage studio={studio} />}
      <Photograph studio={studio} />
      <LegendBox studio={studio} />
      <ScaleBar studio={studio} />
    </div>
  );
}
