"""What a slice of a volume shows of center lines: their pieces near it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.model.volume.slices import Slice
from cpm_core.contours.contour import Contour
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.numerics.types import Array

_NEAR = 1.5
"""Distance from a slice up to which it shows center lines [voxels]."""


def skeleton_in(found: Skeleton, here: Slice) -> Skeleton:
    """The pieces of center lines near a slice, as those of an image."""
    pieces = [
        piece
        for contour, radii in zip(found.contours, found.radii, strict=True)
        for piece in _pieces(contour.path, np.append(radii, radii[0]) if contour.closed else radii, here)
    ]
    return replace(
        Skeleton((), (), here.sides(found.shape), here.sides(found.spacing), found.unit, found.source),
        contours=tuple(Contour(points, False) for points, _ in pieces),
        radii=tuple(radii for _, radii in pieces),
    )


def _pieces(path: Array, radii: Array, here: Slice) -> list[tuple[Array, Array]]:
    """Stretches of a line near a slice, flattened, with the vertices before and after."""
    near = np.abs(path[:, here.axis] - here.index) <= _NEAR
    cuts = np.flatnonzero(np.diff(near)) + 1
    found = []
    for run in np.split(np.arange(len(path)), cuts):
        if near[run[0]]:
            wider = np.arange(max(run[0] - 1, 0), min(run[-1] + 2, len(path)))
            flat = here.flattened(path[wider])
            moved = np.append(True, (np.diff(flat, axis=0) != 0.0).any(axis=1))
            if moved.sum() > 1:
                found.append((flat[moved], radii[wider][moved]))
    return found
