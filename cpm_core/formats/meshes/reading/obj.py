"""OBJ: triangles and polygons of drawing and animation programs, as text; lines and points are passed over."""

from __future__ import annotations

import numpy as np

from cpm_core.formats.images.decoded import UnreadableError
from cpm_core.formats.meshes.obj import GROUP
from cpm_core.formats.meshes.reading.triangles import Triangles, split


def read(content: bytes) -> Triangles:
    """Triangles of a file; UnreadableError when it has none."""
    points: list[list[bytes]] = []
    counts: list[int] = []
    corners: list[int] = []
    remarks: list[str] = []
    number, numbers = 0, []
    for line in content.replace(b"\\\n", b" ").splitlines():
        words = line.split()
        kind = words[0] if words else b""
        if kind == b"v":
            points.append(words[1:4])
        elif kind == b"f":
            ends = [int(word.partition(b"/")[0]) for word in words[1:]]
            counts.append(len(ends))
            corners += [end - 1 if end > 0 else len(points) + end for end in ends]
            numbers.append(number)
        elif kind == b"g":
            name = b" ".join(words[1:]).decode("utf-8", "replace")
            number = int(name[len(GROUP) :]) if name.startswith(GROUP) and name[len(GROUP) :].isdecimal() else 0
        elif kind.startswith(b"#"):
            remarks.append(line.decode("utf-8", "replace").lstrip("# "))
    if not counts:
        raise UnreadableError("it has no triangles")
    faces, of = split(counts, corners)
    whole = np.array(numbers, np.int64)[of] if min(numbers) > 0 else None
    return Triangles(np.array(points, np.float64).reshape(-1, 3), faces, "\n".join(remarks), whole)
