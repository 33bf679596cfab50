"""The boundary of what a start lies in: where its free flight ends.

A particle that flies from the start comes to rest on the first edges that hold it. Single particles slip through weak
stretches, so the first edges are found for the start as a whole: the basin of the start in the edge map is flooded
against one from the border of the image (watershed by flooding from markers, Meyer 1994,
doi:10.1016/0165-1684(94)90060-4). Both meet on the edges that are highest between the start and the border, also across
gaps. What other edges, strong enough to hold particles, enclose within the basin is left out again.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy
import skimage
from numpy.typing import NDArray

from cpm_core.field.edge_map import background_strength, gradient, magnitude
from cpm_core.field.scale_field import WEAKEST_EDGE
from cpm_core.numerics.types import Array, Mask
from cpm_core.segmentation.reach.drawn_area import radius_of

Labels = NDArray[np.int32]

_SIGMA_OF_RADIUS, _LEAST_SIGMA, _MOST_SIGMA = 0.1, 1.0, 4.0
"""Smoothing of the edge map in radii of the start, and its limits [px]: details much smaller than what has been drawn
do not bound it."""

_HOLDS, _BETA = 1.0, 0.8
"""Strength, in multiples of the usual one of the boundary, of the edges that enclose something else within the basin,
at this damping; it falls with the squared damping, as the kinetic energy of a particle that flies freely."""

_EVEN, _LARGE = 0.02, 0.04
"""Fraction of the largest edge strength up to which the image is flat, and of the start that a flat part must cover."""

_LEAST_BETA = 0.01
"""Damping that counts where there is less."""

_LEAST_PART, _PART_OF_START = 16, 0.1
"""Least area of what edges enclose within a basin, in px² and in areas of the start: smaller parts are details."""

_MOST_PIXELS = 400_000
"""Size above which the flooding takes place on a coarser grid."""


class Bounds(NamedTuple):
    """The boundary of what a start lies in.

    Attributes
    ----------
    boundary : ndarray of bool, shape (H, W)
        Pixels beside it, on both sides.
    inside : ndarray of bool, shape (H, W)
        What it encloses.
    sigma : float
        Smoothing of the edge map that it was found in, about its inaccuracy [px].
    whole : bool
        Whether the start lies on one side of it; otherwise it also runs through the start.
    """

    boundary: Mask
    inside: Mask
    sigma: float
    whole: bool


def bounds_of(values: Array, area: Mask, closed: Mask, beta: float) -> Bounds:
    """Find the boundary of what a start lies in.

    Parameters
    ----------
    values : ndarray, shape (H, W)
        Image.
    area : ndarray of bool, shape (H, W)
        What the start covers, `drawn_area`.
    closed : ndarray of bool, shape (H, W)
        Where no particle goes: outside the regions of interest, and on barriers.
    beta : float
        Damping: the less, the stronger an edge must be to hold a particle.
    """
    sigma = float(np.clip(_SIGMA_OF_RADIUS * radius_of(area), _LEAST_SIGMA, _MOST_SIGMA))
    stride = int(np.ceil(np.sqrt(values.size / _MOST_PIXELS)))
    sigma = max(sigma, 0.5 * stride)
    strength = magnitude(gradient(values, sigma))[::stride, ::stride]
    start, shut = area[::stride, ::stride] & ~closed[::stride, ::stride], closed[::stride, ::stride]
    shut = shut | _frame(shut.shape, sigma / stride)
    if not start.any():
        start = scipy.ndimage.maximum_filter(area, stride)[::stride, ::stride]
    start, basin = _basin(strength, start, shut)
    labels = _parts(strength, start, basin, beta)
    own = np.zeros(labels.max() + 1, bool)
    own[labels[start]] = True
    own[0] = False
    beside = _beside(np.where(own[labels], labels, 0)) & ~_rim(shut)
    if stride > 1:
        beside, inside = (_enlarged(mask, stride, values.shape) for mask in (beside, own[labels]))
    else:
        inside = own[labels]
    return Bounds(beside, inside, sigma, int(own.sum()) == 1)


def _basin(strength: Array, start: Mask, shut: Mask) -> tuple[Mask, Mask]:
    """The start, and its basin in the edge map, flooded against what is shut, the image border among it.

    Where flat parts of the start are enclosed by edges and others are not, only the first count; where none is
    enclosed, the start lies in the open, and everything belongs to its basin.
    """
    flat, count = scipy.ndimage.label((strength <= _EVEN * float(strength.max())) & ~shut)
    size = np.bincount(flat[start], minlength=count + 1)
    large = size >= _LARGE * np.count_nonzero(start)
    large[0] = False
    open_ = np.zeros(count + 1, bool)
    open_[flat[_rim(shut)]] = True
    enclosed = large & ~open_
    outside = shut.copy()
    if enclosed.any() and (large & open_).any():
        outside |= (large & open_)[flat]
        start = start & enclosed[flat]
    elif (large & open_).any():
        return start, ~shut
    markers = np.zeros(strength.shape, np.int32)
    markers[outside] = 2
    markers[start] = 1
    return start, np.asarray(_flooded(strength, markers) == 1)


def _parts(strength: Array, start: Mask, basin: Mask, beta: float) -> Labels:
    """Number the parts of a basin that edges strong enough separate, from 1; 0 outside."""
    rim = _rim(~basin) & basin
    usual = float(np.median(strength[rim])) if rim.any() else 0.0
    strongest = float(strength[basin].max())
    least = max(WEAKEST_EDGE * strongest, min(background_strength(strength), usual))
    level = max(_HOLDS * usual * (_BETA / max(beta, _LEAST_BETA)) ** 2, least)
    parts, count = scipy.ndimage.label(basin & (strength < level))
    size = np.bincount(parts.ravel(), minlength=count + 1)
    small = size < max(_LEAST_PART, _PART_OF_START * np.count_nonzero(start))
    small[0] = True
    parts[small[parts]] = 0
    if not parts[start].any():
        return basin.astype(np.int32)
    return _flooded(strength, parts.astype(np.int32), basin)


def _flooded(strength: Array, markers: Labels, basin: Mask | None = None) -> Labels:
    """Labels of the markers that reach each pixel of a basin, or of the image, over the lowest edges."""
    flood: Callable[..., Labels] = skimage.segmentation.watershed
    return np.asarray(flood(strength, markers, mask=basin), np.int32)


def _frame(shape: tuple[int, ...], sigma: float) -> Mask:
    """Pixels at the image border, which often has a line along it that bounds nothing."""
    frame = np.ones(shape, bool)
    width = 1 + round(sigma)
    frame[width:-width, width:-width] = False
    return frame


def _beside(labels: Labels) -> Mask:
    """Pixels beside one of another label, not counting the image border."""
    beside = np.zeros(labels.shape, bool)
    for axis in range(2):
        line, out = np.moveaxis(labels, axis, 0), np.moveaxis(beside, axis, 0)
        other = line[1:] != line[:-1]
        out[1:] |= other
        out[:-1] |= other
    return beside


def _rim(shut: Mask) -> Mask:
    """Pixels of a mask and those beside it."""
    return np.asarray(scipy.ndimage.binary_dilation(shut))


def _enlarged(mask: Mask, stride: int, shape: tuple[int, ...]) -> Mask:
    """A mask on a coarser grid, on the pixels of an image."""
    row, col = (
        np.minimum((np.arange(n) + stride // 2) // stride, m - 1) for n, m in zip(shape, mask.shape, strict=True)
    )
    return np.asarray(mask[np.ix_(row, col)])
