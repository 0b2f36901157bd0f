// A photograph behind the plant, as high as the person says, to fit a model to it. It stays in the page.
import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import type { Studio } from "../studio/studio.js";
import { IconButton } from "./icons.js";
import { Measured, Protractor, apart, pointsIn } from "./measure.js";
import type { Point } from "./measure.js";

/** The overlay of the view, and the tools; `isUsed`: there is a photograph, or somebody measures. */
export function usePhotograph(studio: Studio): { overlay: JSX.Element; tools: JSX.Element; isUsed: boolean } {
  const image = useRef<HTMLImageElement>(null);
  const [url, setUrl] = useState("");
  const [height, setHeight] = useState(1);
  const [strength, setStrength] = useState(1);
  const [way, setWay] = useState<Point>([0, 0]); // of its foot from the plant's, in world units
  const [plantStrength, setPlantStrength] = useState(1);
  const [points, setPoints] = useState<Point[] | null>(null); // of ruler and protractor, world units from the plant's foot
  const [, viewMoved] = useState("");
  const [isHeld, setHeld] = useState(false); // drags in the view move the photograph instead of the camera
  const dragged = useRef(0); // pixels since the button was pressed
  const view = studio.view;
  const hasPoints = points !== null;
  const isUsed = url !== "" || hasPoints;
  const choose = (file: File | undefined) => {
    if (file && view) {
      URL.revokeObjectURL(url);
      setUrl(URL.createObjectURL(file));
      setHeight(Number(view.plantHeight().toPrecision(3)));
    }
  };
  useEffect(() => {
    if (!view) {
      return;
    }
    view.setBackground(url === "");
    view.holdFoot(isUsed);
    view.photograph = url ? image.current : null;
    // it stands where the plant stood when it came, and turns with nothing
    const place = () => {
      const element = image.current;
      const { x, y, unitsPerPixel } = view.foot();
      if (hasPoints) {
        viewMoved([x, y, unitsPerPixel].map((value) => value.toPrecision(6)).join(" "));
      }
      if (element) {
        const pixels = height / unitsPerPixel;
        Object.assign(element.style, { height: `${pixels}px`, left: `${x + way[0] / unitsPerPixel}px`, top: `${y - way[1] / unitsPerPixel - pixels}px` });
      }
    };
    view.onDrawn = place;
    place();
    return () => (view.onDrawn = () => {});
  }, [view, url, height, way, hasPoints]);
  const moved = (event: PointerEvent) => {
    if ((event.currentTarget as Element).hasPointerCapture(event.pointerId)) {
      const { unitsPerPixel } = view!.foot();
      dragged.current += Math.abs(event.movementX) + Math.abs(event.movementY);
      setWay(([x, y]) => [x + event.movementX * unitsPerPixel, y - event.movementY * unitsPerPixel]);
    }
  };
  const STEPS: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  const shifted = (event: KeyboardEvent) => {
    const step = STEPS[event.key];
    if (step) {
      event.preventDefault();
      event.stopPropagation();
      setWay(([x, y]) => [x + step[0] * 0.01 * height, y + step[1] * 0.01 * height]);
    }
  };
  useEffect(() => {
    if (view) {
      view.renderer.domElement.style.opacity = String(url ? plantStrength : 1);
    }
  }, [view, url, plantStrength]);
  const putPoint = (which: number, place: Point) => setPoints((now) => now && now.map((point, i) => (i === which ? place : point)));
  // the first leg gets a length: the photograph grows with it, about the vertex
  const scaled = ([end, vertex]: Point[], length: number) => {
    const ratio = length / apart(end, vertex);
    if (Number.isFinite(ratio)) {
      const from = ([x, y]: Point): Point => [vertex[0] + (x - vertex[0]) * ratio, vertex[1] + (y - vertex[1]) * ratio];
      setHeight(Number((height * ratio).toPrecision(6)));
      setWay(from);
      putPoint(0, from(end));
    }
  };
  const hold = (event: PointerEvent) => {
    dragged.current = 0;
    (event.currentTarget as Element).setPointerCapture(event.pointerId);
  };
  const overlay = (
    <>
      {url && <img ref={image} class="photograph" src={url} alt="Photograph behind the plant" style={{ opacity: strength }} />}
      {url && isHeld && <div id="photograph-hold" onPointerDown={hold} onPointerMove={moved} />}
      {view && points && <Protractor view={view} points={points} onPoint={putPoint} />}
    </>
  );
  const tools = (
    <div class={`photograph-tools ${isUsed ? "" : "floating"}`}>
      {view && <label class="chip" title="A ruler and a protractor (M)"><input id="measure" type="checkbox" checked={points !== null} onChange={(event) => setPoints(event.currentTarget.checked ? pointsIn(view) : null)} />measure</label>}
      {view && points && <Measured points={points} onLength={url ? (length) => scaled(points, length) : undefined} />}
      {!url && (
        <label class="chip" title="A photograph behind the plant. It stays in this page.">
          photograph …
          <input id="photograph" type="file" accept="image/*" class="hidden" onChange={(event) => choose(event.currentTarget.files?.[0])} />
        </label>
      )}
      {url && (
        <>
          <label class="chip">photograph is <input id="photograph-height" type="number" min={0} step="any" value={height} onInput={(event) => event.currentTarget.valueAsNumber > 0 && setHeight(event.currentTarget.valueAsNumber)} /> high</label>
          <button type="button" id="photograph-move" class="chip" aria-pressed={isHeld} title="Press it and drag the photograph in the view; or drag this button, or press arrow keys" onPointerDown={hold} onPointerMove={moved} onKeyDown={shifted} onClick={() => dragged.current < 4 && setHeld(!isHeld)}>move</button>
          <label class="chip" title="How see-through the photograph is">photograph <input type="range" min={0.1} max={1} step={0.05} value={strength} onInput={(event) => setStrength(event.currentTarget.valueAsNumber)} /></label>
          <label class="chip" title="How see-through the plant is">plant <input id="plant-strength" type="range" min={0.1} max={1} step={0.05} value={plantStrength} onInput={(event) => setPlantStrength(event.currentTarget.valueAsNumber)} /></label>
          <IconButton icon="close" label="Remove the photograph" onClick={() => { URL.revokeObjectURL(url); setUrl(""); setWay([0, 0]); setHeld(false); }} />
        </>
      )}
    </div>
  );
  return { overlay, tools, isUsed };
}
