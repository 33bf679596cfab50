"""Contours, and the bridges across their gaps: the outcome of the reconstruction."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np

from cpm_core.image.colors import check_color
from cpm_core.numerics import polyline
from cpm_core.numerics.segments import PathTree
from cpm_core.numerics.types import NO_POINTS, Array, Integers, record
from cpm_core.parameters.formatting import format_count, format_repr

SAMPLE_SPACING = 0.25
"""Distance between samples along contours that are compared [px]."""


@record
class Curve:
    """Polygonal line or polygon through `points` [px]."""

    points: Array
    closed: bool

    @cached_property
    def path(self) -> Array:
        """Vertices with the first repeated at the end when it is closed."""
        return np.concatenate([self.points, self.points[:1]]) if self.closed else self.points

    @cached_property
    def box(self) -> Array:
        """Lowest and highest row and column, shape (2, 2) [px]."""
        return np.stack([self.points.min(axis=0), self.points.max(axis=0)])

    @cached_property
    def length(self) -> float:
        """Length along the curve [px]."""
        return polyline.path_length(self.path)


@record
class Contour(Curve):
    """A polygonal curve through particles.

    Attributes
    ----------
    points : ndarray of float64, shape (K, 2)
        Vertices (row, col) in px of the image, in order along the curve; of center lines in a volume shape (K, 3).
    closed : bool
        Whether the last vertex is joined to the first; the first is not repeated.
    strength : float
        Mean of the edge map along the curve [gray levels / px].
    junctions : tuple of two bool
        Whether the first and the last vertex lie on a junction with other contours.
    measure_contrast : callable or None
        Measures `contrast` (`field.region_contrast.MeanContrast`); None for a curve that was not found in an image.
    name : str
        Name of the object that it bounds, or empty.
    color : str
        Color of the object that it bounds, ``"#rrggbb"``; empty for the default color.
    number : int
        Number that it keeps through the pages of a stack, from 1; 0 for its place in order (`assign_numbers`).
    group : int
        Number of the object whose boundary it is, from 1; 0 for a contour without an object.
    hole : bool
        Whether it is the boundary of a hole in an object.
    bridged : float
        Length of the stretches that close a gap in the edge [px].
    category : str
        Name of the class of the object that it bounds, or empty.
    gray : float or None
        Mean gray value inside it, without contours inside; None where it has not been measured (only pages do).
    confidence : float or None
        Confidence in the object that it bounds, from 0 to 1; None where it is unknown.

    Raises
    ------
    ValueError
        When the color does not have this form.

    Examples
    --------
    >>> corners = np.array([(2.0, 2.0), (2.0, 12.0), (12.0, 12.0), (12.0, 2.0)])
    >>> square = cpm.Contour(corners, closed=True, name="a square")
    >>> square
    <Contour a square, closed, 40.0 px around 100.0 px², 4 vertices>
    >>> square.length, square.area, square.box.tolist(), len(square.path), square.encloses_area
    (40.0, 100.0, [[2.0, 2.0], [12.0, 12.0]], 5, True)
    >>> found = cpm.segment(cpm.example("disk"), cpm.circle((32, 32), 8)).contours[0]
    >>> round(found.contrast, 2)
    0.92
    """

    strength: float = 0.0
    junctions: tuple[bool, bool] = (False, False)
    measure_contrast: Callable[[], float] | None = None
    name: str = ""
    color: str = ""
    number: int = 0
    group: int = 0
    hole: bool = False
    bridged: float = 0.0
    category: str = ""
    gray: float | None = None
    confidence: float | None = None

    def __post_init__(self) -> None:
        check_color("a contour", self.color)

    @property
    def encloses_area(self) -> bool:
        """Whether it is closed around an area, for which two vertices are too few."""
        return self.closed and len(self.points) > 2

    @cached_property
    def contrast(self) -> float:
        """Mean contrast of the regions on both sides, from 0 for equal ones to 1 for uniform ones.

        It takes longer to measure than a contour takes to find, and is measured at the first access.
        """
        return self.measure_contrast() if self.measure_contrast else 0.0

    @property
    def area(self) -> float:
        """Enclosed area [px²]; 0 for an open curve, and for one in a volume."""
        return polyline.enclosed_area(self.points) if self.closed and self.points.shape[1] == 2 else 0.0

    def __repr__(self) -> str:
        kind = "hole" if self.hole else "closed" if self.closed else "open"
        around = f" around {self.area:,.1f} px²" if self.area else ""
        vertices = format_count(len(self.points), "vertex", "vertices")
        return format_repr("Contour", self.name, kind, f"{self.length:,.1f} px{around}", vertices)


Contours = Sequence[Contour]
"""Sequence of contours."""


@record
class Bridge:
    """A closed gap in an edge: a stretch of a contour without particles.

    Attributes
    ----------
    points : ndarray of float64, shape (K, 2)
        Vertices (row, col) in px of the image, from one side of the gap to the other, both included; they are also
        vertices of its contour.
    length : float
        Length along it [px].
    strength : float
        Mean of the edge map along it [gray levels / px].

    Examples
    --------
    >>> parameters = cpm.Parameters(max_gap=30, edge_floor=0.25)
    >>> result = cpm.segment(cpm.example("gap"), cpm.circle((32, 32), 8), parameters)
    >>> bridge = result.bridges[0]
    >>> len(result.bridges), round(bridge.length), bridge.strength < result.contours[0].strength
    (1, 10, True)
    """

    points: Array
    length: float
    strength: float

    def __repr__(self) -> str:
        return format_repr("Bridge", f"{self.length:,.1f} px", f"strength {self.strength:.3g}")


def assign_numbers(contours: Contours) -> Integers:
    """Assign each contour a number, no two equal: its own, or the next free one where it has none."""
    taken = {contour.number for contour in contours}
    free = (number for number in itertools.count(1) if number not in taken)
    return tuple(contour.number or next(free) for contour in contours)


def stack_vertices(contours: Contours) -> Array:
    """Stack the vertices of contours, shape (N, 2) [px]."""
    return np.concatenate([NO_POINTS, *(contour.points for contour in contours)])


def sample_contours(contours: Contours) -> Array:
    """Sample contours every `SAMPLE_SPACING`, shape (N, 2) [px], for averages over their length."""
    return np.concatenate([NO_POINTS, *(polyline.sample_path(contour.path, SAMPLE_SPACING) for contour in contours)])


def build_path_tree(contours: Contours) -> PathTree:
    """Build a spatial index of contours, to find those near a position."""
    return PathTree([contour.path for contour in contours])


_BRIDGE_ON_CONTOUR = 0.01
"""Distance from a contour up to which a bridge is part of it [px]: its vertices are also those of the contour."""


def select_bridges_on(bridges: Sequence[Bridge], contours: Contours) -> tuple[Bridge, ...]:
    """Select the bridges that are part of one of the contours."""
    if not bridges or not contours:
        return ()
    middles = np.array([bridge.points[len(bridge.points) // 2] for bridge in bridges])
    there = set(build_path_tree(contours).pairs_within(middles, _BRIDGE_ON_CONTOUR)[0].tolist())
    return tuple(bridge for number, bridge in enumerate(bridges) if number in there)
