"""Point clouds made by hand, byte by byte, from the pages of the formats (ASPRS LAS 1.2 to 1.4-R15; Turk 1994)."""

import random
import struct
from typing import List, Sequence, Tuple

Point = Tuple[float, float, float]
RECORD_BYTES = (20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67)
HEADER_BYTES = {2: 227, 3: 235, 4: 375}


def tree(count: int, seed: int = 1) -> List[Point]:
    """A ground, a stem and a crown, in millimetres' steps: east, north, up."""
    draw = random.Random(seed)
    points = []
    for i in range(count):
        part = i % 4
        x, y = (draw.uniform(-3, 3), draw.uniform(-3, 3)) if part == 0 else (draw.gauss(0, 0.8), draw.gauss(0, 0.8))
        points.append((round(x, 3), round(y, 3), 0.0 if part == 0 else round(draw.uniform(0.5, 5), 3)))
    return points


def record(user: str, number: int, data: bytes) -> bytes:
    return struct.pack("<H16sHH32s", 0, user.encode(), number, len(data), b"") + data


def geo_keys(*keys: Tuple[int, int]) -> bytes:
    return record("LASF_Projection", 34735, struct.pack("<4H", 1, 1, 0, len(keys)) + b"".join(struct.pack("<4H", key, 0, 1, value)
                                                                                                for key, value in keys))


def las(points: Sequence[Point], minor: int = 2, form: int = 0, classes: Sequence[int] = (), withheld: Sequence[int] = (),
        returns: int = 1, records: Sequence[bytes] = (), extra: int = 0) -> bytes:
    """A LAS file 1.`minor` with a point format; `extra` bytes behind each point."""
    scale, offset = (0.001, 0.001, 0.001), (1000.0, -500.0, 20.0)
    is_long = form >= 6
    body = bytearray()
    for i, point in enumerate(points):
        whole = [round((value - off) / step) for value, step, off in zip(point, scale, offset)]
        kind = classes[i] if classes else 1
        gone = i in withheld
        if is_long:
            head = struct.pack("<3iHBBBBhH", *whole, 7, 1 | returns << 4, 4 if gone else 0, kind, 0, 0, 1)
        else:
            head = struct.pack("<3iHBBbBH", *whole, 7, 1 | returns << 3, kind | (128 if gone else 0), 0, 0, 1)
        body += head + bytes(RECORD_BYTES[form] + extra - len(head))
    variable = b"".join(records)
    start = HEADER_BYTES[minor] + len(variable)
    lows = [min((point[axis] for point in points), default=0.0) for axis in range(3)]
    highs = [max((point[axis] for point in points), default=0.0) for axis in range(3)]
    legacy = 0 if is_long else len(points)
    header = struct.pack("<4sHH16sBB32s32sHHHII", b"LASF", 0, 0, b"", 1, minor, b"by hand", b"test", 1, 2026, HEADER_BYTES[minor], start,
                         len(records))
    header += struct.pack("<BHI5I", form, RECORD_BYTES[form] + extra, legacy, legacy, 0, 0, 0, 0)
    header += struct.pack("<12d", *scale, *offset, highs[0], lows[0], highs[1], lows[1], highs[2], lows[2])
    if minor >= 3:
        header += struct.pack("<Q", 0)
    if minor == 4:
        header += struct.pack("<QIQ15Q", 0, 0, len(points), len(points), *[0] * 14)
    assert len(header) == HEADER_BYTES[minor]
    return header + variable + bytes(body)


def ply(points: Sequence[Point], form: str = "ascii") -> bytes:
    header = (f"ply\nformat {form} 1.0\ncomment by hand\nelement vertex {len(points)}\nproperty double x\nproperty uchar red\n"
              "property double y\nproperty float z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n").encode()
    if form == "ascii":
        return header + "".join(f"{x} 7 {y} {z}\n" for x, y, z in points).encode()
    order = "<" if form == "binary_little_endian" else ">"
    return header + b"".join(struct.pack(order + "dBdf", x, 7, y, z) for x, y, z in points)


def ply_with_lists(points: Sequence[Point], form: str) -> bytes:
    """Cameras, an element without properties and faces before the vertices, and a list in each vertex."""
    header = (f"ply\nformat {form} 1.0\nelement camera 2\nproperty float focus\nelement nothing 7\nelement face 2\n"
              f"property list uchar int vertex_indices\nproperty uchar red\nelement vertex {len(points)}\n"
              "property list short ushort seen_by\nproperty double x\nproperty double y\nproperty float z\nend_header\n").encode()
    if form == "ascii":
        return header + b"1\n2\n3 0 1 2 9\n0 9\n" + "".join(f"2 7 8 {x} {y} {z}\n" for x, y, z in points).encode()
    order = "<" if form == "binary_little_endian" else ">"
    return (header + struct.pack(order + "ffB3iBBB", 1, 2, 3, 0, 1, 2, 9, 0, 9) +
            b"".join(struct.pack(order + "hHHddf", 2, 7, 8, x, y, z) for x, y, z in points))


def hostile_plys() -> List[bytes]:
    """Counts and lengths that the bytes do not have: faces, numbers of a list, a length below 0."""
    whole = ply_with_lists([(1, 2, 3), (4, 5, 6)], "binary_little_endian")
    first = whole.index(b"end_header\n") + len(b"end_header\n")
    vertex = len(whole) - 2 * 26
    cubes = b"property float x\nproperty float y\nproperty float z\nend_header\n"
    return [whole.replace(b"face 2", b"face 18446744073709551615"), whole.replace(b"camera 2", b"camera 18446744073709551615"),
            whole[:first + 8] + b"\xff" + whole[first + 9:],
            whole[:vertex] + b"\xff\xff" + whole[vertex + 2:], whole[:vertex] + b"\xff\x7f" + whole[vertex + 2:],
            b"ply\nformat binary_big_endian 1.0\nelement a 1\nproperty list uint double b\nelement vertex 2\n" + cubes + b"\xff" * 40,
            b"ply\nformat ascii 1.0\nelement a 18446744073709551615\nproperty int b\nelement vertex 2\n" + cubes + b"1\n1 2 3\n"]
