"""PLY: the surface with its normals, for MeshLab, Blender and CloudCompare."""

from __future__ import annotations

import numpy as np

from cpm_core.contours.result import Result
from cpm_core.formats.meshes.world import mesh_of
from cpm_core.image.geometry import Convention
from cpm_core.medial_axis.skeleton import Skeleton

_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


def encode(result: Result | Skeleton, space: Convention = "LPS") -> bytes:
    """Make a binary PLY file of the surface of a result; ValueError when it has none."""
    mesh = mesh_of(result, space)
    properties = "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        + "".join(f"comment {note}\n" for note in mesh.notes)
        + f"element vertex {len(mesh.points)}\n{properties}"
        + f"element face {len(mesh.faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(mesh.faces), _FACE)
    faces["count"], faces["corners"] = 3, mesh.faces
    return header.encode() + np.hstack([mesh.points, mesh.normals]).astype("<f4").tobytes() + faces.tobytes()
