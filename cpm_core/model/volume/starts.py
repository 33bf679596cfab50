"""Starts in a volume: on a sphere or a box, at shapes drawn in slices, evenly, on strong edges, between edges."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy
from numpy.typing import ArrayLike

from cpm_core.field.edge_map import volume_edge_map
from cpm_core.field.volume_field import pitch_of, smooth_volume
from cpm_core.image.gray_levels import limit_specks
from cpm_core.image.image import Image, as_image
from cpm_core.model.starts import STRONG_EDGE_FRACTION, field_divergence_centers, pixels_above, uniform_grid
from cpm_core.numerics.grids import grid_points
from cpm_core.numerics.real_numbers import (
    check_finite_number,
    check_rows,
    check_three_numbers,
    check_voxel_sides,
)
from cpm_core.numerics.types import Array
from cpm_core.parameters.formatting import quote_value

_GOLDEN_TURN = np.pi * (1.0 + 5.0**0.5)
"""Turn from one particle on a sphere to the next: no two of them line up."""

_MAX_SPHERE_RADIUS = 1e5
"""Largest radius, beyond any volume that can be processed [voxels]."""

_MAX_VOLUME_SEEDS = 10_000_000
"""Largest number of particles of a start."""

_MAX_CENTER_CUBES = 2e6
"""Number of cubes in which centers are searched in a large volume."""


def sphere(
    center: Sequence[float],
    radius: float,
    count: int = 625,
    voxel_size: Sequence[float] = (1.0, 1.0, 1.0),
) -> Array:
    """Place particles on a sphere, evenly spread.

    Parameters
    ----------
    center : tuple of float
        Center (plane, row, col) [voxels].
    radius : float
        Radius, in the unit of `voxel_size`: voxels unless a size is given.
    count : int
        Number of particles.
    voxel_size : tuple of float
        Sides of a voxel (plane, row, col), for a sphere in a volume whose voxels are no cubes.

    Returns
    -------
    ndarray, shape (N, 3)
        Positions (plane, row, col) [voxels].

    Raises
    ------
    ValueError
        When the center is not three finite numbers, radius or size is not positive, or the count is not a positive
        whole number.

    Examples
    --------
    >>> cpm.sphere((15, 15, 15), radius=4, count=60).shape
    (60, 3)
    """
    middle, sides = check_three_numbers("center", center), check_voxel_sides("voxel_size", voxel_size)
    check_finite_number(
        "radius", radius, lambda r: 0.0 < r <= _MAX_SPHERE_RADIUS, f"above 0 and at most {_MAX_SPHERE_RADIUS:g}"
    )
    check_finite_number(
        "count",
        count,
        lambda n: n == int(n) and 1 <= n <= _MAX_VOLUME_SEEDS,
        f"a whole number from 1 to {_MAX_VOLUME_SEEDS}",
    )
    step = np.arange(int(count)) + 0.5
    down, around = np.arccos(1.0 - 2.0 * step / count), _GOLDEN_TURN * step
    out = np.stack([np.cos(down), np.sin(down) * np.sin(around), np.sin(down) * np.cos(around)], axis=1)
    return middle + radius * out / sides


def seeds_on_box(first: Sequence[float], last: Sequence[float], spacing: float = 2.0) -> Array:
    """Place particles on the faces of a box.

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

    Examples
    --------
    >>> cpm.seeds_on_box((4, 4, 4), (10, 10, 10)).shape[1]
    3
    """
    low, high = np.sort([check_three_numbers("first", first), check_three_numbers("last", last)], axis=0)
    if not (high > low).all():
        raise ValueError(
            f"the corners of the box are {quote_value(first)} and {quote_value(last)} but must differ along every axis."
        )
    check_finite_number("spacing", spacing, lambda side: side > 0.0, "above 0")
    counts = np.maximum(1.0, np.round((high - low) / spacing))
    if np.prod(counts + 1.0) - np.prod(np.maximum(counts - 1.0, 0.0)) > _MAX_VOLUME_SEEDS:
        raise ValueError(
            f"spacing is {spacing:g}, which makes more than {_MAX_VOLUME_SEEDS} particles: choose a larger one."
        )
    faces = []
    for axis in range(3):
        lines = [np.linspace(low[k], high[k], int(counts[k]) + 1) for k in range(3)]
        lines = [line[1:-1] if k < axis else line for k, line in enumerate(lines)]  # edges belong to one face
        lines[axis] = np.array([low[axis], high[axis]])
        faces.append(grid_points(lines))
    return np.concatenate(faces)


def seeds_in_slice(
    points: ArrayLike, at: float, axis: int = 0, voxel_size: tuple[float, float, float] = (1.0, 1.0, 1.0)
) -> Array:
    """Place points drawn in a slice, such as the particles of a circle or a stroke, in the volume.

    Parameters
    ----------
    points : array_like, shape (N, 2)
        Positions along the two axes of the slice, in the order of the volume's axes and in the unit of `voxel_size`:
        voxels unless a size is given.
    at : float
        Where the slice lies along the other axis [voxels].
    axis : int
        The axis across the slice: 0 for a plane (row, col), 1 for (plane, col), 2 for (plane, row).
    voxel_size : tuple of float
        Sides of a voxel (plane, row, col), for a volume whose voxels are no cubes: a circle is then round.

    Returns
    -------
    ndarray, shape (N, 3)
        Positions (plane, row, col) [voxels].

    Raises
    ------
    ValueError
        When the points are not rows of two finite numbers, the axis is none of the three, the slice is at no finite
        place, or the size is not positive.

    Examples
    --------
    >>> seeds = cpm.seeds_in_slice(cpm.circle((15, 15), 4), at=12)
    >>> seeds.shape[1], set(seeds[:, 0].tolist())
    (3, {12.0})
    """
    drawn, sides = check_rows("points", points, 2), check_voxel_sides("voxel_size", voxel_size)
    across = int(check_finite_number("axis", axis, lambda number: number in (0, 1, 2), "0, 1 or 2"))
    place = check_finite_number("at", at, lambda number: True, "a finite number of voxels")
    return np.insert(drawn / np.delete(sides, across), across, place, axis=1)


def seeds_everywhere(values: ArrayLike | Image, spacing: float = 8.0) -> Array:
    """Spread particles evenly over a volume, at this distance [smallest sides of a voxel]; shape (N, 3) [voxels].

    Examples
    --------
    >>> cpm.seeds_everywhere(cpm.example("ball")).shape[1]
    3
    """
    volume = _require_volume(values)
    pitch = np.array(pitch_of(volume.spacing))
    extent = tuple(int(side) for side in np.ceil((np.array(volume.shape) - 1) * pitch) + 1)
    places = uniform_grid(extent, spacing)
    inset = 0.5 * ((np.array(extent) - 1) - (np.array(volume.shape) - 1) * pitch)
    return (places - inset) / pitch


def seeds_on_strong_edges(
    values: ArrayLike | Image, fraction: float = STRONG_EDGE_FRACTION, smoothing: float = 1.0
) -> Array:
    """Place particles on every voxel with an edge strength above a fraction of the largest; shape (N, 3) [voxels].

    `smoothing` is the sigma of the Gaussian before the gradient [smallest sides of a voxel].

    Examples
    --------
    >>> seeds = cpm.seeds_on_strong_edges(cpm.example("ball"))
    >>> bool((np.abs(np.linalg.norm(seeds - 15, axis=1) - 9) < 3).all())
    True
    """
    check_finite_number("fraction", fraction, lambda share: 0.0 <= share <= 1.0, "from 0 to 1")
    sigma = check_finite_number("smoothing", smoothing, lambda width: width >= 0.0, "0 or more")
    return pixels_above(volume_edge_strength(_require_volume(values), sigma), fraction)


def volume_edge_strength(volume: Image, smoothing: float) -> Array:
    """Return the edge strength of every voxel, shape (P, R, C); `smoothing` as for `seeds_on_strong_edges`."""
    pitch = pitch_of(volume.spacing)
    smoothed = smooth_volume(limit_specks(volume.values), [smoothing / side for side in pitch])
    return volume_edge_map(smoothed, pitch).astype(float)


def seeds_at_centers(values: ArrayLike | Image, smoothing: float = 2.0, spacing: float = 4.0) -> Array:
    """Place particles in the middle between edges, where the field diverges; shape (N, 3) [voxels].

    Parameters
    ----------
    values : array_like, shape (P, R, C), or Image
        Volume. A large one is looked at more coarsely, in cubes of about two million in number.
    smoothing : float
        Sigma of the Gaussian before the gradient [smallest sides of a voxel].
    spacing : float
        Of two centers at most this far apart along each axis only the stronger is kept [smallest sides of a voxel, or
        of those cubes].

    Returns
    -------
    ndarray, shape (N, 3)
        Positions; see `divergence_centers`.

    Raises
    ------
    ValueError
        When it is no volume, smoothing is negative, or spacing is not a positive number.

    Examples
    --------
    >>> seeds = cpm.seeds_at_centers(cpm.example("ball"))
    >>> bool((np.linalg.norm(seeds - 15, axis=1) < 2).any())
    True
    >>> len(seeds) < len(cpm.seeds_everywhere(cpm.example("ball")))
    True
    """
    sigma = check_finite_number("smoothing", smoothing, lambda width: width >= 0.0, "0 or more")
    apart = check_finite_number("spacing", spacing, lambda number: number > 0.0, "above 0")
    volume = _require_volume(values)
    pitch = np.array(pitch_of(volume.spacing))
    smooth = smooth_volume(volume.values, (sigma / pitch).tolist())
    extent = np.maximum(np.array(volume.shape) - 1, 1) * pitch
    cube = max(1.0, float(np.prod(extent) / _MAX_CENTER_CUBES) ** (1.0 / 3.0))
    shape = np.maximum(np.rint(extent / cube).astype(int) + 1, 2)
    even = scipy.ndimage.zoom(smooth, shape / np.array(volume.shape), order=1, grid_mode=False)
    strength = volume_edge_map(even, (1.0, 1.0, 1.0))
    found = field_divergence_centers(np.asarray(strength, float), apart)
    return found * (np.array(volume.shape) - 1) / (np.array(even.shape) - 1)


def _require_volume(values: ArrayLike | Image) -> Image:
    """Return a volume from an image or from gray levels, whose voxels are cubes then."""
    volume = as_image(values)
    if len(volume.shape) != 3:
        raise ValueError(f"{volume.source} has the shape {volume.shape} but must be a volume, (planes, rows, columns).")
    return volume
