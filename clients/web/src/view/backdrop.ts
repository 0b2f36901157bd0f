// What lies behind and below the plants: the background, a photograph, the ground that ends softly.
import { CanvasTexture, SRGBColorSpace } from "three";

/** Background, photograph and plant as they lie over each other on the page. */
export function overPhotograph(plant: HTMLCanvasElement, photograph: HTMLImageElement, isDark: boolean): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  const { width, height } = Object.assign(canvas, { width: plant.width, height: plant.height });
  const context = canvas.getContext("2d")!;
  const [view, seen] = [plant, photograph].map((element) => element.getBoundingClientRect());
  const scale = width / view.width;
  context.drawImage(backgroundCanvas(isDark), 0, 0, width, height);
  context.globalAlpha = Number(photograph.style.opacity || 1);
  context.drawImage(photograph, (seen.left - view.left) * scale, (seen.top - view.top) * scale, seen.width * scale, seen.height * scale);
  context.globalAlpha = Number(plant.style.opacity || 1);
  context.drawImage(plant, 0, 0);
  return canvas;
}

function backgroundCanvas(isDark: boolean): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  canvas.width = 2;
  canvas.height = 256;
  const context = canvas.getContext("2d")!;
  const gradient = context.createLinearGradient(0, 0, 0, 256);
  const stops = isDark ? ["#1d2422", "#2a322f", "#333a35"] : ["#dfe8ea", "#f1f3ee", "#f7f5ee"];
  stops.forEach((stop, i) => gradient.addColorStop(i / 2, stop));
  context.fillStyle = gradient;
  context.fillRect(0, 0, 2, 256);
  return canvas;
}

/** As the background of a scene. */
export function backgroundTexture(isDark: boolean): CanvasTexture {
  const texture = new CanvasTexture(backgroundCanvas(isDark));
  texture.colorSpace = SRGBColorSpace;
  return texture;
}

/** White in the middle, black at the rim: the ground ends softly. */
export function fadeTexture(): CanvasTexture {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 256;
  const context = canvas.getContext("2d")!;
  const gradient = context.createRadialGradient(128, 128, 20, 128, 128, 128);
  gradient.addColorStop(0, "#fff");
  gradient.addColorStop(0.45, "#999");
  gradient.addColorStop(1, "#000");
  context.fillStyle = gradient;
  context.fillRect(0, 0, 256, 256);
  return new CanvasTexture(canvas);
}
