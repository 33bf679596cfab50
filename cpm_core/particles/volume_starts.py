"""Starts in a volume: particles on a sphere and on a box."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.real_numbers import checked_number, three_numbers, voxel_sides
from cpm_core.numerics.types import Array
from cpm_core.parameters.quotation import shown

_GOLDEN = np.pi * (1.0 + 5.0**0.5)
"""Turn from one particle on a sphere to the next: no two of them line up."""

_LARGEST, _MOST = 1e5, 10_000_000
"""Largest radius, beyond any volume that can be processed [voxels], and the most particles."""


def sphere(
    center: tuple[float, float, float],
    radius: float,
    count: int = 625,
    spacing: tuple[float, float, float] = (1.0, 1.0, 1.0),
) -> Array:
    """Particles on a sphere, evenly spread.

    Parameters
    ----------
    center : tuple of float
        Center (plane, row, col) [voxels].
    radius : float
        Radius, in the unit of `spacing`: voxels unless a spacing is given.
    count : int
        Number of particles.
    spacing : tuple of float
        Sides of a voxel (plane, row, col), for a sphere in a volume whose voxels are no cubes.

    Returns
    -------
    ndarray, shape (N, 3)
        Positions (plane, row, col) [voxels].

    Raises
    ------
    ValueError
        When the center is not three finite numbers, radius or spacing is not positive, or the count is not a positive
        whole number.
    """
    middle, sides = three_numbers("center", center), voxel_sides("spacing", spacing)
    checked_number("radius", radius, lambda r: 0.0 < r <= _LARGEST, f"above 0 and at most {_LARGEST:g}")
    checked_number("count", count, lambda n: n == int(n) and 1 <= n <= _MOST, f"a whole number from 1 to {_MOST}")
    step = np.arange(int(count)) + 0.5
    down, around = np.arccos(1.0 - 2.0 * step / count), _GOLDEN * step
    out = np.stack([np.cos(down), np.sin(down) * np.sin(around), np.sin(down) * np.cos(around)], axis=1)
    return np.asarray(middle + radius * out / sides)


def box(first: tuple[float, float, float], last: tuple[float, float, float], spacing: float = 2.0) -> Array:
    """Particles on the faces of a box.

    Parameters
    ----------
    first, last : tuple of float
        Two opposite corners (plane, row, col) [voxels].
    spacing : float
        Distance between particles along each axis [voxels]; adapted so that there are particles on all edges.

    Returns
    -------
    ndarray, shape (N, 3)
        Positions (plane, row, col).

    Raises
    ------
    ValueError
        When the corners are not three finite numbers each or have no distance along an axis, or when the spacing is
        not positive or so small that there would be too many particles.
    """
    low, high = np.sort([three_numbers("first", first), three_numbers("last", last)], axis=0)
    if not (high > low).all():
        raise ValueError(
            f"the corners of the box are {shown(first)} and {shown(last)} but must differ along every axis."
        )
    checked_number("spacing", spacing, lambda side: side > 0.0, "above 0")
    counts = np.maximum(1.0, np.round((high - low) / spacing))
    if np.prod(counts + 1.0) - np.prod(np.maximum(counts - 1.0, 0.0)) > _MOST:
        raise ValueError(f"spacing is {spacing:g}, which makes more than {_MOST} particles: choose a larger one.")
    faces = []
    for axis in range(3):
        lines = [np.linspace(low[k], high[k], int(counts[k]) + 1) for k in range(3)]
        lines = [line[1:-1] if k < axis else line for k, line in enumerate(lines)]  # edges belong to one face
        lines[axis] = np.array([low[axis], high[axis]])
        faces.append(np.stack([part.ravel() for part in np.meshgrid(*lines, indexing="ij")], axis=1))
    return np.concatenate(faces)
