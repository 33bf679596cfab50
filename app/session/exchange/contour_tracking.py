"""Contour tracking: the measures of each contour, and which contour of the last reconstruction it is."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from cpm_core.contours.measurements import Measures, measure
from cpm_core.contours.result import Result
from cpm_core.contours.review import attached, middle
from cpm_core.numerics.types import Position


@dataclass(frozen=True, eq=False, slots=True)
class TrackedContours:
    """The contours of a reconstruction, each with a key that later reconstructions keep, and its measures."""

    result: Result
    keys: tuple[int, ...]
    measures: tuple[Measures, ...]


class ContourTracker:
    """Recognizes the contours of one reconstruction after the other by where they pass."""

    def __init__(self) -> None:
        self._fresh = itertools.count()
        self._seen: list[tuple[int, Position]] = []

    def track(self, result: Result, thorough: bool) -> TrackedContours:
        """Measure the contours of a reconstruction; the contrast, which takes long, only where `thorough`."""
        contours = result.contours
        places = [place for _, place in self._seen]
        known = {
            index: key
            for (key, _), index in zip(self._seen, attached(contours, places), strict=True)
            if index is not None
        }
        keys = tuple(known[index] if index in known else next(self._fresh) for index in range(len(contours)))
        self._seen = list(zip(keys, map(middle, contours), strict=True))
        return TrackedContours(result, keys, measure(contours, result.spacing, contrast=thorough))
