// Objects of binary glTF files: plants with their textures.
import { DoubleSide, Mesh } from "three";
import type { Material, Object3D, Texture } from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

const loader = new GLTFLoader();

const materialsOf = (object: Object3D): Set<Material> => {
  const found = new Set<Material>();
  object.traverse((part) => part instanceof Mesh && [part.material].flat().forEach((material) => found.add(material)));
  return found;
};

export function texturesOf(object: Object3D): Set<Texture> {
  const all = [...materialsOf(object)].flatMap((material) => Object.values(material) as unknown[]);
  return new Set(all.filter((value): value is Texture => (value as Texture | null)?.isTexture === true));
}

/** The object of a binary glTF file. Leaves have two sides, and are seen through each other without being sorted. */
export async function readObject(bytes: ArrayBuffer): Promise<Object3D> {
  const { scene } = await loader.parseAsync(bytes, "");
  for (const material of materialsOf(scene)) {
    material.side = DoubleSide;
    if (material.transparent) {
      Object.assign(material, { transparent: false, depthWrite: true, alphaHash: true });
    }
  }
  return scene;
}

/** Frees what an object has on the graphics card. */
export function freeObject(object: Object3D): void {
  object.traverse((part) => part instanceof Mesh && part.geometry.dispose());
  texturesOf(object).forEach((texture) => texture.dispose());
  materialsOf(object).forEach((material) => material.dispose());
}
