// A canvas that shows plants from binary glTF files, with light, a fitting camera, and rotation by the mouse.
import {
  AmbientLight,
  Box3,
  Color,
  DirectionalLight,
  DoubleSide,
  Mesh,
  Object3D,
  HemisphereLight,
  PerspectiveCamera,
  Scene,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

function addLights(scene: Scene): void {
  scene.add(new HemisphereLight(0xffffff, 0x8a7f6a, 1.6), new AmbientLight(0xffffff, 0.4));
  const sun = new DirectionalLight(0xffffff, 2.2);
  sun.position.set(-0.6, 1, 0.8);
  scene.add(sun);
}

function freeMemory(object: Object3D): void {
  object.traverse((found) => {
    const part = found as Mesh;
    part.geometry?.dispose();
    for (const material of part.material ? [part.material].flat() : []) {
      material.dispose();
    }
  });
}

/** A canvas in an element. Throws when the browser has no WebGL. */
export class PlantScene {
  private readonly renderer = new WebGLRenderer({ antialias: true });
  private readonly scene = new Scene();
  private readonly camera: PerspectiveCamera;
  private readonly controls: OrbitControls;
  private readonly loader = new GLTFLoader();
  private plant: Object3D | null = null;
  private hasCamera = false;

  constructor(
    private readonly element: HTMLElement,
    background = "#f7f7f2",
  ) {
    this.scene.background = new Color(background);
    addLights(this.scene);
    this.camera = new PerspectiveCamera(35, element.clientWidth / element.clientHeight, 0.01, 1000);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setSize(element.clientWidth, element.clientHeight);
    element.append(this.renderer.domElement);
    this.controls.addEventListener("change", () => this.draw());
    new ResizeObserver(() => this.resize()).observe(element);
  }

  draw(): void {
    this.renderer.render(this.scene, this.camera);
  }

  resize(): void {
    const { clientWidth, clientHeight } = this.element;
    if (clientWidth > 0 && clientHeight > 0) {
      this.camera.aspect = clientWidth / clientHeight;
      this.camera.updateProjectionMatrix();
      this.renderer.setSize(clientWidth, clientHeight);
      this.draw();
    }
  }

  /** The object of a binary glTF file (an ArrayBuffer). */
  async read(bytes: ArrayBuffer): Promise<Object3D> {
    const { scene } = await this.loader.parseAsync(bytes, "");
    scene.traverse((object) => {
      for (const material of object instanceof Mesh ? [object.material].flat() : []) {
        material.side = DoubleSide; // leaves have two sides
      }
    });
    return scene;
  }

  /** Shows a plant. Frees the plant before it, unless that plant is kept to be shown again. */
  show(plant: Object3D | null, isKept = false): void {
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
  fit(box: Box3): void {
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
}

export function boxOf(object: Object3D): Box3 {
  return new Box3().setFromObject(object);
}
