// A photograph behind the plant, as high as the person says, to fit a model to it. It stays in the page.
import { useEffect, useRef, useState } from "preact/hooks";
import type { Studio } from "../studio/studio.js";
import { IconButton } from "./icons.js";

export function Photograph({ studio }: { studio: Studio }) {
  const image = useRef<HTMLImageElement>(null);
  const [url, setUrl] = useState("");
  const [height, setHeight] = useState(1);
  const [strength, setStrength] = useState(1);
  const [way, setWay] = useState([0, 0]); // of its foot from the plant's, in world units
  const view = studio.view;
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
    // it stands where the plant stands, and turns with nothing
    const place = () => {
      const element = image.current;
      if (element) {
        const { x, y, unitsPerPixel } = view.foot();
        const pixels = height / unitsPerPixel;
        Object.assign(element.style, { height: `${pixels}px`, left: `${x + way[0] / unitsPerPixel}px`, top: `${y - way[1] / unitsPerPixel - pixels}px` });
      }
    };
    view.onDrawn = place;
    place();
    return () => (view.onDrawn = () => {});
  }, [view, url, height, way]);
  const moved = (event: PointerEvent) => {
    if ((event.currentTarget as Element).hasPointerCapture(event.pointerId)) {
      const { unitsPerPixel } = view!.foot();
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
  return (
    <>
      {url && <img ref={image} class="photograph" src={url} alt="Photograph behind the plant" style={{ opacity: strength }} />}
      <div class="photograph-tools">
        {!url && (
          <label class="chip" title="A photograph behind the plant. It stays in this page.">
            photograph …
            <input id="photograph" type="file" accept="image/*" class="hidden" onChange={(event) => choose(event.currentTarget.files?.[0])} />
          </label>
        )}
        {url && (
          <>
            <label class="chip">photograph is <input id="photograph-height" type="number" min={0} step="any" value={height} onInput={(event) => event.currentTarget.valueAsNumber > 0 && setHeight(event.currentTarget.valueAsNumber)} /> high</label>
            <button type="button" id="photograph-move" class="chip" title="Drag, or press arrow keys, to move the photograph" onPointerDown={(event) => event.currentTarget.setPointerCapture(event.pointerId)} onPointerMove={moved} onKeyDown={shifted}>move</button>
            <label class="chip">strength <input type="range" min={0.1} max={1} step={0.05} value={strength} onInput={(event) => setStrength(event.currentTarget.valueAsNumber)} /></label>
            <IconButton icon="close" label="Remove the photograph" onClick={() => { URL.revokeObjectURL(url); setUrl(""); setWay([0, 0]); }} />
          </>
        )}
      </div>
    </>
  );
}
