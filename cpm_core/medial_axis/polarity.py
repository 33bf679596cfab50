"""Polarity: which parts of a medial axis lie in what is darker, or lighter, than its surroundings on both sides.

Where outlines have gaps, objects and background hang together, and the gray level of a region does not tell one from
the other. What lies between two edges is told by these edges alone: in a dark object the image gets lighter across
each of them, seen from inside.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.medial_axis.boundary import Boundary
from cpm_core.medial_axis.medial_axis import Axis
from cpm_core.medial_axis.pruning import parts
from cpm_core.numerics.types import Array

DARK, LIGHT = -1, 1
"""Polarity of what is darker, and of what is lighter, than its surroundings; 0 stands for neither."""

_TURNED = 0.3
"""Least cosine of the angle between the image gradient at an edge and the direction from the axis to it."""

_CLEAR, _PURE = 0.8, 0.05
"""Share of the objects' length that must have the same polarity, and largest share of all lengths that may lie between
a darker and a lighter side, or in a region of the other polarity, for an image to have one."""


def polarities(axis: Axis, boundary: Boundary) -> NDArray[np.int8]:
    """Polarity of every edge of an axis with sides, shape (M,): `DARK`, `LIGHT` or 0 between different sides."""
    middle = axis.points[axis.edges].mean(axis=1)
    outward = boundary.points[axis.sides] - middle[:, None]
    gradient = boundary.normals[axis.sides]
    size = np.linalg.norm(outward, axis=2) * np.linalg.norm(gradient, axis=2)
    rise = np.einsum("msk,msk->ms", outward, gradient) / np.maximum(size, 1e-300)
    dark, light = (rise > _TURNED).all(axis=1), (rise < -_TURNED).all(axis=1)
    return np.where(dark, DARK, np.where(light, LIGHT, 0)).astype(np.int8)


def of_polarity(axis: Axis, polarity: NDArray[np.int8], sign: int) -> Axis:
    """The parts of an axis with one of the `polarities`; a connected part as a whole if nearly all of it has it.

    At the sharp corners of a region, which smoothing rounds, the gradient does not point away from the axis.
    """
    length = lengths(axis)
    count, part = parts(axis)
    of_part = part[axis.edges[:, 0]]
    same = polarity == sign
    whole = np.bincount(of_part, length * same, count) >= (1.0 - _PURE) * np.bincount(of_part, length, count)
    return axis.chosen(same | whole[of_part])


def common_polarity(
    axis: Axis,
    boundary: Boundary,
    polarity: NDArray[np.int8],
    objects: NDArray[np.bool_],
    shape: tuple[int, ...],
) -> int:
    """Polarity that the objects of an image share; 0 if they do not.

    Parameters
    ----------
    axis, boundary
        Medial axis of all regions, and the edges between them.
    polarity : ndarray of int8, shape (M,)
        `polarities` of its edges.
    objects : ndarray of bool, shape (M,)
        Which edges lie in objects.
    shape : tuple of int
        Shape of the image; what lies outside has no effect.
    """
    inside = axis.inside(np.full(2, -0.5), np.array(shape) - 0.5)[axis.edges].all(axis=1)
    length = np.where(inside, lengths(axis) * _breadth(axis, boundary), 0.0)
    count, part = parts(axis)
    of_part = part[axis.edges[:, 0]]
    dark, light, mixed = (np.bincount(of_part, length * (polarity == sign), count) for sign in (DARK, LIGHT, 0))
    whole = float(length.sum())
    if mixed.sum() > _PURE * whole or np.minimum(dark, light).sum() > _PURE * whole:
        return 0
    shares = [float(length[objects & (polarity == sign)].sum()) for sign in (DARK, LIGHT)]
    if max(shares) <= _CLEAR * sum(shares):
        return 0
    return DARK if shares[0] > shares[1] else LIGHT


def _breadth(axis: Axis, boundary: Boundary) -> Array:
    """How far apart the sides of each edge of an axis are, from 0 to 1 for opposite ones; small at irregularities."""
    outward = boundary.points[axis.sides] - axis.points[axis.edges].mean(axis=1)[:, None]
    across = np.linalg.norm(outward[:, 1] - outward[:, 0], axis=1)
    return np.asarray((across / np.maximum(np.linalg.norm(outward, axis=2).sum(axis=1), 1e-300)) ** 2)


def lengths(axis: Axis) -> Array:
    """Lengths of the edges of an axis, shape (M,) [px]."""
    return np.asarray(np.linalg.norm(np.diff(axis.points[axis.edges], axis=1)[:, 0], axis=1))
