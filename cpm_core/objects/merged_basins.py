"""Basins of the edge map, merged two by two, the weakest boundary first: regions of which no contour need be closed.

Between grains of similar gray levels, or around a leaf with veins as strong as its rim, contours leave openings. The
basins, and what they merge to on the way to the whole image, are the nodes of a tree. Two nodes merge where each is the
one from which the other is parted least, so that what merges depends on what is near alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
import scipy
import skimage

from cpm_core.numerics.grids import Window, flood_from_markers, label_parts
from cpm_core.numerics.types import Array, Index, Mask, Numbers, record
from cpm_core.objects.confidence import FAINT, LARGE_AREA, load_weights

_MIN_BASIN_DEPTH = 0.5
"""Least depth of a basin, in medians of the edge strength."""

_MIN_BASIN_RISE = 0.002
"""Addition to that depth, in differences between white and black [1 / px]."""

_OPEN_WEIGHT = 0.25
"""Weight of a boundary along which no contour runs, where that of a contour is 1."""

_AREA_POWER = 0.15
"""Power of the smaller of two areas with which the boundary between them counts, so that small nodes merge first."""

MIN_OBJECT_AREA = 30
"""Least area of an object [px²]."""

_MIN_ODDS = -3.0
"""Least log odds of a node that may be an object."""

_MAX_DEFICIT = 0.3
"""By how much its log odds may be smaller than those of a node in it or around it."""

_MIN_STRENGTH = 1e-4
"""Least strength of a boundary that others are divided by, in differences between white and black [1 / px]."""

_BORDER_SHARE = 6
"""Place of the share of the boundary that is the border of the image among the features."""

_MAX_BORDER_SHARE = 0.55
"""Largest such share: what an edge bounds less than that, as one half of an image, is not seen to be an object."""

_MAX_INNER = 3.0
"""Strength of the boundaries inside, in that of the one around, above which a larger one makes no difference."""

_MAX_OUTER = 1.2
"""Strength of the boundary to be crossed next, likewise."""


class _Links(NamedTuple):
    """Boundaries between the nodes that touch.

    `one` and `other`, shape (L,), are the nodes. `sums`, shape (L, 3), counts the links between pixels of both, adds
    their edge strengths, and counts those on contours.
    """

    one: Index
    other: Index
    sums: Array

    @classmethod
    def between_basins(cls, labels: Index, strength: Array, on_contours: Mask) -> _Links:
        """Find the boundaries between basins, numbered in `labels`, shape (H, W)."""
        found = []
        for here, there in (np.s_[1:, :], np.s_[:-1, :]), (np.s_[:, 1:], np.s_[:, :-1]):
            at = labels[here] != labels[there]
            between = np.maximum(strength[here], strength[there])[at], (on_contours[here] | on_contours[there])[at]
            found.append(np.stack([labels[here][at], labels[there][at], np.ones(at.sum()), *between]))
        one, other, *sums = np.concatenate(found, axis=1)
        return cls(one.astype(np.int64), other.astype(np.int64), np.stack(sums, axis=1)).joined()

    def joined(self) -> _Links:
        """Join the links between the same two nodes, and leave out those of a node with itself."""
        low, high = np.minimum(self.one, self.other), np.maximum(self.one, self.other)
        apart, count = low != high, int(high.max(initial=0)) + 1
        keys, place = np.unique((low * count + high)[apart], return_inverse=True)
        sums = [np.bincount(place, column, len(keys)) for column in self.sums[apart].T]
        return _Links(keys // count, keys % count, np.stack(sums, axis=1))

    @property
    def strength(self) -> Array:
        """Mean edge strength along each, shape (L,)."""
        return self.sums[:, 1] / self.sums[:, 0]

    def find_weakest(self, area: Array) -> Index:
        """Find the links that are the weakest of both of their nodes, which have an area each, shape (N,)."""
        bounded = _OPEN_WEIGHT + (1.0 - _OPEN_WEIGHT) * self.sums[:, 2] / self.sums[:, 0]
        parting = self.strength * bounded * np.minimum(area[self.one], area[self.other]) ** _AREA_POWER
        order = np.argsort(-parting, kind="stable")
        weakest = np.zeros(len(area), np.int64)
        weakest[np.stack([self.one[order], self.other[order]], axis=1).ravel()] = np.repeat(order, 2)  # the last stays
        number = np.arange(len(order))
        return np.flatnonzero((weakest[self.one] == number) & (weakest[self.other] == number))


@record
class MergedBasins:
    """The tree of the basins of an image.

    Attributes
    ----------
    labels : ndarray of int64, shape (H, W)
        Numbers of the basins, the first of the nodes, from 1.
    parent : ndarray of int64, shape (N,)
        What each node merges to; 0 for the last.
    area : ndarray, shape (N,)
        Area of each [px²].
    around : ndarray, shape (N, 3)
        Number of links between pixels along its boundary, sum of their edge strengths, and number of those on contours.
    inner, outer : ndarray, shape (N,)
        Mean edge strength of the strongest boundary that it has swallowed, and of the one that it merges across.
    """

    labels: Index
    parent: Index
    area: Array
    around: Array
    inner: Array
    outer: Array

    @classmethod
    def from_edges(cls, strength: Array, on_contours: Mask, gray_span: float) -> MergedBasins:
        """Merge the basins of an edge map, shape (H, W), in an image with this difference between white and black."""
        depth = _MIN_BASIN_DEPTH * float(np.median(strength)) + _MIN_BASIN_RISE * gray_span
        bottoms = skimage.morphology.h_minima(strength, depth)  # type: ignore[no-untyped-call]
        markers, count = label_parts(bottoms > 0)
        if not count:  # the edge map is flat
            markers, count = np.ones(strength.shape, np.int64), 1
        labels = flood_from_markers(strength, markers).astype(np.int64)
        links = _Links.between_basins(labels, strength, on_contours)
        size, count = 2 * count, count + 1
        parent = np.zeros(size, np.int64)
        area, inner, outer = np.bincount(labels.ravel(), minlength=size).astype(float), np.zeros(size), np.zeros(size)
        around = np.zeros((size, 3))
        for side in (links.one, links.other):
            np.add.at(around, side, links.sums)
        while len(links.one):
            at = links.find_weakest(area)
            one, other = links.one[at], links.other[at]
            merged = np.arange(count, count + len(at))
            count += len(at)
            parent[one] = parent[other] = merged
            outer[one] = outer[other] = links.strength[at]
            inner[merged] = np.maximum(links.strength[at], np.maximum(inner[one], inner[other]))
            area[merged] = area[one] + area[other]
            around[merged] = around[one] + around[other] - 2.0 * links.sums[at]
            now = np.where(parent > 0, parent, np.arange(size))
            links = _Links(now[links.one], now[links.other], links.sums).joined()
        return cls(labels, parent, area, around, inner, outer)

    def find_regions(self, values: Array, gray_span: float) -> Iterator[tuple[Window, Mask]]:
        """Find the nodes that may be objects of an image, shape (H, W), the likeliest first: boxes and pixels there.

        None is much less likely than what it merges to, or than what was merged to it.
        """
        *weights, offset = load_weights("merged_basins.json", "numbers")
        features = self.encode_nodes(values, gray_span)
        likely = self.find_likely(features @ np.array(weights) + offset)
        yield from self._cut_out(likely[features[likely, _BORDER_SHARE] <= _MAX_BORDER_SHARE].tolist())

    def find_regions_around(self, pixel: tuple[int, int]) -> Iterator[tuple[Window, Mask]]:
        """Find the nodes that hold a pixel and may be objects, the smallest first: boxes and pixels there."""
        nodes = [int(self.labels[pixel])]
        while self.parent[nodes[-1]]:
            nodes.append(int(self.parent[nodes[-1]]))
        yield from self._cut_out(node for node in nodes if self.area[node] >= MIN_OBJECT_AREA)

    def _cut_out(self, nodes: Iterable[int]) -> Iterator[tuple[Window, Mask]]:
        """Cut out nodes: yield the box of each, and its pixels there."""
        first, end = self._order_basins()
        place, boxes = first[self.labels], self._find_boxes()
        for node in nodes:
            box = tuple(slice(*side) for side in boxes[node].tolist())
            yield box, (first[node] <= place[box]) & (place[box] < end[node])

    def encode_nodes(self, values: Array, gray_span: float) -> Array:
        """Encode what speaks for each node being an object as inputs of the logistic rule, shape (N, 8)."""
        at_border = np.ones(values.shape, bool)
        at_border[1:-1, 1:-1] = False
        sums = [np.bincount(self.labels.ravel(), one.ravel(), len(self.area)) for one in (at_border, values, values**2)]
        border, total, squares = self.accumulate(np.stack(sums, axis=1), np.add).T
        length, strength, on_contours = self.around.T
        area, bounded = np.maximum(self.area, 1.0), np.maximum(length, 1.0)
        around = np.maximum(length + border, 1.0)
        edge = np.maximum(strength / bounded, _MIN_STRENGTH * gray_span)
        variation = np.sqrt(np.maximum(squares / area - (total / area) ** 2, 0.0))
        features = [
            np.log(edge / gray_span + FAINT),
            on_contours / bounded,
            np.minimum(self.inner / edge, _MAX_INNER),
            np.minimum(self.outer / edge, _MAX_OUTER),
            np.log(4.0 * np.pi * area / around**2),
            np.log(np.minimum(area, LARGE_AREA)),
            border / around,
            np.log(variation / gray_span + FAINT),
        ]
        return np.stack(features, axis=1)

    def find_likely(self, odds: Array) -> Index:
        """Find the nodes that may be objects, the likeliest first, by the logarithm of their odds, shape (N,)."""
        odds = np.where(self.area >= MIN_OBJECT_AREA, odds, -np.inf)
        beside = np.where(self.parent > 0, odds[self.parent], -np.inf)
        np.maximum.at(beside, self.parent, odds)
        likely = np.flatnonzero((odds >= _MIN_ODDS) & (odds >= beside - _MAX_DEFICIT))
        return likely[np.argsort(-odds[likely], kind="stable")]

    def accumulate(self, values: Numbers, combine: np.ufunc) -> Numbers:
        """Combine the values of all basins of each node, shape (N, K)."""
        for node, parent in enumerate(self.parent.tolist()):
            if parent:  # which has a larger number
                combine(values[parent], values[node], out=values[parent])
        return values

    def _order_basins(self) -> tuple[Index, Index]:
        """Order the basins so that those of each node follow one another: its first, and what is behind its last."""
        count = np.zeros(len(self.parent), np.int64)
        count[1 : int(self.labels.max()) + 1] = 1
        self.accumulate(count[:, None], np.add)
        first, filled = np.zeros_like(count), np.zeros_like(count)
        for node, parent in reversed([*enumerate(self.parent.tolist())]):
            first[node] = first[parent] + filled[parent]
            filled[parent] += count[node] if parent else 0
        return first, first + count

    def _find_boxes(self) -> Index:
        """Find the first row and column of each node, and those behind its last, shape (N, 2, 2)."""
        found = scipy.ndimage.find_objects(self.labels)
        low = np.full((len(self.parent), 2), max(self.labels.shape))
        high = np.zeros_like(low)
        low[1 : len(found) + 1] = [[side.start for side in box] for box in found]
        high[1 : len(found) + 1] = [[side.stop for side in box] for box in found]
        return np.stack([self.accumulate(low, np.minimum), self.accumulate(high, np.maximum)], axis=2)
