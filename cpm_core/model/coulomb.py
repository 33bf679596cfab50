"""The Coulomb force of eq. (9) between particles anywhere: pair by pair, or fast by a tree (the fast multipole method).

The tree halves boxes at the middle of their longest side, each drawn tightly around its particles, so that it resolves
clusters of any density. Boxes that are far from each other, for their size, act by Taylor series: the moments of the
one, times the derivatives of the inverse distance between the centers, are the potential in the other as a power
series, which its halves take over. The remaining pairs of near leaves are summed particle by particle in single
precision from exact differences. Each box is computed by one thread, in the same order on any number of them.
"""

from __future__ import annotations

from functools import lru_cache, partial
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.numerics.jit import compiled, reordered
from cpm_core.numerics.parallel import run_in_parallel
from cpm_core.numerics.real_numbers import as_real_array
from cpm_core.numerics.types import Array, Index, Single
from cpm_core.parameters.formatting import quote_value

COULOMB_METHODS = ("auto", "exact", "tree")
"""Methods for the computation of the force."""

_MIN_TREE_PARTICLES = 1500
"""Particles from which on the tree is faster than the sum over all pairs."""

_COINCIDENT_SQUARED = 1e-36
"""Squared distance up to which two particles are at the same position. Such a pair, and a particle with itself, counts
as one unit apart except for its vanishing distance, so that its force vanishes; without a branch the loop runs on
vector registers. Positions are within some units here, where no two different ones are that near."""

_COULOMB_PAIRS_PER_THREAD = 100_000
"""Pairs from which a thread pays."""

_MAX_LEAF_PARTICLES = 48
"""Particles in a leaf, unless they are all at the same position."""

_MAX_OPENING_RATIO = 0.55
"""Largest ratio of the sum of the radii of two far boxes to the distance of their centers."""

_SERIES_DEGREE = 6
"""Degree of the Taylor series of the potential between two boxes, counted in the coordinates of both."""

_MIN_SUBTREES = 40
"""Least number of parts of the tree that threads take over."""

_TABLE_COLUMNS = 64
"""Columns of a table of vectors."""

_COLUMN_MULTIPLE = 16
"""Multiple to which the columns of a table are filled up, so that loops use vector registers to the end."""

_NEAR_LIST_MULTIPLE = 32
"""Multiple to which lists of near particles are filled up, for the same reason."""

_FILLER_COORDINATE = 1e16
"""Coordinate that fills up a list; its force is next to nothing."""


def coulomb_force(positions: ArrayLike, method: str = "auto") -> Array:
    """Compute the Coulomb force on every particle from all the others, eq. (9) with unit charges.

    Parameters
    ----------
    positions : array_like, shape (N, 2) or (N, 3)
        Positions of the particles [px].
    method : {"auto", "exact", "tree"}
        How the sum is computed. "exact": pair by pair. "tree": groups of particles that are far from one another by
        their moments; the time grows with N. The relative error over all particles (l2) is below 1e-3, and about
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
    points = as_real_array(positions)
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise ValueError(f"positions have the shape {points.shape} but must be (N, 2) or (N, 3).")
    if not isinstance(method, str) or method not in COULOMB_METHODS:
        raise ValueError(f"method is {quote_value(method)} but must be one of {', '.join(COULOMB_METHODS)}.")
    count, axes = points.shape
    if not count:
        return np.zeros((0, axes))
    sites = np.array(points.T, order="C")
    with np.errstate(over="ignore", invalid="ignore"):
        sides = np.ptp(sites, axis=1)
    if not np.isfinite(sides.sum()):
        raise ValueError("positions must be finite numbers; there are others among them, or they lie too far apart.")
    # the extent of the particles is about one in this unit, exactly
    scale = float(2.0 ** np.floor(np.log2(sides.max()))) if sides.max() > 0.0 else 1.0
    sites /= scale
    force = np.empty((count, axes))
    if method == "tree" or (method == "auto" and count > _MIN_TREE_PARTICLES):
        _sum_by_tree(sites, force)
    else:
        run_in_parallel(partial(_sum_pairs, sites, force), count, _COULOMB_PAIRS_PER_THREAD // count + 1)
    with np.errstate(over="ignore"):
        force = force / scale / scale
    if not np.isfinite(force).all():
        raise ValueError(
            f"positions lie within {scale:.2g} px, so close together that forces cannot be computed: give them in "
            "another unit."
        )
    return force


@reordered
def _sum_pairs(sites: Array, force: Array, first: int, last: int) -> None:
    """Sum eq. (9) for some of the particles at `sites`, shape (D, N), over all others, which may include themselves."""
    axes = len(sites)
    for i in range(first, last):
        f_z, f_y, f_x = 0.0, 0.0, 0.0
        for j in range(sites.shape[1]):
            d_y, d_x = sites[axes - 2, i] - sites[axes - 2, j], sites[axes - 1, i] - sites[axes - 1, j]
            d_z = sites[0, i] - sites[0, j] if axes == 3 else 0.0
            squared = d_z * d_z + d_y * d_y + d_x * d_x
            squared = squared if squared > _COINCIDENT_SQUARED else 1.0
            # A root in single precision and a correction are as exact as one in double precision, and take less time.
            root = np.float64(np.float32(1.0) / np.sqrt(np.float32(squared)))
            rest = 1.0 - squared * root * root
            root *= 1.0 + rest * (0.5 + 0.375 * rest)
            cube = root * root * root
            f_z += cube * d_z
            f_y += cube * d_y
            f_x += cube * d_x
        force[i, 0] = f_z
        force[i, axes - 2], force[i, axes - 1] = f_y, f_x


@reordered
def _near_force(near: Array, copies: Single, count: int, z: float, y: float, x: float) -> tuple[float, float, float]:
    """Sum eq. (9) for a particle at (z, y, x) over the copies of those of a list, in single precision."""
    one, nothing, axes = np.float32(1.0), np.float32(0.0), len(near)
    f_z, f_y, f_x, space = nothing, nothing, nothing, axes == 3
    for j in range(count):
        d_y, d_x = np.float32(y - near[axes - 2, j]), np.float32(x - near[axes - 1, j])
        squared = d_y * d_y + d_x * d_x
        if space:
            d_z = np.float32(z - near[0, j])
            squared += d_z * d_z
            squared = squared if squared > np.float32(_COINCIDENT_SQUARED) else one
            root = one / np.sqrt(squared)
            f_z += _force_component(d_z, root, copies[j] * (root * root))
        else:
            squared = squared if squared > np.float32(_COINCIDENT_SQUARED) else one
            root = one / np.sqrt(squared)
        f_y += _force_component(d_y, root, copies[j] * (root * root))
        f_x += _force_component(d_x, root, copies[j] * (root * root))
    return float(f_z), float(f_y), float(f_x)


@compiled
def _force_component(way: np.float32, root: np.float32, strength: np.float32) -> np.float32:
    """Return a component of the inverse square, by factors that stay finite: the cube of the root may not."""
    pushed: np.float32 = way * root * strength
    return pushed


class _SeriesTerms(NamedTuple):
    """Terms of a Taylor series, sorted by degree: one for each choice of powers of the coordinates.

    Attributes
    ----------
    degree : ndarray of int64, shape (T,)
    powers, lower : ndarray of int64, shape (T, D)
        Power of each coordinate, and the term that has one less of it.
    one, other, whole : ndarray of int64, shape (P,)
        Two terms, the other one not constant, and their product, where that is a term as well. Those come first whose
        other term is a coordinate: the last one is term 1.
    """

    degree: Index
    powers: Index
    lower: Index
    one: Index
    other: Index
    whole: Index


@lru_cache(maxsize=2)
def _series_terms(axes: int) -> _SeriesTerms:
    """Return the terms up to the degree of all series, of two or three coordinates."""
    powers = sorted((p for p in product(range(_SERIES_DEGREE + 1), repeat=axes) if sum(p) <= _SERIES_DEGREE), key=sum)
    at = {p: t for t, p in enumerate(powers)}
    lower = [[at.get((*p[:axis], p[axis] - 1, *p[axis + 1 :]), 0) for axis in range(axes)] for p in powers]
    every = ((at[p], at[q], at.get(tuple(np.add(p, q)))) for q in powers[1:] for p in powers)
    products = zip(*((one, other, whole) for one, other, whole in every if whole is not None), strict=True)
    return _SeriesTerms(*map(np.array, ([sum(p) for p in powers], powers, lower, *products)))


class _Tree(NamedTuple):
    """Boxes, each level after the one above.

    Attributes
    ----------
    span : ndarray of int64, shape (B, 2)
        First of the sorted particles in each, and the one behind the last.
    half : ndarray of int64, shape (B,)
        The first of its halves, which the other one follows; 0 for a leaf.
    place : ndarray, shape (B, 4)
        Center and radius; the center in the plane is followed by a zero.
    spots : ndarray of int64, shape (B,)
        Positions in it that differ; negative in a box of no more than fit into a leaf, within which nothing acts by
        series: where particles share few positions, no near pair would outweigh the error.
    moments, series : ndarray, shape (B, T)
        Sum of the terms of the vectors from its particles to its center, and derivatives there of the potential of all
        that is far from it or from a box that contains it.
    """

    span: Index
    half: Index
    place: Array
    spots: Index
    moments: Array
    series: Array


def _sum_by_tree(sites: Array, force: Array) -> None:
    """Approximate the sums of `_sum_pairs` for all particles; sorts `sites`."""
    count, terms = len(force), _series_terms(len(sites))
    order, copies = np.arange(count), np.zeros(count, np.float32)
    levels, begin, span = [], [0], np.array([(0, count)])
    while len(span):
        place, (middle, spots) = np.zeros((len(span), 4)), np.zeros((2, len(span)), np.int64)
        halve = partial(_halve_boxes, sites, order, copies, span, place, middle, spots)
        run_in_parallel(halve, len(span), _COULOMB_PAIRS_PER_THREAD * len(span) // count + 1)
        begin.append(begin[-1] + len(span))
        halved = middle > 0
        levels.append((span, np.where(halved, begin[-1] + 2 * np.cumsum(halved) - 2, 0), place, spots))
        middle = middle[halved]
        span = np.stack([span[halved, 0], middle, middle, span[halved, 1]], axis=1).reshape(-1, 2)
    tree = _Tree(*map(np.concatenate, zip(*levels, strict=True)), *np.zeros((2, begin[-1], len(terms.degree))))
    for first, last in reversed([*pairwise(begin)]):
        run_in_parallel(partial(_add_moments, sites, tree, terms, first), last - first, 200)
    large = (tree.half > 0) & (_MIN_SUBTREES * (tree.span[:, 1] - tree.span[:, 0]) > count)
    below = np.add.outer(tree.half[large], (0, 1)).ravel()
    roots = below[~large[below]] if len(below) else np.zeros(1, np.int64)
    run_in_parallel(partial(_sum_subtrees, sites, order, copies, tree, terms, roots, force), len(roots), 1)


@compiled
def _halve_boxes(
    sites: Array,
    order: Index,
    copies: Single,
    span: Index,
    place: Array,
    middle: Index,
    spots: Index,
    first: int,
    last: int,
) -> None:
    """Place some boxes, sort the particles of each into its halves, and write where the second half begins.

    In a leaf those come first whose positions differ, each with the number of particles there.
    """
    axes = len(sites)
    for k in range(first, last):
        start, end = span[k]
        squared, widest, longest, cut = 0.0, -1.0, 0, 0.0
        for axis in range(axes):
            low, high = np.inf, -np.inf
            for n in range(start, end):
                here = sites[axis, n]
                low = here if here < low else low
                high = here if here > high else high
            place[k, axis] = 0.5 * (low + high)
            squared += 0.25 * (high - low) ** 2
            if high - low > widest:
                widest, longest, cut = high - low, axis, place[k, axis] if place[k, axis] < high else low
        place[k, 3] = np.sqrt(squared)
        if end - start > _MAX_LEAF_PARTICLES and squared > _COINCIDENT_SQUARED:
            behind = start  # swap in any case: a branch would be mispredicted half of the time
            for n in range(start, end):
                before = sites[longest, n] <= cut
                for axis in range(axes):
                    sites[axis, behind], sites[axis, n] = sites[axis, n], sites[axis, behind]
                order[behind], order[n] = order[n], order[behind]
                behind += before
            middle[k] = behind
        else:
            spots[k] = _sort_distinct_first(sites, order, copies, start, end) if squared > _COINCIDENT_SQUARED else 1
            copies[start] += (end - start) * (squared <= _COINCIDENT_SQUARED)


@compiled
def _sort_distinct_first(sites: Array, order: Index, copies: Single, start: int, end: int) -> int:
    """Sort some particles so that those come first whose positions differ, count the copies, return how many differ."""
    axes, behind = len(sites), start
    for n in range(start, end):
        y, x, same = sites[axes - 2, n], sites[axes - 1, n], start
        while same < behind and not (
            sites[axes - 1, same] == x and sites[axes - 2, same] == y and sites[0, same] == sites[0, n]
        ):
            same += 1
        copies[same] += np.float32(1.0)
        if same == behind:
            for axis in range(axes):
                sites[axis, behind], sites[axis, n] = sites[axis, n], sites[axis, behind]
            order[behind], order[n] = order[n], order[behind]
            behind += 1
    return behind - start


@compiled
def _padded_columns(count: int) -> int:
    """Return the number of columns of a table for `count` vectors."""
    return int(min(_TABLE_COLUMNS, (count + _COLUMN_MULTIPLE - 1) // _COLUMN_MULTIPLE * _COLUMN_MULTIPLE))


@reordered
def _fill_terms(vectors: Array, count: int, lanes: int, terms: _SeriesTerms, table: Array) -> None:
    """Write the terms of `count` vectors, divided by the factorials of their powers; zeros for others up to `lanes`."""
    for n in range(lanes):
        table[0, n] = 1.0 if n < count else 0.0
    for t in range(1, len(terms.degree)):
        axis = 0
        while terms.powers[t, axis] == 0:
            axis += 1
        factor, lower = 1.0 / terms.powers[t, axis], terms.lower[t, axis]
        for n in range(lanes):
            table[t, n] = factor * vectors[axis, n] * table[lower, n]


@reordered
def _fill_derivatives(vectors: Array, lanes: int, terms: _SeriesTerms, table: Array) -> None:
    """Write the derivatives of the inverse distance by recursion over the degree; `vectors` are overwritten."""
    axes = len(vectors) - 1
    for n in range(lanes):
        squared = 0.0
        for axis in range(axes):
            squared += vectors[axis, n] * vectors[axis, n]
        vectors[axes, n] = 1.0 / squared
        table[0, n] = np.sqrt(vectors[axes, n])
    for axis in range(axes):
        for n in range(lanes):
            vectors[axis, n] *= vectors[axes, n]
    for t in range(1, len(terms.degree)):
        for n in range(lanes):
            table[t, n] = 0.0
        degree = terms.degree[t]
        for axis in range(axes):
            power, lower = terms.powers[t, axis], terms.lower[t, axis]
            if power > 0:
                factor = -power * (2.0 * degree - 1.0) / degree
                for n in range(lanes):
                    table[t, n] += factor * vectors[axis, n] * table[lower, n]
            if power > 1:
                factor, lower = -power * (power - 1.0) * (degree - 1.0) / degree, terms.lower[lower, axis]
                for n in range(lanes):
                    table[t, n] += factor * vectors[axes, n] * table[lower, n]


@reordered
def _add_moments(sites: Array, tree: _Tree, terms: _SeriesTerms, level: int, first: int, last: int) -> None:
    """Moments of some boxes of the level that begins there: of the particles in a leaf, or from those of its halves."""
    axes, size = len(sites), len(terms.degree)
    vectors, table = np.zeros((axes, _TABLE_COLUMNS)), np.empty((size, _TABLE_COLUMNS))
    for k in range(level + first, level + last):
        half, (start, end) = tree.half[k], tree.span[k]
        if half:
            for n in range(2):
                for axis in range(axes):
                    vectors[axis, n] = tree.place[k, axis] - tree.place[half + n, axis]
            _fill_terms(vectors, 2, 2, terms, table)
            for n in range(2):
                tree.moments[k, 0] += tree.moments[half + n, 0]
                for t in range(1, size):
                    tree.moments[k, t] += tree.moments[half + n, t]
                for p in range(len(terms.whole)):
                    tree.moments[k, terms.whole[p]] += tree.moments[half + n, terms.one[p]] * table[terms.other[p], n]
            tree.spots[k] = tree.spots[half] + tree.spots[half + 1]
            if tree.spots[k] <= _MAX_LEAF_PARTICLES:
                tree.spots[half], tree.spots[half + 1] = -tree.spots[half], -tree.spots[half + 1]
            continue
        for begin in range(start, end, _TABLE_COLUMNS):
            lanes = _padded_columns(end - begin)
            for axis in range(axes):
                for n in range(lanes):
                    vectors[axis, n] = tree.place[k, axis] - sites[axis, min(begin + n, end - 1)]
            _fill_terms(vectors, end - begin, lanes, terms, table)
            for t in range(size):
                total = 0.0
                for n in range(lanes):
                    total += table[t, n]
                tree.moments[k, t] += total


class _Workspace(NamedTuple):
    """Buffers for the work on one box.

    Attributes
    ----------
    rest, far : ndarray of int64, shape (B,)
        Boxes to be looked at, and those found to be far.
    near : ndarray, shape (D, N + some)
    copies : ndarray of float32, shape (N + some,)
        Positions in near leaves, and the number of particles at each.
    vectors : ndarray, shape (D + 1, lanes)
    table, moments : ndarray, shape (T, lanes)
    """

    rest: Index
    far: Index
    near: Array
    copies: Single
    vectors: Array
    table: Array
    moments: Array


@compiled
def _sum_subtrees(
    sites: Array,
    order: Index,
    copies: Single,
    tree: _Tree,
    terms: _SeriesTerms,
    roots: Index,
    force: Array,
    first: int,
    last: int,
) -> None:
    """Write the force on the particles in some boxes, in the order of all.

    Each box gets a list of the boxes that are not far from its parent, and passes to its halves those that are not far
    from it either.
    """
    axes, boxes, size = len(sites), len(tree.half), len(terms.degree)
    stack, lists = np.empty((boxes, 3), np.int64), np.zeros(1024, np.int64)
    desk = _Workspace(
        np.empty(boxes, np.int64),
        np.empty(boxes, np.int64),
        np.empty((axes, len(order) + _NEAR_LIST_MULTIPLE)),
        np.empty(len(order) + _NEAR_LIST_MULTIPLE, np.float32),
        np.empty((axes + 1, _TABLE_COLUMNS)),
        np.empty((size, _TABLE_COLUMNS)),
        np.empty((size, _TABLE_COLUMNS)),
    )
    for root in roots[first:last]:
        stack[0, 0], stack[0, 1], stack[0, 2], top = root, 0, 1, 1
        while top > 0:
            top -= 1
            k, begin, end = stack[top]
            lists, kept, distant, listed = _classify_boxes(sites, copies, tree, desk, k, lists, begin, end)
            for block in range(0, distant, _TABLE_COLUMNS):
                _add_far_boxes(tree, terms, desk, k, desk.far[block : min(block + _TABLE_COLUMNS, distant)])
            if tree.half[k]:
                _pass_series_to_halves(tree, terms, desk, k)
                for n in range(2):
                    stack[top, 0], stack[top, 1], stack[top, 2] = tree.half[k] + n, end, kept
                    top += 1
            else:
                _sum_leaf(sites, order, tree, terms, desk, k, listed, force)


@compiled
def _classify_boxes(
    sites: Array, copies: Single, tree: _Tree, desk: _Workspace, k: int, lists: Index, begin: int, end: int
) -> tuple[Index, int, int, int]:
    """Sort the boxes of a list into those far from a box, those left to its halves, and those near a leaf.

    Return the lists, extended by the boxes left to the halves, where those end, and the numbers of far boxes and of
    near particles.
    """
    half, spots, axes = tree.half[k], tree.spots[k], len(sites)
    z, y, x, radius = tree.place[k, 0], tree.place[k, 1], tree.place[k, 2], tree.place[k, 3]
    left, kept, distant, listed = end - begin, end, 0, 0
    for n in range(left):
        desk.rest[n] = lists[begin + n]
    while left > 0:
        left -= 1
        other = desk.rest[left]
        there, larger = tree.half[other], tree.place[other, 3] > radius
        squared = (tree.place[other, 0] - z) ** 2 + (tree.place[other, 1] - y) ** 2 + (tree.place[other, 2] - x) ** 2
        radii = (tree.place[other, 3] + radius) ** 2
        if radii < _MAX_OPENING_RATIO**2 * squared and spots > 0 and tree.spots[other] > 0:
            desk.far[distant] = other
            distant += 1
        elif there and (
            not half or (tree.spots[other] > _MAX_LEAF_PARTICLES and (larger or spots <= _MAX_LEAF_PARTICLES))
        ):
            desk.rest[left], desk.rest[left + 1] = there, there + 1
            left += 2
        elif half:
            if kept == len(lists):
                lists = np.append(lists, lists)
            lists[kept] = other
            kept += 1
        else:
            start, many = tree.span[other, 0], abs(tree.spots[other])
            for n in range(many):
                desk.copies[listed + n] = copies[start + n]
            for axis in range(axes):
                for n in range(many):
                    desk.near[axis, listed + n] = sites[axis, start + n]
            listed += many
    if not half:
        for axis in range(axes):
            for n in range(listed, listed + _NEAR_LIST_MULTIPLE):
                desk.near[axis, n] = _FILLER_COORDINATE
                desk.copies[n] = 0.0
    return lists, kept, distant, listed


@compiled
def _pass_series_to_halves(tree: _Tree, terms: _SeriesTerms, desk: _Workspace, k: int) -> None:
    """Begin the series of the halves of a box with its own."""
    half = tree.half[k]
    for n in range(2):
        for axis in range(len(desk.vectors) - 1):
            desk.vectors[axis, n] = tree.place[half + n, axis] - tree.place[k, axis]
    _fill_terms(desk.vectors, 2, 2, terms, desk.table)
    for n in range(2):
        for p in range(len(terms.whole)):
            part = tree.series[k, terms.whole[p]] * desk.table[terms.one[p], n]
            tree.series[half + n, terms.other[p]] += part


@reordered
def _add_far_boxes(tree: _Tree, terms: _SeriesTerms, desk: _Workspace, k: int, far: Index) -> None:
    """Add the potential of far boxes to the series of a box."""
    count, lanes = len(far), _padded_columns(len(far))
    for n in range(lanes):
        other = far[min(n, count - 1)]
        for axis in range(len(desk.vectors) - 1):
            desk.vectors[axis, n] = tree.place[k, axis] - tree.place[other, axis]
        for t in range(len(terms.degree)):
            if terms.degree[t] == _SERIES_DEGREE:
                break  # it would add to the potential itself only, of which there is no use
            desk.moments[t, n] = tree.moments[other, t] if n < count else 0.0
    _fill_derivatives(desk.vectors, lanes, terms, desk.table)
    for p in range(len(terms.whole)):
        one, whole, total = terms.one[p], terms.whole[p], 0.0
        for n in range(lanes):
            total += desk.moments[one, n] * desk.table[whole, n]
        tree.series[k, terms.other[p]] += total


@compiled
def _sum_leaf(
    sites: Array, order: Index, tree: _Tree, terms: _SeriesTerms, desk: _Workspace, k: int, listed: int, force: Array
) -> None:
    """Write the force on the particles in a leaf: of those listed as near, and the slope of the series."""
    axes, (start, end) = len(sites), tree.span[k]
    for begin in range(start, end, _TABLE_COLUMNS):
        lanes = _padded_columns(end - begin)
        for axis in range(axes):
            for n in range(lanes):
                desk.vectors[axis, n] = sites[axis, min(begin + n, end - 1)] - tree.place[k, axis]
        _fill_terms(desk.vectors, lanes, lanes, terms, desk.table)
        for axis in range(axes):
            for n in range(lanes):
                desk.vectors[axis, n] = 0.0
        for p in range(len(terms.whole)):
            if terms.other[p] > axes:
                break
            axis, one, slope = axes - terms.other[p], terms.one[p], tree.series[k, terms.whole[p]]
            for n in range(lanes):
                desk.vectors[axis, n] -= slope * desk.table[one, n]
        for n in range(min(_TABLE_COLUMNS, end - begin)):
            i = begin + n
            pushes = _near_force(
                desk.near,
                desk.copies,
                (listed + _NEAR_LIST_MULTIPLE - 1) // _NEAR_LIST_MULTIPLE * _NEAR_LIST_MULTIPLE,
                sites[0, i],
                sites[axes - 2, i],
                sites[axes - 1, i],
            )
            for axis in range(axes):
                force[order[i], axis] = pushes[3 - axes + axis] + desk.vectors[axis, n]
