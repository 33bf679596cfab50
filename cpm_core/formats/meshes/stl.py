"""STL: surfaces of printing programs; equal corners of triangles become one vertex."""

from __future__ import annotations

import re
import struct

import numpy as np

from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.meshes.coordinates import ExportMesh
from cpm_core.formats.meshes.triangles import ParsedTriangles

_HEADER_SIZE = 80
"""Size of the header of a binary file [bytes]."""

_TRIANGLE_TYPE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
"""Record of a triangle in a binary file."""

_VERTEX_LINE = re.compile(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)", re.IGNORECASE)
"""Line of a corner in a text file."""


def encode_stl(mesh: ExportMesh) -> bytes:
    """Encode a surface as binary STL.

    The header holds program, coordinates, unit and the beginning of the hash of the image.
    """
    triangles = np.zeros(len(mesh.faces), _TRIANGLE_TYPE)
    corners = mesh.points[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    triangles["normal"], triangles["corners"] = normals / np.maximum(lengths, 1e-30), corners
    header = mesh.title.encode()[:_HEADER_SIZE].ljust(_HEADER_SIZE)
    return header + struct.pack("<I", len(triangles)) + triangles.tobytes()


def read_stl(content: bytes) -> ParsedTriangles:
    """Read the triangles of a text or binary file; UnreadableError when it has none."""
    count = int.from_bytes(content[_HEADER_SIZE : _HEADER_SIZE + 4], "little")
    if count and len(content) >= _HEADER_SIZE + 4 + count * _TRIANGLE_TYPE.itemsize:
        corners = (
            np.frombuffer(content, _TRIANGLE_TYPE, count, _HEADER_SIZE + 4)["corners"].reshape(-1, 3).astype(float)
        )
    elif content.lstrip()[:5].lower() == b"solid":
        corners = np.array(_VERTEX_LINE.findall(content), float).reshape(-1, 3)
        corners = corners[: len(corners) // 3 * 3]
    else:
        raise UnreadableError("It has no triangles: write it again.")
    order = np.lexsort(corners.T)
    first = np.append(True, (np.diff(corners[order], axis=0) != 0).any(axis=1))[: len(order)]
    number = np.empty(len(corners), np.int64)
    number[order] = np.cumsum(first) - 1
    faces = number.reshape(-1, 3)
    flat = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
    return ParsedTriangles(corners[order[first]], faces[~flat])
