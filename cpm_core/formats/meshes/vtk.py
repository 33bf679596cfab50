"""VTK: the surface with its normals as poly data, for ParaView, 3D Slicer and ITK-SNAP."""

from __future__ import annotations

import numpy as np

from cpm_core.contours.result import Result
from cpm_core.formats.meshes.world import mesh_of
from cpm_core.image.geometry import Convention
from cpm_core.medial_axis.skeleton import Skeleton

_TITLE = 255
"""Most characters of the title."""

OBJECT = "object"
"""Name of the numbers of the objects that triangles bound."""


def encode(result: Result | Skeleton, space: Convention = "LPS") -> bytes:
    """Make a binary file of VTK, version 3.0, of the surface of a result; ValueError when it has none."""
    mesh = mesh_of(result, space)
    count, faces = len(mesh.points), len(mesh.faces)
    title = "; ".join((*mesh.notes[:3], mesh.origin))[:_TITLE]
    polygons = np.hstack([np.full((faces, 1), 3), mesh.faces]).astype(">i4")
    kind, points = ("double", ">f8") if mesh.points.dtype == np.float64 else ("float", ">f4")
    numbers = b""
    if mesh.numbers is not None:
        head = f"\nCELL_DATA {faces}\nSCALARS {OBJECT} int 1\nLOOKUP_TABLE default\n"
        numbers = head.encode() + mesh.numbers.astype(">i4").tobytes()
    return b"".join(
        (
            f"# vtk DataFile Version 3.0\n{title}\nBINARY\nDATASET POLYDATA\nPOINTS {count} {kind}\n".encode(),
            mesh.points.astype(points).tobytes(),
            f"\nPOLYGONS {faces} {polygons.size}\n".encode(),
            polygons.tobytes(),
            numbers,
            f"\nPOINT_DATA {count}\nNORMALS normals float\n".encode(),
            mesh.normals.astype(">f4").tobytes(),
            b"\n",
        )
    )
