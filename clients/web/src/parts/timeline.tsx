// Time: run, pause, a slider through the steps, and figures of every step.
import { useEffect, useRef } from "preact/hooks";
import UPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import type { Studio } from "../studio/studio.js";
import { useChanges } from "./changes.js";
import { IconButton } from "./icons.js";

export function Timeline({ studio }: { studio: Studio }) {
  const { simulation, step, isRunning, isOwn } = studio;
  const has = simulation !== null && !studio.isReadOnly;
  const last = studio.statistics[studio.statistics.length - 1];
  return (
    <footer class="timeline">
      <div class="row">
        <IconButton id="first" icon="first" label="First step (Home)" disabled={!has || isRunning || step === 0} onClick={() => void studio.act(() => studio.goTo(0))} />
        <IconButton id="back" icon="back" label="One step back (←)" disabled={!has || isRunning || step === 0 || !isOwn} onClick={() => void studio.act(() => studio.goTo(step - 1))} />
        <IconButton id="run" class="primary" icon={isRunning ? "pause" : "play"} label={isRunning ? "Pause (Space)" : "Run (Space)"} disabled={!has}
          onClick={() => void studio.act(() => (isRunning ? studio.pause() : studio.run()))} />
        <IconButton id="step" icon="step" label="One step (→)" disabled={!has || isRunning} onClick={() => void studio.act(() => studio.stepOnce())} />
        {!studio.beside.growth && (
          <IconButton id="fork" icon="fork" label="A second plant beside, from this step (B)" disabled={!has || isRunning || !isOwn} onClick={() => void studio.act(() => studio.beside.fork())} />
        )}
        <Scrub studio={studio} />
        {studio.longWork ? <button type="button" id="stop-work" class="recording" onClick={() => studio.longWork?.stop.abort()}>Stop {studio.longWork.name}</button> : <label class="inline" title="Pace of a run">
          <select aria-label="Pace of a run" value={studio.pace} onChange={(event) => { studio.pace = Number(event.currentTarget.value); studio.changed(); }}>
            <option value={0}>fast</option>
            <option value={80}>12 a second</option>
            <option value={250}>4 a second</option>
            <option value={1000}>1 a second</option>
          </select>
        </label>}
      </div>
      <div class="figures">
        <dl id="figures">
          <div><dt>modules</dt><dd data-figure="modules">{last?.modules.toLocaleString("en") ?? "–"}</dd></div>
          <div><dt>queries</dt><dd data-figure="queries">{last?.queries.toLocaleString("en") ?? "–"}</dd></div>
          <div><dt>ms a step</dt><dd>{last ? last.milliseconds.toFixed(1) : "–"}</dd></div>
          {last?.plants !== undefined && <div><dt>plants</dt><dd>{last.plants.toLocaleString("en")}</dd></div>}
        </dl>
        <Plot studio={studio} />
      </div>
    </footer>
  );
}

/** The slider through the steps. */
function Scrub({ studio }: { studio: Studio }) {
  useChanges(studio);
  const { simulation, step, length, isRunning, isOwn, isFinished } = studio;
  return (
    <>
      <input id="scrub" type="range" min={0} max={Math.max(length, step, 1)} step={1} value={step} disabled={simulation === null || studio.isReadOnly || isRunning || !isOwn}
        aria-label="Step" onInput={(event) => void studio.act(() => studio.goTo(Number(event.currentTarget.value)))} />
      <output id="state" aria-live="polite">
        step {step} of {Math.max(length, step)}{isFinished ? ", finished" : ""}
      </output>
    </>
  );
}

const style = (name: string) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// between the numbers below the plot: there is no half step
const WHOLE_STEPS = [1, 10, 100, 1000, 10_000, 100_000, 1e6].flatMap((power) => [power, 2 * power, 5 * power]);

function Plot({ studio }: { studio: Studio }) {
  const place = useRef<HTMLDivElement>(null);
  const plot = useRef<UPlot | null>(null);
  const isDark = studio.view?.settings.isDark ?? false;
  useEffect(() => {
    const element = place.current!;
    const axis = { stroke: style("--quiet"), grid: { stroke: style("--line"), width: 1 }, ticks: { show: false }, font: "11px system-ui" };
    plot.current = new UPlot(
      {
        width: element.clientWidth,
        height: element.clientHeight,
        legend: { show: false },
        cursor: { y: false, points: { show: true } },
        scales: { x: { time: false } },
        axes: [
          { ...axis, size: 22, space: 60, incrs: WHOLE_STEPS },
          { ...axis, size: 46, space: 16, values: (_, values) => values.map((value) => (value >= 1e6 ? `${value / 1e6}M` : value >= 1000 ? `${value / 1000}k` : String(value))) },
          { ...axis, side: 1, scale: "ms", size: 40, space: 16, grid: { show: false } },
        ],
        series: [
          {},
          { label: "modules", stroke: style("--accent"), width: 2, fill: style("--accent-soft") },
          { label: "queries", stroke: style("--code-query"), width: 1.5 },
          { label: "ms", scale: "ms", stroke: style("--quiet"), width: 1, dash: [3, 3] },
        ],
      },
      [[], [], [], []],
      element,
    );
    const follow = new ResizeObserver(() => plot.current?.setSize({ width: element.clientWidth, height: element.clientHeight }));
    follow.observe(element);
    return () => {
      follow.disconnect();
      plot.current?.destroy();
    };
  }, [isDark]);
  useEffect(() => {
    const rows = studio.statistics;
    plot.current?.setData([rows.map(({ step }) => step), rows.map(({ modules }) => modules), rows.map(({ queries }) => queries), rows.map(({ milliseconds }) => milliseconds)]);
  }, [studio.statistics, isDark]);
  return (
    <figure class="plot">
      <div ref={place} role="img" aria-label="Modules, queries and milliseconds of each step" />
      <figcaption><i class="modules" /> modules <i class="queries" /> queries <i class="ms" /> ms</figcaption>
    </figure>
  );
}
