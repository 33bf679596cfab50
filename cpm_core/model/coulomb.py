"""The Coulomb force of eq. (9) between particles anywhere: pair by pair, or fast by a tree.

The tree halves the particles by number along the longest side, so that it is as deep for clusters as for a grid. Each
leaf looks at the boxes from the top down: one that is far enough acts on it by its moments

    M_abc = sum_j (c_z - z_j)^a (c_y - y_j)^b (c_x - x_j)^c / (a! b! c!)

about its center c, through a Taylor series of the fourth order of the potential 1 / r at the center of the leaf; one
that is not is opened; what is left are near leaves, summed pair by pair. Positions in the plane are those of space with
z = 0, where the terms with a > 0 vanish.

What is far enough follows from the tolerance. For a box of M particles at a distance d, a series of order p leaves out
less than about M theta^p / d^2, theta being the sum of the two radii over d. This is compared with the usual force
between these particles, from a sample. So the error stays small against the forces also where most of the forces on a
particle cancel; and where all of them do, everything is near, and the sum is exact.
"""

from __future__ import annotations

from functools import lru_cache, partial
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.numerics.jit import compiled, reordered
from cpm_core.numerics.parallel import share
from cpm_core.numerics.real_numbers import checked_number, real_numbers
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.parameters.quotation import shown

METHODS = ("auto", "exact", "tree")

_WORTH_A_TREE = 1500
"""Targets from which on the tree is faster than the sum over all pairs."""

_SAME_SPOT = 1e-36
"""Squared distance up to which two particles are at the same position. Such a pair, and a particle with itself, counts
as one unit apart except for its vanishing distance, so that its force vanishes; without a branch the loop runs on
vector registers. Positions are within some units here, where no two different ones are that near."""

_WORTH_A_THREAD = 100_000
"""Pairs from which a thread pays."""

_SAMPLES, _KEPT = 32, 24
"""Particles of the sample, and how many of them count: those with the smallest forces."""

_ORDER = 4
"""Order of the series."""

_FULLEST = 32
"""Particles in a leaf."""

_SHARE = 1.4
"""Fraction of the tolerance that one far box may use, times the root of the order of the series from the tolerance: the
smaller that is, the more boxes share it."""

_WIDEST = 0.6
"""Square of the largest theta at which a series is used, at any tolerance."""


def coulomb_force(
    positions: ArrayLike, method: str = "auto", targets: ArrayLike | None = None, tolerance: float = 1e-3
) -> Array:
    """Coulomb force on every particle from all the others, eq. (9) with unit charges.

    Parameters
    ----------
    positions : array_like, shape (N, 2) or (N, 3)
        Positions of the particles [px].
    method : {"auto", "exact", "tree"}
        How the sum is computed. "exact": pair by pair. "tree": groups of particles that are far from one another by
        series; the time grows with N log N. "auto": the faster of the two.
    targets : array_like of int, shape (M,), optional
        Indices of the particles whose force is computed; by default all of them.
    tolerance : float
        Relative error that "auto" and "tree" may make: root of the sum of the squared errors of all particles over
        that of their forces. From 1e-12 to 0.1.

    Returns
    -------
    ndarray, shape (N, D) or (M, D)
        ``sum_j (r_i - r_j) / |r_i - r_j|^3``, not normalized. Particles at the same position do not act on each other;
        this includes particles nearer to each other than 1e-18 of the extent of all.

    Raises
    ------
    ValueError
        For positions of another shape, that are no finite numbers, or whose forces would be none, an unknown method,
        targets that are no particles, or a tolerance out of range.

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
    checked_number("tolerance", tolerance, lambda error: 1e-12 <= error <= 0.1, "from 1e-12 to 0.1")
    count, axes = points.shape
    wanted = np.arange(count) if targets is None else _checked(targets, count)
    if not count:
        return np.zeros((0, axes))
    unit, scale = _in_unit_of_extent(points)
    sites = np.zeros((3, count))
    sites[3 - axes :] = unit.T
    fast = method == "tree" or (method == "auto" and len(wanted) > _WORTH_A_TREE)
    force = (_tree_sums(sites, wanted, axes, tolerance) if fast else _pair_sums(sites, wanted))[:, 3 - axes :]
    with np.errstate(over="ignore"):
        force = force / scale / scale
    if not np.isfinite(force).all():
        raise ValueError(
            f"positions lie within {scale:.2g} px, so near to each other that forces have no number: give them in "
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


def _checked(targets: ArrayLike, count: int) -> Index:
    indices = np.asarray(targets)
    if indices.ndim != 1 or (indices.size and indices.dtype.kind not in "iu"):
        raise ValueError(f"targets must be a list of indices, not {indices.dtype} of the shape {indices.shape}.")
    if indices.size and not (indices.min() >= 0 and indices.max() < count):
        raise ValueError(
            f"targets go from {indices.min()} to {indices.max()} but must be indices of the {count} particles."
        )
    return indices.astype(np.int64, copy=False)


def _pair_sums(sites: Array, targets: Index) -> Array:
    """Sums of eq. (9) for the particles `targets`, shape (M,), of those at `sites`, shape (3, N), shape (M, 3)."""
    force = np.empty((len(targets), 3))
    least = _WORTH_A_THREAD // sites.shape[1] + 1
    share(lambda first, last: _sum_pairs(sites, targets, first, last, force), len(targets), least)
    return force


@reordered
def _sum_pairs(sites: Array, targets: Index, first: int, last: int, force: Array) -> None:
    for n in range(first, last):
        force[n, 0], force[n, 1], force[n, 2] = _pairs_of(
            sites, sites.shape[1], sites[0, targets[n]], sites[1, targets[n]], sites[2, targets[n]]
        )


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


@lru_cache(maxsize=2)
def _series(axes: int) -> tuple[Index, Index, Index]:
    """Terms of a series, their places, and their products.

    Terms are powers (a, b, c) by their order, shape (T, 3); places, by a, b and c, are where a term is among them.
    Rows of products, shape (P, 3), are two terms and the one whose powers are their sums: Taylor's theorem connects a
    derivative in a leaf, a moment, and the derivative of 1 / r by them, or a moment of a box, one of its half, and the
    way between their centers.
    """
    every = [
        term for term in product(range(_ORDER + 1), repeat=3) if sum(term) <= _ORDER and not (axes == 2 and term[0])
    ]
    terms = np.array(sorted(every, key=lambda term: (sum(term), term)), np.int64)
    places = np.full((_ORDER + 2,) * 3, -1, np.int64)
    places[tuple(terms.T)] = np.arange(len(terms))
    rows = [
        (t, s, places[tuple(terms[t] + terms[s])])
        for t, s in product(range(len(terms)), repeat=2)
        if (terms[t] + terms[s]).sum() <= _ORDER
    ]
    return terms, places, np.array(rows, np.int64)


def _tree_sums(points: Array, targets: Index, axes: int, tolerance: float) -> Array:
    """The sums of `_pair_sums` with a relative error over all particles (l2) within the tolerance."""
    count, depth = points.shape[1], 0
    while count > _FULLEST << depth:
        depth += 1
    leaves, order, series = 1 << depth, np.arange(count), _series(axes)
    box = np.empty((2 * leaves, 4))
    for level in range(depth + 1):
        boxes = 1 << level
        share(partial(_halve, points, order, box, boxes), boxes, _WORTH_A_THREAD * boxes // count + 1)
    sites = np.ascontiguousarray(points[:, order])
    moments = np.zeros((2 * leaves, len(series[0])))
    for level in range(depth, -1, -1):
        boxes = 1 << level
        share(partial(_gather, sites, box, *series, moments, boxes), boxes, 64)
    step = np.arange(_SAMPLES)
    # The golden ratio avoids a sample that follows a regular pattern of the particles.
    chosen = ((step + 0.618034 * step % 1.0) * count / _SAMPLES).astype(np.int64)
    usual = np.sort((_pair_sums(sites, chosen) ** 2).sum(axis=1))[:_KEPT].mean()
    allowed = (_SHARE * tolerance * min(tolerance, 1e-3) ** (1.0 / _ORDER)) ** 2 * usual
    wanted = np.zeros(count, np.bool_)
    wanted[targets] = True
    wanted, force = wanted[order], np.zeros((count, 3))
    share(lambda a, b: _sum_leaves(sites, box, moments, *series, wanted, allowed, a, b, order, force), leaves, 4)
    return force[targets]


@compiled
def _halve(points: Array, order: Index, box: Array, boxes: int, first: int, last: int) -> None:
    """Write center and radius of some of the boxes of a level, and sort their particles into two halves each."""
    count, low, high = len(order), np.empty(3), np.empty(3)
    for k in range(first, last):
        start, end = count * k // boxes, count * (k + 1) // boxes
        for axis in range(3):
            low[axis], high[axis] = np.inf, -np.inf
            for n in range(start, end):
                low[axis] = min(low[axis], points[axis, order[n]])
                high[axis] = max(high[axis], points[axis, order[n]])
            box[boxes + k, axis] = 0.5 * (low[axis] + high[axis])
        box[boxes + k, 3] = 0.5 * np.sqrt(((high - low) ** 2).sum())
        if 2 * boxes < len(box):
            key = points[(high - low).argmax()][order[start:end]]
            half = order[start:end][np.argpartition(key, count * (2 * k + 1) // (2 * boxes) - start)]
            for n in range(start, end):
                order[n] = half[n - start]


@compiled
def _write_powers(away: Array, terms: Index, power: Array) -> None:
    """``z^a y^b x^c / (a! b! c!)`` for each term."""
    for t in range(len(terms)):
        power[t] = 1.0
        for axis in range(3):
            for n in range(terms[t, axis]):
                power[t] *= away[axis] / (n + 1)


@compiled
def _gather(
    sites: Array,
    box: Array,
    terms: Index,
    places: Index,
    products: Index,
    moments: Array,
    boxes: int,
    first: int,
    last: int,
) -> None:
    """Moments of some boxes of a level: of leaves from their particles, of others from those of their halves."""
    count, leaves, power = sites.shape[1], len(box) // 2, np.empty(len(terms))
    for node in range(boxes + first, boxes + last):
        if node >= leaves:
            for i in range(count * (node - leaves) // leaves, count * (node - leaves + 1) // leaves):
                _write_powers(box[node, :3] - sites[:, i], terms, power)
                for t in range(len(terms)):
                    moments[node, t] += power[t]
        else:
            for half in range(2 * node, 2 * node + 2):
                _write_powers(box[node] - box[half], terms, power)
                for n in range(len(products)):
                    moments[node, products[n, 2]] += moments[half, products[n, 0]] * power[products[n, 1]]


@compiled
def _write_derivatives(z: float, y: float, x: float, terms: Index, places: Index, d: Array) -> None:
    """Derivatives of 1 / r at (z, y, x) for each term, from those of the two orders below."""
    inverse = 1.0 / (z * z + y * y + x * x)
    d[0] = np.sqrt(inverse)
    for t in range(1, len(terms)):
        a, b, c = terms[t, 0], terms[t, 1], terms[t, 2]
        n, one, two = a + b + c, 0.0, 0.0
        if a > 0:
            one += a * z * d[places[a - 1, b, c]]
        if b > 0:
            one += b * y * d[places[a, b - 1, c]]
        if c > 0:
            one += c * x * d[places[a, b, c - 1]]
        if a > 1:
            two += a * (a - 1) * d[places[a - 2, b, c]]
        if b > 1:
            two += b * (b - 1) * d[places[a, b - 2, c]]
        if c > 1:
            two += c * (c - 1) * d[places[a, b, c - 2]]
        d[t] = -inverse * ((2 * n - 1) * one + (n - 1) * two) / n


@compiled
def _sum_leaves(
    sites: Array,
    box: Array,
    moments: Array,
    terms: Index,
    places: Index,
    products: Index,
    wanted: Mask,
    allowed: float,
    first: int,
    last: int,
    order: Index,
    force: Array,
) -> None:
    """Force on the particles of some leaves.

    For the box of each level that holds a leaf, `left` are the boxes that it leaves to its halves, and `local` are the
    derivatives of the potential of those that are far from it.
    """
    count, leaves, depth = sites.shape[1], len(box) // 2, 1
    while 1 << depth <= leaves:
        depth += 1
    stack, left, near = np.empty(4 * leaves, np.int64), np.empty((depth + 1, leaves), np.int64), np.empty((3, count))
    d, local, length, present = (
        np.empty(len(terms)),
        np.zeros((depth + 1, len(terms))),
        np.zeros(depth + 1, np.int64),
        0,
    )
    left[0, 0], length[0] = 1, 1
    for node in range(leaves + first, leaves + last):
        start, end = count * (node - leaves) // leaves, count * (node - leaves + 1) // leaves
        if not wanted[start:end].any():
            continue
        same = depth  # levels whose boxes hold the leaf before as well
        while same and node >> (depth - same) != present >> (depth - same):
            same -= 1
        present = node
        for level in range(same + 1, depth + 1):
            here = node >> (depth - level)
            for t in range(len(terms)):
                local[level, t] = 0.0
            if level > 1:
                _write_powers(box[here] - box[here // 2], terms, d)
                for n in range(len(products)):
                    local[level, products[n, 0]] += local[level - 1, products[n, 2]] * d[products[n, 1]]
            for n in range(length[level - 1]):
                stack[n] = left[level - 1, n]
            length[level] = _add_far(
                box,
                moments,
                terms,
                places,
                products,
                allowed,
                here,
                stack,
                length[level - 1],
                left[level],
                local[level],
            )
        listed = 0
        for n in range(length[depth]):
            other = left[depth, n] - leaves
            for i in range(count * other // leaves, count * (other + 1) // leaves):
                near[0, listed], near[1, listed], near[2, listed] = sites[0, i], sites[1, i], sites[2, i]
                listed += 1
        for i in range(start, end):
            if wanted[i]:
                to = order[i]
                force[to, 0], force[to, 1], force[to, 2] = _pairs_of(
                    near, listed, sites[0, i], sites[1, i], sites[2, i]
                )
                _write_powers(sites[:, i] - box[node, :3], terms, d)
                for s in range(len(terms)):
                    a, b, c = terms[s, 0], terms[s, 1], terms[s, 2]
                    for axis in range(3 if a + b + c < _ORDER else 0):
                        above = places[a + (axis == 0), b + (axis == 1), c + (axis == 2)]
                        force[to, axis] -= d[s] * local[depth, above] if above >= 0 else 0.0


@compiled
def _add_far(
    box: Array,
    moments: Array,
    terms: Index,
    places: Index,
    products: Index,
    allowed: float,
    node: int,
    stack: Index,
    top: int,
    left: Index,
    local: Array,
) -> int:
    """Add the effect of the boxes of a stack that are far from a node, and list those left; how many these are."""
    leaves, d, found = len(box) // 2, np.empty(len(terms)), 0
    while top > 0:
        top -= 1
        other = stack[top]
        z, y, x = box[node, 0] - box[other, 0], box[node, 1] - box[other, 1], box[node, 2] - box[other, 2]
        squared, reach = z * z + y * y + x * x, (box[node, 3] + box[other, 3]) ** 2
        far = squared > _SAME_SPOT and reach < _WIDEST * squared
        if far and moments[other, 0] ** 2 * reach**_ORDER <= allowed * squared ** (_ORDER + 2):
            _write_derivatives(z, y, x, terms, places, d)
            for n in range(len(products)):
                local[products[n, 0]] += moments[other, products[n, 1]] * d[products[n, 2]]
        elif other < leaves and (node >= leaves or box[other, 3] > box[node, 3]):
            stack[top], stack[top + 1] = 2 * other, 2 * other + 1
            top += 2
        else:
            left[found] = other
            found += 1
    return found
