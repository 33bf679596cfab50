"""STL: triangles of programs for printing, as binary numbers or as text; equal corners become one."""

from __future__ import annotations

import re

import numpy as np

from cpm_core.formats.images.decoded import UnreadableError
from cpm_core.formats.meshes.reading.triangles import Triangles
from cpm_core.formats.meshes.stl import HEADER, TRIANGLE

_VERTEX = re.compile(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)", re.IGNORECASE)


def read(content: bytes) -> Triangles:
    """Triangles of a file; UnreadableError when it has none."""
    if len(content) >= HEADER + 4:
        count = int.from_bytes(content[HEADER : HEADER + 4], "little")
        if len(content) >= HEADER + 4 + count * TRIANGLE.itemsize and count:
            corners = np.frombuffer(content, TRIANGLE, count, HEADER + 4)["corners"]
            return _joined(corners.reshape(-1, 3).astype(np.float64), content[:HEADER].decode("latin-1"))
    if not content.lstrip()[:5].lower() == b"solid":
        raise UnreadableError("it has no triangles")
    places = np.array(_VERTEX.findall(content), dtype=np.float64).reshape(-1, 3)
    return _joined(places[: len(places) // 3 * 3], content.lstrip().partition(b"\n")[0].decode("latin-1"))


def _joined(corners: np.ndarray[tuple[int, int], np.dtype[np.float64]], remarks: str) -> Triangles:
    """Triangles with the same vertex wherever corners coincide, without those that have two corners in one place."""
    order = np.lexsort(corners.T)
    new = np.r_[True, (np.diff(corners[order], axis=0) != 0).any(axis=1)][: len(order)]
    number = np.empty(len(corners), np.int64)
    number[order] = np.cumsum(new) - 1
    faces = number.reshape(-1, 3)
    flat = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
    return Triangles(corners[order[new]], faces[~flat], remarks)
