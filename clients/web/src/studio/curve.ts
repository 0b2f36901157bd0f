// Functions and contours of model folders: control points in a text, and the curve that they make.

export interface ControlPoint {
  x: number;
  y: number;
  multiplicity: number;
  at: Array<{ from: number; to: number }>; // of the texts of x and y
}

export interface Curve {
  name: string;
  isFunction: boolean; // x runs from 0 to 1
  isClosed: boolean;
  points: ControlPoint[];
}

const HEAD = /^[ \t]*points:[ \t]*(\d+)[^\n]*\n/m;
// a set has several, each with a head of its own
const SET_ENTRY = /^[ \t]*[fc]ver\b/gm;

/** The curves of a function, contour or curve file, or of a set of them; none when the text is none of these. */
export function parseCurves(name: string, text: string): Curve[] {
  const suffix = /\.(func|fset|con|cset|crv|curve)$/.exec(name)?.[1];
  if (!suffix) {
    return [];
  }
  const begins = suffix.endsWith("set") ? [...text.matchAll(SET_ENTRY)].map(({ index }) => index) : [0];
  return begins.map((begin, i) => parseCurve(text, begin, begins[i + 1] ?? text.length, suffix.startsWith("f"))).filter((curve) => curve !== null);
}

/** The curve between two places of a text. */
function parseCurve(text: string, begin: number, end: number, isFunction: boolean): Curve | null {
  const part = text.slice(begin, end);
  const head = HEAD.exec(part);
  if (!head) {
    return null;
  }
  // what follows `points:` in contours: type and samples
  const points: ControlPoint[] = [];
  const row = /^[ \t]*([-+]?[\d.]+(?:[eE][-+]?\d+)?)([ \t]+)([-+]?[\d.]+(?:[eE][-+]?\d+)?)([ \t]+[-+.\deE]+)?([ \t]+\d+)?[ \t]*\r?$/gm;
  row.lastIndex = head.index + head[0].length;
  for (let match = row.exec(part); match && points.length < Number(head[1]); match = row.exec(part)) {
    const indent = match[0].length - match[0].trimStart().length;
    const x = begin + match.index + indent;
    const y = x + match[1].length + match[2].length;
    const last = isFunction ? match[4] : match[5];
    points.push({
      x: Number(match[1]),
      y: Number(match[3]),
      multiplicity: last ? Number(last) : 1,
      at: [{ from: x, to: x + match[1].length }, { from: y, to: y + match[3].length }],
    });
  }
  const title = /^[ \t]*name:[ \t]*(.*?)[ \t]*\r?$/m.exec(part)?.[1] ?? "";
  return points.length >= 2 ? { name: title, isFunction, isClosed: /^type:\s*c/m.test(part), points } : null;
}

const short = (value: number): string => String(Number(value.toFixed(4)));

/** The text after a control point has moved: only its two numbers change. */
export function withPoint(text: string, curve: Curve, index: number, x: number, y: number): string {
  const { points, isFunction } = curve;
  const point = points[index];
  let to = x;
  if (isFunction) {
    // the ends stay, and x does not pass a neighbour
    const isEnd = index === 0 || index === points.length - 1;
    to = isEnd ? point.x : Math.min(Math.max(x, points[index - 1].x), points[index + 1].x);
  }
  const [ofX, ofY] = point.at;
  const written = to === point.x ? text.slice(ofX.from, ofX.to) : short(to);
  return text.slice(0, ofX.from) + written + text.slice(ofX.to, ofY.from) + short(y) + text.slice(ofY.to);
}

/** Points of the cubic B-spline: open with fourfold end knots for a function, uniform for a contour. */
export function spline({ points, isFunction, isClosed }: Curve, samples = 160): Array<[number, number]> {
  let control = points.flatMap(({ x, y, multiplicity }) => Array.from({ length: multiplicity }, () => [x, y] as [number, number]));
  if (isClosed) {
    control = [...control, ...control.slice(0, 3)];
  }
  if (control.length < 4) {
    return control;
  }
  const spans = control.length - 3;
  const knots = Array.from({ length: control.length + 4 }, (_, i) => (isFunction ? Math.min(Math.max(i - 3, 0), spans) : i - 3));
  return Array.from({ length: samples + 1 }, (_, i) => {
    const t = (i / samples) * spans;
    const k = Math.min(Math.floor(t), spans - 1) + 3;
    // de Boor, 1972
    const d = [0, 1, 2, 3].map((j) => [...control[j + k - 3]] as [number, number]);
    for (let r = 1; r <= 3; ++r) {
      for (let j = 3; j >= r; --j) {
        const low = knots[j + k - 3];
        const high = knots[j + 1 + k - r];
        const a = high > low ? (t - low) / (high - low) : 0;
        d[j] = [d[j - 1][0] + a * (d[j][0] - d[j - 1][0]), d[j - 1][1] + a * (d[j][1] - d[j - 1][1])];
      }
    }
    return d[3];
  });
}
