// The right side: parameters, the chosen module, the set-up, the simulations of the server.
import { useState } from "preact/hooks";
import type { Studio } from "../studio/studio.js";
import { guessedRange, processesWritten } from "../studio/document.js";
import type { Define } from "../studio/document.js";
import { deleteSimulation } from "../studio/plants.js";
import { linkTo } from "../studio/share.js";
import { remarkOn } from "../studio/turns.js";
import { useChanges } from "./changes.js";
import { ColourBoard } from "./colour_board.js";
import { EnvironmentForm } from "./environment_form.js";
import { IconButton } from "./icons.js";
import { NumberField } from "./number_field.js";
import { Panels } from "./panel.js";

const TABS = ["Parameters", "Module", "Set-up", "Server"] as const;
export type Tab = (typeof TABS)[number];

export function Side({ studio, tab, onTab, onVariations }: { studio: Studio; tab: Tab; onTab: (tab: Tab) => void; onVariations: () => void }) {
  return (
    <aside class="side" aria-label="Tools">
      <div class="tabs" role="tablist">
        {TABS.map((name) => (
          <button type="button" role="tab" key={name} id={`tab-${name}`} aria-selected={name === tab} aria-controls="side-panel" onClick={() => onTab(name)}>{name}</button>
        ))}
      </div>
      <div class="content" role="tabpanel" id="side-panel" aria-labelledby={`tab-${tab}`}>
        {tab === "Parameters" && <Panels studio={studio} />}
        {tab === "Parameters" && <Parameters studio={studio} />}
        {tab === "Parameters" && <ColourBoard studio={studio} />}
        {tab === "Parameters" && studio.isOwn && studio.simulation && (
          <button type="button" id="open-variations" title="A table of plants over two numbers or seeds (V)" onClick={onVariations}>Variations …</button>
        )}
        {tab === "Module" && <Module studio={studio} />}
        {tab === "Set-up" && <SetUp studio={studio} />}
        {tab === "Server" && <Server studio={studio} />}
      </div>
    </aside>
  );
}

// the range of a slider stays while it moves
const ranges = new Map<string, { low: number; high: number; step: number }>();

function rangeOf(studio: Studio, define: Define): { low: number; high: number; step: number } {
  const key = `${studio.document.title}\n${define.file}\n${define.name}`;
  const known = ranges.get(key);
  if (known && define.value >= known.low && define.value <= known.high) {
    return known;
  }
  const range = guessedRange(define.value);
  ranges.set(key, range);
  return range;
}

function Parameters({ studio }: { studio: Studio }) {
  useChanges(studio);
  const defines = studio.defines;
  if (!studio.isOwn && studio.simulation) {
    return (
      <>
        <p class="quiet">{studio.isReadOnly ? "This page only watches a simulation." : "Another program made this simulation. Change its text to make one of your own."}</p>
        <button type="button" id="copy-plant" onClick={() => void studio.act(async () => void open(await linkTo(await studio.watched.copy()), "_blank"))}>Grow a copy of your own</button>
      </>
    );
  }
  if (defines.length === 0) {
    return <p class="quiet">Numbers that the model names with <code>#define NAME 0.5</code> get a slider here.</p>;
  }
  return (
    <div class="parameters">
      {defines.map((define) => {
        const { low, high, step } = rangeOf(studio, define);
        const slide = (value: number, isFinal: boolean) => Number.isFinite(value) && studio.slide(define, value, step, isFinal);
        return (
          <div class="parameter" key={`${define.file} ${define.name}`}>
            <label for={`define-${define.name}`}>{define.name}</label>
            <NumberField class="value" step={step} value={define.value} aria-label={`Value of ${define.name}`} onDone={(input) => slide(input.valueAsNumber, true)} />
            <input id={`define-${define.name}`} type="range" min={low} max={high} step={step} value={define.value}
              onInput={(event) => slide(event.currentTarget.valueAsNumber, false)} onChange={(event) => slide(event.currentTarget.valueAsNumber, true)} />
            {define.comment && <small>{define.comment}</small>}
            {remarkOn(studio.document, define) && <small class="remark" role="status">{remarkOn(studio.document, define)}</small>}
          </div>
        );
      })}
    </div>
  );
}

function Module({ studio }: { studio: Studio }) {
  const [degrees, setDegrees] = useState(20);
  const [turn, setTurn] = useState("+");
  const chosen = studio.picked;
  if (!chosen) {
    return <p class="quiet">Click on a part of the plant. Here you see the module that drew it, and what the next step does with it.</p>;
  }
  return (
    <div class="module">
      <h3><code>{chosen.symbol}</code> <span class="quiet">module {chosen.module}{chosen.plant > 0 ? `, plant ${chosen.plant}` : ""}</span></h3>
      <dl class="facts">
        <div><dt>drawn as</dt><dd>{chosen.kind}</dd></div>
        <div><dt>branch order</dt><dd>{chosen.order}</dd></div>
        {chosen.length !== undefined && <div><dt>length</dt><dd>{chosen.length.toPrecision(4)}</dd></div>}
        {chosen.width !== undefined && <div><dt>width</dt><dd>{chosen.width.toPrecision(3)}</dd></div>}
        <div><dt>place</dt><dd>{chosen.position.map((x) => x.toFixed(2)).join(", ")}</dd></div>
      </dl>
      {!studio.isReadOnly && <div class="row">
        <button type="button" id="prune" onClick={() => void studio.act(() => studio.change("prune"))}>Prune here</button>
        <button type="button" id="bend" onClick={() => void studio.act(() => studio.change("insert", [{ symbol: turn, parameters: [degrees] }]))}>Bend</button>
        <select aria-label="Direction of the bend" value={turn} onChange={(event) => setTurn(event.currentTarget.value)}>
          <option value="+">left (+)</option>
          <option value="-">right (-)</option>
          <option value="&">down (&amp;)</option>
          <option value="^">up (^)</option>
          <option value="/">about itself (/)</option>
        </select>
        <input type="number" aria-label="Degrees of the bend" value={degrees} onInput={(event) => setDegrees(event.currentTarget.valueAsNumber || 0)} />°
      </div>}
      <h3>In the next step</h3>
      <pre id="explanation" tabIndex={0}>{chosen.explanation ?? "…"}</pre>
    </div>
  );
}

function SetUp({ studio }: { studio: Studio }) {
  const given = studio.document.environment;
  const [text, setText] = useState<string | null>(null);
  const shown = text ?? (given ? JSON.stringify(given, null, 1) : "");
  return (
    <div class="setup">
      <label for="seed">Seed of the random numbers</label>
      <div class="row">
        <NumberField id="seed" min={0} step={1} value={studio.seed} onDone={({ valueAsNumber }) => Number.isFinite(valueAsNumber) && void studio.act(() => studio.setSeed(valueAsNumber))} />
        <IconButton icon="dice" label="Another seed (R)" onClick={() => void studio.act(() => studio.setSeed(Math.floor(Math.random() * 1e6)))} />
      </div>
      <EnvironmentForm studio={studio} />
      <details>
        <summary>The environment as JSON</summary>
        <textarea id="environment" rows={6} spellcheck={false} aria-label="Environment, a name or JSON" value={shown} placeholder='honda, or [{"type": "honda", "radius": 0.5}]' onInput={(event) => setText(event.currentTarget.value)} />
        <button type="button" id="use-environment" onClick={() => { setText(null); void studio.act(() => studio.setProcesses(processesWritten(shown))); }}>Grow with it</button>
      </details>
      <label class="check">
        <input type="checkbox" checked={studio.isLive} onChange={(event) => { studio.isLive = event.currentTarget.checked; studio.changed(); }} />
        Grow the plant again when the text changes
      </label>
    </div>
  );
}

function Server({ studio }: { studio: Studio }) {
  return (
    <div class="server">
      <p class="quiet"><span id="server">{studio.server}</span> · <a href="/health">health</a> · <a href="/metrics">metrics</a></p>
      <h3>Simulations</h3>
      <ul id="simulations">
        {studio.simulations.map(({ simulation, name, step, running, damaged }) => (
          <li key={simulation} class={simulation === studio.simulation?.id ? "shown" : ""}>
            <button type="button" class="link" disabled={damaged !== undefined} title={damaged ?? simulation}
              onClick={() => { history.replaceState(null, "", `#simulation=${encodeURIComponent(simulation)}`); void studio.act(() => studio.watch(simulation)); }}>
              {name || simulation}
            </button>
            <span class="quiet">{damaged ? "damaged" : `step ${step}${running ? ", running" : ""}`}</span>
            {!studio.isReadOnly && <IconButton icon="close" label={`Delete ${name || simulation}`} onClick={() => void studio.act(() => deleteSimulation(studio, simulation))} />}
          </li>
        ))}
        {studio.simulations.length === 0 && <li class="quiet">none yet</li>}
      </ul>
    </div>
  );
}
