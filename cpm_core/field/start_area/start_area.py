"""The area of a start: the pixels around it up to the edges that enclose it, by which a run is limited.

The part of the start that no edge crosses is flooded in the edge map against the border of the image (watershed by
flooding from markers, Meyer 1994, doi:10.1016/0165-1684(94)90060-4). The two meet on the edges that are highest between
them, also across gaps. A closed line may have been drawn around an object: if the object is bounded by edges about as
strong as those around the whole start, its area is the one of the start (`find_surrounded_object`).

The area depends on the start and the gray levels of the field alone, on no parameter of the particles.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy
import skimage

from cpm_core.field.edge_map import smoothed_gradient, vector_magnitudes
from cpm_core.field.start_area.drawn_area import (
    MIN_DRAWN_PLACES,
    clicked_area,
    drawn_area,
    hollow_part,
    is_everywhere,
    typical_radius,
)
from cpm_core.field.start_area.surrounded_object import find_surrounded_object
from cpm_core.numerics.grids import Labels, expand_window, flood_from_markers, label_parts
from cpm_core.numerics.types import Array, Extent, Mask

_SIGMA_PER_RADIUS = 0.1
"""Smoothing of the edge map in radii of the start: details much smaller than the start do not bound it."""

_MIN_AREA_SIGMA = 1.0
"""Least smoothing of the edge map [px]."""

_MAX_AREA_SIGMA = 4.0
"""Greatest smoothing of the edge map [px]."""

_CROSSING_FRACTION = 0.5
"""Edge strength, in multiples of the largest one in a piece of the start, above which an edge crosses the piece."""

_MIN_PART_SHARE = 0.3
"""Least size of a part of the start that counts beside the largest one, as a fraction of it."""

_FLAT_STRENGTH = 0.02
"""Fraction of the largest edge strength up to which the image is flat."""

_MAX_COVERED_SHARE = 0.5
"""Largest fraction of the image that a start covers, unless it is one from everywhere."""

_MAX_FLOODED_PIXELS = 400_000
"""Size above which the flooding takes place on a coarser grid."""

_BOUNDARY_WIDTH = 1.0
"""Distance from the boundary up to which an area includes the edge that makes it, beyond the smoothing [px]."""

_MIN_OBJECT_SHARE = 0.15
"""Least share of the area of a start that an object in it has."""

_MIN_OBJECT_STRENGTH = 0.9
"""Least strength of the boundary of that object, in multiples of the boundary of the whole start."""

_MAX_SHARE_AT_LINE = 0.2
"""Largest share of that boundary at the drawn line: the line runs across anything else."""

_LINE_DISTANCE = 0.1
"""Distance up to which a boundary is at the drawn line, in radii of the start."""

_MIN_LINE_DISTANCE = 1.5
"""Least such distance [px]."""


class _Ground(NamedTuple):
    """Where areas are flooded: image, edge strength and shut pixels, shape (h, w), on a grid of `stride` [px]."""

    values: Array
    strength: Array
    shut: Mask
    stride: int


def find_start_area(values: Array, start: Array, closed: Mask) -> tuple[Mask, Mask] | None:
    """Find the area of a start; None for one from everywhere, or in the open, whose area is the whole image.

    Parameters
    ----------
    values : ndarray, shape (H, W)
        Image.
    start : ndarray, shape (N, 2)
        Seeds [px].
    closed : ndarray of bool, shape (H, W)
        Where no particle goes: outside the regions of interest, and on barriers.

    Returns
    -------
    inside, boundary : ndarray of bool, shape (H, W)
        Pixels of the area with the edges that bound it, and those along these edges.
    """
    if not len(start) or is_everywhere(start, values.shape):
        return None
    drawn = (clicked_area if len(start) < MIN_DRAWN_PLACES else drawn_area)(start, values.shape)
    hollow = hollow_part(start, drawn)
    if np.count_nonzero(drawn & ~hollow) > _MAX_COVERED_SHARE * drawn.size:
        return None
    ground, sigma = _prepare_ground(values, drawn, closed)
    pieces = _label_pieces(drawn, closed, ground.stride)
    inside = _find_enclosed_objects(ground, pieces, hollow[:: ground.stride, :: ground.stride])
    rest = np.where(np.isin(pieces, np.setdiff1d(pieces[inside], 0)), 0, pieces)
    if rest.any():
        basin = None if drawn.mean() > _MAX_COVERED_SHARE else _flood_basin(ground, rest)
        if basin is None:
            return None
        inside |= basin
    sides = zip(values.shape, inside.shape, strict=True)
    half = ground.stride // 2
    inside = inside[np.ix_(*(np.minimum((np.arange(n) + half) // ground.stride, m - 1) for n, m in sides))]
    border = _find_borders(inside) & ~closed
    if not border.any():
        return None
    boundary = scipy.ndimage.distance_transform_edt(~border) <= _BOUNDARY_WIDTH + sigma
    return inside | boundary, boundary


def object_enclosed_by(values: Array, places: Array, closed: Mask) -> Mask | None:
    """Return the object, shape (H, W), that places, shape (N, 2) [px], are drawn around; None when they lie in it.

    `closed` is as for `find_start_area`.
    """
    if len(places) < MIN_DRAWN_PLACES:
        return None
    drawn = drawn_area(places, values.shape)
    hollow = hollow_part(places, drawn)
    if not hollow.any():
        return None
    ground, _ = _prepare_ground(values, drawn, closed, coarse=False)
    found = _find_enclosed_objects(ground, _label_pieces(drawn, closed, 1), hollow)
    return found if found.any() else None


def _prepare_ground(values: Array, drawn: Mask, closed: Mask, coarse: bool = True) -> tuple[_Ground, float]:
    """Return where to flood for a drawn start, in a large image if `coarse` on fewer pixels, and the smoothing [px]."""
    sigma = float(np.clip(_SIGMA_PER_RADIUS * typical_radius(drawn), _MIN_AREA_SIGMA, _MAX_AREA_SIGMA))
    stride = int(np.ceil(np.sqrt(values.size / _MAX_FLOODED_PIXELS))) if coarse else 1
    sigma = max(sigma, 0.5 * stride)
    grid = slice(None, None, stride), slice(None, None, stride)
    strength = vector_magnitudes(smoothed_gradient(values, sigma))[grid]
    shut = closed[grid] | _border_frame(strength.shape, sigma / stride)
    return _Ground(values[grid], strength, shut, stride), sigma


def _flood_basin(ground: _Ground, pieces: Labels) -> Mask | None:
    """Flood from the pieces of a start against the border of the image; None where most of them lie in the open.

    Of each piece those parts count that no edge crosses. Flat pixels that are connected to the border are flooded from
    there, unless the start lies on some of them.
    """
    strength, shut = ground.strength, ground.shut
    marker = np.zeros(strength.shape, bool)
    boxes = scipy.ndimage.find_objects(pieces)
    for number in np.setdiff1d(pieces, 0).tolist():
        box = boxes[number - 1]
        piece = (pieces[box] == number) & ~shut[box]
        strongest = float(strength[box].max(where=piece, initial=0.0))
        parts, _ = scipy.ndimage.label(piece & (strength[box] <= _CROSSING_FRACTION * strongest))
        size = np.bincount(parts.ravel())
        size[0] = 0
        marker[box] |= (size >= max(_MIN_PART_SHARE * size.max(), 1))[parts] if size.any() else piece
    if not marker.any():
        return marker
    flat, _ = scipy.ndimage.label((strength <= _FLAT_STRENGTH * float(strength.max())) & ~shut)
    in_open = np.isin(flat, np.setdiff1d(flat[scipy.ndimage.binary_dilation(shut)], 0))
    if 2 * np.count_nonzero(in_open & marker) > np.count_nonzero(marker):
        return None
    beyond = shut if (in_open & marker).any() else shut | in_open
    return flood_from_markers(strength, np.where(marker, 1, 2 * beyond).astype(np.int32)) == 1


def _find_enclosed_objects(ground: _Ground, pieces: Labels, hollow: Mask) -> Mask:
    """Return the objects that pieces of a start have been drawn around."""
    found, rim = np.zeros(pieces.shape, bool), scipy.ndimage.binary_dilation(ground.shut)
    boxes = scipy.ndimage.find_objects(pieces)
    for number in np.setdiff1d(pieces[hollow], 0).tolist():
        box = expand_window(boxes[number - 1], 1, pieces.shape)
        piece = pieces[box] == number
        inner = find_surrounded_object(ground.values[box], ground.strength[box], piece & ~ground.shut[box])
        if (
            np.count_nonzero(inner) < _MIN_OBJECT_SHARE * np.count_nonzero(piece)
            or _share_at_line(piece, inner) > _MAX_SHARE_AT_LINE
        ):
            continue
        basin = flood_from_markers(ground.strength, np.where(pieces == number, 1, 2 * ground.shut).astype(np.int32))
        if _usual_strength(ground.strength[box], inner, rim[box]) > _MIN_OBJECT_STRENGTH * _usual_strength(
            ground.strength, basin == 1, rim
        ):
            found[box] |= inner
    return found


def _share_at_line(piece: Mask, inner: Mask) -> float:
    """Return the share of the boundary of an object that lies at the border of the piece of a start around it."""
    depth = scipy.ndimage.distance_transform_edt(piece)
    along = depth[inner & ~np.asarray(scipy.ndimage.binary_erosion(inner, border_value=1))]
    near = max(_LINE_DISTANCE * float(depth.max()), _MIN_LINE_DISTANCE)
    return float((along <= near).mean()) if along.size else 0.0


def _usual_strength(strength: Array, mask: Mask, rim: Mask) -> float:
    """Return the median edge strength along the boundary of a mask, except at shut pixels; 0 where there is none."""
    along = strength[_find_borders(mask) & ~rim]
    return float(np.median(along)) if along.size else 0.0


def _label_pieces(area: Mask, closed: Mask, stride: int) -> Labels:
    """Label the connected pieces of a start from 1, on a coarser grid; also those that lie between its pixels."""
    pieces, _ = label_parts(area)
    coarse = np.where(closed, 0, pieces)[::stride, ::stride]
    lost = np.setdiff1d(pieces, coarse)
    if not len(lost):
        return np.asarray(coarse, np.int32)
    around = scipy.ndimage.maximum_filter(np.where(np.isin(pieces, lost), pieces, 0), stride)[::stride, ::stride]
    return np.asarray(np.where(coarse > 0, coarse, around), np.int32)


def _border_frame(shape: Extent, sigma: float) -> Mask:
    """Return the pixels at the image border, which often has a line along it that bounds nothing."""
    frame = np.ones(shape, bool)
    width = 1 + round(sigma)
    frame[width:-width, width:-width] = False
    return frame


def _find_borders(mask: Mask) -> Mask:
    """Return the pixels on both sides of the border of a mask, not counting the image border."""
    find: Callable[[Mask], Mask] = skimage.segmentation.find_boundaries
    return find(mask)
