"""PLY: surfaces of MeshLab, Blender and CloudCompare."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.formats.meshes.coordinates import ExportMesh
from cpm_core.formats.meshes.triangles import NUMBER_KINDS, ParsedTriangles, triangulate_polygons
from cpm_core.numerics.types import JsonDict, Texts

_OBJECT_PROPERTY = "object"
"""Property of a triangle: the number of its object."""

_BYTE_ORDERS = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}
"""Format of a file -> byte order of NumPy."""


def encode_ply(mesh: ExportMesh) -> bytes:
    """Encode a surface with its normals as binary PLY."""
    precise = mesh.points.dtype == np.float64
    head = format_ply_header(
        mesh.notes, len(mesh.points), len(mesh.faces), "nx ny nz", precise, mesh.numbers is not None
    )
    vertices = np.empty(len(mesh.points), [("place", "<f8" if precise else "<f4", 3), ("normal", "<f4", 3)])
    vertices["place"], vertices["normal"] = mesh.points, mesh.normals
    return head + vertices.tobytes() + encode_ply_triangles(mesh.faces, mesh.numbers)


def format_ply_header(
    notes: Texts, vertices: int, faces: int, normals: str = "", precise: bool = False, numbered: bool = False
) -> bytes:
    """Format the header of a file with these numbers of vertices and triangles, and these properties of normals."""
    properties = "".join(f"property {'double' if precise else 'float'} {name}\n" for name in ("x", "y", "z"))
    properties += "".join(f"property float {name}\n" for name in normals.split())
    return (
        "ply\nformat binary_little_endian 1.0\n"
        + "".join(f"comment {note}\n" for note in notes)
        + f"element vertex {vertices}\n{properties}"
        + f"element face {faces}\nproperty list uchar int vertex_indices\n"
        + (f"property int {_OBJECT_PROPERTY}\n" if numbered else "")
        + "end_header\n"
    ).encode()


def encode_ply_triangles(corners: NDArray[Any], numbers: NDArray[Any] | None) -> bytes:
    """Encode triangles.

    Parameters
    ----------
    corners : ndarray of int, shape (F, 3)
        Vertices of each triangle.
    numbers : ndarray of int, shape (F,), or None
        Number of the object of each triangle.

    Returns
    -------
    bytes
        Rows of the element ``face``.
    """
    fields: list[Any] = [("count", "u1"), ("corners", "<i4", 3)]
    rows = np.empty(len(corners), fields if numbers is None else [*fields, (_OBJECT_PROPERTY, "<i4")])
    rows["count"], rows["corners"] = 3, corners
    if numbers is not None:
        rows[_OBJECT_PROPERTY] = numbers
    return rows.tobytes()


class _Property(NamedTuple):
    """A number in each row of an element, or a list of numbers whose length has the type `counts`."""

    name: str
    kind: str
    counts: str = ""


def read_ply(content: bytes) -> ParsedTriangles:
    """Read the triangles of a text or binary file; UnreadableError when it has none."""
    head, _, body = content.partition(b"end_header")
    body = body.partition(b"\n")[2]
    form = order = ""
    rows: dict[str, int] = {}
    properties: dict[str, list[_Property]] = {}
    for line in head.decode("latin-1").splitlines():
        match line.split():
            case ["format", form, *_]:
                order = _BYTE_ORDERS[form]
            case ["element", element, count]:
                rows[element], properties[element] = int(count), []
            case ["property", "list", counts, kind, name]:
                properties[element].append(_Property(name, order + NUMBER_KINDS[kind], order + NUMBER_KINDS[counts]))
            case ["property", kind, name]:
                properties[element].append(_Property(name, order + NUMBER_KINDS[kind]))
    if form == "ascii":  # converted to a binary file of double precision
        body = np.array(body.split(), float).astype("<f8").tobytes()
        for element, known in properties.items():
            properties[element] = [_Property(one.name, "<f8", "<f8" if one.counts else "") for one in known]
    columns: dict[str, JsonDict] = {}
    for element, known in properties.items():
        columns[element], body = _read_element(body, rows[element], known)
    vertices, polygons = columns["vertex"], columns["face"]
    corners = polygons["vertex_indices"] if "vertex_indices" in polygons else polygons["vertex_index"]
    points = np.stack([vertices[axis] for axis in "xyz"], axis=1).astype(float)
    faces, polygon = triangulate_polygons(*corners)
    numbers = np.asarray(polygons[_OBJECT_PROPERTY], np.int64)[polygon] if _OBJECT_PROPERTY in polygons else None
    return ParsedTriangles(points, faces, numbers)


def _read_element(body: bytes, count: int, properties: list[_Property]) -> tuple[JsonDict, bytes]:
    """Read the columns of an element by property, for a list its lengths and all entries; return the rest as well."""
    fields: list[Any] = []
    for one in properties:
        fields += [(f"count {one.name}", one.counts), (one.name, one.kind, 3)] if one.counts else [(one.name, one.kind)]
    kind = np.dtype(fields)
    if len(body) >= count * kind.itemsize:
        table = np.frombuffer(body, kind, count)
        counts = {one.name: table[f"count {one.name}"] for one in properties if one.counts}
        if all((lengths == 3).all() for lengths in counts.values()):  # nothing but triangles
            columns = {one.name: table[one.name] for one in properties}
            lists = {name: (lengths, columns[name].ravel()) for name, lengths in counts.items()}
            return columns | lists, body[table.nbytes :]
    found: JsonDict = {one.name: ([], []) for one in properties}
    at = 0
    for _ in range(count):
        for one in properties:
            length, (lengths, entries) = 1, found[one.name]
            if one.counts:
                length = int(np.frombuffer(body, one.counts, 1, at)[0])
                at += np.dtype(one.counts).itemsize
            lengths.append(length)
            entries.extend(np.frombuffer(body, one.kind, length, at).tolist())
            at += length * np.dtype(one.kind).itemsize
    return {one.name: found[one.name] if one.counts else found[one.name][1] for one in properties}, body[at:]
