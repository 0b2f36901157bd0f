// A ruler and a protractor over the view: three points that a person drags. They face the camera at the depth of the plant's foot, and
// move with the picture when the camera comes nearer.
import type { View } from "../view/scene.js";

export type Point = [number, number]; // right of the plant's foot and above it, in units of the model

type Place = [x: number, y: number]; // pixels of the view, from the top left

const WAYS: Record<string, Place> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const NAMES = ["End of the first leg", "Vertex of the angle", "End of the second leg"];

export const apart = ([x, y]: Point, [x1, y1]: Point): number => Math.hypot(x1 - x, y1 - y);
const shortNumber = (value: number): string => String(Number(value.toPrecision(3)));

/** Where the three points lie at the beginning. */
export const pointsIn = (view: View): Point[] =>
  [[0.42, 0.3], [0.5, 0.6], [0.58, 0.3]].map(([x, y]) => pointAt(view, [x * view.element.clientWidth, y * view.element.clientHeight]));

function pointAt(view: View, [px, py]: Place): Point {
  const { x, y, unitsPerPixel } = view.foot();
  return [(px - x) * unitsPerPixel, (y - py) * unitsPerPixel];
}

function placeOf(view: View, [right, up]: Point): Place {
  const { x, y, unitsPerPixel } = view.foot();
  return [x + right / unitsPerPixel, y - up / unitsPerPixel];
}

/** The angle at the middle one of three points, in degrees from 0 to 180. */
export function angleAt([a, b, c]: Point[]): number {
  const [x, y, x1, y1] = [a[0] - b[0], a[1] - b[1], c[0] - b[0], c[1] - b[1]];
  return (Math.atan2(Math.abs(x * y1 - y * x1), x * x1 + y * y1) * 180) / Math.PI;
}

/** The points and the legs between them. `onPoint`: a point is put to another place. */
export function Protractor({ view, points, onPoint }: { view: View; points: Point[]; onPoint: (which: number, place: Point) => void }) {
  const { clientWidth: width, clientHeight: height } = view.element;
  const places = points.map((point) => placeOf(view, point));
  const put = (which: number, [x, y]: Place) => onPoint(which, pointAt(view, [Math.min(Math.max(x, 0), width), Math.min(Math.max(y, 0), height)]));
  const dragged = (which: number, event: PointerEvent) => {
    if ((event.currentTarget as Element).hasPointerCapture(event.pointerId)) {
      const box = view.element.getBoundingClientRect();
      put(which, [event.clientX - box.left, event.clientY - box.top]);
    }
  };
  const pressed = (which: number, event: KeyboardEvent) => {
    const way = WAYS[event.key];
    if (way) {
      event.preventDefault();
      event.stopPropagation();
      const pixels = event.shiftKey ? 10 : 1;
      put(which, [places[which][0] + way[0] * pixels, places[which][1] + way[1] * pixels]);
    }
  };
  const legs = places.map((place) => place.join(",")).join(" ");
  return (
    <>
      <svg class="measure" width={width} height={height} aria-hidden="true"><polyline class="halo" points={legs} /><polyline points={legs} /></svg>
      {places.map(([x, y], i) => (
        <button key={i} type="button" class="measure-point" style={{ left: `${x}px`, top: `${y}px` }} aria-label={`${NAMES[i]}: drag it, or press arrow keys`}
          onPointerDown={(event) => event.currentTarget.setPointerCapture(event.pointerId)} onPointerMove={(event) => dragged(i, event)} onKeyDown={(event) => pressed(i, event)} />
      ))}
    </>
  );
}

/** The measures of the points. `onLength`: a person knows the length of the thing that the first leg lies on. */
export function Measured({ points, onLength }: { points: Point[]; onLength?: (length: number) => void }) {
  const [first, second] = [apart(points[0], points[1]), apart(points[1], points[2])].map(shortNumber);
  const known = (length: number) => length > 0 && onLength?.(length);
  return (
    <>
      <output id="measured" class="chip" title="The angle, and the lengths of the first and the second leg in units of the model">{angleAt(points).toFixed(1)}° · {first} · {second}</output>
      {onLength && (
        <label class="chip" title="Lay the first leg on something in the photograph whose length you know, and write the length: the photograph gets that scale">first leg is <input id="known-length" type="number" min={0} step="any" value={first} onChange={(event) => known(event.currentTarget.valueAsNumber)} /> long</label>
      )}
    </>
  );
}
