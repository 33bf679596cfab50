"""Contour tracking: measures of each contour, and its counterpart in the last reconstruction."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from cpm_core import Result, measure
from cpm_core.contours import ANCHOR_REACH, Mark, Measures, assign_anchors, build_path_tree, contour_midpoint
from cpm_core.contours.contour import Contours
from cpm_core.numerics import Position
from cpm_core.numerics.types import Integers, record
from cpm_core.results import restore_kept_contours


@record
class TrackedContours:
    """The contours of a reconstruction, each with its measures and a key that stays the same in later ones."""

    result: Result
    keys: Integers
    measures: tuple[Measures, ...]

    def with_kept_contours(self, marks: Sequence[Mark]) -> TrackedContours:
        """Add the kept contours that the reconstruction lacks; their keys are their numbers, negated."""
        result = restore_kept_contours(self.result, marks)
        if result is self.result:
            return self
        known = dict(zip(self.result.contours, self.keys, strict=True))
        measured = any(row.contrast is not None for row in self.measures)
        measures = measure(result.contours, result.spacing, contrast=measured)
        each = zip(result.contours, measures, strict=True)
        return TrackedContours(result, tuple(known.get(one, -row.number) for one, row in each), measures)

    def with_contrast(self) -> TrackedContours:
        """Add the contrast of each contour, which takes as long as all other measures together."""
        return replace(self, measures=measure(self.result.contours, self.result.spacing))


class ContourTracker:
    """Recognizes contours by their position from one reconstruction to the next, and numbers those of an image.

    A number is never given to another contour. While particles move, contours come and go: numbers of new ones last
    only until the next reconstruction. Numbers of the last reconstruction of a run stay, also of contours that a filter
    leaves out and later shows again.
    """

    def __init__(self, places: Mapping[int, Position] | None = None) -> None:
        self._fresh = itertools.count()
        self._seen: list[tuple[int, Position]] = []
        self.places = places or {}
        """A place on each numbered contour; the mapping is replaced, never changed."""

    def track_contours(self, result: Result, thorough: bool) -> TrackedContours:
        """Identify, measure and number the contours of a reconstruction.

        If `thorough`, because no other one follows soon, the numbers stay. A volume has a surface and no contours.
        """
        if len(result.shape) == 3:
            return TrackedContours(result, (), ())
        numbers = self.assign_numbers(result.contours, lasting=thorough)
        contours = tuple(replace(one, number=number) for one, number in zip(result.contours, numbers, strict=True))
        found = assign_anchors(contours, [place for _, place in self._seen])
        known = {index: key for (key, _), index in zip(self._seen, found, strict=True) if index is not None}
        keys = tuple(known[index] if index in known else next(self._fresh) for index in range(len(contours)))
        self._seen = list(zip(keys, map(contour_midpoint, contours), strict=True))
        measures = measure(contours, result.spacing, contrast=False)
        return TrackedContours(replace(result, contours=contours) if contours else result, keys, measures)

    def assign_numbers(self, contours: Contours, *, lasting: bool) -> Integers:
        """Give each contour the number of the contour that was there before, or a new one.

        Of several numbers at one contour the oldest wins, so that a contour cut apart by a filter gets its number back
        once it is whole again; distances below one pixel count as equal.
        """
        found: dict[int, int] = {}
        given = set()
        if contours and self.places:
            known = list(self.places)
            near = build_path_tree(contours).pairs_within(np.array(list(self.places.values())), ANCHOR_REACH)
            pairs = sorted(
                (int(away), known[place], -contours[index].length, index)
                for place, index, away in zip(*(of_pair.tolist() for of_pair in near), strict=True)
            )
            for _, number, _, index in pairs:
                if index not in found and number not in given:
                    found[index] = number
                    given.add(number)
        fresh = itertools.count(max(self.places, default=0) + 1)
        numbers = tuple(found[index] if index in found else next(fresh) for index in range(len(contours)))
        if lasting:
            self.places = {**self.places, **dict(zip(numbers, map(contour_midpoint, contours), strict=True))}
        return numbers
