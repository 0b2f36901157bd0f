// A page with the geometry of a plant: one frame, or several frames with a slider and a button that plays the growth.
import { Box3 } from "three";
import { readFrame } from "./plant_frames.js";
import { PlantScene, boxOf } from "./plant_scene.js";

/** Shows frames (base64 texts of .glb files, which may be packed) in an element. Several frames get a slider and a button that plays them. */
export async function showPlant(element, frames, background = "#f7f7f2") {
  const fail = (text) => {
    element.textContent = text;
    element.dataset.state = "failed";
  };
  let view;
  try {
    view = new PlantScene(element, background);
  } catch (error) {
    fail(`This page cannot draw: WebGL is not available (${error.message}).`);
    return;
  }
  const plants = [];
  const whole = new Box3();
  for (const frame of frames) {
    try {
      plants.push(await view.read(await readFrame(frame)));
    } catch (error) {
      fail(`The plant cannot be read: ${error.message}`);
      return;
    }
    whole.union(boxOf(plants[plants.length - 1]));
  }
  const show = (index) => view.show(plants[index], true);
  if (plants.length > 1) {
    addPlayer(element, plants.length, show);
  }
  view.fit(whole);
  show(plants.length - 1);
  element.dataset.state = "shown";
}

function addPlayer(element, count, show) {
  const bar = document.createElement("div");
  bar.style.cssText = "position:absolute;left:12px;right:12px;bottom:10px;display:flex;gap:10px;align-items:center;padding:6px 10px;border-radius:8px;background:rgba(255,255,255,0.82);color:#222;font:13px sans-serif";
  const button = document.createElement("button");
  button.textContent = "Grow";
  button.style.cssText = "font:inherit;padding:4px 14px";
  const slider = document.createElement("input");
  slider.setAttribute("aria-label", "Frame of the growth");
  slider.type = "range";
  slider.max = String(count - 1);
  slider.value = slider.max;
  slider.style.flex = "1";
  const label = document.createElement("span");
  const go = (index) => {
    slider.value = String(index);
    label.textContent = `${index + 1} of ${count}`;
    show(index);
  };
  label.textContent = `${count} of ${count}`;
  slider.addEventListener("input", () => go(Number(slider.value)));
  let timer = 0;
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
