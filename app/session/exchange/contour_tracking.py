"""The survey of the contours of a reconstruction: what is known about each, and which of those before it is."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from cpm_core.contours.measurements import Measures, measure
from cpm_core.contours.result import Result
from cpm_core.contours.review import attached, middle
from cpm_core.numerics.types import Position


@dataclass(frozen=True, eq=False, slots=True)
class TrackedContours:
    """Contours with what is known about them.

    Attributes
    ----------
    result : Result
        The reconstruction.
    keys : tuple of int
        For each contour a number that stays its own through the reconstructions to come.
    measures : tuple of Measures
        For each contour a row of the table.
    """

    result: Result
    keys: tuple[int, ...]
    measures: tuple[Measures, ...]


class ContourTracker:
    """Makes surveys one after the other, and recognises contours that it has seen before by where they pass."""

    def __init__(self) -> None:
        self._fresh = itertools.count()
        self._seen: list[tuple[int, Position]] = []

    def track(self, result: Result, thorough: bool) -> TrackedContours:
        """Look at the contours of a reconstruction.

        Parameters
        ----------
        result : Result
            The reconstruction.
        thorough : bool
            Whether there is time to measure the contrast too.
        """
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
