"""Corrections: what a point changes that contradicts a body.

Near the boundary it only moves the boundary. Else it fills a hollow, adds the part between necks that contrasts with
the surroundings as the body does, or removes the part between necks; where there is none, it decides for another body
around the first point or for one that is cut from what it touches, or the network answers in the slices through it,
and on from these.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import scipy

from cpm_core.numerics.grids import nearest_pixels, spread_labels, true_bounds, window_around
from cpm_core.numerics.types import Array, Mask, Single
from cpm_core.objects.boundaries.necks import measure_hull, split_at_necks
from cpm_core.objects.boundaries.similar_pixels import find_similar_pixels
from cpm_core.objects.prior.body_prediction import EXCLUDED_LOGIT, MAX_LOGIT, BodyPrediction, is_different_body
from cpm_core.objects.prior.crops import CROP_SIDE, average_blocks, repeat_blocks
from cpm_core.objects.prior.intensity_refinement import refine_by_intensity
from cpm_core.objects.prior.network import Network
from cpm_core.objects.prior.slice_propagation import propagate_correction
from cpm_core.objects.prior.stable_regions import predict_opened_body
from cpm_core.objects.prior.volume_slices import CropContext

_CORRECTION_WEIGHT = 2.0
"""Weight of slice logits that a correction has led to, as a multiple of their first weight."""

_BOUNDARY_TOLERANCE = 1.5
"""Distance from the boundary up to which a point only moves the boundary [smallest sides of a voxel]."""

_PART_SIGMA = 1.5
"""Sigma of the Gaussian over logits among which a part is looked for, so that noise makes no necks [steps]."""

_MIN_STRENGTH_RATIO = 0.5
"""Least ratio of the edge strengths around an added part and along the boundary of the body, weaker to stronger.

A body that was painted off the edges says nothing about the parts that it lacks.
"""

_MIN_PART_SOLIDITY = 0.8
"""Least volume of a part between necks, in volumes of its convex hull."""

_POINT_NEIGHBORHOOD = 2
"""Distance from a point within which a change is due to it [steps]."""


def correct_in_crop(
    body: BodyPrediction,
    context: CropContext,
    point: Array,
    adds: bool,
    network: Network,
    find_other: Callable[[], BodyPrediction | None],
) -> BodyPrediction:
    """Correct a body in a crop by a point, shape (3,), that contradicts it, and `adds` to it or removes from it.

    `find_other` finds the body that is meant instead where a point removes no part between necks, if there is one.
    """
    before = body.resample_in(context.crop)
    step, slice_logits = context.crop.to_crop_steps(point), before.slice_logits
    if not lies_at_boundary(before, point):
        part = (_find_missing_part if adds else _find_unwanted_part)(before, context, point)
        if part is not None:
            known = np.where(part > 0.0, np.float32(MAX_LOGIT if adds else -MAX_LOGIT), slice_logits)
            logits = np.maximum(part, before.logits) if adds else np.minimum(-part, before.logits)
            return BodyPrediction(context.crop, known, logits)
        other = None if adds else find_other()
        if other is None:
            other = predict_opened_body(context, before)
            other = None if other is None or is_different_body(other.volume, before.volume) else other
        if other is not None:
            return other.resample_in(context.crop)
        if (slice_logits > EXCLUDED_LOGIT).all():
            found, share = propagate_correction(context, before, step, adds, network)
            largest = _CORRECTION_WEIGHT * MAX_LOGIT
            found = np.clip(_CORRECTION_WEIGHT**2 * found, -largest, largest)
            slice_logits = np.asarray(share * found + (1.0 - share) * slice_logits, np.float32)
    logits = refine_by_intensity(context, slice_logits)
    logits = np.maximum(logits, before.logits) if adds else np.minimum(logits, before.logits)
    return BodyPrediction(context.crop, slice_logits, logits)


def lies_at_boundary(body: BodyPrediction, point: Array) -> bool:
    """Return whether a point, shape (3,), lies so near to the boundary of a body that it only moves the boundary."""
    step = body.crop.to_crop_steps(point)
    ways = np.concatenate([np.eye(3), -np.eye(3)]) * (_BOUNDARY_TOLERANCE / body.crop.step_size)
    near = scipy.ndimage.map_coordinates(body.logits, (step + ways).T, order=1, cval=-MAX_LOGIT) > 0.0
    return bool(near.any() and not near.all())


def _find_missing_part(body: BodyPrediction, context: CropContext, point: Array) -> Single | None:
    """Find the hollow, if smaller than the body, or the part like it, up to its necks, that holds a point.

    Returns logits, or None unless the boundaries of the new part and of the body are about as strong.
    """
    inside, within = body.logits > 0.0, np.zeros_like(body.logits, np.bool_)
    if not inside.any():
        return None
    at = tuple(nearest_pixels(context.crop.to_crop_steps(point), inside.shape))
    hollows, _ = scipy.ndimage.label(scipy.ndimage.binary_fill_holes(inside) & ~inside)
    hollow = hollows == hollows[at]
    if hollows[at] and np.count_nonzero(hollow) < np.count_nonzero(inside):
        return np.where(hollow, MAX_LOGIT, -MAX_LOGIT).astype(np.float32)
    within[tuple(slice(first, last + 1) for first, last in context.inner_steps.tolist())] = True
    share = find_similar_pixels(context.grays, inside, within).astype(np.float32)
    logits = np.float32(MAX_LOGIT) * (2.0 * scipy.ndimage.gaussian_filter(share, _PART_SIGMA) - 1.0)
    similar = BodyPrediction(context.crop, logits, logits)
    part = find_part_at_necks(similar, point)
    logits = similar.logits if part is None else part.logits
    pieces, _ = scipy.ndimage.label((logits > 0.0) & ~inside & (body.slice_logits > EXCLUDED_LOGIT))
    if not pieces[at]:
        return None
    added = pieces == pieces[at]
    edges = scipy.ndimage.gaussian_gradient_magnitude(average_blocks(context.grays, 2), 1.0)
    new, before = (average_blocks(mask.astype(np.float32), 2) > 0.5 for mask in (added, inside))
    along = scipy.ndimage.binary_dilation(new) & ~new & ~scipy.ndimage.binary_dilation(before, iterations=2)
    around = before & ~scipy.ndimage.binary_erosion(before)
    if not along.any() or not around.any():
        return None
    new_strength, strength = (float(np.median(edges[where])) for where in (along, around))
    if min(new_strength, strength) < _MIN_STRENGTH_RATIO * max(new_strength, strength):
        return None
    return np.where(added, logits, np.float32(-MAX_LOGIT))


def _find_unwanted_part(body: BodyPrediction, context: CropContext, point: Array) -> Single | None:
    """Find the part of a body that holds a point, between necks; None where it holds positive points."""
    smooth = replace(body, logits=scipy.ndimage.gaussian_filter(body.logits, _PART_SIGMA))
    part = find_part_at_necks(smooth, point)
    inner = nearest_pixels(context.positive, body.logits.shape)
    return None if part is None or (part.logits[tuple(inner.T)] > 0.0).any() else part.logits


def find_part_at_necks(body: BodyPrediction, point: Array) -> BodyPrediction | None:
    """Find the part of a body that holds a point, shape (3,), once it is split at its necks.

    None without a neck, and where the part is not nearly convex, as an arc of a ring.
    """
    step = nearest_pixels(body.crop.to_crop_steps(point), body.logits.shape)
    pieces, _ = scipy.ndimage.label(body.logits > 0.0)
    if not pieces[tuple(step)]:
        return None
    whole = pieces == pieces[tuple(step)]
    times = 1 if max(np.ptp(true_bounds(whole), axis=0)) < CROP_SIDE // 2 else 2
    inside = average_blocks(whole.astype(np.float32), times) > 0.5
    parts = split_at_necks(inside)
    number = parts[tuple(step // times)]
    if not number or parts.max() == 1:
        return None
    part = parts == number
    if np.count_nonzero(part) < _MIN_PART_SOLIDITY * measure_hull(part):
        return None
    near = repeat_blocks(spread_labels(parts), times)
    left_out = np.float32(-MAX_LOGIT)
    logits = np.where(whole & (near == number), body.logits, np.minimum(body.logits, left_out))
    slice_logits = np.where(whole & (near != number), left_out, body.slice_logits)
    return BodyPrediction(body.crop, slice_logits, logits)


def find_changes_near(before: BodyPrediction, after: BodyPrediction, point: Array) -> Mask:
    """Find the steps of a body that a point, shape (3,), has changed, without a rim that leads away from it.

    Returns a mask, shape (CROP_SIDE, CROP_SIDE, CROP_SIDE).
    """
    changed = (before.resample_in(after.crop).logits > 0.0) != (after.logits > 0.0)
    parts, _ = scipy.ndimage.label(scipy.ndimage.binary_erosion(changed))
    near = np.zeros_like(changed)
    near[window_around(nearest_pixels(after.crop.to_crop_steps(point), near.shape), _POINT_NEIGHBORHOOD)] = True
    held = np.isin(parts, np.setdiff1d(parts[near], 0))
    return np.asarray((scipy.ndimage.binary_dilation(held, iterations=2) | near) & changed)
