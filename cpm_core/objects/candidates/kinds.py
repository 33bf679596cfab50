"""Kinds of candidates: the regions that a click may mean.

For the first click the regions are whole objects, for a further one changes of the object chosen so far: what is to be
added around a click inside, or taken away around one outside.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from enum import IntEnum
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.objects.candidates.appearance import LEVELS
from cpm_core.objects.candidates.flooding import flood
from cpm_core.objects.candidates.grids import Box, union
from cpm_core.objects.candidates.situation import Situation
from cpm_core.objects.candidates.stars import Star, stars
from cpm_core.objects.faces.basins import Labels
from cpm_core.objects.faces.minimum_cut import FreePart, minimum_cut

_FIRST_BALLOONS = np.geomspace(0.0003, 0.2, 12)
_BALLOONS = np.geomspace(0.0005, 0.1, 4)
"""Rewards for each pixel inside that make cheapest boundaries larger [1 / px]."""

_REACHES, _LOCAL_BALLOONS = (0.35, 1.0, 2.5), (0.003, 0.03)
"""How far from a click a boundary may change, in square roots of the object's area; and the rewards there."""

_KEPT = 0.03
"""Reward for each pixel near the click that stays on its side [1 / px]."""

_RADII = (1.5, 4.0, 7.0)
_LEVEL_RADII = (6.0, 14.0, 32.0)
_MARGIN = 8.0
"""Disks around a click, without and with a threshold [px]; and distance from the boundary up to which a click may mean
a margin."""


SEVERAL = 3
"""So many first places tell a size: that of the circle with their mean distance from their middle."""

_LEAST_RADIUS, _MOST_OF_IMAGE, _DRAWN, _STARS = 2.0, 0.6, (0.8, 9.0), 3
"""Least radius of a star [px], the largest as a fraction of the image's longer side, both in radii of a drawn circle;
and the number of stars that are light, and of those that are dark."""

_CLEAR = 0.25
"""Least support of a star: where one was the best candidate, 99 of 100 had more."""


class Kind(IntEnum):
    """Where a candidate comes from."""

    DARK = 0
    BRIGHT = 1
    CUT = 2
    DISK = 3
    MARGIN = 4
    LOCAL_CUT = 5
    LOCAL_LEVEL = 6
    STAR = 7


class Candidate(NamedTuple):
    """A region that may be meant.

    Attributes
    ----------
    kind : Kind
        Where it comes from.
    whole : bool
        Whether it is the whole object rather than what changes.
    box : Box
        Box that holds what changes.
    within : callable
        ``within(rows, cols)`` says which pixels of these rows and columns are in it.
    instability : float
        Logarithm of the factor by which it grows when its threshold, or the reward of size, rises by a step.
    """

    kind: Kind
    whole: bool
    box: Box
    within: Callable[[Index, Index], Mask]
    instability: float = 0.0


def candidates(situation: Situation) -> Iterator[Candidate]:
    """All regions to choose from."""
    if situation.chosen is None:
        yield from _floods(situation, 1.06, 36)
        yield from _cuts(situation, _FIRST_BALLOONS)
        if len(situation.inside) >= SEVERAL:
            yield from _stars(situation)
        return
    yield from _floods(situation, 1.12, 12)
    yield from _disks(situation)
    yield from _margins(situation)
    yield from _local_levels(situation, situation.chosen)
    yield from _local_cuts(situation, situation.chosen)
    yield from _cuts(situation, _BALLOONS)


def _floods(situation: Situation, growth: float, most: int) -> Iterator[Candidate]:
    """Pixels around the click that are not brighter, or not darker, than some level."""
    allowed, limit = situation.allowed, situation.limit
    seeds = situation.inside if situation.chosen is None else situation.pixel[None]
    level = situation.look.level
    for kind, levels in ((Kind.DARK, level), (Kind.BRIGHT, (LEVELS - 1 - level).astype(np.int16))):
        found = flood(levels, LEVELS, allowed, seeds, limit)
        for count, box, instability in found.regions(growth, most):

            def within(rows: Index, cols: Index, count: int = count, place: NDArray[np.int32] = found.position) -> Mask:
                return np.asarray(place[rows[:, None], cols] < count)

            yield Candidate(kind, situation.chosen is None, box, within, instability)


def _stars(situation: Situation) -> Iterator[Candidate]:
    """Smooth lines around a drawn circle along the clearest steps of gray levels."""
    middle = situation.inside.mean(axis=0)
    radius = float(np.linalg.norm(situation.inside - middle, axis=1).mean())
    least = max(_DRAWN[0] * radius, _LEAST_RADIUS)
    most = min(_DRAWN[1] * radius, _MOST_OF_IMAGE * max(situation.look.level.shape))
    allowed = situation.allowed
    found = stars(situation.look, (float(middle[0]), float(middle[1])), (least, most), _STARS)
    for star in (each for each in found if each.support >= _CLEAR):

        def within(rows: Index, cols: Index, star: Star = star) -> Mask:
            return np.asarray(star.within(rows, cols) & allowed[rows[:, None], cols])

        yield Candidate(Kind.STAR, True, _within_image(star.box, situation), within, star.support)


def _disks(situation: Situation) -> Iterator[Candidate]:
    allowed = situation.allowed
    row, col = situation.pixel.tolist()
    for radius in _RADII:
        box = _within_image(
            (row - int(radius), row + int(radius) + 1, col - int(radius), col + int(radius) + 1), situation
        )

        def within(rows: Index, cols: Index, square: float = radius**2) -> Mask:
            near = _away(rows, cols, situation.pixel) <= square
            return np.asarray(near & allowed[rows[:, None], cols])

        yield Candidate(Kind.DISK, False, box, within)


def _margins(situation: Situation) -> Iterator[Candidate]:
    """A margin all around the object that reaches the click, or twice as far."""
    assert situation.chosen is not None
    allowed = situation.allowed
    reach = int(2 * _MARGIN) + 2
    row, col = situation.pixel.tolist()
    box = union(situation.box, (row, row + 1, col, col + 1))
    box = _within_image((box[0] - reach, box[1] + reach, box[2] - reach, box[3] + reach), situation)
    part = situation.chosen[box[0] : box[1], box[2] : box[3]]
    # beyond the border of the image the object continues
    distance = scipy.ndimage.distance_transform_edt(part if not situation.adding else ~part)
    away = float(distance[row - box[0], col - box[2]])
    if away >= _MARGIN:
        return
    for width in (away + 0.3, 1.6 * away + 0.5):
        for radius in (4.0 * away + 6.0, 10.0 * away + 12.0, np.inf):

            def within(rows: Index, cols: Index, width: float = width, radius: float = radius) -> Mask:
                r, c = rows - box[0], cols - box[2]
                known = ((r >= 0) & (r < part.shape[0]))[:, None] & (c >= 0) & (c < part.shape[1])
                r, c = np.clip(r, 0, part.shape[0] - 1), np.clip(c, 0, part.shape[1] - 1)
                near = (distance[r[:, None], c] <= width) & (_away(rows, cols, situation.pixel) <= radius**2)
                return np.asarray(known & near & allowed[rows[:, None], cols])

            yield Candidate(Kind.MARGIN, False, _around(situation, radius, box), within)


def _local_levels(situation: Situation, chosen: Mask) -> Iterator[Candidate]:
    """Pixels near the click whose gray level is nearer to that of the side where they would come to."""
    allowed = situation.allowed
    level = situation.look.level
    own = float(level[situation.pixel[0], situation.pixel[1]])
    for radius in _LEVEL_RADII:
        box = _around(situation, radius, (0, level.shape[0], 0, level.shape[1]))
        part = level[box[0] : box[1], box[2] : box[3]]
        rows, cols = np.arange(box[0], box[1]), np.arange(box[2], box[3])
        near = _away(rows, cols, situation.pixel) <= radius**2
        same = near & (chosen[box[0] : box[1], box[2] : box[3]] == situation.adding)
        other = near & ~same
        if not same.any() or not other.any():
            continue
        here, there = float(part[same].mean()), float(part[other].mean())
        for least in (0.5 * (here + there), own + 0.35 * (there - own)):

            def within(
                rows: Index, cols: Index, least: float = least, radius: float = radius, sign: float = here - there
            ) -> Mask:
                like = (level[rows[:, None], cols] - least) * sign >= 0.0
                return np.asarray(
                    like & (_away(rows, cols, situation.pixel) <= radius**2) & allowed[rows[:, None], cols]
                )

            yield Candidate(Kind.LOCAL_LEVEL, False, box, within)


def _away(rows: Index, cols: Index, pixel: Index) -> Index:
    """Squared distance of pixels from one."""
    return np.asarray((rows[:, None] - pixel[0]) ** 2 + (cols - pixel[1]) ** 2)


def _around(situation: Situation, radius: float, box: Box) -> Box:
    """The part of a box within a distance of the click."""
    if not np.isfinite(radius):
        return box
    row, col = situation.pixel.tolist()
    reach = int(radius) + 1
    return (
        max(box[0], row - reach),
        min(box[1], row + reach + 1),
        max(box[2], col - reach),
        min(box[3], col + reach + 1),
    )


def _cuts(situation: Situation, balloons: Array) -> Iterator[Candidate]:
    """What the cheapest boundaries around all clicks enclose, for some rewards of size."""
    clicked, graph = situation.clicked, situation.clicked.faces.graph
    rim = graph.rim * (0.3 if len(situation.outside) else 1.0)
    labels = clicked.faces.labels
    found = []
    for balloon in balloons:
        leaving = np.where(clicked.inside, np.inf, np.where(clicked.outside, 0.0, balloon * graph.area))
        entering = np.where(clicked.outside, np.inf, np.where(clicked.inside, 0.0, rim))
        found.append(minimum_cut(graph.arcs, situation.price, leaving, entering))
    areas = [max(float(graph.area[faces].sum()), 1.0) for faces in found]
    for faces, area, larger in zip(found, areas, [*areas[1:], areas[-1]], strict=True):
        yield _of_faces(situation, faces, labels, float(np.log(larger / area)))


def _of_faces(situation: Situation, faces: Mask, labels: Labels, instability: float) -> Candidate:
    entries = np.append(faces, False)

    def within(rows: Index, cols: Index) -> Mask:
        return np.asarray(entries[labels[rows[:, None], cols]])

    return Candidate(Kind.CUT, True, _box_of_faces(situation, faces), within, instability)


def _box_of_faces(situation: Situation, faces: Mask) -> Box:
    boxes = situation.clicked.faces.boxes[faces]
    if not len(boxes):
        return 0, 1, 0, 1
    low, high = boxes.min(axis=0).tolist(), boxes.max(axis=0).tolist()
    return low[0], high[1], low[2], high[3]


def _local_cuts(situation: Situation, chosen: Mask) -> Iterator[Candidate]:
    """Cheapest boundaries that differ from the present one near the click alone."""
    clicked, graph = situation.clicked, situation.clicked.faces.graph
    labels = clicked.faces.labels
    known = labels >= 0
    before = np.bincount(labels[known], chosen[known], graph.count) > 0.5 * graph.area
    away = np.linalg.norm(graph.center - situation.pixel, axis=1)
    entries = np.append(before, False)
    kept = _KEPT * graph.area
    for reach in _REACHES:
        free = (away <= reach * np.sqrt(situation.area)) | clicked.inside | clicked.outside
        part = FreePart(graph.first, graph.second, situation.price, free, before)
        for balloon in _LOCAL_BALLOONS:
            pull = balloon * graph.area
            leaving = np.where(before, kept, 0.0) + pull if situation.adding else np.zeros(graph.count)
            entering = np.zeros(graph.count) if situation.adding else np.where(before, 0.0, kept) + pull
            leaving = np.where(clicked.inside, np.inf, np.where(clicked.outside, 0.0, leaving))
            entering = np.where(clicked.outside, np.inf, np.where(clicked.inside, 0.0, entering))
            after = part.cut(leaving, entering)
            changed = after != before
            if not changed.any():
                continue
            now = np.append(after, False)

            def within(rows: Index, cols: Index, now: Mask = now) -> Mask:
                face = labels[rows[:, None], cols]
                return np.where(now[face] == entries[face], chosen[rows[:, None], cols], now[face])

            yield Candidate(Kind.LOCAL_CUT, True, _box_of_faces(situation, changed), within)


def _within_image(box: Box, situation: Situation) -> Box:
    rows, cols = situation.look.level.shape
    return max(box[0], 0), min(box[1], rows), max(box[2], 0), min(box[3], cols)
