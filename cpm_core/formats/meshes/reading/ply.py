"""PLY: triangles of MeshLab, Blender and CloudCompare, as text or as binary numbers in either order of bytes."""

from __future__ import annotations

import struct
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.formats.images.decoded import UnreadableError
from cpm_core.formats.meshes.ply import OBJECT
from cpm_core.formats.meshes.reading.triangles import Triangles, split

_KINDS = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_CORNERS = ("vertex_indices", "vertex_index")


class _Property(NamedTuple):
    name: str
    kind: str
    counts: str = ""
    """Kind of the number of entries of a list; empty for a single number."""


class _Element(NamedTuple):
    name: str
    rows: int
    properties: list[_Property]


Columns = dict[str, Any]
"""Name of a property -> its numbers; of a list how many entries each has, and all entries."""


def read(content: bytes) -> Triangles:
    """Triangles of a file; UnreadableError when it has none."""
    head, mark, body = content.partition(b"end_header")
    if not mark:
        raise UnreadableError("its header has no end")
    order, elements, remarks = _header(head.decode("latin-1"))
    body = body[2:] if body.startswith(b"\r\n") else body[1:]
    found = _text(body, elements) if not order else _binary(body, elements, order)
    vertices, polygons = found.get("vertex", {}), found.get("face", {})
    corners = next((polygons[name] for name in _CORNERS if name in polygons), None)
    if corners is None or not {"x", "y", "z"} <= vertices.keys():
        raise UnreadableError("it has no triangles")
    points = np.stack([vertices[axis] for axis in "xyz"], axis=1).astype(np.float64)
    faces, of = split(*corners)
    numbers = polygons.get(OBJECT)
    return Triangles(points, faces, remarks, None if numbers is None else np.asarray(numbers, np.int64)[of])


def _header(text: str) -> tuple[str, list[_Element], str]:
    """Order of bytes, elements and comments of a header."""
    order: str | None = None
    elements: list[_Element] = []
    remarks = []
    for line in text.splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == "format":
            order = _ORDERS.get(words[1])
        elif words[0] == "comment":
            remarks.append(line[len("comment ") :])
        elif words[0] == "element":
            elements.append(_Element(words[1], int(words[2]), []))
        elif words[:2] == ["property", "list"]:
            elements[-1].properties.append(_Property(words[4], _KINDS[words[3]], _KINDS[words[2]]))
        elif words[0] == "property":
            elements[-1].properties.append(_Property(words[2], _KINDS[words[1]]))
    if order is None or any(element.rows < 0 for element in elements):
        raise UnreadableError("its header is damaged")
    return order, elements, "\n".join(remarks)


def _binary(body: bytes, elements: list[_Element], order: str) -> dict[str, Columns]:
    found, at = {}, 0
    for element in elements:
        sizes = [_first_count(body, at, element, order)] if _lists(element) else []
        kind = np.dtype([entry for one in element.properties for entry in _fields(one, order, sizes)])
        if at + kind.itemsize * element.rows <= len(body):
            rows = np.frombuffer(body, kind, element.rows, at)
            if not sizes or (rows["n " + _lists(element)[0].name] == sizes[0]).all():
                found[element.name] = {one.name: _column(rows, one) for one in element.properties}
                at += kind.itemsize * element.rows
                continue
        found[element.name], at = _row_by_row(body, at, element, order)
    return found


def _lists(element: _Element) -> list[_Property]:
    return [one for one in element.properties if one.counts]


def _first_count(body: bytes, at: int, element: _Element, order: str) -> int:
    """Number of entries of the first list of the first row; the other rows mostly have as many."""
    if not element.rows or len(_lists(element)) > 1:
        return 0
    before = element.properties[: element.properties.index(_lists(element)[0])]
    at += sum(np.dtype(one.kind).itemsize for one in before)
    return int(np.frombuffer(body, order + _lists(element)[0].counts, 1, at)[0])


def _fields(one: _Property, order: str, sizes: list[int]) -> list[tuple[Any, ...]]:
    if not one.counts:
        return [(one.name, order + one.kind)]
    return [("n " + one.name, order + one.counts), (one.name, order + one.kind, (sizes[0],))]


def _column(rows: NDArray[Any], one: _Property) -> Any:
    return (rows["n " + one.name], rows[one.name].reshape(-1)) if one.counts else rows[one.name]


def _row_by_row(body: bytes, at: int, element: _Element, order: str) -> tuple[Columns, int]:
    """The columns of an element whose lists are not all equally long, and where it ends."""
    singles: dict[str, list[float]] = {one.name: [] for one in element.properties if not one.counts}
    lists: dict[str, tuple[list[int], list[float]]] = {one.name: ([], []) for one in _lists(element)}
    for _ in range(element.rows):
        for one in element.properties:
            count = 1
            if one.counts:
                count = int(struct.unpack_from(order + _CODES[one.counts], body, at)[0])
                at += np.dtype(one.counts).itemsize
            values = struct.unpack_from(f"{order}{count}{_CODES[one.kind]}", body, at)
            at += count * np.dtype(one.kind).itemsize
            if one.counts:
                lists[one.name][0].append(count)
                lists[one.name][1].extend(values)
            else:
                singles[one.name].append(values[0])
    return {**{name: np.array(values) for name, values in singles.items()}, **lists}, at


_CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d"}


def _text(body: bytes, elements: list[_Element]) -> dict[str, Columns]:
    found: dict[str, Columns] = {}
    words = np.array(body.split(), dtype=np.float64)
    at = 0
    for element in elements:
        columns: dict[str, Any] = {one.name: ([], []) if one.counts else [] for one in element.properties}
        if not _lists(element):
            rows = words[at : at + element.rows * len(columns)].reshape(element.rows, len(columns))
            found[element.name] = dict(zip(columns, rows.T, strict=True))
            at += rows.size
            continue
        for _ in range(element.rows):
            for one in element.properties:
                if one.counts:
                    count = int(words[at])
                    columns[one.name][0].append(count)
                    columns[one.name][1].extend(words[at + 1 : at + 1 + count])
                    at += count
                else:
                    columns[one.name].append(words[at])
                at += 1
        found[element.name] = columns
    return found
