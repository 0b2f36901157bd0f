"""Readers of mesh files, written from the formats' own descriptions: all triangles of a file, with their corners' normals."""

from __future__ import annotations

import base64
import json
import re
import struct
import xml.etree.ElementTree as xml
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, NamedTuple, Sequence, Tuple

Vector = Tuple[float, float, float]
IDENTITY = [1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0]
TYPES = {5121: "B", 5123: "H", 5125: "I", 5126: "f"}
PLY_TYPES = {"float": "f", "uchar": "B", "ushort": "H", "uint": "I", "int": "i"}


class Triangle(NamedTuple):
    points: Tuple[Vector, Vector, Vector]
    normals: Tuple[Vector, Vector, Vector]


class Mesh:
    def __init__(self, triangles: Sequence[Triangle]) -> None:
        self.triangles = triangles

    def bounds(self) -> Tuple[List[float], List[float]]:
        corners = [point for triangle in self.triangles for point in triangle.points]
        return [min(p[k] for p in corners) for k in range(3)], [max(p[k] for p in corners) for k in range(3)]

    def area(self) -> float:
        return sum(length(side(triangle)) for triangle in self.triangles) / 2

    def volume(self) -> float:
        """Of what is closed: positive when its sides look outward."""
        return sum(dot(t.points[0], cross(t.points[1], t.points[2])) for t in self.triangles) / 6

    def without_slivers(self) -> "Mesh":
        """Only the triangles whose area the 32-bit numbers of a file can tell from nothing."""
        low, high = self.bounds()
        least = 1e-8 * max(b - a for a, b in zip(low, high)) ** 2
        return Mesh([t for t in self.triangles if length(side(t)) > least])

    def backward_normals(self) -> int:
        """Corners whose normal looks away from the side where the corners run counter-clockwise."""
        return sum(dot(side(t), normal) < 0 for t in self.triangles for normal in t.normals)


def cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def length(a: Vector) -> float:
    return dot(a, a) ** 0.5


def side(triangle: Triangle) -> Vector:
    """Twice the triangle's area along its normal."""
    a, b, c = triangle.points
    return cross((b[0] - a[0], b[1] - a[1], b[2] - a[2]), (c[0] - a[0], c[1] - a[1], c[2] - a[2]))


def fan(corners: Sequence[int], points: Sequence[Vector], normals: Sequence[Vector]) -> Iterator[Triangle]:
    for b, c in zip(corners[1:], corners[2:]):
        three = (corners[0], b, c)
        yield Triangle(tuple(points[i] for i in three), tuple(normals[i] for i in three))  # type: ignore[arg-type]


def product(a: Sequence[float], b: Sequence[float]) -> List[float]:
    """Of matrices column by column."""
    return [sum(a[k * 4 + row] * b[column * 4 + k] for k in range(4)) for column in range(4) for row in range(4)]


def matrix_of(node: Dict[str, Sequence[float]]) -> Sequence[float]:
    """glTF 2.0, section 3.5.3: a matrix, or translation after rotation after scale."""
    if "matrix" in node:
        return node["matrix"]
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    a, b, c = node.get("scale", (1, 1, 1))
    t = node.get("translation", (0, 0, 0))
    return [(1 - 2 * (y * y + z * z)) * a, 2 * (x * y + z * w) * a, 2 * (x * z - y * w) * a, 0,
            2 * (x * y - z * w) * b, (1 - 2 * (x * x + z * z)) * b, 2 * (y * z + x * w) * b, 0,
            2 * (x * z + y * w) * c, 2 * (y * z - x * w) * c, (1 - 2 * (x * x + y * y)) * c, 0,
            t[0], t[1], t[2], 1]


def read_glb(file: Path) -> Mesh:
    data = file.read_bytes()
    magic, version, size = struct.unpack_from("<4sII", data)
    assert (magic, version, size) == (b"glTF", 2, len(data))
    json_size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    scene = json.loads(data[20 : 20 + json_size])
    binary = 20 + json_size + 8

    def values(index: int) -> List[Tuple[float, ...]]:
        accessor = scene["accessors"][index]
        view = scene["bufferViews"][accessor["bufferView"]]
        layout = struct.Struct("<" + {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]] * TYPES[accessor["componentType"]])
        at = binary + view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", layout.size)
        return [layout.unpack_from(data, at + i * stride) for i in range(accessor["count"])]

    triangles: List[Triangle] = []

    def add(mesh: int, m: Sequence[float]) -> None:
        # no unequal scales here, so normals turn as points do, up to their length
        for primitive in scene["meshes"][mesh]["primitives"]:
            points = [
                (m[0] * x + m[4] * y + m[8] * z + m[12], m[1] * x + m[5] * y + m[9] * z + m[13], m[2] * x + m[6] * y + m[10] * z + m[14])
                for x, y, z in values(primitive["attributes"]["POSITION"])
            ]
            normals = [
                (m[0] * x + m[4] * y + m[8] * z, m[1] * x + m[5] * y + m[9] * z, m[2] * x + m[6] * y + m[10] * z)
                for x, y, z in values(primitive["attributes"]["NORMAL"])
            ]
            corners = [int(i[0]) for i in values(primitive["indices"])]
            for at in range(0, len(corners), 3):
                triangles.extend(fan(corners[at : at + 3], points, normals))

    def visit(index: int, above: Sequence[float]) -> None:
        node = scene["nodes"][index]
        matrix = product(above, matrix_of(node))
        if "mesh" in node:
            add(node["mesh"], matrix)
        for child in node.get("children", ()):
            visit(child, matrix)

    for root in scene["scenes"][scene.get("scene", 0)]["nodes"]:
        visit(root, IDENTITY)
    return Mesh(triangles)


def read_obj(file: Path) -> Mesh:
    points: List[Vector] = []
    normals: List[Vector] = []
    triangles: List[Triangle] = []
    for line in file.read_text(encoding="ascii").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append((float(words[1]), float(words[2]), float(words[3])))
        elif words[:1] == ["vn"]:
            normals.append((float(words[1]), float(words[2]), float(words[3])))
        elif words[:1] == ["f"]:
            corners = [[int(part) if part else 0 for part in word.split("/")] for word in words[1:]]
            triangles.extend(
                fan(range(len(corners)), [points[c[0] - 1] for c in corners], [normals[c[2] - 1] for c in corners])
            )
    return Mesh(triangles)


def read_ply(file: Path) -> Mesh:
    data = file.read_bytes()
    end = data.index(b"end_header\n") + 11
    counts, layouts = {}, {}
    element = ""
    for line in data[:end].decode("ascii").splitlines():
        words = line.split()
        if words[0] == "element":
            element, counts[words[1]], layouts[words[1]] = words[1], int(words[2]), "<"
        elif words[0] == "property" and words[1] != "list":
            layouts[element] += PLY_TYPES[words[1]]
    vertex = struct.Struct(layouts["vertex"])
    rows = [vertex.unpack_from(data, end + i * vertex.size) for i in range(counts["vertex"])]
    points, normals = [row[0:3] for row in rows], [row[3:6] for row in rows]
    at, triangles = end + vertex.size * counts["vertex"], []
    more = struct.calcsize(layouts["face"])
    for _ in range(counts["face"]):
        corners = struct.unpack_from(f"<{data[at]}I", data, at + 1)
        triangles.extend(fan(corners, points, normals))
        at += 1 + 4 * data[at] + more
    assert at == len(data)
    return Mesh(triangles)


def read_stl(file: Path) -> Mesh:
    data = file.read_bytes()
    (count,) = struct.unpack_from("<I", data, 80)
    assert len(data) == 84 + 50 * count
    triangles = []
    for i in range(count):
        n = struct.unpack_from("<12f", data, 84 + 50 * i)
        triangles.append(Triangle((n[3:6], n[6:9], n[9:12]), (n[0:3], n[0:3], n[0:3])))
    return Mesh(triangles)


def read_usda(file: Path) -> Mesh:
    triangles: List[Triangle] = []
    for prim in file.read_text(encoding="utf-8").split("def Mesh ")[1:]:

        def numbers(attribute: str) -> List[float]:
            found = re.search(re.escape(attribute) + r" = \[([^\]]*)\]", prim)
            assert found, attribute
            return [float(word) for word in re.findall(r"[^\s,()]+", found.group(1))]

        def vectors(attribute: str) -> List[Vector]:
            flat = numbers(attribute)
            return list(zip(flat[0::3], flat[1::3], flat[2::3]))

        points, normals = vectors("point3f[] points"), vectors("normal3f[] normals")
        corners = [int(number) for number in numbers("int[] faceVertexIndices")]
        at = 0
        for count in map(int, numbers("int[] faceVertexCounts")):
            triangles.extend(fan(corners[at : at + count], points, normals))
            at += count
        assert at == len(corners)
    return Mesh(triangles)


VTK_TYPES = {"Float32": "f", "Float64": "d", "Int64": "q", "UInt8": "B", "UInt16": "H", "UInt32": "I", "UInt64": "Q"}


def vtp_array(array: "xml.Element") -> List[Any]:
    """The numbers of an inline array, which stand behind their size in bytes."""
    raw = base64.b64decode(array.text or "", validate=True)
    (size,) = struct.unpack_from("<Q", raw)
    assert size == len(raw) - 8, array.attrib
    code = VTK_TYPES[array.attrib["type"]]
    return list(struct.unpack_from(f"<{size // struct.calcsize(code)}{code}", raw, 8))


def vtp_pieces(file: Path) -> List[Dict[str, List[Any]]]:
    """Of each piece its arrays by name, with the numbers of points and cells that it claims."""
    pieces = []
    for piece in xml.parse(file).getroot().iter("Piece"):
        arrays = {array.attrib["Name"]: vtp_array(array) for array in piece.iter("DataArray")}
        assert len(arrays["Points"]) == 3 * int(piece.attrib["NumberOfPoints"])
        assert len(arrays["offsets"]) == len(arrays["module"]) == int(piece.attrib.get("NumberOfPolys") or piece.attrib["NumberOfCells"])
        pieces.append(arrays)
    return pieces


def read_vtp(file: Path) -> Mesh:
    triangles: List[Triangle] = []
    for arrays in vtp_pieces(file):
        points, normals = ([tuple(arrays[name][i:i + 3]) for i in range(0, len(arrays[name]), 3)] for name in ("Points", "Normals"))
        begin = 0
        for end in arrays["offsets"]:
            triangles.extend(fan(arrays["connectivity"][begin:end], points, normals))
            begin = end
        assert begin == len(arrays["connectivity"])
    return Mesh(triangles)


READERS: Dict[str, Callable[[Path], Mesh]] = {
    "glb": read_glb, "obj": read_obj, "ply": read_ply, "stl": read_stl, "usda": read_usda, "vtp": read_vtp, "vtu": read_vtp,
}
