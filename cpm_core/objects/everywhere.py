"""Objects everywhere in an image: what contours part it into and the prior finds likely, or all that are like some."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
import scipy
import skimage

from cpm_core.numerics.grids import running_maximum
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.objects.boundaries.alike import alike
from cpm_core.objects.boundaries.crossings import crossings
from cpm_core.objects.boundaries.necks import bodies
from cpm_core.objects.confidence import Signs
from cpm_core.objects.partition import Partition
from cpm_core.objects.prior.prior import Likely
from cpm_core.objects.selection import Selection

_THREADS = 4
"""Most threads that ask the prior at once."""

_SIZE, _CUT = (0.2, 4.0), 0.05
"""Area of others, as fractions of that of the chosen one; and the least area of one that the border of the image cuts."""

_EDGE = 0.3
"""Least strength of the boundary of others, as a fraction of that of the chosen one's."""

_GAP, _DEEP, _LEAST, _MOST = 0.75, 1.5, 30, 0.4
"""How much deeper than the gap between them parts are, and least depth [px]; least area [px²], and largest share of the
image."""

_BOUNDED, _OWN, _LIKELY = 0.6, 0.5, 0.8
"""Least share of the boundary of a part at contours, and that it owns: its neighbor there is less likely an object; and
least overlap that the prior expects."""

_OVER, _WITHIN, _AT_RIM = 0.3, 0.95, 0.3
"""Share of an object from which it is another one again; of one that lies in another; and of its boundary at that of
the other up to which it is an object in an object."""


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
    for number, box in enumerate(scipy.ndimage.find_objects(parts), start=1):
        if box is None:
            continue
        body = parts[box] == number
        cut = any(part.start == 0 or part.stop > last for part, last in zip(box, limit.tolist(), strict=True))
        if (_CUT if cut else _SIZE[0]) * area <= np.count_nonzero(body) <= _SIZE[1] * area:
            mask = np.zeros(partition.shape, np.bool_)
            mask[box] = _largest(body)
            other = _proposed(partition, mask)
            if _boundary_strength(other) >= _EDGE * strength:
                yield other


class _Part(NamedTuple):
    """A part of an image between contours, and what the prior makes of it."""

    number: int
    likely: Likely
    pixels: int


def everywhere(partition: Partition) -> Iterator[Selection]:
    """The objects of an image: what is certain, and parts between contours that are likely objects.

    Parts meet where the gaps between contours are narrowest. Of two with a stretch of boundary in common, the one that
    is more likely an object owns it; one that owns little of its boundary is what lies behind the others.
    """
    known: list[Mask] = []
    taken = np.zeros(partition.shape, np.bool_)
    for mask in partition.certain():
        known.append(mask)
        taken |= mask
        yield _proposed(partition, mask, Signs(places=0, certain=True))
    if not partition.prior or not partition.contours:
        return
    parts, bounded = _parts(partition)
    seen = _judged(partition, parts, np.flatnonzero(bounded >= _BOUNDED), taken)
    worth = np.zeros(len(bounded))
    worth[[one.number for one in seen]] = [one.likely.overlap for one in seen]
    owned = _owned(parts, worth)
    for part in sorted(seen, key=lambda one: -one.likely.overlap):
        mask = part.likely.mask & partition.interest
        if part.likely.overlap < _LIKELY or owned[part.number] < _OWN or np.count_nonzero(mask) < _LEAST:
            continue
        over = np.count_nonzero(mask & taken) / np.count_nonzero(mask)
        if over > _OVER and not all(_apart(mask, other) for other in known):
            continue
        mask = mask if over > _OVER else _largest(mask & ~taken)
        known.append(mask)
        taken |= mask
        yield _proposed(partition, mask, Signs(*part.likely[2:], places=0))


def _parts(partition: Partition) -> tuple[Index, Array]:
    """Parts of an image, shape (H, W), numbered from 1; and the share of the boundary of each that runs along contours.

    The first share is that of number 0, which is no part.
    """
    lines = crossings([contour.path for contour in partition.contours], partition.shape).pixels
    depth = scipy.ndimage.gaussian_filter(scipy.ndimage.distance_transform_edt(~lines), 1.0)
    tops = skimage.morphology.h_maxima(depth, _GAP)  # type: ignore[no-untyped-call]
    markers, count = scipy.ndimage.label((tops > 0) & (depth > _DEEP), np.ones((3, 3)))
    parts = skimage.segmentation.watershed(-depth, markers)  # type: ignore[no-untyped-call]
    near = running_maximum(lines, 1)
    all_around, along = np.zeros(count + 1), np.zeros(count + 1)
    for one, other, at in _sides(parts):
        for side in (one, other):
            all_around += np.bincount(side, minlength=count + 1)
            along += np.bincount(side[near[at]], minlength=count + 1)
    for rim in (parts[0], parts[-1], parts[:, 0], parts[:, -1]):
        all_around += np.bincount(rim, minlength=count + 1)
    return np.asarray(parts, np.int64), along / np.maximum(all_around, 1.0)


def _sides(parts: Index) -> Iterator[tuple[Index, Index, tuple[Index, Index]]]:
    """Numbers of the parts on both sides of each link between two of them, and the pixels of the first side."""
    for step in (np.s_[1:, :], np.s_[:-1, :]), (np.s_[:, 1:], np.s_[:, :-1]):
        rows, cols = np.nonzero(parts[step[0]] != parts[step[1]])
        yield parts[step[1]][rows, cols], parts[step[0]][rows, cols], (rows, cols)


def _judged(partition: Partition, parts: Index, numbers: Index, taken: Mask) -> list[_Part]:
    """What the prior makes of parts that are neither tiny, nor most of the image, nor taken already."""
    boxes = scipy.ndimage.find_objects(parts)

    def judge(number: int) -> _Part | None:
        box = boxes[number - 1]
        within = parts[box] == number
        pixels = np.count_nonzero(within)
        if not _LEAST <= pixels <= _MOST * parts.size or np.count_nonzero(within & taken[box]) > _OVER * pixels:
            return None
        mask = np.zeros(parts.shape, np.bool_)
        mask[box] = within
        return _Part(number, partition.judged(mask), pixels)

    with ThreadPoolExecutor(min(os.cpu_count() or 1, _THREADS)) as threads:
        return [one for one in threads.map(judge, numbers[numbers > 0].tolist()) if one is not None]


def _owned(parts: Index, worth: Array) -> Array:
    """Share of the boundary of each part where its neighbor is worth less."""
    won, all_around = np.zeros(len(worth)), np.zeros(len(worth))
    for one, other, _ in _sides(parts):
        won += np.bincount(np.where(worth[one] > worth[other], one, other), minlength=len(worth))
        all_around += np.bincount(one, minlength=len(worth)) + np.bincount(other, minlength=len(worth))
    return won / np.maximum(all_around, 1.0)


def _apart(mask: Mask, other: Mask) -> bool:
    """Whether an object shares nothing with another one, or one lies in the other, away from its boundary."""
    both = np.count_nonzero(mask & other)
    if not both:
        return True
    small, large = (mask, other) if np.count_nonzero(mask) < np.count_nonzero(other) else (other, mask)
    if both < _WITHIN * np.count_nonzero(small) or both > 0.6 * np.count_nonzero(large):
        return False
    rim = small & ~scipy.ndimage.binary_erosion(small)
    return bool((~scipy.ndimage.binary_erosion(large, iterations=3))[rim].mean() <= _AT_RIM)


def _proposed(partition: Partition, mask: Mask, signs: Signs | None = None) -> Selection:
    """An object of some pixels, shape (H, W), with the deepest of them as the place inside."""
    box = scipy.ndimage.find_objects(mask.astype(np.uint8))[0]
    depth = scipy.ndimage.distance_transform_edt(np.pad(mask[box], 1))
    place = np.argwhere(depth == depth.max())[:1] - 1.0 + [side.start for side in box]
    if signs is None:
        signs = Signs(*partition.judged(mask, place)[2:] if partition.prior else (), places=0)
    return partition.selection_of(mask, place, signs=signs)


def _largest(mask: Mask) -> Mask:
    """The largest connected part of a mask."""
    parts, _ = scipy.ndimage.label(mask)
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    return np.asarray(parts == sizes.argmax())


def _boundary_strength(selection: Selection) -> float:
    """Mean edge strength along the boundary [gray levels / px]."""
    lengths = np.array([contour.length for contour in selection.contours])
    strengths = np.array([contour.strength for contour in selection.contours])
    return float(lengths @ strengths / lengths.sum()) if len(lengths) else 0.0
