"""The boundary of the area that a start lies in: where its free flight ends.

A particle that flies from the start comes to rest on the first edges that hold it. Single particles slip through weak
stretches, so the first edges are found for each connected piece of the start as a whole: its basin in the edge map is
flooded against those of the other pieces and one from the border of the image (watershed by flooding from markers,
Meyer 1994, doi:10.1016/0165-1684(94)90060-4). They meet on the edges that are highest between them, also across gaps.
Two pieces in one object, with no edge between them, share a basin. Areas within a basin that other edges, strong enough
to hold particles, enclose are left out again.

A closed line may also have been drawn around an object (`find_surrounded_object`). Then it is bounded by the edges of
that object, if these are stronger than those around the whole start.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy
import skimage

from cpm_core.field.edge_map import background_strength, smoothed_gradient, vector_magnitudes
from cpm_core.field.scale_field import WEAKEST_EDGE
from cpm_core.numerics.grids import Labels, label_joined_pairs
from cpm_core.numerics.types import Array, Extent, Mask
from cpm_core.segmentation.reach.drawn_area import (
    MIN_DRAWN_PLACES,
    drawn_area,
    hollow_part,
    is_everywhere,
    typical_radius,
)
from cpm_core.segmentation.reach.surrounded_object import find_surrounded_object, flood_from_markers

_SIGMA_PER_RADIUS = 0.1
"""Smoothing of the edge map in radii of the start: details much smaller than the start do not bound it."""

_MIN_BOUNDS_SIGMA = 1.0
"""Least smoothing of the edge map [px]."""

_MAX_BOUNDS_SIGMA = 4.0
"""Greatest smoothing of the edge map [px]."""

_HOLDING_FRACTION = 1.0
"""Strength, in multiples of the usual one of the boundary, of edges that enclose something else within the basin; it
falls with the squared damping, as the kinetic energy of a particle that flies freely."""

_HOLDING_BETA = 0.8
"""Damping at which that strength applies."""

_FLAT_STRENGTH = 0.02
"""Fraction of the largest edge strength up to which the image is flat."""

_MIN_FLAT_SHARE = 0.04
"""Least fraction of the start that a flat part must cover."""

_JOINING_FRACTION = 0.5
"""Strength of the border between the basins of two pieces of a start, in multiples of the weaker one of their other
boundaries, below which both lie in the same object."""

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

_MAX_COVERED_SHARE = 0.5
"""Largest fraction of the image that a start covers, unless it is one from everywhere."""

MIN_DAMPING = 0.01
"""Damping that counts where there is less."""

_MIN_PART_AREA = 16
"""Least area that edges enclose within a basin [px²]: smaller parts are details."""

_MIN_PART_OF_START = 0.1
"""Least such area, in areas of the start."""

_MAX_FLOODED_PIXELS = 400_000
"""Size above which the flooding takes place on a coarser grid."""


class Bounds(NamedTuple):
    """Boundary of the area that a start lies in.

    Attributes
    ----------
    area : ndarray of bool, shape (H, W)
        Pixels that the start covers.
    boundary : ndarray of bool, shape (H, W)
        Pixels next to it, on both sides.
    inside : ndarray of bool, shape (H, W)
        Pixels that it encloses.
    sigma : float
        Smoothing of the edge map that it was found in, and about the error of its position [px].
    whole : bool
        Whether no piece of the start is cut by it.
    around : bool
        Whether a piece of the start has been drawn around an object.
    """

    area: Mask
    boundary: Mask
    inside: Mask
    sigma: float
    whole: bool
    around: bool


def find_bounds(values: Array, start: Array, closed: Mask, beta: float) -> Bounds | None:
    """Find the boundary of the area that a start lies in, or of the object that it surrounds; None for one everywhere.

    Parameters
    ----------
    values : ndarray, shape (H, W)
        Image.
    start : ndarray, shape (N, 2)
        Seeds [px].
    closed : ndarray of bool, shape (H, W)
        Where no particle goes: outside the regions of interest, and on barriers.
    beta : float
        Damping: the less, the stronger an edge must be to hold a particle.
    """
    if is_everywhere(start, values.shape):
        return None
    return _bounds_unless_everywhere(values, *_drawn_and_hollow(start, values.shape), closed, beta)


def object_enclosed_by(values: Array, places: Array, closed: Mask) -> Mask | None:
    """Return the object, shape (H, W), that places, shape (N, 2) [px], are drawn around; None when they lie in it.

    `closed` is as for `find_bounds`.
    """
    if len(places) < MIN_DRAWN_PLACES:
        return None
    area, hollow = _drawn_and_hollow(places, values.shape)
    bounds = _bounds_unless_everywhere(values, area, hollow, closed, _HOLDING_BETA) if hollow.any() else None
    return bounds.inside if bounds is not None and bounds.around else None


def _drawn_and_hollow(start: Array, shape: Extent) -> tuple[Mask, Mask]:
    """Return the area that a start covers, and the part of it that it only encloses."""
    area = drawn_area(start, shape)
    return area, hollow_part(start, area)


def _bounds_unless_everywhere(values: Array, area: Mask, hollow: Mask, closed: Mask, beta: float) -> Bounds | None:
    """Return the bounds of a start, unless it covers so much of the image that it is one from everywhere."""
    if not area.any() or np.count_nonzero(area & ~hollow) > _MAX_COVERED_SHARE * area.size:
        return None
    found = _compute_bounds(values, area, hollow, closed, beta)
    return found if found.around or area.mean() <= _MAX_COVERED_SHARE else None


def _compute_bounds(values: Array, area: Mask, hollow: Mask, closed: Mask, beta: float) -> Bounds:
    """Compute the bounds of a start, on a coarser grid in a large image."""
    sigma = float(np.clip(_SIGMA_PER_RADIUS * typical_radius(area), _MIN_BOUNDS_SIGMA, _MAX_BOUNDS_SIGMA))
    stride = int(np.ceil(np.sqrt(values.size / _MAX_FLOODED_PIXELS)))
    sigma = max(sigma, 0.5 * stride)
    strength = vector_magnitudes(smoothed_gradient(values, sigma))[::stride, ::stride]
    shut = closed[::stride, ::stride] | _border_frame(strength.shape, sigma / stride)
    drawn = _label_pieces(area, closed, stride)
    pieces, labels = _split_basins(strength, drawn, shut, beta)
    surrounded = _find_enclosed_objects(
        values[::stride, ::stride], strength, drawn, hollow[::stride, ::stride], labels, shut
    )
    if surrounded.any():
        rest = np.where(np.isin(drawn, np.setdiff1d(drawn[surrounded], 0)), 0, drawn).astype(np.int32)
        pieces, labels = _split_basins(strength, rest, shut | surrounded, beta)
        labels[surrounded] = pieces[surrounded] = max(int(labels.max()), int(pieces.max())) + 1
    touched = np.unique(np.stack([pieces, labels])[:, (pieces > 0) & (labels > 0)], axis=1)
    own = np.zeros(labels.max() + 1, bool)
    own[touched[1]] = True
    beside = _label_borders(np.where(own[labels], labels, 0)) & ~_dilate_once(shut)
    sides = zip(values.shape, beside.shape, strict=True)
    grid = np.ix_(*(np.minimum((np.arange(n) + stride // 2) // stride, m - 1) for n, m in sides))
    beside, inside = beside[grid], own[labels][grid]
    whole = touched.shape[1] == len(np.unique(touched[0])) > 0
    return Bounds(area, beside, inside, sigma, whole, bool(surrounded.any()))


def _split_basins(strength: Array, pieces: Labels, shut: Mask, beta: float) -> tuple[Labels, Labels]:
    """Return the pieces of a start, one number for those in one basin, and the parts of their basins."""
    pieces, basins = _flood_basins(strength, pieces, shut)
    return pieces, _label_basin_parts(strength, pieces, basins, beta)


def _find_enclosed_objects(
    values: Array, strength: Array, pieces: Labels, hollow: Mask, labels: Labels, shut: Mask
) -> Mask:
    """Return the objects that pieces of a start have been drawn around."""
    found, rim = np.zeros(pieces.shape, bool), _dilate_once(shut)
    boxes = scipy.ndimage.find_objects(pieces)
    for number in np.setdiff1d(pieces[hollow], 0).tolist():
        box = tuple(slice(max(side.start - 1, 0), side.stop + 1) for side in boxes[number - 1])
        piece = pieces[box] == number
        inner = find_surrounded_object(values[box], strength[box], piece & ~shut[box])
        if (
            np.count_nonzero(inner) < _MIN_OBJECT_SHARE * np.count_nonzero(piece)
            or _share_at_line(piece, inner) > _MAX_SHARE_AT_LINE
        ):
            continue
        bounded = np.isin(labels, np.setdiff1d(labels[box][piece], 0))
        if _usual_strength(strength[box], inner, rim[box]) > _MIN_OBJECT_STRENGTH * _usual_strength(
            strength, bounded, rim
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
    along = strength[_label_borders(mask.astype(np.int32)) & ~rim]
    return float(np.median(along)) if along.size else 0.0


def _label_pieces(area: Mask, closed: Mask, stride: int) -> Labels:
    """Label the connected pieces of a start from 1, on a coarser grid; also those that lie between its pixels."""
    pieces, _ = scipy.ndimage.label(area, np.ones((3, 3), bool))
    coarse = np.where(closed, 0, pieces)[::stride, ::stride]
    lost = np.setdiff1d(pieces, coarse)
    if not len(lost):
        return np.asarray(coarse, np.int32)
    around = scipy.ndimage.maximum_filter(np.where(np.isin(pieces, lost), pieces, 0), stride)[::stride, ::stride]
    return np.asarray(np.where(coarse > 0, coarse, around), np.int32)


def _flood_basins(strength: Array, pieces: Labels, shut: Mask) -> tuple[Labels, Labels]:
    """Return the pieces of a start, and their basins, flooded in the edge map against each other and what is shut.

    Where flat parts of a piece are enclosed by edges and others are not, only the first count; where none is
    enclosed, the piece lies in the open, and everything else belongs to its basin. Pieces in one basin get one number.
    """
    flat, count = scipy.ndimage.label((strength <= _FLAT_STRENGTH * float(strength.max())) & ~shut)
    size = np.bincount((pieces * (count + 1) + flat).ravel(), minlength=(pieces.max() + 1) * (count + 1)).reshape(
        -1, count + 1
    )
    large = size >= np.maximum(_MIN_FLAT_SHARE * size.sum(axis=1, keepdims=True), 1)
    large[0], large[:, 0] = False, False
    open_ = np.zeros(count + 1, bool)
    open_[flat[_dilate_once(shut)]] = True
    enclosed, opened = (large & ~open_).any(axis=1), (large & open_).any(axis=1)
    pieces = np.where((enclosed & opened)[pieces] & ~(large & ~open_)[pieces, flat], 0, pieces).astype(np.int32)
    background = int(pieces.max()) + 1
    markers = np.where(shut | (large & open_)[enclosed].any(axis=0)[flat], background, 0).astype(np.int32)
    bounded = (pieces > 0) & ~(opened & ~enclosed)[pieces]
    markers[bounded] = pieces[bounded]
    basins = np.where(shut, background, 1).astype(np.int32)
    if bounded.any():
        basins = flood_from_markers(strength, markers)
    number = _join_weak_borders(strength, basins, background)
    number[0], number[background] = 0, 0
    in_open = opened & ~enclosed
    if in_open.any():
        number = np.append(number, number.max() + 1)
        number[np.flatnonzero(in_open)] = number[-1]
        basins[(basins == background) & ~shut] = background + 1
    return number[pieces], number[basins]


def _join_weak_borders(strength: Array, basins: Labels, background: int) -> Labels:
    """Label the basins, neighbors alike whose common border is weak next to the rest of their boundaries."""
    count = background + 1
    pairs, crossed = [np.zeros((2, 0), np.int32)], [np.zeros(0)]
    for axis in range(2):
        line, height = np.moveaxis(basins, axis, 0), np.moveaxis(strength, axis, 0)
        other = line[1:] != line[:-1]
        pairs.append(np.sort(np.stack([line[1:][other], line[:-1][other]]), axis=0))
        crossed.append(np.maximum(height[1:], height[:-1])[other])
    pair, height = np.concatenate(pairs, axis=1), np.concatenate(crossed)
    code = pair[0] * count + pair[1]
    borders = np.unique(code)
    median = np.asarray(scipy.ndimage.median(height, code, borders)) if len(borders) else np.zeros(0)
    one, other = borders // count, borders % count
    outer = np.full(count, np.inf)
    outer[one[other == background]] = median[other == background]
    usual = np.minimum(outer[one], outer[other])
    weak = (other < background) & np.isfinite(usual) & (median < _JOINING_FRACTION * usual)
    return (label_joined_pairs((one[weak], other[weak]), count) + 1).astype(np.int32)


def _label_basin_parts(strength: Array, pieces: Labels, basins: Labels, beta: float) -> Labels:
    """Label the parts of the basins that edges strong enough separate, from 1; 0 outside."""
    every = np.arange(basins.max() + 1)
    rim = np.where(_label_borders(basins), basins, 0)
    along = rim > 0
    along.flat[0] = True  # no median of nothing
    usual = np.nan_to_num(scipy.ndimage.median(strength[along], rim[along], every))
    strongest = np.zeros(len(every))
    np.maximum.at(strongest, basins.ravel(), strength.ravel())
    least = np.maximum(WEAKEST_EDGE * strongest, np.minimum(background_strength(strength), usual))
    level = np.maximum(_HOLDING_FRACTION * usual * (_HOLDING_BETA / max(beta, MIN_DAMPING)) ** 2, least)
    numbered: Callable[..., Labels] = skimage.measure.label
    parts = numbered(np.where(strength < level[basins], basins, 0), connectivity=1)
    basin_of_part = np.zeros(parts.max() + 1, np.int32)
    basin_of_part[parts] = basins
    size = np.bincount(parts.ravel())
    small = size < np.maximum(
        _MIN_PART_AREA, _MIN_PART_OF_START * np.bincount(pieces.ravel(), minlength=len(every))[basin_of_part]
    )
    small[0] = True
    parts[small[parts]] = 0
    held = np.zeros(len(every), bool)
    held[basins[(pieces > 0) & (pieces == basins) & (parts > 0)]] = True
    whole = ~held[basins] & (basins > 0)
    parts[whole] = parts.max() + basins[whole]
    return flood_from_markers(strength, parts.astype(np.int32), basins > 0)


def _border_frame(shape: Extent, sigma: float) -> Mask:
    """Return the pixels at the image border, which often has a line along it that bounds nothing."""
    frame = np.ones(shape, bool)
    width = 1 + round(sigma)
    frame[width:-width, width:-width] = False
    return frame


def _label_borders(labels: Labels) -> Mask:
    """Return the pixels next to one of another label, not counting the image border."""
    beside = np.zeros(labels.shape, bool)
    for axis in range(2):
        line, out = np.moveaxis(labels, axis, 0), np.moveaxis(beside, axis, 0)
        other = line[1:] != line[:-1]
        out[1:] |= other
        out[:-1] |= other
    return beside


def _dilate_once(shut: Mask) -> Mask:
    """Return the pixels of a mask and those next to it."""
    return scipy.ndimage.binary_dilation(shut)
