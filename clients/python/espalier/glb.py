"""Plants of .glb files as NumPy arrays: triangles, materials, and organs that are drawn many times.

    from espalier import glb
    scene = glb.read(simulation.geometry())            # or the bytes of a file that `espalier run -o plant.glb` wrote
    places = scene.plants[0].mesh.places               # (vertices, 3), metres, y up as in glTF

Needs NumPy. The add-on for Blender reads with it.
"""

import json
import struct
from typing import Any, Dict, List, NamedTuple, Optional, Tuple

import numpy as np

Array = Any  # numpy.ndarray
MOST_VERTICES = 50_000_000
TYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class GlbError(Exception):
    """The file cannot be used; a sentence."""


class Material(NamedTuple):
    name: str
    colour: Tuple[float, ...]  # red, green, blue, opacity; linear
    roughness: float
    is_masked: bool  # points of the picture that are less than half opaque are holes
    picture: Optional[bytes]  # PNG or JPEG


class Mesh(NamedTuple):
    """Triangles, y up."""
    places: Array  # (vertices, 3)
    normals: Optional[Array]  # (vertices, 3)
    coordinates: Optional[Array]  # u, v of the picture, v upward (vertices, 2)
    triangles: Array  # (triangles, 3)
    materials: Array  # number in Scene.materials of each triangle


class Instances(NamedTuple):
    """One organ at many places of a plant."""
    name: str
    mesh: Mesh
    places: Array  # matrices (instances, 4, 4)


class Plant(NamedTuple):
    name: str
    mesh: Mesh
    instances: List[Instances]


class Scene(NamedTuple):
    plants: List[Plant]
    materials: List[Material]


def read(content: bytes) -> Scene:
    """The plants of a file that Espalier wrote. GlbError when it is no such file or is damaged; more than 50 million vertices are refused."""
    try:
        return _Reader(content).scene()
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, RecursionError, struct.error) as error:
        raise GlbError("The file is no .glb of Espalier, or is damaged. Write it again with: espalier run MODEL -o plant.glb") from error


def joined(meshes: List[Mesh]) -> Mesh:
    """One mesh of several. What one of them lacks is zero."""
    if len(meshes) == 1:
        return meshes[0]
    count = sum(len(mesh.places) for mesh in meshes)
    first = np.cumsum([0] + [len(mesh.places) for mesh in meshes])
    parts = [(mesh.triangles + start) for mesh, start in zip(meshes, first)]

    def column(name: str, width: int) -> Array:
        return np.concatenate([np.zeros((len(mesh.places), width)) if getattr(mesh, name) is None else getattr(mesh, name)
                               for mesh in meshes]) if count else np.zeros((0, width))

    return Mesh(column("places", 3), column("normals", 3), column("coordinates", 2),
                np.concatenate(parts) if parts else np.zeros((0, 3), dtype=np.int64),
                np.concatenate([mesh.materials for mesh in meshes]) if meshes else np.zeros(0, dtype=np.int64))


class _Reader:
    def __init__(self, content: bytes) -> None:
        magic, version, size = struct.unpack_from("<4sII", content)
        if magic != b"glTF" or version != 2 or size > len(content):
            raise ValueError
        length, kind = struct.unpack_from("<I4s", content, 12)
        if kind != b"JSON" or 20 + length > size:
            raise ValueError
        self.json: Dict[str, Any] = json.loads(content[20:20 + length])
        self.data = memoryview(b"")
        if 20 + length < size:
            data_length, data_kind = struct.unpack_from("<I4s", content, 20 + length)
            if data_kind != b"BIN\0" or 28 + length + data_length > size:
                raise ValueError
            self.data = memoryview(content)[28 + length:28 + length + data_length]
        self.meshes: Dict[int, Mesh] = {}
        self.vertices = 0

    def view(self, number: int) -> memoryview:
        view = self.json["bufferViews"][_index(number)]
        start = _index(view.get("byteOffset", 0))
        end = start + _index(view["byteLength"])
        if end > len(self.data):
            raise ValueError
        return self.data[start:end]

    def numbers(self, number: int) -> Array:
        """An accessor as (count, width)."""
        accessor = self.json["accessors"][_index(number)]
        view = self.view(accessor["bufferView"])
        kind = np.dtype(TYPES[accessor["componentType"]])
        count, width = _index(accessor["count"]), WIDTHS[accessor["type"]]
        stride = self.json["bufferViews"][accessor["bufferView"]].get("byteStride", kind.itemsize * width)
        start = _index(accessor.get("byteOffset", 0))
        if stride < kind.itemsize * width or count == 0 or start + stride * (count - 1) + kind.itemsize * width > len(view):
            raise ValueError
        self.vertices += count
        if self.vertices > MOST_VERTICES:
            raise GlbError(f"The file has more than {MOST_VERTICES} numbers of vertices. Write it with --detail 0.5 or --instancing.")
        return np.ndarray((count, width), kind, view, start, (stride, kind.itemsize)).copy()

    def mesh(self, number: int) -> Mesh:
        number = _index(number)
        if number not in self.meshes:
            self.meshes[number] = joined([self.part(part) for part in self.json["meshes"][number]["primitives"]])
        return self.meshes[number]

    def part(self, part: Dict[str, Any]) -> Mesh:
        attributes = part["attributes"]
        places = self.numbers(attributes["POSITION"]).astype(np.float64)
        normals = self.numbers(attributes["NORMAL"]).astype(np.float64) if "NORMAL" in attributes else None
        coordinates = self.numbers(attributes["TEXCOORD_0"]).astype(np.float64) if "TEXCOORD_0" in attributes else None
        if coordinates is not None:
            coordinates[:, 1] = 1 - coordinates[:, 1]
        triangles = self.numbers(part["indices"]).astype(np.int64).reshape(-1, 3)
        if places.shape[1] != 3 or not np.isfinite(places).all() or triangles.max() >= len(places):
            raise ValueError
        return Mesh(places, normals, coordinates, triangles, np.full(len(triangles), _index(part.get("material", 0)), dtype=np.int64))

    def material(self, material: Dict[str, Any]) -> Material:
        look = material.get("pbrMetallicRoughness", {})
        picture = None
        if "baseColorTexture" in look:
            source = self.json["textures"][_index(look["baseColorTexture"]["index"])]["source"]
            picture = bytes(self.view(self.json["images"][_index(source)]["bufferView"]))
        return Material(str(material.get("name", "material")), tuple(map(float, look.get("baseColorFactor", (1, 1, 1, 1)))),
                        float(look.get("roughnessFactor", 1)), material.get("alphaMode") == "MASK", picture)

    def scene(self) -> Scene:
        nodes = self.json["scenes"][_index(self.json.get("scene", 0))].get("nodes", [])
        materials = [self.material(material) for material in self.json.get("materials", [])] or [Material("plant", (1, 1, 1, 1), 1, False, None)]
        plants = [self.plant(self.json["nodes"][_index(node)]) for node in nodes]
        for mesh in self.meshes.values():
            if len(mesh.materials) and mesh.materials.max() >= len(materials):
                raise ValueError
        return Scene(plants, materials)

    def plant(self, root: Dict[str, Any]) -> Plant:
        meshes: List[Mesh] = []
        instances: List[Instances] = []
        open_nodes = [(root, np.eye(4))]
        for _ in range(1_000_000):
            if not open_nodes:
                break
            node, outer = open_nodes.pop()
            place = outer @ _matrix(node)
            open_nodes += [(self.json["nodes"][_index(child)], place) for child in reversed(node.get("children", []))]
            if "mesh" not in node:
                continue
            mesh = self.mesh(node["mesh"])
            copies = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
            if copies is None:
                meshes.append(_moved(mesh, place))
            else:
                columns = {name: self.numbers(number) for name, number in copies["attributes"].items()}
                local = _matrices(columns.get("TRANSLATION"), columns.get("ROTATION"), columns.get("SCALE"))
                instances.append(Instances(str(node.get("name", "organ")), mesh, place @ local))
        else:
            raise ValueError
        return Plant(str(root.get("name", "plant")), joined(meshes), instances)


def _index(number: Any) -> int:
    if not isinstance(number, int) or number < 0:
        raise ValueError
    return number


def _moved(mesh: Mesh, place: Array) -> Mesh:
    if np.array_equal(place, np.eye(4)):
        return mesh
    normals = mesh.normals
    if normals is not None:
        normals = normals @ np.linalg.inv(place[:3, :3])
        normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    return mesh._replace(places=mesh.places @ place[:3, :3].T + place[:3, 3], normals=normals)


def _matrix(node: Dict[str, Any]) -> Array:
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    rows = [np.array([node[name]], dtype=np.float64) if name in node else None for name in ("translation", "rotation", "scale")]
    return _matrices(*rows)[0]


def _matrices(places: Optional[Array], turns: Optional[Array], sizes: Optional[Array]) -> Array:
    """Translation, quaternion (x, y, z, w) and scale as matrices (count, 4, 4)."""
    count = next((len(column) for column in (places, turns, sizes) if column is not None), 1)
    made = np.zeros((count, 4, 4))
    x, y, z, w = (np.array([[0, 0, 0, 1.0]] * count) if turns is None else turns.astype(np.float64)).T
    made[:, 0, 0], made[:, 0, 1], made[:, 0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)
    made[:, 1, 0], made[:, 1, 1], made[:, 1, 2] = 2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)
    made[:, 2, 0], made[:, 2, 1], made[:, 2, 2] = 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)
    if sizes is not None:
        made[:, :3, :3] *= sizes.astype(np.float64)[:, None, :]
    if places is not None:
        made[:, :3, 3] = places
    made[:, 3, 3] = 1
    return made
