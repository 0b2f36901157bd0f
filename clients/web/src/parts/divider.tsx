// Between the text and the plant: dragged or moved with the arrow keys it changes the width of the text; its button hides the text.
import { useState } from "preact/hooks";

const NARROWEST = 200; // pixels
const WIDEST_SHARE = 0.7; // of the window
const KEY_STEP = 24; // pixels

const widest = () => Math.round(innerWidth * WIDEST_SHARE);

function kept(): number | null {
  try {
    return Number(localStorage.getItem("text-width")) || null;
  } catch {
    return null;
  }
}

/** The width of the text in pixels that the user chose; null: as the page thinks best. It stays in this browser. */
export function useTextWidth(): [number | null, (width: number | null) => void] {
  const [width, setWidth] = useState(kept());
  const change = (next: number | null) => {
    const bounded = next === null ? null : Math.min(Math.max(Math.round(next), NARROWEST), widest());
    setWidth(bounded);
    try {
      bounded === null ? localStorage.removeItem("text-width") : localStorage.setItem("text-width", String(bounded));
    } catch {
      // a page without storage forgets the choice
    }
  };
  return [width, change];
}

export function Divider({ isTextShown, onFold, onWidth }: { isTextShown: boolean; onFold: () => void; onWidth: (width: number | null) => void }) {
  const now = () => Math.round(document.querySelector(".text")?.getBoundingClientRect().width ?? NARROWEST);
  const dragged = (event: PointerEvent) => {
    if ((event.currentTarget as Element).hasPointerCapture(event.pointerId)) {
      onWidth(event.clientX);
    }
  };
  const pressed = (event: KeyboardEvent) => {
    const step = event.key === "ArrowLeft" ? -KEY_STEP : event.key === "ArrowRight" ? KEY_STEP : 0;
    if (step !== 0) {
      event.preventDefault();
      event.stopPropagation();
      onWidth(now() + step);
    }
  };
  return (
    <div class="divider">
      {isTextShown && (
        <div role="separator" tabIndex={0} aria-orientation="vertical" aria-label="Width of the text" aria-valuenow={now()} aria-valuemin={NARROWEST} aria-valuemax={widest()}
          title="Drag: width of the text. Double click: as usual"
          onPointerDown={(event) => { event.preventDefault(); event.currentTarget.setPointerCapture(event.pointerId); }}
          onPointerMove={dragged} onDblClick={() => onWidth(null)} onKeyDown={pressed} />
      )}
      <button type="button" class="fold" aria-label={isTextShown ? "Hide the text" : "Show the text"} title={isTextShown ? "Hide the text" : "Show the text"} onClick={onFold}>{isTextShown ? "‹" : "›"}</button>
    </div>
  );
}
