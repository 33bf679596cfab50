"""Corrections: what a point changes that contradicts a body.

Near the boundary it only moves the boundary. Else it adds the part that edges enclose, or removes the part behind a
neck; where there is none, the network answers in the slices through it, and on from these.
"""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.grids import (
    first_pixel,
    flood_from_markers,
    label_parts,
    measure_depth,
    nearest_pixels,
    spread_labels,
)
from cpm_core.numerics.types import Array, Mask, Single
from cpm_core.objects.boundaries.necks import measure_hull, split_at_clear_necks, split_at_necks
from cpm_core.objects.prior.body_prediction import MAX_LOGIT, BodyPrediction
from cpm_core.objects.prior.crops import average_blocks
from cpm_core.objects.prior.intensity_refinement import refine_by_intensity
from cpm_core.objects.prior.network import Network
from cpm_core.objects.prior.slice_propagation import propagate_correction
from cpm_core.objects.prior.volume_slices import CropContext

_CORRECTION_WEIGHT = 2.0
"""Weight of slice logits that a correction has led to, as a multiple of their first weight."""

_BOUNDARY_TOLERANCE = 1.5
"""Distance from the boundary up to which a point only moves the boundary [smallest sides of a voxel]."""

_BODY_BASIN = 1
"""Number of the basin of the body."""

_OUTSIDE_BASIN = 2
"""Number of the basin outside."""

_MIN_ADDED_STRENGTH = 0.5
"""Least edge strength around an added part, as a fraction of that along the boundary of the body."""

_MAX_NECK_RADIUS = 3
"""Half the width of the widest neck [steps]."""

_MIN_PART_SOLIDITY = 0.8
"""Least volume of a part between necks, in volumes of its convex hull."""

_POINT_NEIGHBORHOOD = 2
"""Distance from a point within which a change is due to it [steps]."""


def correct_in_crop(
    body: BodyPrediction, context: CropContext, point: Array, adds: bool, network: Network
) -> BodyPrediction:
    """Correct a body in a crop by a point, shape (3,), that contradicts it, and `adds` to it or removes from it.

    Of bodies that touch, such as nuclei in a clump, only the one is added that holds the point.
    """
    before = body.resample_in(context.crop)
    slice_logits = _correct_slice_logits(before, context, context.crop.to_crop_steps(point), adds, network)
    logits = refine_by_intensity(context, slice_logits)
    logits = np.maximum(logits, before.logits) if adds else np.minimum(logits, before.logits)
    after = BodyPrediction(context.crop, slice_logits, logits)
    part = find_part_at_necks(after, point, clear=True) if adds else None
    if part is None:
        return after
    found = ((part.slice_logits, before.slice_logits), (part.logits, before.logits))
    return BodyPrediction(context.crop, *(np.maximum(one, other) for one, other in found))


def _correct_slice_logits(
    body: BodyPrediction, context: CropContext, step: Array, adds: bool, network: Network
) -> Single:
    """Correct the logits of the slices by a point [steps]."""
    if _is_at_boundary(body, step):
        return body.slice_logits
    changed = _add_by_watershed(body, context) if adds else _cut_at_neck(body, context, step)
    if changed is None:
        logits, share = propagate_correction(context, body, step, adds, network)
        largest = _CORRECTION_WEIGHT * MAX_LOGIT
        logits = np.clip(_CORRECTION_WEIGHT**2 * logits, -largest, largest)
        return np.asarray(share * logits + (1.0 - share) * body.slice_logits, np.float32)
    # at the rim of the change gray levels decide
    weight = np.where(changed, 1.0, 0.0) + (_CORRECTION_WEIGHT - 1.0) * scipy.ndimage.binary_erosion(changed)
    return np.where(changed, (MAX_LOGIT if adds else -MAX_LOGIT) * weight.astype(np.float32), body.slice_logits)


def _is_at_boundary(body: BodyPrediction, step: Array) -> bool:
    """Return whether a step lies so near to the boundary of a body that its point only moves the boundary."""
    ways = np.concatenate([np.eye(3), -np.eye(3)]) * (_BOUNDARY_TOLERANCE / body.crop.step_size)
    near = scipy.ndimage.map_coordinates(body.logits, (step + ways).T, order=1, mode="nearest") > 0.0
    return bool(near.any() and not near.all())


def _add_by_watershed(body: BodyPrediction, context: CropContext) -> Mask | None:
    """Find the part that edges enclose together with points that a body lacks.

    Basins of the edge map are flooded from the body and its points, and from the sides of the crop and negative points
    (watershed from markers: Meyer 1994, doi:10.1016/0165-1684(94)90060-4). None unless the boundary of the new part is
    about as strong as that of the body.
    """
    before = average_blocks(body.logits, 2) > 0.0
    edges = scipy.ndimage.gaussian_gradient_magnitude(average_blocks(context.grays, 2), 1.0)
    markers = np.where(before, _BODY_BASIN, 0).astype(np.int32)
    for axis in range(3):
        np.moveaxis(markers, axis, 0)[[0, -1]] = _OUTSIDE_BASIN
    for steps, basin in ((context.negative, _OUTSIDE_BASIN), (context.positive, _BODY_BASIN)):
        blocks = nearest_pixels((steps - 0.5) / 2.0, before.shape)
        markers[tuple(blocks.T)] = basin
    added = (flood_from_markers(edges, markers) == _BODY_BASIN) & ~before
    along = scipy.ndimage.binary_dilation(added) & ~added & ~scipy.ndimage.binary_dilation(before, iterations=2)
    around = before & ~scipy.ndimage.binary_erosion(before)
    if not along.any() or not around.any() or np.median(edges[along]) < _MIN_ADDED_STRENGTH * np.median(edges[around]):
        return None
    return np.asarray(added.repeat(2, axis=0).repeat(2, axis=1).repeat(2, axis=2))


def _cut_at_neck(body: BodyPrediction, context: CropContext, step: Array) -> Mask | None:
    """Find the part of a body that holds a step and lies behind a neck, seen from the positive points; else None."""
    whole = body.logits > 0.0
    if not whole.any():
        return None
    box = scipy.ndimage.find_objects(whole.astype(np.int8))[0]
    before, removed = whole[box], np.zeros_like(whole)
    depth = measure_depth(before)
    first, last = first_pixel(box), np.array(before.shape) - 1
    inner = tuple(np.clip(np.rint(context.positive) - first, 0, last).astype(np.int64).T)
    outer = tuple(np.clip(np.rint(step) - first, 0, last).astype(np.int64))
    for radius in range(1, _MAX_NECK_RADIUS + 1):
        parts, _ = scipy.ndimage.label(depth > radius)
        held = np.setdiff1d(parts[inner], 0)
        if not len(held):
            return None
        if parts[outer] in held:
            continue
        kept = scipy.ndimage.distance_transform_edt(~np.isin(parts, held)) <= radius + 1.0
        rest, _ = label_parts(before & ~kept)
        if rest[outer] and rest[outer] not in rest[inner]:
            removed[box] = rest == rest[outer]
            return removed
    return None


def find_part_at_necks(body: BodyPrediction, point: Array, *, clear: bool = False) -> BodyPrediction | None:
    """Find the part of a body that holds a point, shape (3,), once it is split at its necks.

    None without a neck, and where the part is not nearly convex, as an arc of a ring. If necks must be `clear`, all
    parts are nearly convex.
    """
    step = nearest_pixels(body.crop.to_crop_steps(point), body.logits.shape)
    pieces, _ = scipy.ndimage.label(body.logits > 0.0)
    if not pieces[tuple(step)]:
        return None
    whole = pieces == pieces[tuple(step)]
    inside = average_blocks(whole.astype(np.float32), 2) > 0.5
    parts = split_at_clear_necks(inside) if clear else split_at_necks(inside)
    number = parts[tuple(step // 2)]
    if not number or parts.max() == 1:
        return None
    part = parts == number
    if np.count_nonzero(part) < _MIN_PART_SOLIDITY * measure_hull(part):
        return None
    near = spread_labels(parts).repeat(2, axis=0).repeat(2, axis=1).repeat(2, axis=2)
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
    near[
        tuple(
            slice(max(step - _POINT_NEIGHBORHOOD, 0), step + _POINT_NEIGHBORHOOD + 1)
            for step in np.rint(after.crop.to_crop_steps(point)).astype(int)
        )
    ] = True
    held = np.isin(parts, np.setdiff1d(parts[near], 0))
    return np.asarray((scipy.ndimage.binary_dilation(held, iterations=2) | near) & changed)
