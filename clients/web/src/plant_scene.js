// A canvas that shows plants from binary glTF files, with light, a fitting camera, and rotation by the mouse.
import {
  AmbientLight,
  Box3,
  CanvasTexture,
  CircleGeometry,
  Color,
  DirectionalLight,
  DoubleSide,
  HemisphereLight,
  Mesh,
  MeshBasicMaterial,
  PerspectiveCamera,
  Scene,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

function addLights(scene) {
  scene.add(new HemisphereLight(0xffffff, 0x8a7f6a, 1.6), new AmbientLight(0xffffff, 0.4));
  const sun = new DirectionalLight(0xffffff, 2.2);
  sun.position.set(-0.6, 1, 0.8);
  scene.add(sun);
}

// a dark middle that fades to nothing, for every spot on the ground
let shadeTexture = null;
function shade() {
  if (!shadeTexture) {
    const size = 128;
    const canvas = Object.assign(document.createElement("canvas"), { width: size, height: size });
    const context = canvas.getContext("2d");
    const gradient = context.createRadialGradient(size / 2, size / 2, 0, size / 2, size / 2, size / 2);
    gradient.addColorStop(0, "rgba(0,0,0,0.45)");
    gradient.addColorStop(0.2, "rgba(0,0,0,0.24)");
    gradient.addColorStop(0.6, "rgba(0,0,0,0.08)");
    gradient.addColorStop(1, "rgba(0,0,0,0)");
    context.fillStyle = gradient;
    context.fillRect(0, 0, size, size);
    shadeTexture = new CanvasTexture(canvas);
  }
  return shadeTexture;
}

function freeMemory(object) {
  object.traverse((part) => {
    part.geometry?.dispose();
    for (const material of part.material ? [part.material].flat() : []) {
      material.dispose();
    }
  });
}

/** A canvas in an element. Throws when the browser has no WebGL. */
export class PlantScene {
  constructor(element, background = "#f7f7f2") {
    this.element = element;
    this.renderer = new WebGLRenderer({ antialias: true });
    this.scene = new Scene();
    this.scene.background = new Color(background);
    addLights(this.scene);
    this.camera = new PerspectiveCamera(35, element.clientWidth / element.clientHeight, 0.01, 1000);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setSize(element.clientWidth, element.clientHeight);
    element.append(this.renderer.domElement);
    this.controls.addEventListener("change", () => this.draw());
    new ResizeObserver(() => this.resize()).observe(element);
    this.loader = new GLTFLoader();
    this.plant = null;
  }

  draw() {
    this.renderer.render(this.scene, this.camera);
  }

  resize() {
    const { clientWidth, clientHeight } = this.element;
    if (clientWidth > 0 && clientHeight > 0) {
      this.camera.aspect = clientWidth / clientHeight;
      this.camera.updateProjectionMatrix();
      this.renderer.setSize(clientWidth, clientHeight);
      this.draw();
    }
  }

  /** The object of a binary glTF file (an ArrayBuffer). */
  async read(bytes) {
    const { scene, parser } = await this.loader.parseAsync(bytes, "");
    scene.traverse((object) => {
      for (const material of object.isMesh ? [object.material].flat() : []) {
        material.side = DoubleSide; // leaves have two sides
      }
    });
    this.addGround(scene, parser.json.scenes[0].extras?.ground ?? []);
    return scene;
  }

  /** Shades the ground where the plants stand, so that they do not float. */
  addGround(plant, contacts) {
    for (const [x, y, z, radius] of contacts) {
      const spot = new Mesh(new CircleGeometry(radius, 48), new MeshBasicMaterial({
        map: shade(), transparent: true, depthWrite: false, polygonOffset: true, polygonOffsetFactor: 1 }));
      spot.rotation.x = -Math.PI / 2;
      spot.position.set(x, y, z);
      spot.renderOrder = -1;
      plant.add(spot);
    }
  }

  /** Shows a plant. Frees the plant before it, unless that plant is kept to be shown again. */
  show(plant, isKept = false) {
    if (this.plant) {
      this.scene.remove(this.plant);
      if (!isKept) {
        freeMemory(this.plant);
      }
    }
    this.plant = plant;
    if (plant) {
      this.scene.add(plant);
    }
    this.draw();
  }

  /** Places the camera a little above the plant, so far away that the whole box is visible. */
  fit(box) {
    if (box.isEmpty()) {
      return;
    }
    const { camera, controls } = this;
    const centre = box.getCenter(new Vector3());
    const size = box.getSize(new Vector3());
    const slope = Math.tan((camera.fov * Math.PI) / 360);
    const radius = Math.max(size.length() / 2, 1e-6);
    // the camera may turn about the vertical, so the diagonal is the width of the box
    const width = Math.hypot(size.x, size.z);
    const distance = 1.08 * Math.max(size.y / 2 / slope, width / 2 / slope / camera.aspect, radius) + width / 2;
    // keep the present direction; begin at the front
    const direction = this.hasCamera ? camera.position.clone().sub(controls.target) : new Vector3(0, 0.18, 1);
    this.hasCamera = true;
    camera.position.copy(centre).add(direction.normalize().multiplyScalar(distance));
    camera.near = distance / 100;
    camera.far = distance + 20 * radius;
    camera.updateProjectionMatrix();
    controls.target.copy(centre);
    controls.update();
    this.draw();
  }

  /** Zooms out when the plant has grown beyond the fitted box. */
  fitGrown(box) {
    if (!this.fitted || !this.fitted.containsBox(box)) {
      this.fitted = box.clone().expandByScalar(0.15 * box.getSize(new Vector3()).length());
      this.fit(box);
    }
  }
}

export function boxOf(object) {
  return new Box3().setFromObject(object);
}
