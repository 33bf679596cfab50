"""The Coulomb force of eq. (9) between particles anywhere: pair by pair, or fast by a tree.

The tree halves the particles by number along the longest side, so that it is as deep for clusters as for a grid. A box
that is far from a leaf acts on its particles by its number of particles at their mean, and by their quadrupole moments
``Q_ab = sum_j d_a d_b`` about it; one that is not is opened. What is left are near leaves, summed pair by pair.
Positions in the plane are those of space with z = 0.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.numerics.jit import compiled, reordered
from cpm_core.numerics.parallel import share
from cpm_core.numerics.real_numbers import real_numbers
from cpm_core.numerics.types import Array, Index
from cpm_core.parameters.quotation import shown

METHODS = ("auto", "exact", "tree")

_WORTH_A_TREE = 1500
"""Particles from which on the tree is faster than the sum over all pairs."""

_SAME_SPOT = 1e-36
"""Squared distance up to which two particles are at the same position. Such a pair, and a particle with itself, counts
as one unit apart except for its vanishing distance, so that its force vanishes; without a branch the loop runs on
vector registers. Positions are within some units here, where no two different ones are that near."""

_WORTH_A_THREAD = 100_000
"""Pairs from which a thread pays."""

_FULLEST = 32
"""Particles in a leaf."""

_OPENING = 0.33
"""Radius of a far box over its distance from the nearest particle it acts on, at most."""


def coulomb_force(positions: ArrayLike, method: str = "auto") -> Array:
    """Coulomb force on every particle from all the others, eq. (9) with unit charges.

    Parameters
    ----------
    positions : array_like, shape (N, 2) or (N, 3)
        Positions of the particles [px].
    method : {"auto", "exact", "tree"}
        How the sum is computed. "exact": pair by pair. "tree": groups of particles that are far from one another by
        their moments; the time grows with N log N. The relative error over all particles (l2) is below 1e-3, and about
        1e-2 where nearly all forces cancel, as along an evenly spaced line. "auto": the faster of the two.

    Returns
    -------
    ndarray, shape (N, D)
        ``sum_j (r_i - r_j) / |r_i - r_j|^3``, not normalized. Particles at the same position do not act on each other;
        this includes particles nearer to each other than 1e-18 of the extent of all.

    Raises
    ------
    ValueError
        For positions of another shape, that are no finite numbers, or whose forces would be none, or an unknown method.

    Examples
    --------
    >>> cpm.coulomb_force(np.array([(0.0, 0.0), (0.0, 2.0)])).round(3).tolist()
    [[0.0, -0.25], [0.0, 0.25]]
    """
    points = real_numbers(positions)
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise ValueError(f"positions have the shape {points.shape} but must be (N, 2) or (N, 3).")
    if not isinstance(method, str) or method not in METHODS:
        raise ValueError(f"method is {shown(method)} but must be one of {', '.join(METHODS)}.")
    count, axes = points.shape
    if not count:
        return np.zeros((0, axes))
    unit, scale = _in_unit_of_extent(points)
    sites = np.zeros((3, count))
    sites[3 - axes :] = unit.T
    fast = method == "tree" or (method == "auto" and count > _WORTH_A_TREE)
    force = (_tree_sums(sites) if fast else _pair_sums(sites))[:, 3 - axes :]
    with np.errstate(over="ignore"):
        force = force / scale / scale
    if not np.isfinite(force).all():
        raise ValueError(
            f"positions lie within {scale:.2g} px, so close together that forces cannot be computed: give them in "
            "another unit."
        )
    return force


def _in_unit_of_extent(points: Array) -> tuple[Array, float]:
    """Positions in a unit of length in which the extent of the particles is about one, and that unit, exactly."""
    with np.errstate(over="ignore", invalid="ignore"):
        sides = points.max(axis=0) - points.min(axis=0)
    if not np.isfinite(sides.sum()):
        raise ValueError("positions must be finite numbers; there are others among them, or they lie too far apart.")
    extent = float(sides.max())
    scale = float(2.0 ** np.floor(np.log2(extent))) if extent > 0.0 else 1.0
    return points / scale, scale


def _pair_sums(sites: Array) -> Array:
    """Sums of eq. (9) for particles at `sites`, shape (3, N), shape (N, 3)."""
    count = sites.shape[1]
    force = np.empty((count, 3))
    share(partial(_sum_pairs, sites, force), count, _WORTH_A_THREAD // count + 1)
    return force


@reordered
def _sum_pairs(sites: Array, force: Array, first: int, last: int) -> None:
    for n in range(first, last):
        force[n, 0], force[n, 1], force[n, 2] = _pairs_of(sites, sites.shape[1], sites[0, n], sites[1, n], sites[2, n])


@reordered
def _pairs_of(sites: Array, count: int, z: float, y: float, x: float) -> tuple[float, float, float]:
    """Eq. (9) for a particle at (z, y, x) and the first of the others, which may include itself."""
    f_z, f_y, f_x = 0.0, 0.0, 0.0
    for j in range(count):
        d_z, d_y, d_x = z - sites[0, j], y - sites[1, j], x - sites[2, j]
        squared = d_z * d_z + d_y * d_y + d_x * d_x
        squared = squared if squared > _SAME_SPOT else 1.0
        # A root in single precision and a correction are as exact as a root in double precision, and take less time.
        root = np.float64(np.float32(1.0) / np.sqrt(np.float32(squared)))
        rest = 1.0 - squared * root * root
        root *= 1.0 + rest * (0.5 + 0.375 * rest)
        cube = root * root * root
        f_z += cube * d_z
        f_y += cube * d_y
        f_x += cube * d_x
    return f_z, f_y, f_x


_MOMENTS = 11
"""Numbers of a box: mean position, radius about it, number of particles, and quadrupole zz, yy, xx, zy, zx, yx."""


def _tree_sums(points: Array) -> Array:
    """The sums of `_pair_sums`, nearly."""
    count, leaves = points.shape[1], 1
    while count > _FULLEST * leaves:
        leaves *= 2
    boxes, order, force = np.zeros((2 * leaves, _MOMENTS)), np.arange(count), np.empty((count, 3))
    level = 1
    while level <= leaves:
        share(partial(_build, points, order, boxes, level), level, _WORTH_A_THREAD * level // count + 1)
        level *= 2
    sites = np.ascontiguousarray(points[:, order])
    share(partial(_sum_leaves, sites, boxes, order, force), leaves, 4)
    return force


@compiled
def _build(points: Array, order: Index, boxes: Array, level: int, first: int, last: int) -> None:
    """Write the numbers of some boxes of a level, and sort their particles into two halves each."""
    count, side = len(order), np.empty(3)
    for k in range(first, last):
        start, end = count * k // level, count * (k + 1) // level
        box, inside = boxes[level + k], order[start:end]
        box[4] = end - start
        for axis in range(3):
            places = points[axis][inside]
            side[axis], box[axis] = places.max() - places.min(), places.mean()
        for n in inside:
            z, y, x = points[0, n] - box[0], points[1, n] - box[1], points[2, n] - box[2]
            box[3] = max(box[3], np.sqrt(z * z + y * y + x * x))
            box[5], box[6], box[7] = box[5] + z * z, box[6] + y * y, box[7] + x * x
            box[8], box[9], box[10] = box[8] + z * y, box[9] + z * x, box[10] + y * x
        if 2 * level < len(boxes):
            half = inside[np.argpartition(points[side.argmax()][inside], count * (2 * k + 1) // (2 * level) - start)]
            for n in range(start, end):
                order[n] = half[n - start]


@compiled
def _sum_leaves(sites: Array, boxes: Array, order: Index, force: Array, first: int, last: int) -> None:
    """Force on the particles of some leaves, in the order of all."""
    count, leaves = sites.shape[1], len(boxes) // 2
    stack, near, far = np.empty(leaves + 1, np.int64), np.empty((3, count)), np.empty((_MOMENTS, 2 * leaves))
    for leaf in range(leaves + first, leaves + last):
        top, listed, distant = 1, 0, 0
        stack[0] = 1
        while top > 0:
            top -= 1
            node = stack[top]
            box = boxes[node]
            away = np.sqrt(((box[:3] - boxes[leaf, :3]) ** 2).sum()) - boxes[leaf, 3]
            if box[3] < _OPENING * away:
                for n in range(_MOMENTS):
                    far[n, distant] = box[n]
                distant += 1
            elif node < leaves:
                stack[top], stack[top + 1] = 2 * node, 2 * node + 1
                top += 2
            else:
                for i in range(count * (node - leaves) // leaves, count * (node - leaves + 1) // leaves):
                    near[0, listed], near[1, listed], near[2, listed] = sites[0, i], sites[1, i], sites[2, i]
                    listed += 1
        for i in range(count * (leaf - leaves) // leaves, count * (leaf - leaves + 1) // leaves):
            z, y, x = sites[0, i], sites[1, i], sites[2, i]
            one, other = _pairs_of(near, listed, z, y, x), _far_boxes(far, distant, z, y, x)
            for axis in range(3):
                force[order[i], axis] = one[axis] + other[axis]


@reordered
def _far_boxes(far: Array, count: int, z: float, y: float, x: float) -> tuple[float, float, float]:
    """Force on a particle at (z, y, x) of boxes far from it: that of their number, and of their quadrupole."""
    f_z, f_y, f_x = 0.0, 0.0, 0.0
    for k in range(count):
        d_z, d_y, d_x = z - far[0, k], y - far[1, k], x - far[2, k]
        inverse = 1.0 / (d_z * d_z + d_y * d_y + d_x * d_x)
        cube = inverse * np.sqrt(inverse)
        q_z = far[5, k] * d_z + far[8, k] * d_y + far[9, k] * d_x
        q_y = far[8, k] * d_z + far[6, k] * d_y + far[10, k] * d_x
        q_x = far[9, k] * d_z + far[10, k] * d_y + far[7, k] * d_x
        along = 7.5 * inverse * (q_z * d_z + q_y * d_y + q_x * d_x) - 1.5 * (far[5, k] + far[6, k] + far[7, k])
        central = cube * (far[4, k] + inverse * along)
        f_z += central * d_z - 3.0 * cube * inverse * q_z
        f_y += central * d_y - 3.0 * cube * inverse * q_y
        f_x += central * d_x - 3.0 * cube * inverse * q_x
    return f_z, f_y, f_x
