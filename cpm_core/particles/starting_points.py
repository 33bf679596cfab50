"""Seeds: the places that particles are put at, and which of them may be."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cpm_core.image.regions import Regions
from cpm_core.numerics.types import Array


def starting_points(seeds: ArrayLike, shape: tuple[int, ...], regions: Regions | None) -> Array:
    """Check where particles are to start, and leave out those that may not be there."""
    points = np.asarray(seeds, dtype=float)
    if points.size == 0:
        raise ValueError("there are no particles to start with: draw a circle or click some points first.")
    if points.ndim != 2 or points.shape[1] != len(shape):
        raise ValueError(f"the starting particles have the shape {points.shape} but must be (N, {len(shape)}).")
    if not np.isfinite(points).all():
        wrong = int((~np.isfinite(points)).sum())
        raise ValueError(f"{wrong} coordinates of the starting particles are not finite: leave those particles out.")
    inside = inside_image(points, shape)
    if not inside.any():
        size = " x ".join(map(str, shape))
        raise ValueError(
            f"none of the {len(points)} starting particles lies inside the image ({size} pixels): draw inside it."
        )
    points = points[inside]
    allowed = allowed_by(points, regions)
    if not allowed.any():
        raise ValueError(
            f"none of the {len(points)} starting particles lies inside the regions of interest, clear of barriers: "
            "draw inside them."
        )
    return points[allowed]


def inside_image(positions: Array, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Which positions lie on the image, its outermost pixels whole."""
    return np.asarray(((positions >= -0.5) & (positions <= np.array(shape) - 0.5)).all(axis=1))


def allowed_by(positions: Array, regions: Regions | None) -> NDArray[np.bool_]:
    """Which positions [px of the image] lie in the regions of interest and on no barrier."""
    return np.ones(len(positions), np.bool_) if regions is None else regions.allows(positions)
