"""Review: verdicts, names and colors that the user gives contours, kept through further reconstructions.

A mark has a fixed position, its anchor, and belongs to the contour that passes there. The next reconstruction moves
contours by fractions of a pixel and may change their order, but not the anchor. When a contour splits, the piece at the
anchor keeps the mark. A mark without a contour at its anchor is kept for later.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from cpm_core.contours.contour import Contour, Contours, build_path_tree, check_color
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Line, Position, frozen, record

Verdict = Literal["", "kept", "rejected"]
"""Verdict on a contour: none yet, kept, or rejected."""

ANCHOR_REACH = 4.0
"""Greatest distance of a contour from an anchor that belongs to it [px]."""

_ANCHOR_CANDIDATES = 24
"""Number of positions along a contour among which its anchor is selected."""

_ISOLATED_DISTANCE = 3.0 * ANCHOR_REACH
"""Distance from all other contours beyond which positions are equally good [px]."""


@frozen
class KeptOutline:
    """Course of a contour when it was kept; the attributes are those of `Contour`, by default none."""

    points: Line = ()
    closed: bool = False
    strength: float = 0.0
    number: int = 0

    def to_contour(self, name: str = "", color: str = "") -> Contour:
        """Convert the outline to a contour."""
        points = np.array(self.points, float).reshape(-1, 2)
        return Contour(points, self.closed, self.strength, name=name, color=color, number=self.number)


@frozen
class Mark:
    """Verdict, name and color of the contour at a position.

    Attributes
    ----------
    anchor : tuple of float
        Position (row, col) [px].
    verdict : {"", "kept", "rejected"}
        Rejected contours are not exported, kept ones stay (`cpm_core.results.review`); empty where nothing is decided.
    name : str
        Name, or empty.
    color : str
        Color, ``"#rrggbb"``; empty for the default color.
    outline : KeptOutline
        Where a kept contour ran.
    """

    anchor: Position
    verdict: Verdict = ""
    name: str = ""
    color: str = ""
    outline: KeptOutline = KeptOutline()

    def __post_init__(self) -> None:
        check_color("a mark", self.color)


@record
class ReviewedContour:
    """A contour with its mark.

    Attributes
    ----------
    contour : Contour
        The contour with the name and the color of its mark.
    mark : Mark or None
        None without a mark.
    index : int
        Index among the contours of the reconstruction.
    """

    contour: Contour
    mark: Mark | None
    index: int

    @property
    def verdict(self) -> Verdict:
        """The verdict of the mark."""
        return self.mark.verdict if self.mark else ""

    @property
    def rejected(self) -> bool:
        """Whether it is left out of exports."""
        return self.verdict == "rejected"


def pair_with_marks(contours: Contours, marks: Sequence[Mark]) -> tuple[ReviewedContour, ...]:
    """Pair each contour with its mark, in order; the marks may be from an earlier reconstruction."""
    owner = assign_anchors(contours, [mark.anchor for mark in marks])
    by_contour = {contour: mark for contour, mark in zip(owner, marks, strict=True) if contour is not None}
    found = []
    for index, contour in enumerate(contours):
        mark = by_contour.get(index)
        named = contour
        if mark is not None and (mark.name, mark.color) != (contour.name, contour.color):
            named = replace(contour, name=mark.name or contour.name, color=mark.color or contour.color)
        found.append(ReviewedContour(named, mark, index))
    return tuple(found)


def assign_anchors(contours: Contours, anchors: Sequence[Position]) -> list[int | None]:
    """Assign each anchor (row, col) the index of the nearest contour within `ANCHOR_REACH` [px]; None without one.

    Each anchor has at most one contour and each contour one anchor: the nearest pair is assigned first, then the
    nearest of the others. Among equally near anchors the first has priority, among contours the longest.
    """
    found: list[int | None] = [None] * len(anchors)
    if not contours or not anchors:
        return found
    near = build_path_tree(contours).pairs_within(np.array(anchors, float), ANCHOR_REACH)
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


def contour_midpoint(contour: Contour) -> Position:
    """Return the position halfway along a contour."""
    return tuple(polyline.path_midpoints(contour.path, 1)[0].tolist())


def find_anchors(contours: Contours, indices: Sequence[int]) -> list[Position]:
    """Find for each index a position (row, col) on its contour, far from other contours and from its own ends [px]."""
    if not indices:
        return []
    share = (np.arange(_ANCHOR_CANDIDATES) + 0.5) / _ANCHOR_CANDIDATES
    order = np.argsort(np.abs(share - 0.5), kind="stable")  # the middle has priority among equals
    low, high = np.concatenate([one.box for one in contours]).reshape(-1, 2, 2).swapaxes(0, 1)
    found: list[Position] = []
    along = polyline.midpoints_of_paths([contours[index].path for index in indices], _ANCHOR_CANDIDATES)[:, order]
    for index, places in zip(indices, along, strict=True):
        clear = np.full(_ANCHOR_CANDIDATES, _ISOLATED_DISTANCE)
        apart = np.maximum(low - high[index], low[index] - high).max(axis=1)
        for other in np.flatnonzero(apart < _ISOLATED_DISTANCE).tolist():
            if other != index:
                clear = np.minimum(clear, polyline.distances_to_path(contours[other].path, places))
        row, col = places[int(np.argmax(clear))].tolist()
        found.append((row, col))
    return found


def capture_outline(contour: Contour) -> KeptOutline:
    """Capture the course of a contour, to restore it later."""
    points = tuple((round(row, 4), round(col, 4)) for row, col in contour.points.tolist())
    return KeptOutline(points, contour.closed, contour.strength, contour.number)
