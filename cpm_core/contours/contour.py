"""Contours: what the reconstruction finds and the writers write."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cpm_core.field.region_contrast import Sides


def lengths_along(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Length of the way along a polygonal curve, shape (K, D), to each of its vertices [px]; the first is at 0."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


@dataclass(frozen=True, eq=False)
class Contour:
    """A polygonal curve through particles.

    Attributes
    ----------
    points : ndarray of float64, shape (K, 2)
        Vertices (row, col) in px of the image, in order along the curve.
    closed : bool
        Whether the last vertex is joined to the first; the first is not repeated.
    strength : float
        Mean of the edge map along the curve [grey levels / px].
    junctions : tuple of two bool
        Whether the first and the last vertex lie on a junction that further contours share.
    sides : Sides or None
        What `contrast` is measured on; None for a curve that was not found in an image.
    name : str
        What a user calls it; empty when nobody has named it.
    colour : str
        Colour that a user has given it, ``"#rrggbb"``; empty when nobody has.

    Raises
    ------
    ValueError
        When the colour is none of these.
    """

    points: NDArray[np.float64]
    closed: bool
    strength: float = 0.0
    junctions: tuple[bool, bool] = (False, False)
    sides: Sides | None = field(default=None, repr=False)
    name: str = ""
    colour: str = ""

    def __post_init__(self) -> None:
        if self.colour and not re.fullmatch("#[0-9A-Fa-f]{6}", self.colour):
            raise ValueError(
                f'The colour of a contour is "{self.colour}" but must be "#rrggbb", two hexadecimal digits each for '
                "red, green and blue, or empty."
            )

    @cached_property
    def contrast(self) -> float:
        """Mean contrast of the regions on both sides, from 0 for two alike to 1 for two even ones.

        It takes longer to measure than a contour takes to find, and is measured when it is first asked for.
        """
        return self.sides.contrast if self.sides else 0.0

    @property
    def path(self) -> NDArray[np.float64]:
        """Vertices with the first repeated at the end when the contour is closed."""
        return np.concatenate([self.points, self.points[:1]]) if self.closed else self.points

    @cached_property
    def length(self) -> float:
        """Length along the curve [px]."""
        path = self.path
        return float(np.linalg.norm(path[1:] - path[:-1], axis=1).sum())

    @cached_property
    def box(self) -> NDArray[np.float64]:
        """Lowest and highest row and column, shape (2, 2) [px]."""
        return np.stack([self.points.min(axis=0), self.points.max(axis=0)])

    @property
    def area(self) -> float:
        """Enclosed area [px²]; 0 for an open curve."""
        if not self.closed:
            return 0.0
        row, col = self.path.T
        return 0.5 * abs(float(row[:-1] @ col[1:] - col[:-1] @ row[1:]))
