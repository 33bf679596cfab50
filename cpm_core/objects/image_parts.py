"""Parts of an image between its contours, which meet where the gaps between contours are narrowest."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property

import numpy as np
import scipy

from cpm_core.field.edge_map import edge_map
from cpm_core.numerics.grids import Window, find_high_maxima, flood_from_markers, label_parts, running_maximum
from cpm_core.numerics.types import Array, Extent, Index, Mask, record
from cpm_core.objects.boundaries.crossings import find_crossings
from cpm_core.objects.merged_basins import MIN_OBJECT_AREA, MergedBasins
from cpm_core.objects.partition import Partition

_MIN_GAP_DEPTH = 0.75
"""How much deeper parts are than the gap between them [px]."""

_MIN_PART_DEPTH = 1.5
"""Least depth of a part [px]."""

_MAX_PART_SHARE = 0.4
"""Largest share of the image that a part covers."""

_MIN_CONTOUR_SHARE = 0.6
"""Least share of the boundary of a part that runs along contours."""

_MIN_VISIBLE_CONTOUR_SHARE = 0.3
"""Least such share for a part that is not seen as a whole."""

_DEPTH_BLUR_REACH = 4.0
"""Distance up to which other pixels influence the smoothed distance of a pixel from the contours [px]."""

_CONTEXT_LENGTHS = 0.75
"""Distance from the middle of an object up to which the network sees its surroundings, in object lengths."""

_CONTEXT_MARGIN = 16
"""Addition to that distance [px]."""


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
    lines : ndarray of bool, shape (H, W)
        Pixels that contours cross.
    """

    partition: Partition
    labels: Index
    areas: Index
    contour_fraction: Array
    link_part: Index
    link_neighbor: Index
    may_change: Mask
    lines: Mask

    @classmethod
    def from_partition(cls, partition: Partition) -> ImageParts:
        """Divide an image into the parts between its contours."""
        shape, none = partition.shape, np.zeros(0, np.int64)
        if not partition.uses_network or not partition.contours:
            labels, count = np.ones(shape, np.int64), np.array([0, math.prod(shape)])
            return cls(partition, labels, count, np.zeros(2), none, none, np.zeros(2, bool), np.zeros(shape, bool))
        lines = find_crossings([contour.path for contour in partition.contours], shape).pixels
        depth = scipy.ndimage.gaussian_filter(scipy.ndimage.distance_transform_edt(~lines), 1.0)
        markers, _ = label_parts(find_high_maxima(depth, _MIN_GAP_DEPTH) & (depth > _MIN_PART_DEPTH))
        labels = flood_from_markers(-depth, markers).astype(np.int64)
        near, sides, along = running_maximum(lines, 1), [], []
        for here, there in (np.s_[1:, :], np.s_[:-1, :]), (np.s_[:, 1:], np.s_[:, :-1]):
            links = np.nonzero(labels[here] != labels[there])
            sides.append(np.stack([labels[here][links], labels[there][links]]))
            along.append(near[there][links])
        one, other = np.concatenate(sides, axis=1)
        one, other, on = np.concatenate([one, other]), np.concatenate([other, one]), np.tile(np.concatenate(along), 2)
        pixels = np.bincount(labels.ravel())
        around = np.bincount(one, minlength=len(pixels))  # the border of the image bounds nothing, nor leaves it open
        bounded = np.bincount(one[on], minlength=len(pixels)) / np.maximum(around, 1)
        ends = np.array(_find_inner_borders(partition))
        cut = np.zeros(len(pixels), bool)
        cut[labels[depth + _DEPTH_BLUR_REACH > _measure_border_distance(shape, ends)]] = True
        return cls(partition, labels, pixels, bounded, one, other, cut, lines)

    @cached_property
    def _may_be_object(self) -> Mask:
        """Which parts may be objects, shape (N + 1,)."""
        parent = self.partition.parent
        most = _MAX_PART_SHARE * math.prod(self.partition.shape if parent is None else parent.shape)
        bounded = self.contour_fraction >= np.where(self.may_change, _MIN_VISIBLE_CONTOUR_SHARE, _MIN_CONTOUR_SHARE)
        wanted = (self.areas >= MIN_OBJECT_AREA) & (self.areas <= most) & bounded
        wanted[0] = False
        return np.asarray(wanted)

    @cached_property
    def _boxes(self) -> list[Window]:
        return scipy.ndimage.find_objects(self.labels)

    @property
    def masks(self) -> Iterator[tuple[Window, Mask]]:
        """The parts that may be objects and would be the same in a larger image: their boxes and their pixels there."""
        for number in np.flatnonzero(self._may_be_object & ~self.may_change).tolist():
            box = self._boxes[number - 1]
            yield box, self.labels[box] == number

    @cached_property
    def edge_strength(self) -> Array:
        """Edge map by which boundaries are judged, shape (H, W)."""
        parent = self.partition.parent
        return edge_map(self.partition.values, "auto" if parent is None else parent.smoothing)

    @property
    def merged_masks(self) -> Iterator[tuple[Window, Mask]]:
        """What merged basins may be objects and would be the same in a larger image: boxes, and pixels there."""
        values, span = self.partition.values, self.partition.gray_span
        basins = MergedBasins.from_edges(self.edge_strength, running_maximum(self.lines, 1), span)
        for box, mask in basins.find_regions(values, span):
            if self._is_seen_whole(box):
                yield box, mask

    def _is_seen_whole(self, box: Window) -> bool:
        """Return whether what is in a box ends within the image, or where the larger image around it ends."""
        first = [side.start == 0 for side in box]
        last = [side.stop == n for side, n in zip(box, self.partition.shape, strict=True)]
        return not (np.array([first, last]) & _find_inner_borders(self.partition)).any()

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
