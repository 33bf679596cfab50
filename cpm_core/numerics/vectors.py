"""Vectors in space as three numbers, for compiled loops that allocate no array; and places that are far apart."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask

Vector = tuple[float, float, float]
"""A position or a direction (plane, row, col)."""


@compiled
def dot(one: Vector, other: Vector) -> float:
    """Return the scalar product of two vectors."""
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


@compiled
def vector_length(vector: Vector) -> float:
    """Return the length of a vector."""
    return float(np.sqrt(dot(vector, vector)))


@compiled
def move_along(place: Vector, way: float, direction: Vector) -> Vector:
    """Return the place at a distance from another one in a direction."""
    return place[0] + way * direction[0], place[1] + way * direction[1], place[2] + way * direction[2]


@compiled
def scale_vector(vector: Vector, factor: float) -> Vector:
    """Return a vector times a number."""
    return factor * vector[0], factor * vector[1], factor * vector[2]


@compiled
def subtract_vectors(one: Vector, other: Vector) -> Vector:
    """Return the vector from the other place to the first one."""
    return one[0] - other[0], one[1] - other[1], one[2] - other[2]


@compiled
def row_of(rows: Array, i: int) -> Vector:
    """One row of an array of shape (N, 3)."""
    return float(rows[i, 0]), float(rows[i, 1]), float(rows[i, 2])


@compiled
def set_row(rows: Array, i: int, vector: Vector) -> None:
    """Write one row of an array of shape (N, 3)."""
    rows[i, 0], rows[i, 1], rows[i, 2] = vector[0], vector[1], vector[2]


def row_lengths(vectors: Array) -> Array:
    """Return the length of each row of vectors, shape (N, D), as shape (N,); faster than `np.linalg.norm`."""
    return np.sqrt(np.einsum("ni,ni->n", vectors, vectors))


def keep_apart(places: Array, distance: float, are_rivals: Callable[[Index, Index], Mask] | None = None) -> Mask:
    """Keep places, shape (N, D), so that none has an earlier one that stays nearer than a distance; a mask, shape (N,).

    `are_rivals` tells of pairs, by the indices of both, which are in each other's way, by default all.
    """
    kept = np.ones(len(places), bool)
    if len(places):
        pairs = scipy.spatial.cKDTree(places).query_pairs(np.nextafter(distance, 0.0), output_type="ndarray")
        if are_rivals is not None:
            pairs = pairs[are_rivals(*pairs.T)]
        for earlier, later in pairs[np.argsort(pairs[:, 0], kind="stable")].tolist():
            if kept[earlier]:
                kept[later] = False
    return kept
