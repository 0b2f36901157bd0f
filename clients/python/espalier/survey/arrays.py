"""The arrays of VTK's XML files: ascii, binary and appended (base64 or raw), without a compressor and with zlib."""

from __future__ import annotations

import base64
import binascii
import struct
import xml.etree.ElementTree as xml
import zlib
from typing import List, Optional, Tuple

TYPES = {"Float32": "f", "Float64": "d", "Int8": "b", "UInt8": "B", "Int16": "h", "UInt16": "H", "Int32": "i", "UInt32": "I", "Int64": "q", "UInt64": "Q"}
MOST_NUMBERS = 20_000_000
_COMPRESSORS = {None: False, "": False, "vtkZLibDataCompressor": True}
_MARK = b"<AppendedData"


class SurveyError(Exception):
    """A file that cannot be read or written: one sentence, with what to do."""


class _Source:
    """Bytes from a place on, that are raw or base64."""

    def __init__(self, content: "bytes | memoryview", isRaw: bool) -> None:
        self.rest = memoryview(content)
        self.isRaw = isRaw

    def peek(self, count: int) -> bytes:
        """The first bytes of what is read together."""
        if self.isRaw:
            return bytes(self.rest[:count])
        return base64.b64decode(self.rest[:-(-count // 3) * 4], validate=True)[:count]

    def take(self, count: int) -> bytes:
        """Bytes that were written together: base64 ends behind them."""
        taken = self.peek(count)
        if len(taken) != count:
            raise ValueError("too short")
        self.rest = self.rest[count if self.isRaw else -(-count // 3) * 4:]
        return taken


class Arrays:
    """The arrays of one file. Raises SurveyError for files that are no little-endian VTK files, or too large."""

    def __init__(self, content: bytes, kind: str) -> None:
        content, self._appended, self._isRaw = _split(content)
        text = content.decode("utf-8")
        if "<!" in text:  # entities could grow without bound
            raise SurveyError("it has declarations, which a file of VTK has not: write the file again.")
        self.top = xml.fromstring(text)
        if self.top.get("type") != kind or self.top.get("byte_order", "LittleEndian") != "LittleEndian":
            raise SurveyError(f"it is no little-endian {kind}: give a file that Espalier or VTK wrote.")
        if self.top.get("compressor") not in _COMPRESSORS:
            raise SurveyError(f"it is compressed by {self.top.get('compressor')}: write it with SetCompressorTypeToZLib or SetCompressorTypeToNone.")
        self._isCompressed = _COMPRESSORS[self.top.get("compressor")]
        self._header = "<Q" if self.top.get("header_type") == "UInt64" else "<I"
        self._left = MOST_NUMBERS

    def numbers(self, array: "xml.Element") -> Tuple[float, ...]:
        kind = TYPES.get(array.get("type", ""))
        name = array.get("Name", "?")
        if kind is None:
            raise SurveyError(f"the array '{name}' has the type {array.get('type')}, which has no numbers.")
        try:
            if array.get("format", "ascii") == "ascii":
                words = (array.text or "").split()
                self._require(len(words))
                return tuple(float(word) if kind in "fd" else int(word) for word in words)
            raw = self._bytes(array, struct.calcsize(kind))
            return struct.unpack(f"<{len(raw) // struct.calcsize(kind)}{kind}", raw)
        except (ValueError, binascii.Error, struct.error, zlib.error):
            raise SurveyError(f"the array '{name}' is damaged: get a complete copy.") from None

    def _require(self, count: int) -> None:
        self._left -= count
        if self._left < 0:
            raise SurveyError(f"its arrays have more than {MOST_NUMBERS} numbers: write it with a smaller --detail.")

    def _bytes(self, array: "xml.Element", size: int) -> bytes:
        if array.get("format") == "binary":
            source = _Source("".join((array.text or "").split()).encode("ascii"), False)
        elif array.get("format") == "appended" and self._appended is not None:
            offset = int(array.get("offset", ""))
            if not 0 <= offset < len(self._appended):
                raise ValueError("the place is not there")
            source = _Source(memoryview(self._appended)[offset:], self._isRaw)
        else:
            raise SurveyError(f"the array '{array.get('Name', '?')}' is {array.get('format')}, and its numbers are not there: get a complete copy.")
        if self._isCompressed:
            raw = self._inflated(source, size)
        else:
            width = struct.calcsize(self._header)
            (claimed,) = struct.unpack(self._header, source.peek(width))
            if claimed > len(source.rest):
                raise ValueError("less than it claims")
            self._require(claimed // size)
            raw = source.take(width + claimed)[width:]
            if array.get("format") == "binary" and len(source.rest) > 0:
                raise ValueError("more than it claims")
        if len(raw) % size:
            raise ValueError("a part of a number")
        return raw

    def _inflated(self, source: _Source, size: int) -> bytes:
        """Blocks of zlib: their number, the size of a block and of the last one, the compressed size of each."""
        width = struct.calcsize(self._header)
        (count,) = struct.unpack(self._header, source.peek(width))
        if count > len(source.rest):
            raise ValueError("more blocks than bytes")
        head = struct.unpack(f"<{3 + count}{self._header[1]}", source.take(width * (3 + count)))
        sizes: List[int] = [head[1]] * count
        if count > 0 and head[2] > 0:
            sizes[-1] = head[2]
        self._require(count + sum(sizes) // size)
        packed = memoryview(source.take(sum(head[3:])))
        raw = bytearray()
        for whole, part in zip(sizes, head[3:]):
            # a byte more than the block claims is too much
            block = zlib.decompressobj().decompress(packed[:part], whole + 1)
            if len(block) != whole:
                raise ValueError("another size")
            raw += block
            packed = packed[part:]
        return bytes(raw)


def _split(content: bytes) -> Tuple[bytes, Optional[bytes], bool]:
    """The XML without appended data, the data behind its '_', and whether they are raw."""
    at = content.find(_MARK)
    if at < 0:
        return content, None, False
    begin, end = content.find(b"_", content.find(b">", at)), content.rfind(b"</AppendedData>")
    if begin < 0 or end < begin:
        raise SurveyError("its appended data are cut off: get a complete copy.")
    isRaw = b'"raw"' in content[at:begin]
    data = content[begin + 1:end]
    return content[:content.find(b">", at) + 1] + content[end:], data if isRaw else b"".join(data.split()), isRaw
