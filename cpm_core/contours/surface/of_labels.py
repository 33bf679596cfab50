"""The surfaces of the objects of a label volume."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.contours.surface import Surface
from cpm_core.numerics.grids import zero_surface

_ROOM = 1
"""Voxels around an object in which its surface lies."""


def surface_of_labels(
    labels: NDArray[np.int32], spacing: tuple[float, ...], unit: str | None, *, open_border: bool = False
) -> Surface:
    """The surfaces halfway between the voxels of labels and their neighbors.

    At the border of the volume they are closed, or with `open_border` open, as the objects may go on beyond it. With
    a single label the connected parts are the objects, and none has a number.
    """
    places, corners, numbers, count = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], [np.empty(0, np.int64)], 0
    parts: Sequence[tuple[slice, ...] | None] = scipy.ndimage.find_objects(labels)
    for number, part in enumerate(parts, start=1):
        if part is None:
            continue
        room = tuple(slice(max(side.start - _ROOM, 0), side.stop + _ROOM) for side in part) if open_border else part
        inside = labels[room] == number if open_border else np.pad(labels[room] == number, _ROOM)
        begin = [side.start - (0 if open_border else _ROOM) for side in room]
        vertices, faces = zero_surface(inside.astype(np.float32) - np.float32(0.5))
        places.append(vertices + begin)
        corners.append(faces + count)
        numbers.append(np.full(len(faces), number))
        count += len(vertices)
    of = np.concatenate(numbers) if sum(part is not None for part in parts) > 1 else None
    return Surface(np.concatenate(places), np.concatenate(corners), spacing, unit, numbers=of)
