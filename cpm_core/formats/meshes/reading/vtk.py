"""VTK: poly data of ParaView and 3D Slicer in files of the older kind, versions 2 to 5, as text or binary numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.formats.images.decoded import UnreadableError
from cpm_core.formats.meshes.reading.triangles import Triangles, split
from cpm_core.formats.meshes.vtk import OBJECT
from cpm_core.numerics.types import Index

_KINDS = {
    "char": "i1",
    "unsigned_char": "u1",
    "short": "i2",
    "unsigned_short": "u2",
    "int": "i4",
    "unsigned_int": "u4",
    "long": "i8",
    "unsigned_long": "u8",
    "vtktypeint64": "i8",
    "vtkidtype": "i8",
    "float": "f4",
    "double": "f8",
}
_CELLS = ("VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS")


class _Stream:
    """The content of a file, line by line and number by number."""

    def __init__(self, content: bytes, binary: bool) -> None:
        self._content, self._binary, self._at = content, binary, 0

    def line(self) -> list[str]:
        """The words of the next line that has any; none at the end."""
        while self._at < len(self._content):
            end = self._content.find(b"\n", self._at)
            end = len(self._content) if end < 0 else end
            words = self._content[self._at : end].decode("latin-1").split()
            self._at = end + 1
            if words:
                return words
        return []

    def numbers(self, count: int, kind: str) -> NDArray[Any]:
        """The next numbers of a kind."""
        if self._binary:
            dtype = np.dtype(">" + _KINDS[kind.lower()])
            if count < 0 or self._at + count * dtype.itemsize > len(self._content):
                raise UnreadableError("it ends before its last number")
            found = np.frombuffer(self._content, dtype, count, self._at)
            self._at += count * dtype.itemsize
            return found
        words: list[bytes] = []
        while len(words) < count and self._at < len(self._content):
            end = self._content.find(b"\n", self._at)
            end = len(self._content) if end < 0 else end
            words += self._content[self._at : end].split()
            self._at = end + 1
        if len(words) != count:
            raise UnreadableError("it ends before its last number")
        return np.array(words, np.float64)


def read(content: bytes) -> Triangles:
    """Triangles of a file; UnreadableError when it has none."""
    head, title, coding, dataset = (*content.split(b"\n", 4)[:4], b"", b"", b"", b"")[:4]
    if not head.startswith(b"# vtk DataFile") or dataset.split() != [b"DATASET", b"POLYDATA"]:
        raise UnreadableError("it is no poly data of VTK")
    stream = _Stream(content[sum(map(len, (head, title, coding, dataset))) + 4 :], coding.strip() == b"BINARY")
    points: NDArray[Any] = np.empty((0, 3))
    faces, of = np.empty((0, 3), np.int64), np.empty(0, np.int64)
    numbers: Index | None = None
    modern = not head.split()[-1].startswith((b"1", b"2", b"3", b"4"))
    while words := stream.line():
        if words[0] == "POINTS":
            points = stream.numbers(3 * int(words[1]), words[2]).reshape(-1, 3).astype(np.float64)
        elif words[0] in _CELLS:
            counts, corners = _cells(stream, words, modern)
            if words[0] == "POLYGONS":
                faces, of = split(counts, corners)
            elif words[0] == "TRIANGLE_STRIPS":
                faces, of = np.concatenate([faces, _strips(counts, corners)]), np.empty(0, np.int64)
        elif words[0] == "CELL_DATA":
            numbers = _object_numbers(stream, int(words[1]))
            break
        elif words[0] == "POINT_DATA":
            break
    if not len(faces):
        raise UnreadableError("it has no triangles")
    fits = numbers is not None and len(of) and of.max() < len(numbers)
    return Triangles(points, faces, title.decode("latin-1"), numbers[of] if fits and numbers is not None else None)


def _cells(stream: _Stream, words: list[str], modern: bool) -> tuple[Index, Index]:
    """Numbers of corners of cells, and all corners."""
    first, second = int(words[1]), int(words[2])
    if modern:
        ends = stream.numbers(first, stream.line()[1]).astype(np.int64)
        return np.diff(ends), stream.numbers(second, stream.line()[1]).astype(np.int64)
    rows = stream.numbers(second, "int").astype(np.int64)
    if first and second == 4 * first and (rows[::4] == 3).all():
        return rows[::4], rows.reshape(-1, 4)[:, 1:].ravel()
    starts, at = np.empty(first, np.int64), 0
    for cell in range(first):
        starts[cell] = at
        at += int(rows[at]) + 1
    return rows[starts], np.delete(rows, starts)


def _strips(counts: Index, corners: Index) -> Index:
    """The triangles of strips, every second of which is turned."""
    made = []
    for begin, count in zip((np.cumsum(counts) - counts).tolist(), counts.tolist(), strict=True):
        strip = corners[begin : begin + count]
        triangles = np.stack([strip[:-2], strip[1:-1], strip[2:]], axis=1)
        triangles[1::2] = triangles[1::2, [1, 0, 2]]
        made.append(triangles)
    return np.concatenate([np.empty((0, 3), np.int64), *made])


def _object_numbers(stream: _Stream, count: int) -> Index | None:
    """The numbers of the objects that CPM has written for each triangle."""
    words = stream.line()
    if words[:2] != ["SCALARS", OBJECT]:
        return None
    stream.line()  # the table of colors
    return stream.numbers(count, words[2]).astype(np.int64)
