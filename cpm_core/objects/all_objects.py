"""All objects of an image: parts between contours that the network finds likely, or all that are similar to some."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cached_property

import numpy as np
import scipy
import skimage

from cpm_core.numerics.grids import Window, bounding_window, running_maximum
from cpm_core.numerics.types import Array, Callback, Extent, Index, Mask, record
from cpm_core.objects.boundaries.crossings import find_crossings
from cpm_core.objects.boundaries.necks import split_at_necks
from cpm_core.objects.boundaries.similar_pixels import find_similar_pixels
from cpm_core.objects.confidence import ConfidenceFeatures, estimate_confidence
from cpm_core.objects.partition import Candidate, Partition
from cpm_core.objects.prior.object_predictor import Prediction
from cpm_core.objects.selection import Selection

_SIZE_RANGE = (0.2, 4.0)
"""Smallest and largest area of a similar object, as fractions of the selected one's area."""

_MIN_TRUNCATED_SIZE = 0.05
"""Least area of a similar object cut by the image border, as a fraction of the selected one's area."""

_MIN_RELATIVE_STRENGTH = 0.3
"""Least boundary strength of similar objects, as a fraction of the selected one's."""

_MIN_GAP_DEPTH = 0.75
"""How much deeper parts are than the gap between them [px]."""

_MIN_PART_DEPTH = 1.5
"""Least depth of a part [px]."""

_MIN_PROPOSAL_AREA = 30
"""Least area of a part or an object [px²]."""

_MAX_PART_SHARE = 0.4
"""Largest share of the image that a part covers."""

_MIN_CONTOUR_SHARE = 0.6
"""Least share of the boundary of a part that runs along contours."""

_MIN_VISIBLE_CONTOUR_SHARE = 0.3
"""Least such share for a part that is not seen as a whole."""

_MIN_OWNED_SHARE = 0.5
"""Least share of its boundary that a part owns: the neighbor there is less likely an object."""

_MIN_CONFIDENCE = 0.1
"""Least probability that a proposed object is correct."""

_DEPTH_BLUR_REACH = 4.0
"""Distance up to which other pixels influence the smoothed distance of a pixel from the contours [px]."""

_CONTEXT_LENGTHS = 0.75
"""Distance from the middle of an object up to which the network sees its surroundings, in object lengths."""

_CONTEXT_MARGIN = 16
"""Addition to that distance [px]."""

_MAX_OVERLAP = 0.3
"""Share of an object above which it is a duplicate, unless one of the two is nested in the other."""

_MIN_NESTED_SHARE = 0.95
"""Least share of the smaller object that lies in the larger one if it is nested."""

_MAX_NESTED_AREA = 0.6
"""Largest area of a nested object, as a fraction of the larger one's area."""

_MAX_SHARED_RIM = 0.3
"""Largest share of the boundary of a nested object that runs along the boundary of the larger one."""


def find_similar_objects(partition: Partition, chosen: Selection) -> Iterator[Selection]:
    """Find the objects similar to a selected one, from the top left to the bottom right.

    Their gray level differs from the surroundings of the selected object in the same direction, and their size and the
    strength of their boundary are similar. Where two bodies touch, they are split at the neck between them. Objects
    that the border of the image cuts are closed along it, and may be smaller.
    """
    area = float(np.count_nonzero(chosen.mask))
    if not area:
        return
    parts = split_at_necks(
        find_similar_pixels(partition.values, chosen.mask, partition.interest), float(np.sqrt(area / np.pi))
    )
    parts[chosen.mask] = 0
    limit, strength = np.array(partition.shape) - 1, _measure_boundary_strength(chosen)
    boxes = enumerate(scipy.ndimage.find_objects(parts), start=1)
    for number, box in ((number, box) for number, box in boxes if box):
        body = parts[box] == number
        cut = any(part.start == 0 or part.stop > last for part, last in zip(box, limit.tolist(), strict=True))
        if (_MIN_TRUNCATED_SIZE if cut else _SIZE_RANGE[0]) * area <= np.count_nonzero(body) <= _SIZE_RANGE[1] * area:
            mask = np.zeros(partition.shape, bool)
            mask[box] = _find_largest_component(body)
            other = _build_proposal(partition, mask)
            if _measure_boundary_strength(other) >= _MIN_RELATIVE_STRENGTH * strength:
                yield other


def find_objects_everywhere(partition: Partition, check: Callback = lambda: None) -> Iterator[Selection]:
    """Find all objects of an image: unambiguous ones, and parts between contours that are likely objects.

    Parts meet where the gaps between contours are narrowest. Of two parts with a common stretch of boundary, the one
    that is more likely an object owns it; a part that owns little of its boundary is background of the others. `check`
    is called between the parts, and may raise to end the search.
    """
    for mask, features, unambiguous in find_object_candidates(ImageParts.from_partition(partition), check):
        yield _build_proposal(partition, mask, features, unambiguous=unambiguous)


@record
class ImageParts:
    """Parts of an image between contours.

    Attributes
    ----------
    partition : Partition
        The image with the contours.
    labels : ndarray of int64, shape (H, W)
        Numbers of the parts, from 1; a single part where the network is not used.
    areas : ndarray of int64, shape (N + 1,)
        Area of each [px²].
    contour_fraction : ndarray, shape (N + 1,)
        Share of its boundary that runs along contours.
    link_part, link_neighbor : ndarray of int64, shape (L,)
        The two parts at each link between pixels of different parts, in both directions.
    may_change : ndarray of bool, shape (N + 1,)
        Which parts may look different in the larger image around this one; see `ParentImage`.
    """

    partition: Partition
    labels: Index
    areas: Index
    contour_fraction: Array
    link_part: Index
    link_neighbor: Index
    may_change: Mask

    @classmethod
    def from_partition(cls, partition: Partition) -> ImageParts:
        """Divide an image into the parts between its contours."""
        shape, none = partition.shape, np.zeros(0, np.int64)
        if not partition.uses_network or not partition.contours:
            labels, count = np.ones(shape, np.int64), np.array([0, math.prod(shape)])
            return cls(partition, labels, count, np.zeros(2), none, none, np.zeros(2, bool))
        lines = find_crossings([contour.path for contour in partition.contours], shape).pixels
        depth = scipy.ndimage.gaussian_filter(scipy.ndimage.distance_transform_edt(~lines), 1.0)
        tops = skimage.morphology.h_maxima(depth, _MIN_GAP_DEPTH)  # type: ignore[no-untyped-call]
        markers, _ = scipy.ndimage.label((tops > 0) & (depth > _MIN_PART_DEPTH), np.ones((3, 3)))
        labels = np.asarray(skimage.segmentation.watershed(-depth, markers), np.int64)  # type: ignore[no-untyped-call]
        near, sides, along = running_maximum(lines, 1), [], []
        for here, there in (np.s_[1:, :], np.s_[:-1, :]), (np.s_[:, 1:], np.s_[:, :-1]):
            links = np.nonzero(labels[here] != labels[there])
            sides.append(np.stack([labels[here][links], labels[there][links]]))
            along.append(near[there][links])
        one, other = np.concatenate(sides, axis=1)
        one, other, on = np.concatenate([one, other]), np.concatenate([other, one]), np.tile(np.concatenate(along), 2)
        pixels = np.bincount(labels.ravel())
        ends = np.array(_find_inner_borders(partition))
        rim = [np.moveaxis(labels, axis, 0)[end] for axis, end in ((0, 0), (0, -1), (1, 0), (1, -1))]
        borders = [line for line, inner in zip(rim, ends.T.ravel(), strict=True) if not inner]
        around = np.bincount(np.concatenate([one, *borders]), minlength=len(pixels))
        bounded = np.bincount(one[on], minlength=len(pixels)) / np.maximum(around, 1)
        cut = np.zeros(len(pixels), bool)
        cut[labels[depth + _DEPTH_BLUR_REACH > _measure_border_distance(shape, ends)]] = True
        return cls(partition, labels, pixels, bounded, one, other, cut)

    @cached_property
    def _may_be_object(self) -> Mask:
        """Which parts may be objects, shape (N + 1,)."""
        parent = self.partition.parent
        most = _MAX_PART_SHARE * math.prod(self.partition.shape if parent is None else parent.shape)
        bounded = self.contour_fraction >= np.where(self.may_change, _MIN_VISIBLE_CONTOUR_SHARE, _MIN_CONTOUR_SHARE)
        wanted = (self.areas >= _MIN_PROPOSAL_AREA) & (self.areas <= most) & bounded
        wanted[0] = False
        return np.asarray(wanted)

    @cached_property
    def _boxes(self) -> list[Window]:
        return scipy.ndimage.find_objects(self.labels)

    def is_settled(self, core: Window) -> bool:
        """Return whether the objects that touch the pixels of a window would be the same in a larger image."""
        touching = np.unique(self.labels[core])
        near = np.union1d(touching, self.link_neighbor[np.isin(self.link_part, touching)])
        near = near[self._may_be_object[near]]
        inner, shape = np.array(_find_inner_borders(self.partition)), np.array(self.partition.shape)
        for box in (self._boxes[number - 1] for number in near.tolist()):
            low, high = np.array([[side.start, side.stop] for side in box]).T
            reach = _CONTEXT_LENGTHS * (high - low).max() + _CONTEXT_MARGIN
            seen = 0.5 * (low + high) + np.array([[-reach], [reach]])
            if (inner & [seen[0] < 0, seen[1] > shape]).any():
                return False
        return not self.may_change[near].any()

    def evaluate_parts(self, taken: Mask, check: Callback) -> dict[int, Prediction]:
        """Evaluate the parts that may be objects by the network: number -> prediction.

        `taken`, shape (H, W), are pixels of objects already found; parts that mostly lie in them are left out.
        """

        def evaluate_part(number: int) -> Prediction | None:
            check()
            box = self._boxes[number - 1]
            within = self.labels[box] == number
            if np.count_nonzero(within & taken[box]) > _MAX_OVERLAP * self.areas[number]:
                return None
            mask = np.zeros(self.labels.shape, bool)
            mask[box] = within
            return self.partition.evaluate_mask(mask)

        answers = (
            (number, evaluate_part(number))
            for number in np.flatnonzero(self._may_be_object & ~self.may_change).tolist()
        )
        return {number: one for number, one in answers if one is not None}

    def measure_boundary_ownership(self, predictions: Mapping[int, Prediction]) -> Array:
        """Measure the share of its boundary that each part owns, shape (N + 1,), the image border left out.

        `predictions` are by part number; of two parts, the one of higher predicted overlap owns the boundary.
        """
        worth = np.zeros(len(self.areas))
        worth[list(predictions)] = [one.predicted_iou for one in predictions.values()]
        around = np.bincount(self.link_part, minlength=len(worth))
        won = np.bincount(self.link_part[worth[self.link_part] > worth[self.link_neighbor]], minlength=len(worth))
        return won / np.maximum(around, 1)


def _find_inner_borders(partition: Partition) -> list[tuple[bool, ...]]:
    """Return whether the first rows and columns of an image, and the last, lie inside a larger one, shape (2, 2)."""
    parent = partition.parent
    if parent is None:
        return [(False, False), (False, False)]
    sides = list(zip(parent.corner, partition.shape, parent.shape, strict=True))
    return [tuple(first > 0 for first, _, _ in sides), tuple(first + n < whole for first, n, whole in sides)]


def _measure_border_distance(shape: Extent, inner: Mask) -> Array:
    """Measure the distance of each pixel from the ends that lie within a larger image, shape (H, W) [px]."""
    lines = []
    for axis, n in enumerate(shape):
        away = np.full(n, np.inf)
        for at, each in zip((np.arange(n), np.arange(n)[::-1]), inner[:, axis].tolist(), strict=True):
            away = np.minimum(away, at) if each else away
        lines.append(away)
    return np.minimum.outer(*lines)


def find_object_candidates(parts: ImageParts, check: Callback = lambda: None) -> Iterator[Candidate]:
    """Find the pixels of the objects of `find_objects_everywhere`, without their outlines."""
    partition = parts.partition
    known: list[tuple[Window, Mask]] = []
    taken = np.zeros(partition.shape, bool)
    for mask in partition.find_unambiguous_objects():
        box = bounding_window(mask)
        known.append((box, mask[box]))
        taken[box] |= scipy.ndimage.binary_fill_holes(mask[box])
        yield Candidate(mask, unambiguous=True)
    predictions = parts.evaluate_parts(taken, check)
    owned = parts.measure_boundary_ownership(predictions)
    for number, likely in sorted(predictions.items(), key=lambda item: -item[1].predicted_iou):
        mask = likely.mask & partition.interest
        pixels = np.count_nonzero(mask)
        features = ConfidenceFeatures(*likely[2:], point_count=0)
        if (
            estimate_confidence(features) < _MIN_CONFIDENCE
            or owned[number] < _MIN_OWNED_SHARE
            or pixels < _MIN_PROPOSAL_AREA
        ):
            continue
        over = np.count_nonzero(mask & taken) / pixels
        if over <= _MAX_OVERLAP:
            mask = _find_largest_component(mask & ~taken)
        elif not all(_is_disjoint_or_nested(mask, *other) for other in known):
            continue
        box = bounding_window(mask)
        known.append((box, mask[box]))
        taken |= mask
        yield Candidate(mask, features)


def _is_disjoint_or_nested(mask: Mask, box: Window, there: Mask) -> bool:
    """Return whether an object, shape (H, W), and another in a box are disjoint, or one lies deep in the other."""
    both = np.count_nonzero(mask[box] & there)
    if not both:
        return True
    other = np.zeros_like(mask)
    other[box] = there
    small, large = (mask, other) if np.count_nonzero(mask) < np.count_nonzero(there) else (other, mask)
    if both < _MIN_NESTED_SHARE * np.count_nonzero(small) or both > _MAX_NESTED_AREA * np.count_nonzero(large):
        return False
    rim = small & ~scipy.ndimage.binary_erosion(small)
    return bool((~scipy.ndimage.binary_erosion(large, iterations=3))[rim].mean() <= _MAX_SHARED_RIM)


def _build_proposal(
    partition: Partition, mask: Mask, features: ConfidenceFeatures | None = None, *, unambiguous: bool = False
) -> Selection:
    """Build the selection of some pixels, shape (H, W), with the deepest of them as its positive point."""
    box = bounding_window(mask)
    depth = scipy.ndimage.distance_transform_edt(np.pad(mask[box], 1))
    place = np.argwhere(depth == depth.max())[:1] - 1.0 + [side.start for side in box]
    if features is None:
        features = (
            ConfidenceFeatures(*partition.evaluate_mask(mask, place)[2:], point_count=0)
            if partition.uses_network
            else ConfidenceFeatures(point_count=0)
        )
    return partition.build_selection(mask, place, features=features, unambiguous=unambiguous)


def _find_largest_component(mask: Mask) -> Mask:
    """Find the largest connected part of a mask."""
    parts, _ = scipy.ndimage.label(mask)
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    return parts == sizes.argmax()


def _measure_boundary_strength(selection: Selection) -> float:
    """Measure the mean edge strength along the boundary [gray levels / px]."""
    lengths = np.array([contour.length for contour in selection.contours])
    strengths = np.array([contour.strength for contour in selection.contours])
    return float(lengths @ strengths / lengths.sum()) if len(lengths) else 0.0
