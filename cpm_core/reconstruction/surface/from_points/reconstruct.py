"""Surfaces from points alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.contours.surface import Surface
from cpm_core.numerics.real_numbers import real_numbers
from cpm_core.numerics.types import Array
from cpm_core.parameters.quotation import shown
from cpm_core.reconstruction.surface.components import support
from cpm_core.reconstruction.surface.from_points.crust import crust
from cpm_core.reconstruction.surface.from_points.implicit import implicit_surface
from cpm_core.reconstruction.surface.from_points.normals import estimated_normals
from cpm_core.reconstruction.surface.sampling import typical_distance

METHODS = ("implicit", "crust")
"""Ways to a surface from points alone."""

_FEWEST, _FEWEST_FOR_NORMALS = 4, 13
"""Least number of points, and the least from which normals are estimated."""

_SMALLEST, _LARGEST = 1e-100, 1e100
"""Least and largest extent of the points: its cube is still a number."""


def reconstruct_surface(points: ArrayLike, normals: ArrayLike | None = None, method: str = "implicit") -> Surface:
    """Surface through points that lie densely on it, without the volume in which they were found.

    Parameters
    ----------
    points : array_like of real numbers, shape (N, 3)
        Places on the surface, in any unit, about equally far from their neighbors.
    normals : array_like of real numbers, shape (N, 3), optional
        Directions outward at the points, of any length. Without them they are estimated from the neighbors.
    method : {"implicit", "crust"}
        ``"implicit"``: the zero of a function that the points with their normals define, closed and manifold by
        construction. ``"crust"``: triangles between the points themselves, by Amenta, Bern and Kamvysselis (1998),
        with normal filtering, trimming and manifold extraction; it needs no normals, but a dense sample.

    Returns
    -------
    Surface
        Vertices are in the unit of the points.

    Raises
    ------
    ValueError
        When points or normals are not three finite real numbers each, when all points lie in a plane, or when they
        are too few, or not dense enough for the crust.

    Notes
    -----
    Sheets, nested ones as well, have to be apart by more than about twice the distance between neighboring points, or
    they grow together. A sheet that ends in the open bounds nothing: the implicit surface closes it by a guess, and
    the crust leaves it out, or is refused when nothing else is left.

    Examples
    --------
    >>> surface = cpm.reconstruct_surface(cpm.sphere((15, 15, 15), 9, 400))
    >>> surface.closed, surface.euler
    (True, 2)
    """
    if not isinstance(method, str) or method not in METHODS:
        raise ValueError(f"method is {shown(method)} but must be one of {', '.join(METHODS)}.")
    places = np.unique(_triples(points, "points"), axis=0) if normals is None else _triples(points, "points")
    _check_extent(places)
    apart = typical_distance(places)
    if method == "crust":
        vertices, faces = crust(places)
        if not len(faces):
            raise ValueError(
                f"The {len(places)} points are not dense enough for the crust, in which every gap spreads: "
                'give more points, or choose the method "implicit".'
            )
    else:
        vertices, faces = implicit_surface(places, _outward(places, normals, apart), apart)
    return Surface(vertices, faces, unsupported=1.0 - float(support(vertices, places, apart).mean()))


def _outward(places: Array, normals: ArrayLike | None, apart: float) -> Array:
    """Unit normals of the points: those given, or estimated ones."""
    if normals is not None:
        given = _triples(normals, "normals")
        if len(given) != len(places):
            raise ValueError(f"There are {len(places)} points, but {len(given)} normals: give one for each point.")
        return _unit(given)
    if len(places) < _FEWEST_FOR_NORMALS:
        raise ValueError(
            f"{len(places)} different points are too few to estimate normals: give {_FEWEST_FOR_NORMALS} or more, or "
            "their normals."
        )
    return estimated_normals(places, apart)


def _check_extent(places: Array) -> None:
    """Refuse points that span no volume, or one whose measures are too small or too large for numbers."""
    extent = float(np.abs(places - places[:1]).max()) if len(places) else 0.0
    if extent and not _SMALLEST < extent < _LARGEST:
        raise ValueError(f"The points spread over {extent:g}: give them in another unit.")
    if len(places) < _FEWEST or not extent or np.linalg.matrix_rank((places - places.mean(0)) / extent, tol=1e-9) < 3:
        raise ValueError(f"A surface needs points that span a volume, but these {len(places)} lie in a plane.")


def _triples(given: ArrayLike, name: str) -> Array:
    found = real_numbers(given)
    if found.ndim != 2 or found.shape[1] != 3:
        raise ValueError(f"The {name} have the shape {found.shape}, but must be real numbers of shape (N, 3).")
    if not np.isfinite(found).all():
        raise ValueError(f"The {name} hold NaN or infinite numbers: leave them out.")
    return found


def _unit(normals: Array) -> Array:
    lengths = np.linalg.norm(normals, axis=1)
    if not (lengths > 0.0).all():
        raise ValueError("A normal of length zero points nowhere: leave its point out.")
    return np.asarray(normals / lengths[:, None])
