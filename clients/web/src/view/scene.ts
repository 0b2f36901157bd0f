// The view: camera, light, ground, and the plants of a simulation from its columns.
import {
  Box3,
  CircleGeometry,
  Color,
  DirectionalLight,
  HemisphereLight,
  Mesh,
  MeshLambertMaterial,
  Object3D,
  PCFShadowMap,
  PerspectiveCamera,
  Plane,
  Raycaster,
  Scene,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import type { Geometry, GeometryChange, TurtleTable } from "espalier";
import { backgroundTexture, fadeTexture, overPhotograph } from "./backdrop.js";
import { CONTEXT, canvasToDraw } from "./canvas.js";
import type { ColourMode, Legend, ModelPalette } from "./colours.js";
import { FieldView, fieldBox } from "./fields.js";
import type { Field, FieldLook } from "./fields.js";
import { GpuClock, onNextFrame } from "./frames.js";
import { boundsOf, pick } from "./measures.js";
import { freeObject, texturesOf } from "./objects.js";
import type { Bounds, Picked } from "./measures.js";
import { Plants } from "./plants.js";
import { Surroundings } from "./surroundings.js";
import type { Solid } from "./surroundings.js";

const FIELD_OF_VIEW = 32;
// in a browser whose pictures take long: after the last move, for the picture with everything, if it takes less than
const REST_MILLISECONDS = 700;
const LONGEST_FINE_MILLISECONDS = 1000;
const TIGHT_MILLISECONDS = 150; // after the last change of a plant
const FEW_SEGMENTS = 2000; // fewer take as long
const TIMINGS = 2;
const FAST_MILLISECONDS = 30; // of pictures with everything, after which a browser is not slow any more
const FIT_MARGIN = 1.12; // the plant does not touch the rim, nor the tools there

export interface ViewSettings {
  mode: ColourMode;
  hasGround: boolean;
  hasShadows: boolean;
  hasSurroundings: boolean;
  isDark: boolean;
}

export class View {
  readonly renderer: WebGLRenderer;
  readonly camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 1000);
  readonly controls: OrbitControls;
  /** It draws only what `pictureOf` asks for. */
  isOfPictures = false;
  private readonly clock: GpuClock;
  /** Called after the camera moved or the plant changed. */
  onDrawn: () => void = () => {};
  /** Called after the camera was placed anew: the scale is another one. */
  onFitted: () => void = () => {};

  private readonly scene = new Scene();
  private readonly sun = new DirectionalLight(0xfff4e2, 2.4);
  private readonly sky = new HemisphereLight(0xf4f8ff, 0xb7ab92, 1.6);
  private readonly ground: Mesh<CircleGeometry, MeshLambertMaterial>;
  readonly surroundings = new Surroundings();
  readonly fieldView = new FieldView();
  private field: Field | null = null;
  private processes: unknown[] = [];
  private readonly plants = new Plants();
  private fitted: Box3 | null = null;
  private first: Vector3 | null = null; // the direction to the viewer at the beginning
  private hasBackground = true;
  private isComplete = false; // the first picture has neither shadows, ground nor sky: their programs take long to make
  private timings = 0; // pictures after the first complete one that only tell the clock how fast the card is
  private isSlow = false; // pictures take long
  private isFine = false; // the picture that is drawn has everything
  private rest = 0; // the timer of the picture at rest
  private tight = 0; // the timer of exact bounds
  private fine = { count: 0, milliseconds: 0 }; // the last picture with everything: its segments, and how long it took
  private isDrawing = false;
  private isDue = false; // as soon as the picture before is ready
  private readonly size = new Vector2(); // of the element
  private isTurned = false; // by a person, who does not want it turned back
  private other: Object3D | null = null; // an object of a file instead of the columns
  private partner: View | null = null; // it is looked at from the same place
  private anchor: Vector3 | null = null; // the foot of the plants when the photograph or the ruler came
  /** The photograph behind the canvas. */
  photograph: HTMLImageElement | null = null;

  constructor(
    readonly element: HTMLElement,
    public settings: ViewSettings,
    canvas = canvasToDraw(),
  ) {
    const context = canvas.getContext("webgl2") as WebGL2RenderingContext | null;
    this.renderer = new WebGLRenderer({ canvas, ...(context && { context }), ...CONTEXT });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.clock = new GpuClock(this.renderer.getContext() as WebGL2RenderingContext, () => (this.isSlow = true), (time) => this.pictureReady(time));
    this.renderer.shadowMap.type = PCFShadowMap;
    element.append(this.renderer.domElement);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", () => {
      this.moved();
      this.partner?.lookAs(this);
      this.draw();
    });
    this.controls.addEventListener("start", () => {
      this.isTurned = true;
      if (this.partner) {
        this.partner.isTurned = true;
      }
    });
    this.sun.shadow.mapSize.set(2048, 2048);
    this.sun.shadow.radius = 5;
    this.sun.shadow.intensity = 0.75;
    this.ground = new Mesh(
      new CircleGeometry(1, 96).rotateX(-Math.PI / 2),
      new MeshLambertMaterial({ transparent: true, alphaMap: fadeTexture(), depthWrite: false }),
    );
    this.ground.receiveShadow = true;
    this.scene.add(this.sun, this.sun.target, this.sky, this.ground, this.plants.tubes.mesh, this.plants.organs.mesh, this.surroundings.group, this.fieldView.group);
    this.camera.position.set(0, 2, 10);
    this.apply(settings);
    new ResizeObserver(() => this.resize()).observe(element);
    this.resize();
    // the card makes the program of segments, which every plant has, before there is a plant; nobody waits for it
    this.renderer.compile(this.plants.tubes.mesh, this.camera, this.scene);
  }

  /** Takes new settings over. */
  apply(settings: ViewSettings): void {
    this.settings = settings;
    this.refine(false); // the picture gets shadows when they are asked for
    this.shade();
    this.scene.background = this.hasBackground && this.isComplete ? backgroundTexture(settings.isDark) : null;
    this.ground.material.color = new Color(settings.isDark ? 0x39413a : 0xe9e7da);
    this.sky.intensity = settings.isDark ? 1.3 : 1.6;
    this.surroundings.group.visible = settings.hasSurroundings;
    this.repaint();
    this.arrange();
  }

  private shade(): void {
    const hasShadows = this.settings.hasShadows && this.isComplete && !this.plants.tubes.isCoarse;
    this.renderer.shadowMap.enabled = hasShadows;
    this.sun.castShadow = hasShadows;
  }

  /** The plant or the camera moves. Where pictures take long they have neither shadows nor round ends until it rests. */
  private moved(): void {
    if (this.isSlow && !this.isOfPictures) {
      clearTimeout(this.rest);
      this.refine(true);
      this.rest = setTimeout(() => {
        const { count, milliseconds } = this.fine;
        const growth = Math.max(this.plants.tubes.count, FEW_SEGMENTS) / Math.max(count, FEW_SEGMENTS);
        if (milliseconds * growth < LONGEST_FINE_MILLISECONDS) {
          this.refine(false);
        }
      }, REST_MILLISECONDS);
    }
  }

  private refine(isCoarse: boolean): void {
    if (this.plants.tubes.isCoarse !== isCoarse) {
      this.plants.tubes.isCoarse = isCoarse;
      if (this.plants.geometry) {
        this.plants.tubes.update(this.plants.geometry, []);
      }
      this.shade();
      this.draw();
    }
  }

  setPalette(palette: ModelPalette | null): void {
    this.plants.palette = palette;
    this.repaint();
  }

  /** Parameters of the modules, for colours by parameter. */
  setTable(table: TurtleTable | null): void {
    this.plants.table = table;
    this.repaint();
  }

  get legend(): Legend | null {
    return this.plants.legend;
  }

  /** Shows a frame. Rows that did not change are not written again. */
  update(geometry: Geometry, change: GeometryChange, step: number, isLast: boolean): void {
    this.moved();
    this.plants.update(geometry, change, step, this.settings.mode);
    clearTimeout(this.tight);
    this.tight = setTimeout(() => this.plants.tighten() && this.surround(this.processes), TIGHT_MILLISECONDS);
    this.arrange();
    this.surround(this.processes);
    this.fitGrown(isLast);
  }

  /** Shows what surrounds the plants: the processes of the environment. */
  surround(processes: unknown[]): void {
    this.processes = processes;
    const box = this.plants.bounds;
    const radius = box.isEmpty() ? 1 : Math.max(box.getSize(new Vector3()).length() / 2, 1e-3);
    this.surroundings.group.visible = this.settings.hasSurroundings;
    this.surroundings.show(processes, box.isEmpty() ? new Vector3() : box.getCenter(new Vector3()), radius);
    this.draw();
  }

  /** Shows a field of the environment; null: none. */
  showField(field: Field | null, look: FieldLook): void {
    const isOther = field !== null && field.name !== this.field?.name;
    this.field = field;
    this.lookAtField(look);
    if (isOther) {
      this.fit(); // soil lies below the plant, where nobody looks
    }
  }

  lookAtField(look: FieldLook): void {
    this.fieldView.show(this.field, look);
    this.draw();
  }

  showQueries(found: Array<{ position: number[]; answer: number }> | null): void {
    this.surroundings.showQueries(found);
    this.draw();
  }

  private repaint(): void {
    this.plants.repaint(this.settings.mode);
    this.draw();
  }

  /** Shows an object of a file (with its textures) instead of the columns, in the model's colours; null: the columns. */
  showObject(object: Object3D | null, step = 0): void {
    if (this.other) {
      this.scene.remove(this.other);
      freeObject(this.other);
    }
    this.other = object;
    if (object) {
      object.traverse((part) => {
        part.castShadow = part.receiveShadow = true;
      });
      this.scene.add(object);
      this.element.dataset.textured = String(step);
    }
    this.arrange();
  }

  /** Either the columns or the object is visible. A chosen module has its colour in the columns only, and so have plants that are compared. */
  private arrange(): void {
    const isObject = this.other !== null && this.settings.mode === "model" && !this.plants.picked && !this.partner;
    if (this.other) {
      this.other.visible = isObject;
    }
    this.plants.tubes.mesh.visible = !isObject && this.plants.geometry !== null && this.plants.tubes.count > 0;
    this.plants.organs.mesh.visible = !isObject && this.plants.geometry !== null && this.plants.organs.count > 0;
    this.draw();
  }

  clear(): void {
    this.plants.geometry = null;
    this.fitted = null;
    this.plants.picked = null;
    this.showObject(null);
  }

  draw(): void {
    if (!this.isDrawing) {
      this.isDrawing = true;
      onNextFrame(() => {
        this.drawWhenIdle();
      });
    }
  }

  /** A picture waits until the one before it is ready: pictures that queue up would hold up the whole page. */
  private drawWhenIdle(): void {
    if (this.isOfPictures) {
      this.isDrawing = false;
      return;
    }
    this.isDue = this.clock.isBusy;
    if (!this.isDue) {
      this.isDrawing = false;
      this.drawNow();
    }
  }

  /** The last picture is ready. */
  private pictureReady(milliseconds: number): void {
    if (this.isFine) {
      this.fine = { count: this.plants.tubes.count, milliseconds };
      this.isSlow &&= milliseconds > FAST_MILLISECONDS;
    }
    if (this.isComplete && this.timings < TIMINGS) {
      if (this.timings === 0) {
        this.clock.start();
      }
      ++this.timings;
      this.draw();
    }
    this.complete();
    if (this.isDue) {
      this.drawWhenIdle();
    }
  }

  /** The plant is seen. Now everything about it. */
  private complete(): void {
    if (!this.isComplete) {
      this.isComplete = true;
      this.apply(this.settings);
    }
  }

  drawNow(): void {
    if (!this.isComplete && !this.plants.geometry && !this.other) {
      return; // there is nothing to see yet
    }
    const height = this.renderer.domElement.height || 1;
    this.plants.tubes.setPixelScale(((2 * Math.tan((FIELD_OF_VIEW * Math.PI) / 360)) / height) * this.renderer.getPixelRatio());
    this.light();
    this.isFine = !this.plants.tubes.isCoarse;
    this.renderer.render(this.scene, this.camera);
    this.clock.begin();
    this.onDrawn();
  }

  /** Sun, shadows and ground follow the size of the plants. */
  private light(): void {
    const box = this.plants.bounds;
    const hasPlant = !box.isEmpty();
    const radius = hasPlant ? Math.max(box.getSize(new Vector3()).length() / 2, 1e-3) : 1;
    const centre = hasPlant ? box.getCenter(new Vector3()) : new Vector3();
    this.sun.target.position.copy(centre);
    this.sun.position.copy(centre).add(new Vector3(-0.55, 1.1, 0.75).normalize().multiplyScalar(4 * radius));
    const { camera } = this.sun.shadow;
    Object.assign(camera, { left: -1.5 * radius, right: 1.5 * radius, top: 1.5 * radius, bottom: -1.5 * radius, near: radius, far: 8 * radius });
    camera.updateProjectionMatrix();
    this.sun.shadow.bias = -0.0004;
    this.sun.shadow.normalBias = radius * 0.002;
    const size = box.getSize(new Vector3());
    // flat drawings, and plants below the ground, stand in the air
    const isStanding = hasPlant && size.z > 0.02 * radius && box.min.y > -0.05 * size.y && this.plants.geometry?.widths === "world";
    // it would cover what lies behind the canvas
    this.ground.visible = this.settings.hasGround && this.hasBackground && this.isComplete && isStanding;
    this.ground.position.set(centre.x, Math.min(box.min.y, 0), centre.z);
    this.ground.scale.setScalar(4.5 * radius);
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.element;
    const { x, y } = this.size;
    if (clientWidth > 0 && clientHeight > 0 && (clientWidth !== x || clientHeight !== y)) {
      this.size.set(clientWidth, clientHeight);
      this.camera.aspect = clientWidth / clientHeight;
      this.camera.updateProjectionMatrix();
      this.renderer.setSize(clientWidth, clientHeight);
      // another size empties the canvas; in the beginning there is nothing to draw
      if (x > 0) {
        if (this.fitted && !this.isTurned) {
          this.fitTo(this.fitted); // a narrow view sees less
        }
        this.drawNow();
        this.onFitted(); // a pixel shows another length
      } else {
        this.draw();
      }
    }
  }

  /** Two views look from the same place from now on, and show both plants as a whole; null ends that. */
  pairWith(other: View | null): void {
    if (this.partner) {
      this.partner.partner = null;
    }
    this.partner = other;
    if (other) {
      other.partner = this;
      other.fitted = this.fitted;
      other.isTurned = this.isTurned;
      other.lookAs(this);
    }
    this.arrange();
  }

  private lookAs({ camera, controls }: View): void {
    this.moved();
    this.camera.position.copy(camera.position);
    this.camera.quaternion.copy(camera.quaternion);
    this.camera.near = camera.near;
    this.camera.far = camera.far;
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(controls.target);
    this.draw();
  }

  /** Of the plants of this view and of the one beside it, and of a field that is shown, as far as it is near the plants. */
  private get wholeBounds(): Box3 {
    const plants = this.partner ? this.plants.bounds.clone().union(this.partner.plants.bounds) : this.plants.bounds;
    if (!this.field || plants.isEmpty()) {
      return plants;
    }
    const near = plants.clone().expandByScalar(plants.getSize(new Vector3()).length());
    return fieldBox(this.field).intersect(near).union(plants);
  }

  /** Shows the whole plants. */
  fit(): void {
    this.plants.tighten();
    this.partner?.plants.tighten();
    this.fitTo(this.wholeBounds);
  }

  /** Places the camera so that the whole box is visible; it keeps its direction. */
  private fitTo(box: Box3): void {
    if (box.isEmpty()) {
      return;
    }
    const centre = box.getCenter(new Vector3());
    const size = box.getSize(new Vector3());
    const slope = Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
    const radius = Math.max(size.length() / 2, 1e-6);
    const isFlat = size.z < 0.02 * radius;
    const front = this.first ?? new Vector3(0, isFlat ? 0 : 0.2, 1);
    const direction = (this.fitted ? this.camera.position.clone().sub(this.controls.target) : front.clone()).normalize();
    const distance = this.distanceToSee(box, centre, direction, slope * this.camera.aspect, slope);
    this.camera.position.copy(centre).add(direction.multiplyScalar(distance));
    this.camera.near = distance / 200;
    this.camera.far = distance + 40 * radius;
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(centre);
    this.controls.update();
    this.partner?.lookAs(this);
    this.draw();
    this.onFitted();
  }

  /** How far the camera must be to see what is in a box; it may turn about the vertical. A box larger than the plants leaves room for what grows. */
  private distanceToSee(box: Box3, centre: Vector3, direction: Vector3, across: number, up: number): number {
    const seen: Array<Plants | Bounds> = [this, this.partner].flatMap((view) => (view && !view.plants.bounds.isEmpty() ? [view.plants] : []));
    const room = seen.length > 0 ? box.getSize(new Vector3()).length() / Math.max(this.wholeBounds.getSize(new Vector3()).length(), 1e-9) : 1;
    if (this.field || seen.length === 0) {
      seen.push(boundsOf(box));
    }
    return FIT_MARGIN * Math.max(1, room) * Math.max(1e-6, ...seen.map((one) => one.distanceToSee(centre, direction, across, up)));
  }

  /** Moves back when the plant has grown beyond what was fitted. */
  private fitGrown(isLast: boolean): void {
    const isLoose = isLast && !this.isTurned;
    if (isLast) {
      this.plants.tighten();
    }
    const bounds = this.wholeBounds;
    if (!bounds.isEmpty() && (isLoose || !this.fitted || !this.fitted.containsBox(bounds))) {
      // a margin for the next steps
      const box = this.fitted && !isLast ? bounds.clone().expandByVector(bounds.getSize(new Vector3()).multiplyScalar(0.1)) : bounds.clone();
      // another model stands elsewhere
      this.anchor = this.anchor && !this.fitted ? this.footPoint() : this.anchor;
      this.fitTo(box);
      this.fitted = box;
      if (this.partner) {
        this.partner.fitted = box;
      }
    }
  }

  /** The next plant is looked at as a whole, from a direction (to the viewer); without one, from the front. */
  forgetFit(direction: number[] | null = null): void {
    this.first = direction && new Vector3(...direction);
    this.fitted = null;
    this.isTurned = false;
  }

  /** Looks from a side: front, right or top. */
  look(side: "front" | "right" | "top"): void {
    const distance = this.camera.position.distanceTo(this.controls.target);
    const direction = { front: new Vector3(0, 0.02, 1), right: new Vector3(1, 0.02, 0), top: new Vector3(0, 1, 0.001) }[side];
    this.camera.position.copy(this.controls.target).add(direction.normalize().multiplyScalar(distance));
    this.controls.update();
    this.draw();
  }

  /** Turns the camera about the vertical through what it looks at. */
  turn(angle: number): void {
    const { camera, controls } = this;
    camera.position.sub(controls.target).applyAxisAngle(new Vector3(0, 1, 0), angle).add(controls.target);
    controls.update();
  }

  private casterAt(clientX: number, clientY: number): Raycaster {
    const place = this.renderer.domElement.getBoundingClientRect();
    const point = new Vector2(((clientX - place.left) / place.width) * 2 - 1, 1 - ((clientY - place.top) / place.height) * 2);
    const caster = new Raycaster();
    caster.setFromCamera(point, this.camera);
    return caster;
  }

  /** A solid under a point of the page, with a function that gives the way to another point; nothing when a plant is nearer. */
  solidAt(clientX: number, clientY: number): { solid: Solid; wayTo: (clientX: number, clientY: number) => number[] } | null {
    const found = this.surroundings.pick(this.casterAt(clientX, clientY));
    const plant = this.pickAt(clientX, clientY);
    if (!found || (plant && this.camera.position.distanceTo(new Vector3(...plant.position)) < found.distance)) {
      return null;
    }
    // it moves in the plane that faces the camera
    const facing = new Plane().setFromNormalAndCoplanarPoint(this.camera.getWorldDirection(new Vector3()), found.point);
    const wayTo = (x: number, y: number) => {
      const point = this.casterAt(x, y).ray.intersectPlane(facing, new Vector3());
      return point ? point.sub(found.point).toArray() : [0, 0, 0];
    };
    return { solid: found.solid, wayTo };
  }

  /** The module that drew the thing under a point of the page. */
  pickAt(clientX: number, clientY: number): Picked | null {
    const place = this.renderer.domElement.getBoundingClientRect();
    const caster = this.casterAt(clientX, clientY);
    const onePixel = (2 * Math.tan((FIELD_OF_VIEW * Math.PI) / 360)) / place.height;
    return this.plants.geometry ? pick(this.plants.geometry, caster.ray.origin, caster.ray.direction, onePixel) : null;
  }

  highlight(module: { plant: number; module: number } | null): void {
    this.plants.picked = module;
    this.repaint();
    this.arrange();
  }

  /** World units that a pixel shows at the centre of the plant. */
  unitsPerPixel(): number {
    const distance = this.camera.position.distanceTo(this.controls.target);
    return (2 * distance * Math.tan((FIELD_OF_VIEW * Math.PI) / 360)) / (this.element.clientHeight || 1);
  }

  /** With a background of its own, or with what lies behind the canvas. */
  setBackground(isOwn: boolean): void {
    if (this.hasBackground !== isOwn) {
      this.hasBackground = isOwn;
      this.apply(this.settings);
    }
  }

  /** Numbers of the model's colours that something has. */
  usedColours(): number[] {
    const { segments, organs } = this.plants.geometry ?? {};
    const used = new Set<number>();
    for (const colours of [segments?.column("Colour"), organs?.column("Colour")]) {
      for (let i = 0; i < (colours?.length ?? 0); ++i) {
        used.add(colours![i] & 255);
      }
    }
    return [...used].sort((a, b) => a - b);
  }

  plantHeight(): number {
    this.plants.tighten();
    return this.plants.bounds.isEmpty() ? 1 : Math.max(this.plants.bounds.max.y - this.plants.bounds.min.y, 1e-6);
  }

  private footPoint(): Vector3 {
    this.plants.tighten();
    const { bounds } = this.plants;
    return bounds.isEmpty() ? new Vector3() : bounds.getCenter(new Vector3()).setY(bounds.min.y);
  }

  /** The foot stays where it is, also when the plants grow or get other angles: a photograph does not follow them. */
  holdFoot(isHeld: boolean): void {
    this.anchor = isHeld ? (this.anchor ?? this.footPoint()) : null;
  }

  /** Where on the canvas the plants stand, in pixels, and the world units of a pixel there. */
  foot(): { x: number; y: number; unitsPerPixel: number } {
    const point = this.anchor?.clone() ?? this.footPoint();
    const depth = -point.clone().applyMatrix4(this.camera.matrixWorldInverse).z;
    const { clientWidth, clientHeight } = this.element;
    point.project(this.camera);
    const unitsPerPixel = (2 * Math.max(depth, 1e-9) * Math.tan((FIELD_OF_VIEW * Math.PI) / 360)) / (clientHeight || 1);
    return { x: ((point.x + 1) / 2) * clientWidth, y: ((1 - point.y) / 2) * clientHeight, unitsPerPixel };
  }

  /** Figures for tests: draw calls of the last picture, bytes of a segment, what is shown. */
  figures(): { calls: number; segmentBytes: number; segments: number; organs: number; textures: number } {
    return {
      calls: this.renderer.info.render.calls,
      segmentBytes: this.plants.tubes.bytesEach,
      segments: this.plants.geometry?.segments.count ?? 0,
      organs: this.plants.geometry?.organs.count ?? 0,
      textures: this.other?.visible ? texturesOf(this.other).size : 0,
    };
  }

  /** Draws what is seen, with everything about it. */
  private drawComplete(): HTMLCanvasElement {
    this.complete();
    this.refine(false);
    this.drawNow();
    return this.renderer.domElement;
  }

  /** The last picture, over the photograph behind it. */
  composed(): HTMLCanvasElement {
    const canvas = this.renderer.domElement;
    return this.photograph ? overPhotograph(canvas, this.photograph, this.settings.isDark) : canvas;
  }

  /** The view as a PNG file, with the photograph that lies behind it. */
  async picture(): Promise<Blob> {
    this.resize(); // the page may have changed since the last frame of the browser
    this.drawComplete();
    const whole = this.composed();
    const made = await new Promise<Blob | null>((done) => whole.toBlob(done, "image/png"));
    if (!made) {
      throw new Error("The browser makes no picture of this size. Make the window smaller.");
    }
    return made;
  }

  /** A picture of other plants, as a whole, seen from the side from which another view looks. */
  pictureOf(geometry: Geometry, change: GeometryChange, other: View): string {
    this.camera.position.copy(other.camera.position);
    this.controls.target.copy(other.controls.target);
    // then fit() keeps the direction
    this.fitted = new Box3();
    this.plants.tubes.isSmall = true;
    this.isComplete = true;
    // one drawing is enough
    this.isDrawing = true;
    this.update(geometry, { ...change, isWhole: true }, 0, true);
    const made = this.drawComplete().toDataURL("image/png");
    this.isDrawing = false;
    return made;
  }

  /** Frees the canvas; browsers allow few. */
  dispose(): void {
    clearTimeout(this.rest);
    clearTimeout(this.tight);
    this.pairWith(null);
    this.controls.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.renderer.domElement.remove();
  }
}
