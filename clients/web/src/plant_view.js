// A plant in a page: a binary glTF file, a camera that fits it, and a mouse that turns it.
import {
  AmbientLight,
  Box3,
  Color,
  DirectionalLight,
  DoubleSide,
  HemisphereLight,
  PerspectiveCamera,
  Scene,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) {
    bytes[i] = text.charCodeAt(i);
  }
  return bytes.buffer;
}

function addLights(scene) {
  scene.add(new HemisphereLight(0xffffff, 0x8a7f6a, 1.6), new AmbientLight(0xffffff, 0.4));
  const sun = new DirectionalLight(0xffffff, 2.2);
  sun.position.set(-0.6, 1, 0.8);
  scene.add(sun);
}

// far enough that the whole box is in view, from a little above
function fit(camera, controls, box) {
  const centre = box.getCenter(new Vector3());
  const size = box.getSize(new Vector3());
  const slope = Math.tan((camera.fov * Math.PI) / 360);
  const radius = Math.max(size.length() / 2, 1e-6);
  // the camera may be turned about the vertical: the box is as wide as its diagonal
  const width = Math.hypot(size.x, size.z);
  const distance = 1.08 * Math.max(size.y / 2 / slope, width / 2 / slope / camera.aspect, radius) + width / 2;
  camera.position.copy(centre).add(new Vector3(0, 0.18, 1).normalize().multiplyScalar(distance));
  camera.near = distance / 100;
  camera.far = distance + 20 * radius;
  camera.updateProjectionMatrix();
  controls.target.copy(centre);
  controls.update();
}

/** Shows frames (base64 texts of .glb files) in an element; more than one get a slider and a button that plays them. */
export async function showPlant(element, frames, background = "#f7f7f2") {
  const say = (text) => {
    element.textContent = text;
    element.dataset.state = "failed";
  };
  let renderer;
  try {
    renderer = new WebGLRenderer({ antialias: true });
  } catch (error) {
    say(`This page cannot draw: WebGL is not available (${error.message}).`);
    return;
  }
  const scene = new Scene();
  scene.background = new Color(background);
  addLights(scene);
  const camera = new PerspectiveCamera(35, element.clientWidth / element.clientHeight, 0.01, 1000);
  const controls = new OrbitControls(camera, renderer.domElement);
  renderer.setPixelRatio(window.devicePixelRatio);
  renderer.setSize(element.clientWidth, element.clientHeight);
  element.append(renderer.domElement);
  const draw = () => renderer.render(scene, camera);

  const loader = new GLTFLoader();
  const plants = [];
  const whole = new Box3();
  for (const frame of frames) {
    let gltf;
    try {
      gltf = await loader.parseAsync(bytesOf(frame), "");
    } catch (error) {
      say(`The plant cannot be read: ${error.message}`);
      return;
    }
    gltf.scene.traverse((object) => {
      for (const material of object.isMesh ? [object.material].flat() : []) {
        material.side = DoubleSide; // leaves have two sides
      }
    });
    plants.push(gltf.scene);
    whole.union(new Box3().setFromObject(gltf.scene));
  }
  let shown = -1;
  const show = (index) => {
    if (shown >= 0) {
      scene.remove(plants[shown]);
    }
    scene.add(plants[index]);
    shown = index;
    draw();
  };
  if (plants.length > 1) {
    addPlayer(element, plants.length, show);
  }
  fit(camera, controls, whole);
  controls.addEventListener("change", draw);
  new ResizeObserver(() => {
    camera.aspect = element.clientWidth / element.clientHeight;
    camera.updateProjectionMatrix();
    renderer.setSize(element.clientWidth, element.clientHeight);
    draw();
  }).observe(element);
  show(plants.length - 1);
  element.dataset.state = "shown";
}

function addPlayer(element, count, show) {
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
  const go = (index) => {
    slider.value = String(index);
    label.textContent = `step ${index} of ${count - 1}`;
    show(index);
  };
  label.textContent = `step ${count - 1} of ${count - 1}`;
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
