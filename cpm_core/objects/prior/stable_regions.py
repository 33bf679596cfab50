"""Stable regions: what is connected to a point and has about its gray level, whatever the network says."""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce
from itertools import accumulate

import numpy as np
import scipy

from cpm_core.numerics.grids import Values, compute_iou, nearest_pixels, running_maximum, window_around
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Index, Mask, Single
from cpm_core.objects.prior.body_prediction import EXCLUDED_LOGIT, MAX_LOGIT, BodyPrediction
from cpm_core.objects.prior.crops import average_blocks, repeat_blocks
from cpm_core.objects.prior.intensity_refinement import refine_by_intensity
from cpm_core.objects.prior.volume_slices import CropContext

_GRAY_TOLERANCES = 8.0 * 1.25 ** np.arange(12)
"""Differences from the gray level of a point."""

_MAX_STABLE_GROWTH = 0.2
"""Largest growth of the logarithm of a volume from one tolerance to the next where it is stable."""

_MAX_CUT_SIZE = 0.8
"""Largest size of a region without its bridges, as a fraction of its size with them: else little hangs on them."""

_MIN_STABLE_SIZE = 0.9
"""Least size of a region without wider bridges, as a fraction of that without narrower ones, where it is stable."""

_MIN_OPENED_SIZE = 500
"""Least size of a region whose bridges are cut; a closer crop shows more of smaller ones [steps twice as long]."""

_BESIDE = np.eye(3, dtype=np.int64), 1 - np.eye(3, dtype=np.int64)
"""Reaches of the boxes that hold the neighbors of a step by faces, and those by faces or edges [steps]."""

_BALLS = tuple(_BESIDE[number % 2] for number in range(5))
"""What makes the radius of a ball larger by one step, up to that of the widest bridges that are cut."""

_OPENED_MARGIN = 2
"""Distance up to which gray levels widen an opened region [steps twice as long]."""

_THIN_BRIDGE_RADIUS = 3
"""Radius of the bridges that gray levels lead over, which are cut last [steps]."""

MIN_RELATIVE_EDGE = 0.35
"""Strength of an edge, in medians around a region, below which there is a gap."""

SAME_GAP_SHARE = 0.02
"""Difference between shares of gaps that says nothing."""


def find_stable_regions(context: CropContext) -> Iterator[Mask]:
    """Find regions connected to the first positive point whose gray levels differ little from its own.

    Only those tolerances count at which the region hardly grows (maximally stable regions: Matas et al. 2004,
    doi:10.1016/j.imavis.2004.02.006). Bridges narrower than three steps are cut. Yields masks, shape
    (CROP_SIDE, CROP_SIDE, CROP_SIDE).
    """
    step = tuple(nearest_pixels(context.positive[0], context.grays.shape).tolist())
    grays = scipy.ndimage.gaussian_filter(context.grays, 1.0)
    difference = np.abs(grays - grays[step])
    for axis, (first, last) in enumerate(context.inner_steps.tolist()):
        slices = np.moveaxis(difference, axis, 0)
        slices[:first], slices[last + 1 :] = np.inf, np.inf
    rank = np.searchsorted(_GRAY_TOLERANCES, difference, side="right").astype(np.uint8)
    rank = _find_largest_beside(rank, _BESIDE[0]).astype(np.int64)
    joined = np.full(rank.shape, len(_GRAY_TOLERANCES), np.int64)
    _join_by_rank(rank.ravel(), int(np.ravel_multi_index(step, rank.shape)), joined.reshape(-1))
    sizes = np.cumsum(np.bincount(joined.ravel(), minlength=len(_GRAY_TOLERANCES) + 1))[:-1]
    growth = np.diff(np.log(np.maximum(sizes, 1)))
    beside = np.pad(growth, 1, constant_values=_MAX_STABLE_GROWTH)
    is_stable = (growth <= beside[:-2]) & (growth < beside[2:]) & (sizes[:-1] > 1)
    for number in np.flatnonzero(is_stable).tolist():
        near = reduce(_find_largest_beside, [_BESIDE[0]] * 2, joined <= number)
        yield near & (difference < _GRAY_TOLERANCES[number])


def predict_opened_body(context: CropContext, before: BodyPrediction | None = None) -> BodyPrediction | None:
    """Predict the body around the positive points that is left once it is cut from what it touches in many places.

    So a brain is found in a head. On steps twice as long, bridges of growing width are cut from what lies within each
    tolerance of the gray levels of the points (morphological opening) until hardly more is lost. Of these regions that
    hold all positive and no negative points it is the one most like a body before, or else, of those with the fewest
    gaps in the edges around them, the one that grows least with the next tolerance; None if there is none. Gray levels
    widen it a little, and thin bridges to where they lead are cut again; beyond these it stays outside in corrections.
    """
    grays = scipy.ndimage.gaussian_filter(average_blocks(context.grays, 2), 0.5)
    inner, outer = (nearest_pixels(0.5 * steps - 0.25, grays.shape) for steps in (context.positive, context.negative))
    levels = [np.median(grays[window_around(step, 1)]) for step in inner]
    difference = np.abs(grays - np.clip(grays, min(levels), max(levels)))
    for axis, (first, last) in enumerate((context.inner_steps // 2).tolist()):
        slices = np.moveaxis(difference, axis, 0)
        slices[:first], slices[last + 1 :] = np.inf, np.inf
    largest = list(accumulate(_BALLS, _find_largest_beside, initial=difference))
    opened = {tolerance: _cut_bridges(largest, tolerance, inner[0]) for tolerance in _GRAY_TOLERANCES.tolist()}
    fits = {
        tolerance: region
        for tolerance, region in opened.items()
        if region is not None and region[tuple(inner.T)].all() and not region[tuple(outer.T)].any()
    }
    if not fits:
        return None
    if before is None:
        tolerance = _find_clearest(fits, grays)
    else:
        known = average_blocks((before.logits > 0.0).astype(np.float32), 2) > 0.5
        tolerance = min(fits, key=lambda each: np.count_nonzero(fits[each] ^ known))
    best, leads = fits[tolerance], difference < tolerance
    near, reached = (scipy.ndimage.binary_dilation(best, None, _OPENED_MARGIN, within) for within in (None, leads))
    coarse = np.where(best, MAX_LOGIT, np.where(near & (reached | ~leads), -MAX_LOGIT, EXCLUDED_LOGIT))
    slice_logits = repeat_blocks(coarse.astype(np.float32), 2)
    logits = refine_by_intensity(context, slice_logits)
    inside = logits > 0.0
    core = ~reduce(_find_largest_beside, _BALLS[:_THIN_BRIDGE_RADIUS], ~inside)
    left = _open_around(inside, core, nearest_pixels(context.positive[0], inside.shape), _THIN_BRIDGE_RADIUS)
    if left is not None:
        slice_logits, logits = (
            np.where(inside & ~left, np.float32(low), values)
            for low, values in ((EXCLUDED_LOGIT, slice_logits), (-MAX_LOGIT, logits))
        )
    return BodyPrediction(context.crop, slice_logits, logits)


def _find_clearest(regions: dict[float, Mask], grays: Single) -> float:
    """Find the tolerance whose region, of those with the fewest gaps around them, grows least with the next one."""
    edges = scipy.ndimage.maximum_filter(scipy.ndimage.gaussian_gradient_magnitude(grays, 0.5), 3)
    gaps = {}
    for tolerance, region in regions.items():
        rim = edges[scipy.ndimage.binary_dilation(region) & ~scipy.ndimage.binary_erosion(region)]
        gaps[tolerance] = float(np.mean(rim < MIN_RELATIVE_EDGE * np.median(rim)))
    least, grown = min(gaps.values()), [*list(regions.values())[1:], np.zeros_like(grays, np.bool_)]
    same = {
        tolerance: compute_iou(region, larger)
        for (tolerance, region), larger in zip(regions.items(), grown, strict=True)
        if gaps[tolerance] <= least + SAME_GAP_SHARE
    }
    return max(same, key=lambda each: same[each])


def _cut_bridges(largest: list[Single], tolerance: float, step: Index) -> Mask | None:
    """Cut bridges from a region within a tolerance around a step, the thinnest first, until hardly more is lost.

    None unless much is lost before. `largest` are the largest differences within balls of radius 0, 1, ... around each
    step. A part may begin as far from the step as the bridges are wide.
    """
    mask = largest[0] < tolerance
    parts, _ = scipy.ndimage.label(mask)
    before = (parts == parts[tuple(step)]) & mask
    most = _MAX_CUT_SIZE * np.count_nonzero(before)
    if most < _MIN_OPENED_SIZE:
        return None
    for radius in range(1, len(largest)):
        region = _open_around(mask, largest[radius] < tolerance, step, radius)
        size = 0 if region is None else np.count_nonzero(region)
        if region is None or size < _MIN_OPENED_SIZE:
            return None
        left = np.count_nonzero(before)
        if size >= _MIN_STABLE_SIZE * left and left <= most:
            return before
        before = region
    return None


def _open_around(mask: Mask, core: Mask, step: Index, radius: int) -> Mask | None:
    """Open a mask by a ball (morphological opening), and find the part that is left near a step; None without one.

    `core` are the middles of the balls that lie in the mask.
    """
    parts, _ = scipy.ndimage.label(core)
    counts = np.bincount(parts[window_around(step, radius)].ravel())
    if not counts[1:].any():
        return None
    part = parts == 1 + counts[1:].argmax()
    return np.asarray(reduce(_find_largest_beside, reversed(_BALLS[:radius]), part) & mask)


def _find_largest_beside(values: Values, reaches: Index) -> Values:
    """Find the largest of the values at each step and beside it, in boxes of these reaches along the axes."""
    return reduce(np.maximum, [running_maximum(values, reach) for reach in reaches])


@compiled
def _join_by_rank(rank: Index, start: int, joined: Index) -> None:
    """Find the rank at which each step of a crop is joined to a start by steps of no higher rank.

    `rank` and `joined` are cubes as one row; where `joined` is not reached it stays as it is, at the number of ranks.
    """
    side = round(len(rank) ** (1.0 / 3.0))
    count = joined[start]
    first, following = np.full(count, -1), np.full(len(rank), -1)
    if rank[start] < count:
        first[rank[start]] = start
        joined[start] = rank[start]
    for number in range(count):
        while first[number] >= 0:
            at = first[number]
            first[number] = following[at]
            place = at // (side * side), at // side % side, at % side
            for axis in range(3):
                stride = side ** (2 - axis)
                for way in (-1, 1):
                    if 0 <= place[axis] + way < side:
                        beside = at + way * stride
                        if joined[beside] == count and rank[beside] < count:
                            joined[beside] = max(rank[beside], number)
                            following[beside] = first[joined[beside]]
                            first[joined[beside]] = beside
