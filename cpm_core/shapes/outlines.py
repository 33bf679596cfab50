"""The closed lines of drawn starts, from which methods that need an inside begin; and starts along given lines."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array
from cpm_core.shapes import Circle, Ellipse, Points, Polygon, Shape, Stroke


def outlines_of(shapes: Iterable[Shape]) -> tuple[Array, ...]:
    """Corners of each circle, ellipse and polygon among shapes, shape (K, 2) [px], the first not repeated."""
    return tuple(shape.outline[:-1] for shape in shapes if isinstance(shape, Circle | Ellipse | Polygon))


def starts_along(contours: Sequence[Contour], places: Array | None = None) -> tuple[Polygon | Stroke | Points, ...]:
    """Starts along contours, with the corners that matter: polygons and strokes, and single points as one start."""
    starts: list[Polygon | Stroke | Points] = []
    for contour in contours:
        corners = polyline.thinned([(row, col) for row, col in contour.path.tolist()])
        closed = contour.closed and len(set(corners)) > 2
        starts.append(Polygon(corners[:-1]) if closed else Stroke(corners))
    if places is not None and len(places):
        starts.append(Points(tuple((row, col) for row, col in np.asarray(places).tolist())))
    return tuple(starts)
