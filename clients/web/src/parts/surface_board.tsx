// Draws the patches of a surface file, from any side; its control points are dragged in the plane of the picture.
import { useRef, useState } from "preact/hooks";
import type { Studio } from "../studio/studio.js";
import { pointsAt, samplesOf, withPoints } from "../studio/surface.js";
import type { Surface, SurfacePoint, Vector } from "../studio/surface.js";

const WIDTH = 360;
const HEIGHT = 260;
const MARGIN = 22;
const SIDES: Array<[string, number, number]> = [["front", 0, 0], ["side", 90, 0], ["top", 0, 90], ["oblique", 35, 25]];
const MOST_SQUARES = 1500;

const dot = (a: Vector, b: Vector): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a: Vector, b: Vector): Vector => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const difference = (a: Vector, b: Vector): Vector => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

/** Right, up and towards the person, for angles in degrees. */
function axesOf(yaw: number, pitch: number): [Vector, Vector, Vector] {
  const [y, p] = [(yaw * Math.PI) / 180, (pitch * Math.PI) / 180];
  const right: Vector = [Math.cos(y), 0, -Math.sin(y)];
  const towards: Vector = [Math.sin(y) * Math.cos(p), Math.sin(p), Math.cos(y) * Math.cos(p)];
  return [right, cross(towards, right), towards];
}

interface Frame {
  centre: Vector;
  pixels: number; // of a unit
}

function frameOf({ patches, contact, end }: Surface): Frame {
  const places = [contact, end, ...patches.flatMap(({ points }) => points.map(({ place }) => place))];
  const low = [0, 1, 2].map((axis) => Math.min(...places.map((place) => place[axis])));
  const high = [0, 1, 2].map((axis) => Math.max(...places.map((place) => place[axis])));
  const [x, y, z] = high.map((value, axis) => Math.max(value - low[axis], 1e-9));
  // it fits from every side
  const pixels = Math.min((WIDTH - 2 * MARGIN) / Math.max(x, z), (HEIGHT - 2 * MARGIN) / Math.max(y, z));
  return { centre: low.map((value, axis) => (value + high[axis]) / 2) as Vector, pixels };
}

interface Held {
  points: SurfacePoint[] | null; // null: the picture turns
  place: Vector;
  begin: [number, number]; // of the mouse, in the picture
  sides: [number, number];
  text: string;
  frame: Frame;
}

export function SurfaceBoard({ studio, file, surface }: { studio: Studio; file: string; surface: Surface }) {
  const place = useRef<SVGSVGElement>(null);
  const [[yaw, pitch], turn] = useState<[number, number]>([0, 0]);
  const [held, setHeld] = useState<Held | null>(null);
  const [right, up, towards] = axesOf(yaw, pitch);
  // the frame stays while a point moves
  const frame = held?.frame ?? frameOf(surface);
  const { centre, pixels } = frame;
  const drawn = (point: Vector): [number, number] => {
    const from = difference(point, centre);
    return [WIDTH / 2 + dot(from, right) * pixels, HEIGHT / 2 - dot(from, up) * pixels];
  };
  const mouse = (event: PointerEvent): [number, number] => {
    const box = place.current!.getBoundingClientRect();
    const scale = Math.min(box.width / WIDTH, box.height / HEIGHT);
    return [(event.clientX - box.left - (box.width - WIDTH * scale) / 2) / scale, (event.clientY - box.top - (box.height - HEIGHT * scale) / 2) / scale];
  };
  const moved = (from: Vector, dx: number, dy: number): Vector => from.map((value, axis) => value + (dx * right[axis] + dy * up[axis]) / pixels) as Vector;
  const write = (text: string, points: SurfacePoint[], to: Vector) => {
    const changed = withPoints(text, points, to);
    if (changed !== studio.document.files[file]) {
      void studio.act(() => studio.editContinuously(file, changed));
    }
  };
  const hold = (event: PointerEvent, point: SurfacePoint | null) => {
    event.stopPropagation();
    place.current!.setPointerCapture(event.pointerId);
    // points at one place are one point, unless Alt is pressed
    const points = point && (event.altKey ? [point] : pointsAt(surface, point.place));
    setHeld({ points, place: point?.place ?? [0, 0, 0], begin: mouse(event), sides: [yaw, pitch], text: studio.document.files[file], frame });
  };
  const dragged = (event: PointerEvent) => {
    if (!held) {
      return;
    }
    const [x, y] = mouse(event);
    const [dx, dy] = [x - held.begin[0], y - held.begin[1]];
    if (held.points) {
      write(held.text, held.points, moved(held.place, dx, -dy));
    } else {
      turn([held.sides[0] - dx * 0.6, Math.max(-90, Math.min(90, held.sides[1] + dy * 0.6))]);
    }
  };
  const STEPS: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };
  const count = Math.max(2, Math.min(8, Math.floor(Math.sqrt(MOST_SQUARES / surface.patches.length))));
  const squares = surface.patches.flatMap(({ points }) => {
    const rows = samplesOf(points, count);
    return rows.slice(1).flatMap((row, i) =>
      row.slice(1).map((corner, j) => {
        const corners = [rows[i][j], rows[i][j + 1], corner, row[j]];
        const normal = cross(difference(corners[2], corners[0]), difference(corners[3], corners[1]));
        const length = Math.sqrt(dot(normal, normal)) || 1;
        return { corners, depth: corners.reduce((sum, one) => sum + dot(one, towards), 0), light: Math.abs(dot(normal, towards)) / length };
      }),
    );
  });
  squares.sort((a, b) => a.depth - b.depth);
  // the nearest points are drawn last, so that they are the ones that are caught
  const handles = surface.patches.flatMap(({ name, points }) => points.map((point, i) => ({ point, i, label: `Point ${i + 1} of ${name}` })));
  handles.sort((a, b) => dot(a.point.place, towards) - dot(b.point.place, towards));
  return (
    <div class="surface">
      <div class="row">
        {SIDES.map(([name, y, p]) => <button type="button" key={name} class="chip" aria-pressed={y === yaw && p === pitch} onClick={() => turn([y, p])}>{name}</button>)}
        <span class="quiet">Drag a point, or beside it to turn. Alt: only one of several at a place.</span>
      </div>
      <svg ref={place} class="graph" viewBox={`0 0 ${WIDTH} ${HEIGHT}`} role="group" aria-label={`Surface of ${file}`}
        onPointerDown={(event) => hold(event, null)} onPointerMove={dragged} onPointerUp={() => setHeld(null)} onPointerCancel={() => setHeld(null)}>
        {squares.map(({ corners, light }, i) => <polygon key={i} class="square" style={{ fillOpacity: 0.25 + 0.55 * light }} points={corners.map((one) => drawn(one).join(",")).join(" ")} />)}
        {surface.patches.map(({ name, points }) =>
          [0, 1, 2, 3].flatMap((k) => [points.slice(4 * k, 4 * k + 4), points.filter((_, i) => i % 4 === k)]).map((line, k) => (
            <polyline key={`${name} ${k}`} class="frame" points={line.map((one) => drawn(one.place).join(",")).join(" ")} />
          )),
        )}
        {([["contact", surface.contact], ["end", surface.end]] as const).map(([name, point]) => {
          const [x, y] = drawn(point);
          return <path key={name} class="mark" d={`M${x - 5} ${y}h10M${x} ${y - 5}v10`}><title>{name} point</title></path>;
        })}
        {handles.map(({ point, i, label }) => {
          const [x, y] = drawn(point.place);
          return (
            <circle key={`${label} ${i}`} cx={x} cy={y} r={5} tabIndex={0} role="slider" aria-label={label} aria-valuenow={point.place[1]} aria-valuetext={point.place.join(", ")}
              onPointerDown={(event) => hold(event, point)}
              onKeyDown={(event) => {
                const step = STEPS[event.key];
                if (step) {
                  event.preventDefault();
                  event.stopPropagation();
                  write(studio.document.files[file], event.altKey ? [point] : pointsAt(surface, point.place), moved(point.place, 3 * step[0], 3 * step[1]));
                }
              }}>
              <title>{label}: {point.place.join(", ")}</title>
            </circle>
          );
        })}
      </svg>
    </div>
  );
}
