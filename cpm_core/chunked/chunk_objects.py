"""All objects of one chunk, evaluated as those of the whole image."""

from __future__ import annotations

from dataclasses import replace

from cpm_core.chunked.chunked_contours import ChunkedContours
from cpm_core.chunked.grid import Chunk, box_touches, outer_limits
from cpm_core.chunked.seams import clip_contour
from cpm_core.contours.contour import Contour
from cpm_core.image.image import Image
from cpm_core.numerics.grids import expand_window, first_pixel, relative_window, true_bounds
from cpm_core.objects.all_objects import find_objects_in_parts
from cpm_core.objects.image_parts import ImageParts
from cpm_core.objects.partition import ParentImage, Partition

OBJECT_MARGINS = 128, 384, 1024
"""Margins by which a chunk looks beyond its core, in turn, until it sees all that touches the core [px].

They are multiples of 32, so that the pyramids of neighbors have the same pixels.
"""

_CLEAR_MARGIN = 16
"""Distance from the border of a window within which a closed contour does not count as seen as a whole [px]."""


def find_chunk_objects(found: ChunkedContours, parent: ParentImage, chunk: Chunk) -> list[Contour]:
    """Find the objects whose middle is in the core of a chunk: their contours, each with the number of its object."""
    for margin in OBJECT_MARGINS:
        window = expand_window(chunk.core, margin, parent.shape)
        contours, corner = found.find_contours_near(window), first_pixel(window)
        low, high = outer_limits(window, parent.shape)
        first, last = low + _CLEAR_MARGIN, high - _CLEAR_MARGIN
        lines, is_cut = [], False
        for one in contours:
            if one.closed and (one.box[0] >= first).all() and (one.box[1] <= last).all():
                lines.append(Contour(one.points - corner, True))
            else:
                lines += [Contour(piece.path - corner, False) for piece in clip_contour(one, low, high)]
                is_cut |= one.closed and box_touches(one, chunk.core)
        if not contours:
            return []
        links = tuple(link - corner for link in found.find_links_near(window))
        here = replace(parent, corner=tuple(corner.tolist()))
        image = Image(found.task.source.read_grays(window))
        parts = ImageParts.from_partition(Partition(image, tuple(lines), parent=here, links=links))
        if not is_cut and parts.is_settled(relative_window(chunk.core, window)):
            break
    own = []
    for each in find_objects_in_parts(parts):
        middle = (true_bounds(each.mask) + corner).mean(axis=0)
        if found.grid.find_chunk_numbers(middle[None]) == chunk.number:
            own.append(each.contours)
    return [
        Contour(line.points + corner, True, line.strength, hole=line.hole, group=number)
        for number, contours in enumerate(own, start=1)
        for line in contours
    ]
