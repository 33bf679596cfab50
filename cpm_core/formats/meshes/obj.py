"""OBJ: surfaces of drawing and animation programs, as text."""

from __future__ import annotations

import io

import numpy as np

from cpm_core.formats.meshes.coordinates import ExportMesh
from cpm_core.formats.meshes.triangles import ParsedTriangles, triangulate_polygons

_GROUP_PREFIX = "object_"
"""Prefix of the names of groups that are objects; their number follows."""


def encode_obj(mesh: ExportMesh) -> bytes:
    """Encode a surface with its normals as OBJ."""
    stream = io.BytesIO()
    stream.write("".join(f"# {note}\n" for note in mesh.notes).encode())
    np.savetxt(stream, mesh.points, "v" + 3 * f" %.{mesh.decimals}f")
    np.savetxt(stream, mesh.normals, "vn %.5f %.5f %.5f")
    for number in (None,) if mesh.numbers is None else np.unique(mesh.numbers):
        faces = mesh.faces
        if mesh.numbers is not None:
            stream.write(f"g {_GROUP_PREFIX}{number}\n".encode())
            faces = mesh.faces[mesh.numbers == number]
        np.savetxt(stream, np.repeat(faces + 1, 2, axis=1), "f %d//%d %d//%d %d//%d")
    return stream.getvalue()


def read_obj(content: bytes) -> ParsedTriangles:
    """Read the triangles of a file, skipping lines and points; UnreadableError when it has none."""
    points: list[list[str]] = []
    counts: list[int] = []
    corners: list[int] = []
    number, numbers = 0, []
    for line in content.decode("utf-8", "replace").replace("\\\n", " ").splitlines():
        match line.split():
            case ["v", x, y, z, *_]:
                points.append([x, y, z])
            case ["f", *words]:
                ends = [int(word.partition("/")[0]) for word in words]
                counts.append(len(ends))
                corners += [end - 1 if end > 0 else len(points) + end for end in ends]
                numbers.append(number)
            case ["g", *words]:
                name = " ".join(words)
                number = int(name[len(_GROUP_PREFIX) :]) if name.startswith(_GROUP_PREFIX) else 0
    faces, polygon = triangulate_polygons(counts, corners)
    objects = np.array(numbers, np.int64)[polygon] if min(numbers) > 0 else None
    return ParsedTriangles(np.array(points, float).reshape(-1, 3), faces, objects)
