"""Objects everywhere in an image: what contours part it into and the prior finds likely, or all that are like some."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
import scipy
import skimage

from cpm_core.numerics.grids import box_of, running_maximum
from cpm_core.numerics.types import Array, Callback, Index, Mask
from cpm_core.objects.boundaries.alike import alike
from cpm_core.objects.boundaries.crossings import crossings
from cpm_core.objects.boundaries.necks import bodies
from cpm_core.objects.confidence import Signs, probability
from cpm_core.objects.partition import Partition
from cpm_core.objects.prior.prior import Likely
from cpm_core.objects.selection import Selection

_SIZE, _CUT = (0.2, 4.0), 0.05
"""Area of others, as fractions of that of the chosen one; and least area of one that the border of the image cuts."""

_EDGE = 0.3
"""Least strength of the boundary of others, as a fraction of that of the chosen one's."""

_GAP, _DEEP, _LEAST, _MOST = 0.75, 1.5, 30, 0.4
"""How much deeper than the gap between them parts are, and least depth [px]; least area [px²], and largest share of the
image."""

_BOUNDED, _OWN, _LIKELY = 0.6, 0.5, 0.1
"""Least share of the boundary of a part at contours, and that it owns: its neighbor there is less likely an object; and
least probability that it is right."""

_OVER, _WITHIN, _MOST_WITHIN, _AT_RIM = 0.3, 0.95, 0.6, 0.3
"""Share of an object from which it is another one again, unless it is an object in it, or around it: least share of the
smaller that lies in the larger, largest area in that of the larger, and share of its boundary at that of the larger."""


def similar(partition: Partition, chosen: Selection) -> Iterator[Selection]:
    """The objects like a chosen one, from the top left to the bottom right.

    They have a gray level that differs from the surroundings of the chosen object in the same direction, a similar
    size, and a boundary of similar strength. Where the bodies of two touch, they are parted at the neck between them.
    What the border of the image cuts is closed along it, and may be smaller.
    """
    area = float(np.count_nonzero(chosen.mask))
    if not area:
        return
    parts = bodies(alike(partition.values, chosen.mask, partition.interest), float(np.sqrt(area / np.pi)))
    parts[chosen.mask] = 0
    limit, strength = np.array(partition.shape) - 1, _boundary_strength(chosen)
    boxes = enumerate(scipy.ndimage.find_objects(parts), start=1)
    for number, box in ((number, box) for number, box in boxes if box):
        body = parts[box] == number
        cut = any(part.start == 0 or part.stop > last for part, last in zip(box, limit.tolist(), strict=True))
        if (_CUT if cut else _SIZE[0]) * area <= np.count_nonzero(body) <= _SIZE[1] * area:
            mask = np.zeros(partition.shape, bool)
            mask[box] = _largest(body)
            other = _proposed(partition, mask)
            if _boundary_strength(other) >= _EDGE * strength:
                yield other


def everywhere(partition: Partition, check: Callback = lambda: None) -> Iterator[Selection]:
    """The objects of an image: what is certain, and parts between contours that are likely objects.

    Parts meet where the gaps between contours are narrowest. Of two with a stretch of boundary in common, the one that
    is more likely an object owns it; one that owns little of its boundary is what lies behind the others. `check` is
    called between the parts, and may raise to end it.
    """
    known: list[Mask] = []
    taken = np.zeros(partition.shape, bool)
    for mask in partition.certain():
        known.append(mask)
        box = box_of(mask)
        taken[box] |= scipy.ndimage.binary_fill_holes(mask[box])
        yield _proposed(partition, mask, certain=True)
    if not partition.prior or not partition.contours:
        return
    parts = _Parts.of(partition)
    judged = parts.judged(partition, taken, check)
    owned = parts.owned(judged)
    for number, likely in sorted(judged.items(), key=lambda item: -item[1].overlap):
        mask = likely.mask & partition.interest
        pixels = np.count_nonzero(mask)
        signs = Signs(*likely[2:], places=0)
        if probability(signs) < _LIKELY or owned[number] < _OWN or pixels < _LEAST:
            continue
        over = np.count_nonzero(mask & taken) / pixels
        if over <= _OVER:
            mask = _largest(mask & ~taken)
        elif not all(_apart(mask, other) for other in known):
            continue
        known.append(mask)
        taken |= mask
        yield _proposed(partition, mask, signs)


class _Parts(NamedTuple):
    """Parts of an image between contours.

    Attributes
    ----------
    labels : ndarray of int64, shape (H, W)
        Numbers of the parts, from 1.
    pixels : ndarray of int64, shape (N + 1,)
        Area of each [px²].
    bounded : ndarray, shape (N + 1,)
        Share of its boundary that runs along contours.
    one, other : ndarray of int64, shape (L,)
        Parts on both sides of each link between pixels of two, in both directions.
    """

    labels: Index
    pixels: Index
    bounded: Array
    one: Index
    other: Index

    @classmethod
    def of(cls, partition: Partition) -> _Parts:
        """The parts of an image."""
        lines = crossings([contour.path for contour in partition.contours], partition.shape).pixels
        depth = scipy.ndimage.gaussian_filter(scipy.ndimage.distance_transform_edt(~lines), 1.0)
        tops = skimage.morphology.h_maxima(depth, _GAP)  # type: ignore[no-untyped-call]
        markers, _ = scipy.ndimage.label((tops > 0) & (depth > _DEEP), np.ones((3, 3)))
        labels = np.asarray(skimage.segmentation.watershed(-depth, markers), np.int64)  # type: ignore[no-untyped-call]
        near, sides, along = running_maximum(lines, 1), [], []
        for here, there in (np.s_[1:, :], np.s_[:-1, :]), (np.s_[:, 1:], np.s_[:, :-1]):
            links = np.nonzero(labels[here] != labels[there])
            sides.append(np.stack([labels[here][links], labels[there][links]]))
            along.append(near[there][links])
        one, other = np.concatenate(sides, axis=1)
        one, other, on = np.concatenate([one, other]), np.concatenate([other, one]), np.tile(np.concatenate(along), 2)
        pixels = np.bincount(labels.ravel())
        rim = np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]])
        around = np.bincount(np.concatenate([one, rim]), minlength=len(pixels))
        bounded = np.bincount(one[on], minlength=len(pixels)) / np.maximum(around, 1)
        return cls(labels, pixels, bounded, one, other)

    def judged(self, partition: Partition, taken: Mask, check: Callback) -> dict[int, Likely]:
        """What the prior makes of those that may be objects, by their numbers."""
        boxes = scipy.ndimage.find_objects(self.labels)

        def judge(number: int) -> Likely | None:
            check()
            box = boxes[number - 1]
            within = self.labels[box] == number
            if np.count_nonzero(within & taken[box]) > _OVER * self.pixels[number]:
                return None
            mask = np.zeros(self.labels.shape, bool)
            mask[box] = within
            return partition.judged(mask)

        wanted = (self.pixels >= _LEAST) & (self.pixels <= _MOST * self.labels.size) & (self.bounded >= _BOUNDED)
        numbers = (np.flatnonzero(wanted[1:]) + 1).tolist()
        answers = ((number, judge(number)) for number in numbers)
        return {number: one for number, one in answers if one is not None}

    def owned(self, judged: Mapping[int, Likely]) -> Array:
        """Share of the boundary of each, but that at the border of the image, where it is worth more than the other."""
        worth = np.zeros(len(self.pixels))
        worth[list(judged)] = [one.overlap for one in judged.values()]
        around = np.bincount(self.one, minlength=len(worth))
        won = np.bincount(self.one[worth[self.one] > worth[self.other]], minlength=len(worth))
        return won / np.maximum(around, 1)


def _apart(mask: Mask, other: Mask) -> bool:
    """Whether an object shares nothing with another one, or one lies in the other, away from its boundary."""
    both = np.count_nonzero(mask & other)
    if not both:
        return True
    small, large = (mask, other) if np.count_nonzero(mask) < np.count_nonzero(other) else (other, mask)
    if both < _WITHIN * np.count_nonzero(small) or both > _MOST_WITHIN * np.count_nonzero(large):
        return False
    rim = small & ~scipy.ndimage.binary_erosion(small)
    return bool((~scipy.ndimage.binary_erosion(large, iterations=3))[rim].mean() <= _AT_RIM)


def _proposed(partition: Partition, mask: Mask, signs: Signs | None = None, *, certain: bool = False) -> Selection:
    """An object of some pixels, shape (H, W), with the deepest of them as the place inside."""
    box = box_of(mask)
    depth = scipy.ndimage.distance_transform_edt(np.pad(mask[box], 1))
    place = np.argwhere(depth == depth.max())[:1] - 1.0 + [side.start for side in box]
    if signs is None:
        signs = Signs(*partition.judged(mask, place)[2:], places=0) if partition.prior else Signs(places=0)
    return partition.selection_of(mask, place, signs=signs, certain=certain)


def _largest(mask: Mask) -> Mask:
    """The largest connected part of a mask."""
    parts, _ = scipy.ndimage.label(mask)
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    return parts == sizes.argmax()


def _boundary_strength(selection: Selection) -> float:
    """Mean edge strength along the boundary [gray levels / px]."""
    lengths = np.array([contour.length for contour in selection.contours])
    strengths = np.array([contour.strength for contour in selection.contours])
    return float(lengths @ strengths / lengths.sum()) if len(lengths) else 0.0
