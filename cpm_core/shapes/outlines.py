"""The closed lines of drawn starts, from which methods that need an inside begin."""

from __future__ import annotations

from collections.abc import Iterable

from cpm_core.numerics.types import Array
from cpm_core.shapes import Circle, Ellipse, Polygon, Shape


def outlines_of(shapes: Iterable[Shape]) -> tuple[Array, ...]:
    """Corners of each circle, ellipse and polygon among shapes, shape (K, 2) [px], the first not repeated."""
    return tuple(shape.outline[:-1] for shape in shapes if isinstance(shape, Circle | Ellipse | Polygon))
