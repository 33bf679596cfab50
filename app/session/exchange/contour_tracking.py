"""Contour tracking: the measures of each contour, and which contour of the last reconstruction it is."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cpm_core import Contour, Result, measure
from cpm_core.contours import REACH, Mark, Measures, attached, middle, neighborhood, with_kept
from cpm_core.numerics import Position


@dataclass(frozen=True, eq=False, slots=True)
class TrackedContours:
    """The contours of a reconstruction, each with a key that later reconstructions keep, and its measures."""

    result: Result
    keys: tuple[int, ...]
    measures: tuple[Measures, ...]

    def keeping(self, marks: Sequence[Mark]) -> TrackedContours:
        """The same with kept contours that the reconstruction lacks; their keys are their numbers below zero."""
        result = with_kept(self.result, marks)
        if result is self.result:
            return self
        known = dict(zip(self.result.contours, self.keys, strict=True))
        measured = any(row.contrast is not None for row in self.measures)
        measures = measure(result.contours, result.spacing, contrast=measured)
        each = zip(result.contours, measures, strict=True)
        return TrackedContours(result, tuple(known.get(one, -row.number) for one, row in each), measures)


class ContourTracker:
    """Recognizes the contours of one reconstruction after the other by where they pass."""

    def __init__(self) -> None:
        self._fresh = itertools.count()
        self._seen: list[tuple[int, Position]] = []
        self._numbers = ContourNumbers()

    def begin(self, places: Mapping[int, Position] | None = None) -> None:
        """Another image has been opened: its contours are numbered from one again, or as in `places`."""
        self._numbers = ContourNumbers(places)

    @property
    def places(self) -> Mapping[int, Position]:
        """A place of each numbered contour; never changed once returned."""
        return self._numbers.places

    def track(self, result: Result, thorough: bool) -> TrackedContours:
        """Number and measure the contours of a reconstruction.

        Where `thorough`, because no other one follows soon, the numbers stay, and the contrast is measured, which takes
        long. A volume has a surface and no contours.
        """
        if len(result.shape) == 3:
            return TrackedContours(result, (), ())
        numbers = self._numbers.of(result.contours, settled=thorough)
        contours = tuple(replace(one, number=number) for one, number in zip(result.contours, numbers, strict=True))
        places = [place for _, place in self._seen]
        known = {
            index: key
            for (key, _), index in zip(self._seen, attached(contours, places), strict=True)
            if index is not None
        }
        keys = tuple(known[index] if index in known else next(self._fresh) for index in range(len(contours)))
        self._seen = list(zip(keys, map(middle, contours), strict=True))
        measures = measure(contours, result.spacing, contrast=thorough)
        return TrackedContours(replace(result, contours=contours) if contours else result, keys, measures)


class ContourNumbers:
    """The numbers of the contours of an image, by where they pass; a number is never given to another contour.

    While particles move, contours come and go: those that are new have numbers only until the next reconstruction. The
    numbers of a settled one stay, also those of contours that a filter leaves out and later shows again.
    """

    def __init__(self, places: Mapping[int, Position] | None = None) -> None:
        self.places: Mapping[int, Position] = places or {}

    def of(self, contours: Sequence[Contour], *, settled: bool) -> tuple[int, ...]:
        """Number of each contour."""
        known = self._found_again(contours)
        fresh = itertools.count(max(self.places, default=0) + 1)
        numbers = tuple(known[index] if index in known else next(fresh) for index in range(len(contours)))
        if settled:
            self.places = {**self.places, **dict(zip(numbers, map(middle, contours), strict=True))}
        return numbers

    def _found_again(self, contours: Sequence[Contour]) -> dict[int, int]:
        """Numbers by index of the contours that pass where one did before.

        Of several numbers at one contour the oldest wins, so that contours which a filter has cut apart have their
        number again when they are whole again; distances below one pixel are alike.
        """
        if not contours or not self.places:
            return {}
        numbers = list(self.places)
        near = neighborhood(contours).pairs(np.array(list(self.places.values())), REACH)
        pairs = sorted(
            (int(away), numbers[place], -contours[index].length, index)
            for place, index, away in zip(*(of_pair.tolist() for of_pair in near), strict=True)
        )
        found: dict[int, int] = {}
        given: set[int] = set()
        for _, number, _, index in pairs:
            if index not in found and number not in given:
                found[index] = number
                given.add(number)
        return found
