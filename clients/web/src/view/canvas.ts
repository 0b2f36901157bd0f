// The canvas of a view. This file imports nothing: the page asks for the graphics card before it runs anything else.

export const CONTEXT = { antialias: true, alpha: true, preserveDrawingBuffer: true };

/** A canvas whose graphics card has been asked for: the card answers while the page is made. */
export function canvasToDraw(): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("webgl2", CONTEXT) as WebGL2RenderingContext | null;
  context?.flush();
  return canvas;
}
