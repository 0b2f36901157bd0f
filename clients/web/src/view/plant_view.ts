// A page with the geometry of a plant: one frame, or several frames with a slider and a button that plays the growth.
import { Box3 } from "three";
import type { Object3D } from "three";
import { PlantScene, boxOf } from "./plant_scene.js";

function bytesOf(base64: string): ArrayBuffer {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) {
    bytes[i] = text.charCodeAt(i);
  }
  return bytes.buffer;
}

/** Shows frames (base64 texts of .glb files) in an element. Several frames get a slider and a button that plays them. */
export async function showPlant(element: HTMLElement, frames: string[], background = "#f7f7f2"): Promise<void> {
  const fail = (text: string) => {
    element.textContent = text;
    element.dataset.state = "failed";
  };
  let view: PlantScene;
  try {
    view = new PlantScene(element, background);
  } catch (error) {
    fail(`This page cannot draw: WebGL is not available (${(error as Error).message}).`);
    return;
  }
  const plants: Object3D[] = [];
  const whole = new Box3();
  for (const frame of frames) {
    try {
      plants.push(await view.read(bytesOf(frame)));
    } catch (error) {
      fail(`The plant cannot be read: ${(error as Error).message}`);
      return;
    }
    whole.union(boxOf(plants[plants.length - 1]));
  }
  const show = (index: number) => view.show(plants[index], true);
  if (plants.length > 1) {
    addPlayer(element, plants.length, show);
  }
  view.fit(whole);
  show(plants.length - 1);
  element.dataset.state = "shown";
}

function addPlayer(element: HTMLElement, count: number, show: (index: number) => void): void {
  const bar = document.createElement("div");
  bar.style.cssText = "position:absolute;left:12px;right:12px;bottom:10px;display:flex;gap:10px;font:13px sans-serif";
  const button = document.createElement("button");
  button.textContent = "Grow";
  const slider = document.createElement("input");
  slider.type = "range";
  slider.max = String(count - 1);
  slider.value = slider.max;
  slider.style.flex = "1";
  const label = document.createElement("span");
  const go = (index: number) => {
    slider.value = String(index);
    label.textContent = `${index + 1} of ${count}`;
    show(index);
  };
  label.textContent = `${count} of ${count}`;
  slider.addEventListener("input", () => go(Number(slider.value)));
  let timer: ReturnType<typeof setInterval> | undefined;
  button.addEventListener("click", () => {
    clearInterval(timer);
    let index = 0;
    go(0);
    timer = setInterval(() => {
      index += 1;
      go(index);
      if (index === count - 1) {
        clearInterval(timer);
      }
    }, 400);
  });
  bar.append(button, slider, label);
  element.append(bar);
}
