"""Curation: what a person says about contours, kept although every reconstruction makes the contours anew.

A mark is put on a place, its anchor, and belongs to the contour that passes there; the next reconstruction moves the
contours by fractions of a pixel and may change their order, but not the place. A contour that splits leaves its mark
with the piece at the anchor. A mark that no contour passes stays where it is and waits.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour
from cpm_core.contours.result import Result
from cpm_core.numerics import polyline
from cpm_core.numerics.segments import distances_to_segments
from cpm_core.numerics.types import Array, Position

Verdict = Literal["", "kept", "rejected"]
"""What a person thinks of a contour: nothing yet, that it is right, or that it is none."""

REACH = 4.0
"""Farthest that a contour may pass from an anchor to be the one that is meant [px]."""

_PLACES = 24
"""Places along a contour among which its anchor is chosen."""

_ALONE = 3.0 * REACH
"""Distance from all other contours beyond which a place is as good as any [px]."""


@dataclass(frozen=True, slots=True)
class Mark:
    """What a person says about the contour at a place.

    Attributes
    ----------
    anchor : tuple of float
        Place (row, col) [px].
    verdict : {"", "kept", "rejected"}
        Rejected contours are not written; empty where nothing has been decided.
    name : str
        What it is called, empty for nothing.
    color : str
        Color that it is drawn in, ``"#rrggbb"``; empty for that of its kind.

    Raises
    ------
    ValueError
        When a value is none of these.
    """

    anchor: Position
    verdict: Verdict = ""
    name: str = ""
    color: str = ""

    def __post_init__(self) -> None:
        if len(self.anchor) != 2 or not all(math.isfinite(place) for place in self.anchor):
            raise ValueError(f"The anchor of a mark is {self.anchor} but must be two finite numbers, row and column.")
        if self.verdict not in get_args(Verdict):
            raise ValueError(f'The verdict of a mark is "{self.verdict}" but must be "kept", "rejected" or empty.')
        if self.color and not re.fullmatch("#[0-9A-Fa-f]{6}", self.color):
            raise ValueError(
                f'The color of a mark is "{self.color}" but must be "#rrggbb", two hexadecimal digits each for red, '
                "green and blue, or empty."
            )

    @property
    def says_nothing(self) -> bool:
        """Whether it can be left out."""
        return not (self.verdict or self.name or self.color)


@dataclass(frozen=True, eq=False, slots=True)
class ReviewedContour:
    """A contour with what has been said about it.

    Attributes
    ----------
    contour : Contour
        With the name and the color that its mark gives it.
    mark : Mark or None
        None when nothing has been said.
    index : int
        Its place among the contours of the reconstruction.
    """

    contour: Contour
    mark: Mark | None
    index: int

    @property
    def verdict(self) -> Verdict:
        """What is thought of it."""
        return self.mark.verdict if self.mark else ""

    @property
    def rejected(self) -> bool:
        """Whether it is not to be written."""
        return self.verdict == "rejected"


def reviewed(contours: Sequence[Contour], marks: Sequence[Mark]) -> tuple[ReviewedContour, ...]:
    """Give each contour the mark that is meant for it.

    Parameters
    ----------
    contours : sequence of Contour
        Contours of a reconstruction.
    marks : sequence of Mark
        What has been said, of whichever reconstruction.

    Returns
    -------
    tuple of Curated
        One for each contour, in their order.
    """
    owner = attached(contours, [mark.anchor for mark in marks])
    by_contour = {contour: mark for contour, mark in zip(owner, marks, strict=True) if contour is not None}
    return tuple(_curated(contour, by_contour.get(index), index) for index, contour in enumerate(contours))


def apply(result: Result, marks: Sequence[Mark]) -> Result:
    """The result without the contours that have been rejected, and with names and colors.

    Parameters
    ----------
    result : Result
        Outcome of a run.
    marks : sequence of Mark
        What has been said about its contours.

    Returns
    -------
    Result
        The same one when nothing has been said.
    """
    if not marks:
        return result
    every = reviewed(result.contours, marks)
    kept = tuple(one.contour for one in every if not one.rejected)
    dropped = [one.contour for one in every if one.rejected]
    bridges = result.bridges
    if dropped:  # a bridge is a stretch of a contour, and goes with it
        lost = _on(dropped, [bridge.points for bridge in bridges])
        stays = _on(kept, [bridge.points for bridge in bridges])
        bridges = tuple(b for b, off, on in zip(bridges, lost, stays, strict=True) if on <= off)
    return replace(result, contours=kept, bridges=bridges)


def attached(contours: Sequence[Contour], anchors: Sequence[Position], reach: float = REACH) -> list[int | None]:
    """Find for each anchor the contour that is meant: the one that passes nearest.

    Each anchor has one contour at most and each contour one anchor: the nearest pair comes first, then the nearest
    among the others. Of anchors that lie equally near, the first comes first; of contours, the longest.

    Parameters
    ----------
    contours : sequence of Contour
        Contours in any order.
    anchors : sequence of tuple of float
        Places (row, col) [px].
    reach : float
        Farthest that a contour may pass from its anchor [px].

    Returns
    -------
    list of (int or None)
        For each anchor the index of its contour; None where there is none.
    """
    found: list[int | None] = [None] * len(anchors)
    if not contours or not anchors:
        return found
    near = Neighborhood(contours).pairs(np.array(anchors, dtype=float), reach)
    pairs = sorted(
        (away, number, -contours[index].length, index)
        for number, index, away in zip(*(of_pair.tolist() for of_pair in near), strict=True)
    )
    taken: set[int] = set()
    for _, number, _, index in pairs:
        if found[number] is None and index not in taken:
            found[number] = index
            taken.add(index)
    return found


class Neighborhood:
    """Contours by the places where they pass, so that those near a place are found without looking at them all.

    Parameters
    ----------
    contours : sequence of Contour
        Contours.
    """

    def __init__(self, contours: Sequence[Contour]) -> None:
        paths = [contour.path if len(contour.path) > 1 else contour.path[[0, 0]] for contour in contours]
        begin = np.concatenate([np.empty((0, 2)), *(path[:-1] for path in paths)])
        end = np.concatenate([np.empty((0, 2)), *(path[1:] for path in paths)])
        owner = np.repeat(np.arange(len(paths)), [len(path) - 1 for path in paths])
        row = 0.5 * (begin[:, 0] + end[:, 0])
        order = np.argsort(row, kind="stable")
        self._row = row[order]
        self._begin, self._along, self._owner = begin[order], (end - begin)[order], owner[order]
        half = 0.5 * np.abs(self._along)
        self._middle_col = self._begin[:, 1] + 0.5 * self._along[:, 1]
        self._half_col = half[:, 1]
        self._tallest = float(half[:, 0].max(initial=0.0))

    def passing(self, place: Position, reach: float) -> list[tuple[int, float]]:
        """The contours that pass near a place, nearest first.

        Parameters
        ----------
        place : tuple of float
            (row, col) [px].
        reach : float
            How near [px].

        Returns
        -------
        list of (int, float)
            Index and distance [px] of each.
        """
        _, index, away = self.pairs(np.array([place]), reach)
        return sorted(zip(index.tolist(), away.tolist(), strict=True), key=lambda one: (one[1], one[0]))

    def pairs(self, places: Array, reach: float) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
        """The pairs of a place and a contour that passes near it.

        Parameters
        ----------
        places : ndarray, shape (N, 2)
            Places (row, col) [px].
        reach : float
            How near [px].

        Returns
        -------
        tuple of three ndarray, shape (P,)
            For each pair the index of the place, that of the contour, and their distance [px].
        """
        # Segments are in the order of their rows, so that those beside a place stand together.
        width = reach + self._tallest
        first = np.searchsorted(self._row, places[:, 0] - width)
        count = np.searchsorted(self._row, places[:, 0] + width, side="right") - first
        number = np.repeat(np.arange(len(places)), count)
        segment = np.arange(len(number)) + np.repeat(first - np.cumsum(count) + count, count)
        beside = np.abs(self._middle_col[segment] - places[number, 1]) <= reach + self._half_col[segment]
        number, segment = number[beside], segment[beside]
        away = distances_to_segments(places[number], self._begin[segment], self._along[segment])
        near = away <= reach
        number, owner, away = number[near], self._owner[segment[near]], away[near]
        order = np.lexsort((away, owner, number))
        number, owner, away = number[order], owner[order], away[order]
        nearest = np.ones(len(number), np.bool_)  # the first of a place and a contour is the nearest segment
        nearest[1:] = (np.diff(number) != 0) | (np.diff(owner) != 0)
        return number[nearest], owner[nearest], away[nearest]


def middle(contour: Contour) -> Position:
    """Place half the way along a contour."""
    row, col = polyline.middles(contour.path, 1)[0].tolist()
    return row, col


def anchor(contours: Sequence[Contour], index: int) -> Position:
    """Place on a contour that tells it best from the others: far from them, and from its own ends.

    Parameters
    ----------
    contours : sequence of Contour
        All contours.
    index : int
        Which one is to be marked.

    Returns
    -------
    tuple of float
        (row, col) [px].
    """
    contour = contours[index]
    share = (np.arange(_PLACES) + 0.5) / _PLACES
    order = np.argsort(np.abs(share - 0.5), kind="stable")  # the middle comes first among equals
    places = polyline.middles(contour.path, _PLACES)[order]
    clear = np.full(_PLACES, _ALONE)
    low, high = contour.box
    for other, neighbor in enumerate(contours):
        apart = np.maximum(neighbor.box[0] - high, low - neighbor.box[1]).max()
        if other != index and apart < _ALONE:
            clear = np.minimum(clear, polyline.distances(neighbor.path, places))
    row, col = places[int(np.argmax(clear))].tolist()
    return row, col


def _curated(contour: Contour, mark: Mark | None, index: int) -> ReviewedContour:
    if mark is not None and (mark.name, mark.color) != (contour.name, contour.color):
        contour = replace(contour, name=mark.name or contour.name, color=mark.color or contour.color)
    return ReviewedContour(contour, mark, index)


def _on(contours: Sequence[Contour], paths: Sequence[Array]) -> list[float]:
    """How far the middle of each path lies off the nearest of some contours [px]."""
    places = [path[len(path) // 2] for path in paths]
    return [min((float(polyline.distances(c.path, p[None])[0]) for c in contours), default=math.inf) for p in places]
