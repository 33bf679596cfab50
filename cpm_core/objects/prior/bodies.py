"""The prior in a volume: the body that clicks mean, from what the network makes of slices across all three axes.

The network answers in the three slices through a click. Its answer is the former one of the next slice, on both sides
across each axis, as long as it is sure of itself. The mean of the logits of the three directions is the opinion of the
slices on each step of a cube; that of the gray levels is added: how much likelier each is inside than outside, by the
means and deviations of both around it (local regions: Lankton and Tannenbaum 2008, doi:10.1109/TIP.2008.2004611).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import combinations
from typing import NamedTuple

import numpy as np
import scipy

from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.objects.prior.cubes import Cube, Grays, resampled
from cpm_core.objects.prior.network import Network, trained
from cpm_core.objects.prior.prior import maps_of
from cpm_core.objects.prior.windows import LEAST_DEVIATION, SIDE

_GROWS, _LEAST, _MOST = 1.6, 40.0, 1.1
"""Ratio of the sides of one cube to those of the next smaller one; least side around a click [smallest sides of a
voxel]; and the largest, in sides of the volume."""

_AROUND, _CLOSEST = 1.35, 24.0
"""Side of a cube around an answer, as a multiple of it, and the least one."""

_WIDER, _TURNS = 1.4, 4
"""How much wider a cube becomes whose sides a body touches, and how often it does at most."""

_OTHER_SIZE = 1.5
"""Ratio of volumes from which two bodies around a place are different ones."""

_EVERY = 6
"""Every so manieth slice is asked; between two of them logits are interpolated."""

_SURE = 0.5
"""Overlap that the network expects of its answer, below which that is not carried on."""

_LIKELY = 0.5
"""Probability above which a step is said to lie in the body."""

_AGREES = 0.3
"""What the agreement of slices along the lines that they share counts, next to the overlap that the network expects."""

FAR = 5.0
"""Logit of what lies beyond the slices that were asked, as outside; and the largest one."""

_WIDE = 10.0
"""Deviation of the Gaussian that weights gray levels around a step [steps]."""

_ROUNDS, _OPINION, _LEVELS = 6, 0.5, 4.0
"""Rounds in which gray levels are measured anew; what the opinion of the slices counts; and the most that gray levels
count [logits]."""

_FEW = np.float32(1e-3)
"""What the gray levels of one side count where none of it is near, as a share of where all is."""

_COARSE = 4
"""Steps along each side of the blocks in which gray levels are measured."""

_PLACE, _NEAR = 8.0, 3.0
"""What a click counts [logits], and the deviation of the Gaussian within which it does [steps]."""

_OTHERS = ((1, 2), (0, 2), (0, 1))
"""The axes of a slice across each axis."""


@dataclass(frozen=True, eq=False)
class Body:
    """A body that clicks mean.

    Attributes
    ----------
    cube : Cube
        The cube that it lies in.
    opinion, logits : ndarray of float32, shape (SIDE, SIDE, SIDE)
        Logits of its steps to lie in the body, by the slices alone, and all in all.
    """

    cube: Cube
    opinion: Single
    logits: Single

    @property
    def size(self) -> float:
        """Its volume [smallest sides of a voxel, cubed]."""
        return float(np.count_nonzero(self.logits > 0.0)) * self.cube.scale**3

    def logit(self, place: Array) -> float:
        """How surely a place, shape (3,), lies in it: above 0 it does."""
        step = self.cube.steps(place)[:, None]
        return float(scipy.ndimage.map_coordinates(self.logits, step, order=1, cval=-FAR)[0])


def is_other(size: float, other: float) -> bool:
    """Whether two bodies around a place are different ones, by their volumes."""
    return max(size, other) > _OTHER_SIZE * min(size, other)


def body_of(mask: Mask, size: Array) -> Body:
    """The body of some voxels, shape (P, R, C), whose sides are given, the smallest being 1."""
    on = [np.flatnonzero(mask.any(axis=tuple(k for k in range(3) if k != axis)))[[0, -1]] for axis in range(3)]
    low, high = (np.array(on)[:, end] + end - 0.5 for end in (0, 1))
    low, high = low * size, high * size
    cube = Cube(0.5 * (low + high), max(_AROUND * float((high - low).max()), _CLOSEST))
    lines = [line / side for line, side in zip(cube.lines, size.tolist(), strict=True)]
    logits = (2.0 * resampled(mask, lines, tuple(cube.scale / size)) - 1.0) * np.float32(FAR)
    for axis, line in enumerate(lines):
        np.moveaxis(logits, axis, 0)[(line < -0.5) | (line > mask.shape[axis] - 0.5)] = -FAR
    return Body(cube, logits, logits)


class _Slice(NamedTuple):
    """A slice of a cube that the network is asked about: the axis across, the step there, and the answer so far."""

    axis: int
    step: int
    before: Single


class _Asked(NamedTuple):
    """What the network makes of slices: probabilities, and the overlaps that it expects."""

    seen: list[Single]
    overlap: list[float]


class _Within(NamedTuple):
    """A cube with the gray levels at its steps, those of the object, and the steps of places inside and outside."""

    cube: Cube
    grays: Single
    level: float
    inside: Array
    outside: Array


@dataclass(frozen=True, eq=False)
class BodyPrior:
    """What the network makes of clicks in a volume.

    Attributes
    ----------
    values : ndarray, shape (P, R, C)
        Gray levels.
    size : ndarray, shape (3,)
        Sides of a voxel; the smallest is 1. Places are in the same unit.
    network : Network
        The network.
    """

    values: Array
    size: Array
    network: Network = field(default_factory=trained)

    def bodies_at(self, place: Array) -> Iterator[Body]:
        """The bodies of different sizes that a place, shape (3,), may lie in, the most plausible one first.

        Those come last that would leave out the place if it had not been said to be inside, such as a head around a
        place in its ventricles.
        """
        sizes: list[float] = []
        forced = []
        for cube, seen in self._looks(place):
            body = self._body(place, *self._closer(cube, seen, place))
            if all(is_other(body.size, one) for one in sizes):
                sizes.append(body.size)
                if body.logit(place) > _PLACE:
                    yield body
                else:
                    forced.append(body)
        yield from forced

    def _body(self, place: Array, cube: Cube, seen: list[Single]) -> Body:
        """The body that a place lies in, and of which the slices of a cube through it show so much."""
        for turn in range(_TURNS):
            within = self._within(cube, place[None], np.empty((0, 3)))
            if turn == 0:
                opinion = self._carried(within, seen)
            body = Body(cube, opinion, self._settled(within, opinion))
            if not self._touches(body) or cube.side >= _MOST * self._grays.extent:
                break
            cube, before = Cube(cube.middle, min(_WIDER * cube.side, _MOST * self._grays.extent)), cube
            opinion = cube.of(before, opinion, -FAR)
        return body

    def corrected(self, body: Body, place: Array, adds: bool, inside: Array, outside: Array) -> Body:
        """The body after a place that contradicts it, which `adds` to it or takes away; with all places so far."""
        cube = self._holding(body, place)
        while True:
            before = Body(cube, cube.of(body.cube, body.opinion, -FAR), cube.of(body.cube, body.logits, -FAR))
            within = self._within(cube, inside, outside)
            opinion = self._changed(within, before, cube.steps(place))
            logits = self._settled(within, opinion)
            logits = np.maximum(logits, before.logits) if adds else np.minimum(logits, before.logits)
            after = Body(cube, opinion, logits)
            if not adds or not self._touches(after) or cube.side > _WIDER * body.cube.side:
                return after
            cube = Cube(cube.middle, _WIDER * cube.side)

    # Slices

    def _looks(self, place: Array) -> list[tuple[Cube, list[Single]]]:
        """Cubes of all sizes around a place, and what the network sees of it in their slices; the clearest first."""
        largest = _MOST * self._grays.extent
        count = max(int(np.ceil(np.log(largest / _LEAST) / np.log(_GROWS) - 0.5)), 0)
        cubes = [Cube(place, side) for side in (*(_LEAST * _GROWS**k for k in range(count)), largest)]
        asked = [self._through(cube, place, None) for cube in cubes]
        answers = self._ask([maps for each in asked for maps in each])
        ratings, seen = [], [answers.seen[k : k + 3] for k in range(0, len(answers.seen), 3)]
        for k, slices in enumerate(seen):
            middle = np.array([SIDE // 2] * 3)
            ratings.append(np.mean(answers.overlap[3 * k : 3 * k + 3]) + _AGREES * _agreement(slices, middle))
        return [(cubes[k], seen[k]) for k in np.argsort(-np.array(ratings), kind="stable")]

    def _closer(self, cube: Cube, found: list[Single], place: Array) -> tuple[Cube, list[Single]]:
        """A cube around what is seen in the slices of another one, and what is seen there."""
        for _ in range(2):
            wider = _around(cube, found, place)
            before = [_in_slice(wider, cube, axis, found[axis]) for axis in range(3)]
            cube, found = wider, self._ask(self._through(wider, place, before)).seen
        return cube, found

    def _through(self, cube: Cube, place: Array, before: list[Single] | None) -> list[Callable[[], Single]]:
        """What makes the maps of the slices of a cube through a place that lies inside."""
        step = cube.steps(place[None])
        makers = []
        for axis in range(3):
            grays = partial(self._grays.through, cube, {axis: float(place[axis])})
            former = np.zeros((SIDE, SIDE), np.float32) if before is None else before[axis]
            makers.append(partial(_maps_through, grays, axis, step[:, _OTHERS[axis]], former))
        return makers

    def _ask(self, makers: Sequence[Callable[[], Single]]) -> _Asked:
        """What the network makes of slices, those side by side that there are cores for."""
        seen: list[Single] = [np.empty(0, np.float32)] * len(makers)
        overlap = [0.0] * len(makers)

        def some(first: int, end: int) -> None:
            for k in range(first, end):
                seen[k], overlap[k] = self.network(makers[k]())

        share(some, len(makers), 1)
        return _Asked(seen, overlap)

    def _ask_within(self, within: _Within, slices: Sequence[_Slice]) -> _Asked:
        return self._ask([partial(_maps_within, within, each) for each in slices])

    def _carried(self, within: _Within, seen: list[Single]) -> Single:
        """The opinion of slices, every so manieth, from those through the first place on."""
        start = np.clip(np.rint(within.inside[0]).astype(int), 0, SIDE - 1).tolist()
        ends = self._grays.within(within.cube)
        known = [{start[axis]: _logit(seen[axis])} for axis in range(3)]
        heads = [(_Slice(axis, start[axis], seen[axis]), way) for axis in range(3) for way in (-1, 1)]
        while heads:
            heads = [(head._replace(step=head.step + way * _EVERY), way) for head, way in heads]
            heads = [(head, way) for head, way in heads if ends[head.axis, 0] <= head.step <= ends[head.axis, 1]]
            answers = self._ask_within(within, [head for head, _ in heads])
            left = []
            for (head, way), found, overlap in zip(heads, *answers, strict=True):
                sure = overlap >= _SURE and ((found > _LIKELY) & (head.before > _LIKELY)).any()
                known[head.axis][head.step] = _logit(found)
                if sure:
                    left.append((head._replace(before=found), way))
                else:
                    known[head.axis][head.step] = np.minimum(known[head.axis][head.step], -FAR)
            heads = left
        return np.mean([_between(known[axis], axis, -FAR)[0] for axis in range(3)], axis=0, dtype=np.float32)

    def _changed(self, within: _Within, body: Body, step: Array) -> Single:
        """The opinion of slices once a place has been added, asked anew near it as long as they change."""
        start = np.clip(np.rint(step).astype(int), 0, SIDE - 1).tolist()
        ends = self._grays.within(within.cube)
        now = scipy.special.expit(body.logits)
        heads = [(_Slice(axis, start[axis], now.take(start[axis], axis)), 0) for axis in range(3)]
        known: list[dict[int, Single]] = [{}, {}, {}]
        while heads:
            answers = self._ask_within(within, [head for head, _ in heads])
            left = []
            for (head, way), found, overlap in zip(heads, *answers, strict=True):
                known[head.axis][head.step] = _logit(found)
                before = now.take(head.step, head.axis)
                other = (found > _LIKELY) != (before > _LIKELY)
                if overlap < _SURE or not other.any() or len(known[head.axis]) > 6:
                    continue
                for turn in (way,) if way else (-1, 1):
                    at = head.step + turn * _EVERY
                    if ends[head.axis, 0] <= at <= ends[head.axis, 1]:
                        there = np.where(other, found, now.take(at, head.axis))
                        left.append((_Slice(head.axis, at, there), turn))
            heads = left
        opinions, weights = zip(*(_between(known[axis], axis, 0.0) for axis in range(3)), strict=True)
        total = np.maximum(np.sum(weights, axis=0), 1e-6)
        mean = np.sum([one * weight for one, weight in zip(opinions, weights, strict=True)], axis=0) / total
        blend = np.max(weights, axis=0)
        return np.asarray(blend * mean + (1.0 - blend) * body.opinion, np.float32)

    # Gray levels

    def _settled(self, within: _Within, opinion: Single) -> Single:
        """Logits by the opinion of the slices, places and gray levels."""
        places = np.zeros_like(opinion)
        for steps, sign in ((within.inside, 1.0), (within.outside, -1.0)):
            for step in steps:
                plane, row, col = np.exp(-0.5 * np.square((np.arange(SIDE) - step[:, None]) / _NEAR)).astype(np.float32)
                places += (sign * _PLACE * plane)[:, None, None] * np.multiply.outer(row, col)
        given = _OPINION * opinion + places
        half, coarse = _blocks(within.grays, _COARSE // 2), _blocks(given, _COARSE // 2)
        logits = coarse
        for _ in range(_ROUNDS):
            gain, middle = _likelihood(half, scipy.special.expit(logits))
            logits = coarse + np.clip(_finer(gain, 2) * (half - _finer(middle, 2)), -_LEVELS, _LEVELS)
        finer = _finer(gain, _COARSE) * (within.grays - _finer(middle, _COARSE))
        return np.asarray(given + np.clip(finer, -_LEVELS, _LEVELS), np.float32)

    # Cubes

    def _within(self, cube: Cube, inside: Array, outside: Array) -> _Within:
        grays = self._grays.through(cube)
        within, beyond = cube.steps(inside), cube.steps(outside)
        level = float(np.median(scipy.ndimage.map_coordinates(grays, within.T, order=1, mode="nearest")))
        return _Within(cube, grays, level, within, beyond)

    def _touches(self, body: Body) -> bool:
        """Whether a body reaches the sides of its cube inside of the volume."""
        likely = body.logits > 0.0
        for axis, (first, last) in enumerate(self._grays.within(body.cube).tolist()):
            sides = np.moveaxis(likely, axis, 0)
            if (first == 0 and sides[:2].any()) or (last == SIDE - 1 and sides[-2:].any()):
                return True
        return False

    def _holding(self, body: Body, place: Array) -> Cube:
        """The cube of a body, or a wider one if a place lies at its sides or beyond."""
        off = np.abs(body.cube.steps(place) - SIDE / 2).max()
        most = SIDE / 2 - _EVERY
        return body.cube if off <= most else Cube(body.cube.middle, body.cube.side * float(off / most))

    @cached_property
    def _grays(self) -> Grays:
        return Grays(self.values, self.size)


def _maps_through(grays: Callable[[], Single], axis: int, inside: Array, before: Single) -> Single:
    """Maps of a slice whose gray levels have yet to be found, and which places inside lie in."""
    there = np.take(grays(), 0, axis)
    on = _holding(inside)
    return _maps(there, float(np.median(there[on])), on, np.zeros_like(on), before)


def _maps_within(within: _Within, asked: _Slice) -> Single:
    """Maps of a slice of a cube, which the places near it lie in."""
    there = within.grays.take(asked.step, asked.axis)
    near = [
        _holding(steps[np.abs(steps[:, asked.axis] - asked.step) <= 1.0][:, _OTHERS[asked.axis]])
        for steps in (within.inside, within.outside)
    ]
    return _maps(there, within.level, near[0], near[1], asked.before)


def _maps(grays: Single, level: float, inside: Mask, outside: Mask, before: Single) -> Single:
    mean, deviation = grays.mean(), grays.std() + LEAST_DEVIATION
    seen = np.zeros((3, SIDE, SIDE), np.float32)
    seen[0] = (grays - mean) / deviation
    like = np.array([(level - mean) / deviation, 0.0, 0.0], np.float32)
    return maps_of(seen, like, inside, outside, np.zeros_like(grays), before)


def _holding(steps: Array) -> Mask:
    """Pixels of a slice that hold places, shape (N, 2) [steps]."""
    on = np.zeros((SIDE, SIDE), np.bool_)
    place = np.rint(steps).astype(np.int64)
    on[tuple(place[((place >= 0) & (place < SIDE)).all(axis=1)].T)] = True
    return on


def _agreement(slices: Sequence[Single], at: Index) -> float:
    """Mean overlap of the answers in three slices along the lines that they share, through some step."""
    found = []
    for one, other in combinations(range(3), 2):
        first, second = (
            slices[across].take(at[rest], _OTHERS[across].index(rest)) > _LIKELY
            for across, rest in ((one, other), (other, one))
        )
        found.append(np.count_nonzero(first & second) / max(np.count_nonzero(first | second), 1))
    return float(np.mean(found))


def _around(cube: Cube, slices: Sequence[Single], place: Array) -> Cube:
    """A cube around what three slices show, and a place."""
    low, high = place.copy(), place.copy()
    for axis, seen in enumerate(slices):
        for row, other in enumerate(_OTHERS[axis]):
            on = np.flatnonzero((seen > _LIKELY).any(axis=1 - row))
            if len(on):
                ends = cube.lines[other][on[[0, -1]]]
                low[other], high[other] = min(low[other], ends[0]), max(high[other], ends[1])
    return Cube(0.5 * (low + high), max(_AROUND * float((high - low).max()), _CLOSEST))


def _in_slice(cube: Cube, other: Cube, axis: int, seen: Single) -> Single:
    """What was seen in a slice of another cube across an axis, in that of a cube; zeros beyond."""
    lines = [(cube.lines[k] - other.middle[k]) / other.scale + SIDE / 2 for k in _OTHERS[axis]]
    places = np.meshgrid(*lines, indexing="ij")
    return np.asarray(scipy.ndimage.map_coordinates(seen, places, order=1), np.float32)


def _between(known: dict[int, Single], axis: int, beyond: float) -> tuple[Single, Single]:
    """Slices across an axis, interpolated between those that are known, and how much each counts from 0 to 1.

    From the outermost ones on they fall to what is `beyond` over the distance of two.
    """
    steps = sorted(known)
    at = [steps[0] - _EVERY, *steps, steps[-1] + _EVERY]
    maps = np.stack([known[steps[0]], *(known[step] for step in steps), known[steps[-1]]])
    weight = np.array([0.0, *[1.0] * len(steps), 0.0])
    if beyond:
        maps[0], maps[-1] = beyond, beyond
    line = np.clip(np.arange(SIDE), at[0], at[-1])
    low = np.clip(np.searchsorted(at, line, side="right") - 1, 0, len(at) - 2)
    part = ((line - np.take(at, low)) / (np.take(at, low + 1) - np.take(at, low))).astype(np.float32)
    share_of = part[:, None, None]
    found = maps[low] * (1.0 - share_of) + maps[low + 1] * share_of
    counts = np.asarray(weight[low] * (1.0 - part) + weight[low + 1] * part, np.float32)
    return np.moveaxis(found, 0, axis), np.moveaxis(np.broadcast_to(counts[:, None, None], found.shape), 0, axis)


def _logit(seen: Single) -> Single:
    return np.clip(scipy.special.logit(seen), -FAR, FAR)


def _blocks(values: Single, side: int) -> Single:
    """Means of blocks of steps."""
    count = len(values) // side
    return values.reshape(count, side, count, side, count, side).mean(axis=(1, 3, 5))


def _finer(values: Single, times: int) -> Single:
    """So many times as many steps along each axis, interpolated."""
    line = (np.arange(len(values) * times) + 0.5) / times - 0.5
    return resampled(values, [line] * 3, (1.0, 1.0, 1.0))


def _likelihood(grays: Single, inside: Single) -> tuple[Single, Single]:
    """By how much a gray level that is higher by 1 is likelier inside, and that which is as likely on both sides."""
    means, variance = [], np.float32(LEAST_DEVIATION**2 / 4.0)
    deviation = _WIDE / _COARSE
    for weight in (inside, 1.0 - inside):
        blurred = [
            scipy.ndimage.gaussian_filter(_blocks(weight * part, 2), deviation, truncate=2.5)
            for part in (1.0, grays, np.square(grays))
        ]
        few = [_FEW * part.mean() / max(blurred[0].mean(), 1e-6) for part in blurred]
        total, first, second = (part + some for part, some in zip(blurred, few, strict=True))
        mean = first / total
        variance = variance + 0.5 * np.maximum(second / total - np.square(mean), 0.0)
        means.append(mean)
    return (means[0] - means[1]) / variance, 0.5 * (means[0] + means[1])
