"""PLY: the surface with its normals, for MeshLab, Blender and CloudCompare."""

from __future__ import annotations

from typing import Any

import numpy as np

from cpm_core.contours.result import Result
from cpm_core.formats.meshes.world import mesh_of
from cpm_core.image.geometry import Convention
from cpm_core.medial_axis.skeleton import Skeleton

_FACE: list[tuple[Any, ...]] = [("count", "u1"), ("corners", "<i4", 3)]

OBJECT = "object"
"""Property of a triangle: the number of its object."""


def encode(result: Result | Skeleton, space: Convention = "LPS") -> bytes:
    """Make a binary PLY file of the surface of a result; ValueError when it has none."""
    mesh = mesh_of(result, space)
    precise = mesh.points.dtype == np.float64
    properties = "".join(f"property {'double' if precise else 'float'} {name}\n" for name in ("x", "y", "z"))
    properties += "".join(f"property float {name}\n" for name in ("nx", "ny", "nz"))
    numbered = "" if mesh.numbers is None else f"property int {OBJECT}\n"
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        + "".join(f"comment {note}\n" for note in mesh.notes)
        + f"element vertex {len(mesh.points)}\n{properties}"
        + f"element face {len(mesh.faces)}\nproperty list uchar int vertex_indices\n{numbered}end_header\n"
    )
    vertices = np.empty(len(mesh.points), [("place", "<f8" if precise else "<f4", 3), ("normal", "<f4", 3)])
    vertices["place"], vertices["normal"] = mesh.points, mesh.normals
    faces = np.empty(len(mesh.faces), _FACE if mesh.numbers is None else [*_FACE, (OBJECT, "<i4")])
    faces["count"], faces["corners"] = 3, mesh.faces
    if mesh.numbers is not None:
        faces[OBJECT] = mesh.numbers
    return header.encode() + vertices.tobytes() + faces.tobytes()
