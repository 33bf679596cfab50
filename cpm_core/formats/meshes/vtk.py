"""VTK: surfaces as poly data of ParaView, 3D Slicer and ITK-SNAP, in legacy files."""

from __future__ import annotations

import numpy as np

from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.meshes.coordinates import ExportMesh
from cpm_core.formats.meshes.triangles import NUMBER_KINDS, ParsedTriangles, triangulate_polygons
from cpm_core.numerics.types import Index, Numbers

_MAX_TITLE_LENGTH = 255
"""Longest title [characters]."""

_OBJECT_ARRAY = "object"
"""Name of the array with the object of each triangle."""


def encode_vtk(mesh: ExportMesh) -> bytes:
    """Encode a surface with its normals as a binary file of version 3.0."""
    count, faces = len(mesh.points), len(mesh.faces)
    polygons = np.hstack([np.full((faces, 1), 3), mesh.faces]).astype(">i4")
    kind, points = ("double", ">f8") if mesh.points.dtype == np.float64 else ("float", ">f4")
    numbers = b""
    if mesh.numbers is not None:
        head = f"\nCELL_DATA {faces}\nSCALARS {_OBJECT_ARRAY} int 1\nLOOKUP_TABLE default\n"
        numbers = head.encode() + mesh.numbers.astype(">i4").tobytes()
    return b"".join(
        (
            f"# vtk DataFile Version 3.0\n{mesh.title[:_MAX_TITLE_LENGTH]}\nBINARY\nDATASET POLYDATA\n".encode(),
            f"POINTS {count} {kind}\n".encode(),
            mesh.points.astype(points).tobytes(),
            f"\nPOLYGONS {faces} {polygons.size}\n".encode(),
            polygons.tobytes(),
            numbers,
            f"\nPOINT_DATA {count}\nNORMALS normals float\n".encode(),
            mesh.normals.astype(">f4").tobytes(),
            b"\n",
        )
    )


class _VtkStream:
    """Content of a file, read line by line or number by number."""

    def __init__(self, content: bytes, binary: bool) -> None:
        self._rest, self._binary = content, binary

    def read_words(self) -> list[str]:
        """Return the words of the next line that has any; empty at the end."""
        while self._rest:
            line, _, self._rest = self._rest.partition(b"\n")
            if words := line.decode("latin-1").split():
                return words
        return []

    def read_numbers(self, count: int, kind: str) -> Numbers:
        """Read the next numbers of a type, shape (count,)."""
        if self._binary:
            numbers = np.frombuffer(self._rest, ">" + NUMBER_KINDS[kind.lower()], count)
            self._rest = self._rest[numbers.nbytes :]
            return numbers
        words = self._rest.split(None, count)
        self._rest = b"".join(words[count:])
        return np.array(words[:count], float)


def read_vtk(content: bytes) -> ParsedTriangles:
    """Read the triangles of a text or binary file of version 2 to 5; UnreadableError when it has none."""
    head, _, coding, dataset, rest = content.split(b"\n", 4)
    if not head.startswith(b"# vtk DataFile") or dataset.split() != [b"DATASET", b"POLYDATA"]:
        raise UnreadableError("It is no poly data of VTK: write it as such.")
    stream, modern = _VtkStream(rest, coding.strip() == b"BINARY"), head.split()[-1] >= b"5"
    points: Numbers = np.empty((0, 3))
    counts, corners = np.empty(0, np.int64), np.empty(0, np.int64)
    numbers: Index | None = None
    while words := stream.read_words():
        match words:
            case ["POINTS", count, kind]:
                points = stream.read_numbers(3 * int(count), kind).reshape(-1, 3).astype(float)
            case ["VERTICES" | "LINES" | "TRIANGLE_STRIPS", first, second]:
                _read_cells(stream, int(first), int(second), modern)
            case ["POLYGONS", first, second]:
                counts, corners = _read_cells(stream, int(first), int(second), modern)
            case ["SCALARS", name, kind, *_] if name == _OBJECT_ARRAY:
                stream.read_words()  # skip the color table
                numbers = stream.read_numbers(len(counts), kind).astype(np.int64)
            case ["POINT_DATA", *_]:
                break
    faces, polygon = triangulate_polygons(counts, corners)
    return ParsedTriangles(points, faces, None if numbers is None else numbers[polygon])


def _read_cells(stream: _VtkStream, first: int, second: int, modern: bool) -> tuple[Index, Index]:
    """Read the number of corners of each cell, shape (M,), and all corners."""
    if modern:
        ends = stream.read_numbers(first, stream.read_words()[1]).astype(np.int64)
        return np.diff(ends), stream.read_numbers(second, stream.read_words()[1]).astype(np.int64)
    rows = stream.read_numbers(second, "int").astype(np.int64)
    counts, at = [], 0
    while at < len(rows):
        counts.append(int(rows[at]))
        if counts[-1] < 0:
            raise ValueError("a polygon has a negative number of corners")
        at += counts[-1] + 1
    starts = np.cumsum([0, *(count + 1 for count in counts[:-1])])
    return np.array(counts, np.int64), np.delete(rows, starts)
