"""A second reader of LAS 1.2 to 1.4, for tests, from the tables of ASPRS, LAS Specification 1.4-R15 (sections 2.4 and 2.6)."""

import struct
from typing import Iterator, NamedTuple, Tuple


class LasPoint(NamedTuple):
    place: Tuple[float, float, float]
    kind: int  # class
    isWithheld: bool


def las_points(content: bytes) -> Iterator[LasPoint]:
    # table 3: the public header block
    assert content[:4] == b"LASF" and content[24] == 1, "no LAS file 1.x"
    minor, (start,), form, (length, legacy) = content[25], struct.unpack_from("<I", content, 96), content[104], struct.unpack_from("<HI", content, 105)
    scale, offset = struct.unpack_from("<3d", content, 131), struct.unpack_from("<3d", content, 155)
    count = struct.unpack_from("<Q", content, 247)[0] if minor >= 4 else legacy
    assert legacy in (0, count) and (form < 6 or legacy == 0), "the two counts of points"
    for at in range(start, start + count * length, length):
        numbers = struct.unpack_from("<3i", content, at)
        if form >= 6:
            # table 10: the flags of classification are bits of byte 15, withheld is the third; the class is byte 16
            kind, isWithheld = content[at + 16], bool(content[at + 15] & 4)
        else:
            # tables 7 and 8: the class has five bits of byte 15, and withheld is the highest
            kind, isWithheld = content[at + 15] & 31, bool(content[at + 15] & 128)
        x, y, z = (number * step + low for number, step, low in zip(numbers, scale, offset))
        yield LasPoint((x, y, z), kind, isWithheld)
