"""Contours, and the bridges across gaps in them: what the reconstruction finds and the writers write."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array

SAMPLING = 0.25
"""Distance from sample to sample along contours that are compared [px]."""

FORMER_NAMES: dict[str, str] = {"colour": "color"}
"""Names of properties of contours in older files -> their present names."""


def present_names(properties: Mapping[str, Any]) -> dict[str, Any]:
    """Properties of a contour as a file has them, under their present names."""
    return {FORMER_NAMES.get(name, name): value for name, value in properties.items()}


class HasContrast(Protocol):
    """What the contrast of a contour is measured on, when it is first asked for."""

    @property
    def contrast(self) -> float:
        """Mean contrast of the regions on both sides, 0 to 1."""


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
        Mean of the edge map along the curve [gray levels / px].
    junctions : tuple of two bool
        Whether the first and the last vertex lie on a junction that further contours share.
    sides : HasContrast or None
        What `contrast` is measured on (`field.region_contrast.Sides`); None for a curve that was not found in an image.
    name : str
        What a user calls it; empty when it has no name.
    color : str
        Color that a user has given it, ``"#rrggbb"``; empty for the color of its kind.

    Raises
    ------
    ValueError
        When the color is none of these.
    """

    points: Array
    closed: bool
    strength: float = 0.0
    junctions: tuple[bool, bool] = (False, False)
    sides: HasContrast | None = field(default=None, repr=False)
    name: str = ""
    color: str = ""

    def __post_init__(self) -> None:
        if self.color and not re.fullmatch("#[0-9A-Fa-f]{6}", self.color):
            raise ValueError(
                f'The color of a contour is "{self.color}" but must be "#rrggbb", two hexadecimal digits each for '
                "red, green and blue, or empty."
            )

    @cached_property
    def contrast(self) -> float:
        """Mean contrast of the regions on both sides, from 0 for two alike to 1 for two even ones.

        It takes longer to measure than a contour takes to find, and is measured when it is first asked for.
        """
        return self.sides.contrast if self.sides else 0.0

    @property
    def path(self) -> Array:
        """Vertices with the first repeated at the end when the contour is closed."""
        return np.concatenate([self.points, self.points[:1]]) if self.closed else self.points

    @cached_property
    def length(self) -> float:
        """Length along the curve [px]."""
        return polyline.length(self.path)

    @cached_property
    def box(self) -> Array:
        """Lowest and highest row and column, shape (2, 2) [px]."""
        return np.stack([self.points.min(axis=0), self.points.max(axis=0)])

    @property
    def area(self) -> float:
        """Enclosed area [px²]; 0 for an open curve."""
        return polyline.area(self.points) if self.closed else 0.0


@dataclass(frozen=True, eq=False)
class Bridge:
    """A gap in an edge that the reconstruction has closed: a stretch of a contour that no particle has found.

    Attributes
    ----------
    points : ndarray of float64, shape (K, 2)
        Vertices (row, col) in px of the image, from one side of the gap to the other, both included; those of the
        contour that it belongs to.
    length : float
        Length along it [px].
    strength : float
        Mean of the edge map along it [gray levels / px].
    """

    points: Array
    length: float
    strength: float


def sampled(contours: Sequence[Contour]) -> Array:
    """Points every `SAMPLING` along contours, shape (N, 2) [px]: what averages over their length are made of."""
    return np.concatenate([np.empty((0, 2)), *(polyline.sampled(contour.path, SAMPLING) for contour in contours)])
