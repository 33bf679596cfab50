"""STL: the triangles of the surface, for printing in three dimensions."""

from __future__ import annotations

import struct

import numpy as np

from cpm_core.contours.result import Result
from cpm_core.formats.meshes.world import mesh_of
from cpm_core.image.geometry import Convention
from cpm_core.medial_axis.skeleton import Skeleton

HEADER = 80
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def encode(result: Result | Skeleton, space: Convention = "LPS") -> bytes:
    """Make a binary STL file of the surface of a result; ValueError when it has none.

    Its header has room for the program, the coordinates, the unit and the beginning of the hash of the image.
    """
    mesh = mesh_of(result, space)
    triangles = np.zeros(len(mesh.faces), TRIANGLE)
    corners = mesh.points[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    triangles["normal"], triangles["corners"] = normals / np.maximum(lengths, 1e-30), corners
    header = " ".join((*mesh.notes[:3], mesh.origin)).encode()[:HEADER].ljust(HEADER)
    return header + struct.pack("<I", len(triangles)) + triangles.tobytes()
