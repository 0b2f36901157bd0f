// Draws the curve of a function or contour file; its control points are dragged.
import { useRef, useState } from "preact/hooks";
import type { Studio } from "../studio/studio.js";
import { spline, withPoint } from "../studio/curve.js";
import type { Curve } from "../studio/curve.js";

const WIDTH = 360;
const HEIGHT = 200;
const MARGIN = 26;

/** The curves of a file; of a set one at a time. */
export function Graphs({ studio, file, curves }: { studio: Studio; file: string; curves: Curve[] }) {
  const [chosen, choose] = useState(0);
  const index = Math.min(chosen, curves.length - 1);
  return (
    <>
      {curves.length > 1 && (
        <select id="curve" class="chip" aria-label={`Curve of ${file}`} value={index} onChange={(event) => choose(Number(event.currentTarget.value))}>
          {curves.map(({ name }, i) => <option key={i} value={i}>{name || `curve ${i + 1}`}</option>)}
        </select>
      )}
      <Graph key={index} studio={studio} file={file} curve={curves[index]} />
    </>
  );
}

function Graph({ studio, file, curve }: { studio: Studio; file: string; curve: Curve }) {
  const place = useRef<SVGSVGElement>(null);
  const [held, setHeld] = useState<{ index: number; frame: number[] } | null>(null);
  const line = spline(curve);
  const all = [...line, ...curve.points.map(({ x, y }) => [x, y])];
  const ends = (values: number[]) => [Math.min(...values), Math.max(...values)];
  const [left, right] = curve.isFunction ? [0, 1] : ends(all.map(([x]) => x));
  const [low, high] = ends([...all.map(([, y]) => y), ...(curve.isFunction ? [0, 1] : [])]);
  // the frame stays while a point moves
  const [x0, x1, y0, y1] = held?.frame ?? [left, right, low - 0.08 * (high - low), high + 0.08 * (high - low)];
  const toX = (x: number) => MARGIN + ((x - x0) / (x1 - x0 || 1)) * (WIDTH - 2 * MARGIN);
  const toY = (y: number) => HEIGHT - MARGIN - ((y - y0) / (y1 - y0 || 1)) * (HEIGHT - 2 * MARGIN);
  const move = (index: number, x: number, y: number) => studio.act(() => studio.editContinuously(file, withPoint(studio.document.files[file], curve, index, x, y)));
  const dragged = (event: PointerEvent) => {
    if (held) {
      const box = place.current!.getBoundingClientRect();
      const px = ((event.clientX - box.left) / box.width) * WIDTH;
      const py = ((event.clientY - box.top) / box.height) * HEIGHT;
      move(held.index, x0 + ((px - MARGIN) / (WIDTH - 2 * MARGIN)) * (x1 - x0), y0 + ((HEIGHT - MARGIN - py) / (HEIGHT - 2 * MARGIN)) * (y1 - y0));
    }
  };
  const steps: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };
  const ticks = [y0, (y0 + y1) / 2, y1];
  return (
    <svg ref={place} class="graph" viewBox={`0 0 ${WIDTH} ${HEIGHT}`} onPointerMove={dragged} onPointerUp={() => setHeld(null)} role="group" aria-label={`Curve of ${file}`}>
      {ticks.map((y) => (
        <g key={y}>
          <line x1={MARGIN} x2={WIDTH - MARGIN} y1={toY(y)} y2={toY(y)} class="tick" />
          <text x={3} y={toY(y) + 3}>{Number(y.toPrecision(2))}</text>
        </g>
      ))}
      <polyline class="frame" points={curve.points.map(({ x, y }) => `${toX(x)},${toY(y)}`).join(" ")} />
      <polyline class="curve" points={line.map(([x, y]) => `${toX(x)},${toY(y)}`).join(" ")} />
      {curve.points.map(({ x, y }, i) => (
        <circle key={i} cx={toX(x)} cy={toY(y)} r={6} tabIndex={0} role="slider" aria-label={`Point ${i + 1}`} aria-valuenow={y} aria-valuetext={`${x}, ${y}`}
          onPointerDown={(event) => { place.current!.setPointerCapture(event.pointerId); setHeld({ index: i, frame: [x0, x1, y0, y1] }); }}
          onKeyDown={(event) => {
            const step = steps[event.key];
            if (step) {
              event.preventDefault();
              event.stopPropagation();
              move(i, x + step[0] * 0.01 * (x1 - x0), y + step[1] * 0.01 * (y1 - y0));
            }
          }} />
      ))}
    </svg>
  );
}
