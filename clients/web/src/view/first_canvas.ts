import { canvasToDraw } from "./canvas.js";

/** The canvas of the page's first view: it is there before the libraries of the page have run. */
export const firstCanvas = canvasToDraw();
