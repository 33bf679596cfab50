"""The Coulomb force of eq. (9) between particles anywhere: pair by pair, or fast by a tree.

The tree halves boxes at the middle of their longest side, each drawn tightly around its particles, so that it resolves
clusters of any density. A box that is far from a leaf acts on its particles by its number of particles at their mean,
and by their quadrupole moments about it; one that is not is opened. What is left are near leaves, summed particle by
particle. Both sums are made in single precision from exact differences. Positions in the plane are those of space with
z = 0. Each leaf is computed by one thread, in the same order on any number of them.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.numerics.jit import compiled, reordered
from cpm_core.numerics.parallel import share
from cpm_core.numerics.real_numbers import real_numbers
from cpm_core.numerics.types import Array, Index, Single
from cpm_core.numerics.vectors import Vector
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
"""Particles in a leaf, unless they are all at the same position; between two such leaves nothing acts."""

_OPENING = 0.28
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
    with np.errstate(over="ignore", invalid="ignore"):
        sides = np.ptp(points, axis=0)
    if not np.isfinite(sides.sum()):
        raise ValueError("positions must be finite numbers; there are others among them, or they lie too far apart.")
    # the extent of the particles is about one in this unit, exactly
    scale = float(2.0 ** np.floor(np.log2(sides.max()))) if sides.max() > 0.0 else 1.0
    sites, force = np.zeros((3, count)), np.empty((count, 3))
    sites[3 - axes :] = points.T / scale
    if method == "tree" or (method == "auto" and count > _WORTH_A_TREE):
        _sum_by_tree(sites, force)
    else:
        share(partial(_sum_pairs, sites, force), count, _WORTH_A_THREAD // count + 1)
    with np.errstate(over="ignore"):
        force = force[:, 3 - axes :] / scale / scale
    if not np.isfinite(force).all():
        raise ValueError(
            f"positions lie within {scale:.2g} px, so close together that forces cannot be computed: give them in "
            "another unit."
        )
    return force


@reordered
def _sum_pairs(sites: Array, force: Array, first: int, last: int) -> None:
    """Eq. (9) for some of the particles at `sites`, shape (3, N), and all the others, which may include themselves."""
    for i in range(first, last):
        f_z, f_y, f_x = 0.0, 0.0, 0.0
        for j in range(sites.shape[1]):
            d_z, d_y, d_x = sites[0, i] - sites[0, j], sites[1, i] - sites[1, j], sites[2, i] - sites[2, j]
            squared = d_z * d_z + d_y * d_y + d_x * d_x
            squared = squared if squared > _SAME_SPOT else 1.0
            # A root in single precision and a correction are as exact as one in double precision, and take less time.
            root = np.float64(np.float32(1.0) / np.sqrt(np.float32(squared)))
            rest = 1.0 - squared * root * root
            root *= 1.0 + rest * (0.5 + 0.375 * rest)
            cube = root * root * root
            f_z += cube * d_z
            f_y += cube * d_y
            f_x += cube * d_x
        force[i, 0], force[i, 1], force[i, 2] = f_z, f_y, f_x


_MOMENTS = 10
"""Numbers of a box: mean position, number of particles, and quadrupole zz, yy, xx, zy, zx, yx without its trace."""


def _sum_by_tree(sites: Array, force: Array) -> None:
    """The sums of `_sum_pairs` for all, nearly; sorts `sites`."""
    count, behind = len(force), 0
    order, span, levels = np.arange(count), np.array([(0, count)]), []
    while len(span):
        boxes, radius, middle = np.zeros((len(span), _MOMENTS)), np.zeros(len(span)), np.zeros(len(span), np.int64)
        halve = partial(_halve, sites, order, span, boxes, radius, middle)
        share(halve, len(span), _WORTH_A_THREAD * len(span) // count + 1)
        halved, behind = middle > 0, behind + len(span)
        levels.append((span, np.where(halved, behind + 2 * np.cumsum(halved) - 2, 0), boxes, radius))
        middle = middle[halved]
        span = np.stack([span[halved, 0], middle, middle, span[halved, 1]], axis=1).reshape(-1, 2)
    spans, half, boxes, radius = map(np.concatenate, zip(*levels, strict=True))
    leaves = np.flatnonzero(half == 0)
    share(partial(_sum_leaves, sites, order, spans, half, boxes, radius, leaves, force), len(leaves), 4)


@compiled
def _halve(
    sites: Array, order: Index, span: Index, boxes: Array, radius: Array, middle: Index, first: int, last: int
) -> None:
    """Write the numbers of some boxes, sort the particles of each into its halves, and where the second half begins."""
    for k in range(first, last):
        box, (start, end) = boxes[k], span[k]
        box[3], widest, longest, cut = end - start, 0.0, 0, 0.0
        for axis in range(3):
            low = high = some = sites[axis, start]
            total = 0.0
            for n in range(start, end):
                here = sites[axis, n]
                low, high, total = min(low, here), max(high, here), total + (here - some)
            box[axis] = some + total / box[3]
            if high - low > widest:
                center = low + 0.5 * (high - low)
                widest, longest, cut = high - low, axis, center if center < high else low
        farthest = 0.0
        for n in range(start, end):
            z, y, x = sites[0, n] - box[0], sites[1, n] - box[1], sites[2, n] - box[2]
            squared = z * z + y * y + x * x
            farthest, third = max(farthest, squared), squared / 3.0
            box[4], box[5], box[6] = box[4] + z * z - third, box[5] + y * y - third, box[6] + x * x - third
            box[7], box[8], box[9] = box[7] + z * y, box[8] + z * x, box[9] + y * x
        radius[k] = np.sqrt(farthest)
        if end - start > _FULLEST and widest**2 > _SAME_SPOT:
            behind = start  # what is sorted out is written in any case: a branch would be a guess each time
            for n in range(start, end):
                before = sites[longest, n] <= cut
                for axis in range(3):
                    sites[axis, behind], sites[axis, n] = sites[axis, n], sites[axis, behind]
                order[behind], order[n] = order[n], order[behind]
                behind += before
            middle[k] = behind


@compiled
def _sum_leaves(
    sites: Array,
    order: Index,
    span: Index,
    half: Index,
    boxes: Array,
    radius: Array,
    leaves: Index,
    force: Array,
    first: int,
    last: int,
) -> None:
    """Force on the particles of some leaves, in the order of all."""
    stack, near = np.empty(len(half), np.int64), np.empty((3, len(order)))
    far, moments = np.empty((3, len(half))), np.empty((_MOMENTS - 3, len(half)), np.float32)
    for leaf in leaves[first:last]:
        stack[0], top, listed, distant = 0, 1, 0, 0
        while top > 0:
            top -= 1
            k = stack[top]
            apart = np.sqrt(((boxes[k, :3] - boxes[leaf, :3]) ** 2).sum())
            if radius[k] < _OPENING * (apart - radius[leaf]):
                for n in range(3):
                    far[n, distant] = boxes[k, n]
                for n in range(3, _MOMENTS):
                    moments[n - 3, distant] = boxes[k, n]
                distant += 1
            elif half[k]:
                stack[top], stack[top + 1] = half[k], half[k] + 1
                top += 2
            elif (radius[k] + apart + radius[leaf]) ** 2 > _SAME_SPOT:
                for i in range(span[k, 0], span[k, 1]):
                    near[0, listed], near[1, listed], near[2, listed] = sites[0, i], sites[1, i], sites[2, i]
                    listed += 1
        for i in range(span[leaf, 0], span[leaf, 1]):
            site = sites[0, i], sites[1, i], sites[2, i]
            one, other = _near_force(near, listed, site), _far_force(far, moments, distant, site)
            for axis in range(3):
                force[order[i], axis] = one[axis] + other[axis]


@compiled
def _scaled(way: np.float32, root: np.float32, strength: np.float32) -> np.float32:
    """A product whose factors stay finite in this order: the cube of the root may not."""
    scaled: np.float32 = way * root * strength
    return scaled


@reordered
def _near_force(near: Array, count: int, site: Vector) -> Vector:
    """Eq. (9) for a particle at a site and those of a list, in single precision."""
    one, (z, y, x) = np.float32(1.0), site
    f_z, f_y, f_x = np.float32(0.0), np.float32(0.0), np.float32(0.0)
    for j in range(count):
        d_z, d_y, d_x = np.float32(z - near[0, j]), np.float32(y - near[1, j]), np.float32(x - near[2, j])
        squared = d_z * d_z + d_y * d_y + d_x * d_x
        root = one / np.sqrt(squared if squared > np.float32(_SAME_SPOT) else one)
        inverse = root * root
        f_z += _scaled(d_z, root, inverse)
        f_y += _scaled(d_y, root, inverse)
        f_x += _scaled(d_x, root, inverse)
    return float(f_z), float(f_y), float(f_x)


@reordered
def _far_force(far: Array, moments: Single, count: int, site: Vector) -> Vector:
    """Force on a particle at a site of boxes far from it: that of their number, and of their quadrupole."""
    one, three, more, (z, y, x) = np.float32(1.0), np.float32(3.0), np.float32(7.5), site
    f_z, f_y, f_x = np.float32(0.0), np.float32(0.0), np.float32(0.0)
    for k in range(count):
        d_z, d_y, d_x = np.float32(z - far[0, k]), np.float32(y - far[1, k]), np.float32(x - far[2, k])
        squared = d_z * d_z + d_y * d_y + d_x * d_x
        root = one / np.sqrt(squared if squared > np.float32(_SAME_SPOT) else one)
        inverse = root * root
        u_z, u_y, u_x = d_z * root, d_y * root, d_x * root
        q_z = moments[1, k] * u_z + moments[4, k] * u_y + moments[5, k] * u_x
        q_y = moments[4, k] * u_z + moments[2, k] * u_y + moments[6, k] * u_x
        q_x = moments[5, k] * u_z + moments[6, k] * u_y + moments[3, k] * u_x
        central = moments[0, k] + more * (inverse * (q_z * u_z + q_y * u_y + q_x * u_x))
        f_z += inverse * (central * u_z - three * (inverse * q_z))
        f_y += inverse * (central * u_y - three * (inverse * q_y))
        f_x += inverse * (central * u_x - three * (inverse * q_x))
    return float(f_z), float(f_y), float(f_x)
