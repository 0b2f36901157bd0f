// When the page is drawn anew.
import { useEffect, useReducer } from "preact/hooks";
import type { Studio } from "../studio/studio.js";
import { nextFrame, onNextFrame } from "../view/frames.js";

// for two pictures of the browser
const SLOW_MILLISECONDS = 80;
const LOOK_MILLISECONDS = 100;

/**
 * Draws a part of the page anew after changes; many changes make one picture. A part that is patient waits while a slider moves, if the
 * browser needs long for its pictures: without a graphics card the page costs it more than the plant.
 */
export function useChanges(studio: Studio, isPatient = false): void {
  const [, redraw] = useReducer((count: number) => count + 1, 0);
  useEffect(() => {
    let isWaiting = false;
    let isSlow = false;
    const draw = () =>
      onNextFrame(() => {
        isWaiting = false;
        redraw(undefined);
        if (isPatient) {
          const begin = performance.now();
          void nextFrame().then(nextFrame).then(() => (isSlow = performance.now() - begin > SLOW_MILLISECONDS));
        }
      });
    const drawAtRest = () => void (isSlow && studio.isSliding ? setTimeout(drawAtRest, LOOK_MILLISECONDS) : draw());
    const end = studio.subscribe(() => {
      if (!isWaiting) {
        isWaiting = true;
        void studio.frames.withPlant().then(isPatient ? drawAtRest : draw);
      }
    });
    redraw(undefined); // of what has come since the first drawing
    return end;
  }, []);
}
