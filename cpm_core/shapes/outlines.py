"""Closed lines of drawn starts, for methods that need an inside; and starts along contours, surfaces and lines."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from cpm_core.contours.contour import Contours
from cpm_core.image.surface import Surface
from cpm_core.medial_axis.centerlines import Centerlines
from cpm_core.numerics import polyline
from cpm_core.numerics.polyline import as_line
from cpm_core.numerics.types import Array, Arrays
from cpm_core.shapes.ellipse import Circle, Ellipse
from cpm_core.shapes.lines import Points, Polygon, Stroke
from cpm_core.shapes.shape import Shape

SURFACE_START_SPACING = 2.0
"""Distance of the particles of a start on a surface, equal to that along a stroke [smallest sides of a voxel]."""


def drawn_outlines(shapes: Iterable[Shape]) -> Arrays:
    """Collect the corners of circles, ellipses and polygons, shape (K, 2) each [px], the first not repeated."""
    return tuple(shape.outline[:-1] for shape in shapes if isinstance(shape, Circle | Ellipse | Polygon))


def starts_from_contours(contours: Contours, places: Array | None = None) -> tuple[Polygon | Stroke | Points, ...]:
    """Convert contours to starts with the corners that matter: polygons and strokes.

    Single points, shape (N, 2) [px], make one more start.
    """
    starts: list[Polygon | Stroke | Points] = []
    for contour in contours:
        corners = polyline.simplify_path(contour.path.tolist())
        closed = contour.closed and len(set(corners)) > 2
        starts.append(Polygon(corners[:-1]) if closed else Stroke(corners))
    if places is not None and len(places):
        starts.append(Points(as_line(places)))
    return tuple(starts)


def start_from_surface(surface: Surface) -> Points:
    """Sample a surface as a start: one vertex in each cube with sides of `SURFACE_START_SPACING`."""
    used = surface.vertices[np.unique(surface.faces)]
    cubes = np.floor(used * surface.spacing / (SURFACE_START_SPACING * min(surface.spacing))).astype(np.int64)
    first = np.sort(np.unique(cubes, axis=0, return_index=True)[1])
    return Points(as_line(used[first]))


def starts_from_centerlines(lines: Centerlines) -> tuple[Stroke, ...]:
    """Convert center lines to starts with the corners that matter."""
    return tuple(Stroke(polyline.simplify_path(branch.points.tolist())) for branch in lines.branches)
