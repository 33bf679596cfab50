"""All objects of one chunk, evaluated as those of the whole image."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from cpm_core.chunked.grid import Chunk, ChunkedSource, box_touches
from cpm_core.contours.contour import Contour
from cpm_core.image.image import Image
from cpm_core.numerics.grids import Window, expand_window, relative_window, true_bounds
from cpm_core.numerics.types import Array
from cpm_core.objects.all_objects import find_image_objects
from cpm_core.objects.image_parts import ImageParts
from cpm_core.objects.partition import ParentImage, Partition

OBJECT_MARGINS = 128, 384, 1024
"""Margins by which a chunk looks beyond its core, in turn, until it sees all that touches the core [px].

They are multiples of 32, so that the pyramids of neighbors have the same pixels.
"""

MAX_OBJECT_SIDE = 800.0
"""Longest side of the box of an object that each chunk sees as a whole, with its surroundings for the network [px]."""

_CLEAR_MARGIN = 16
"""Distance from the border of a window within which a closed contour does not count as seen as a whole [px]."""


def find_chunk_objects(
    source: ChunkedSource, find_contours_near: Callable[[Window], Sequence[Contour]], chunk: Chunk, parent: ParentImage
) -> Iterator[tuple[Array, list[Contour]]]:
    """Find the objects whose middle is in the core of a chunk, each with its box and its contours.

    `find_contours_near` gives all contours of the image that reach into a window, so that neighbors see the same ones.
    Yields the box, shape (2, 2), and the closed contours of each object, in px of the image.
    """
    for margin in OBJECT_MARGINS:
        window = expand_window(chunk.core, margin, parent.shape)
        low, high = np.array([[side.start, side.stop] for side in window]).T
        first, end = (
            np.where(low > 0, low + _CLEAR_MARGIN, -1),
            np.where(high < parent.shape, high - _CLEAR_MARGIN, high + 1),
        )
        contours = find_contours_near(window)
        whole = [one.closed and bool((one.box[0] >= first).all() and (one.box[1] < end).all()) for one in contours]
        cut = (one for one, seen in zip(contours, whole, strict=True) if one.closed and not seen)
        if not contours:
            return
        if margin < OBJECT_MARGINS[-1] and any(box_touches(one, chunk.core) for one in cut):
            continue
        lines = (Contour(one.path - low, False) for one in contours)
        seen = tuple(
            Contour(one.points - low, True) if all_of_it else line
            for one, line, all_of_it in zip(contours, lines, whole, strict=True)
        )
        here = replace(parent, corner=tuple(low.tolist()))
        parts = ImageParts.from_partition(Partition(Image(source.read_grays(window)), seen, parent=here))
        if parts.is_settled(relative_window(chunk.core, window)):
            break
    for found in find_image_objects(parts):
        mask = found.region.paste(parts.partition.shape)
        box = low + true_bounds(mask)
        if chunk.may_own(box.mean(axis=0)):
            outlines = (one.contour for one in parts.partition.outline_mask(mask))
            yield box, [Contour(one.points + low, True, one.strength, hole=one.hole) for one in outlines]
