"""OBJ: the surface with its normals as text, for drawing and animation programs."""

from __future__ import annotations

import io

import numpy as np

from cpm_core.contours.result import Result
from cpm_core.formats.meshes.world import mesh_of
from cpm_core.image.geometry import Convention
from cpm_core.medial_axis.skeleton import Skeleton

GROUP = "object_"
"""What the names of groups begin with that are objects; their number follows."""


def encode(result: Result | Skeleton, space: Convention = "LPS") -> bytes:
    """Make an OBJ file of the surface of a result; ValueError when it has none."""
    mesh = mesh_of(result, space)
    stream = io.BytesIO()
    stream.write("".join(f"# {note}\n" for note in mesh.notes).encode())
    np.savetxt(stream, mesh.points, "v" + 3 * f" %.{mesh.decimals}f")
    np.savetxt(stream, mesh.normals, "vn %.5f %.5f %.5f")
    for number in (None,) if mesh.numbers is None else np.unique(mesh.numbers):
        faces = mesh.faces
        if mesh.numbers is not None:
            stream.write(f"g {GROUP}{number}\n".encode())
            faces = mesh.faces[mesh.numbers == number]
        np.savetxt(stream, np.repeat(faces + 1, 2, axis=1), "f %d//%d %d//%d %d//%d")
    return stream.getvalue()
