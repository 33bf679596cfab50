"""The Coulomb force of eq. (9) between particles anywhere: pair by pair, or fast by a tree.

The boxes of a k-d tree are drawn tightly around their particles, so that it resolves clusters of any density. On the
particles of a leaf, a box that is far away for its size acts by charges on a grid of nodes in it: their force is that
of its particles, interpolated by polynomials (Fong and Darve 2009, doi:10.1016/j.jcp.2009.08.031). Boxes that are near
act by their particles. All of these are summed in one loop, pair by pair. Each leaf is computed by one thread, in the
same order on any number of them.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from cpm_core.numerics.jit import compiled, reordered
from cpm_core.numerics.parallel import run_in_parallel
from cpm_core.numerics.real_numbers import as_real_array
from cpm_core.numerics.types import Array, Index
from cpm_core.parameters.formatting import quote_value

COULOMB_METHODS = ("auto", "exact", "tree")
"""Methods for the computation of the force."""

_MIN_TREE_PARTICLES = 2000
"""Particles from which on the tree is faster than the sum over all pairs."""

_COINCIDENT_SQUARED = 1e-36
"""Squared distance up to which two particles are at the same position. Such a pair, and a particle with itself, counts
as one unit apart except for its vanishing distance, so that its force vanishes; without a branch the loop runs on
vector registers. Positions are within some units here, where no two different ones are that near."""

_COULOMB_PAIRS_PER_THREAD = 100_000
"""Pairs from which a thread pays."""

_MAX_LEAF_PARTICLES = 64
"""Particles in a leaf, unless they are all at the same position."""

_MAX_OPENING_RATIO = 0.65
"""Largest ratio of the sum of the radii of two far boxes to the distance of their centers."""

_NODES = 4
"""Nodes along each axis of a box that carry its charge."""

_NODE_PHASES = np.pi * (np.arange(_NODES) + 0.5) / _NODES
"""Chebyshev nodes lie at their cosines, between the ends of an axis at -1 and 1."""

_NODE_POLYNOMIALS = np.cos(np.outer(np.arange(_NODES), _NODE_PHASES))
"""Chebyshev polynomials, by degree, at the nodes; the second one is the place of each."""


def coulomb_force(positions: ArrayLike, method: str = "auto") -> Array:
    """Compute the Coulomb force on every particle from all the others, eq. (9) with unit charges.

    Parameters
    ----------
    positions : array_like, shape (N, 2) or (N, 3)
        Positions of the particles [px].
    method : {"auto", "exact", "tree"}
        How the sum is computed. "exact": pair by pair. "tree": groups of particles that are far away together;
        the time grows with N log N. The relative error over all particles (l2) is below 1e-3, and about
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
        sum_all = partial(_sum_sources, sites, np.ones(count), count, sites, np.arange(count), force)
        run_in_parallel(sum_all, count, _COULOMB_PAIRS_PER_THREAD // count + 1)
    with np.errstate(over="ignore"):
        force = force / scale / scale
    if not np.isfinite(force).all():
        raise ValueError(
            f"positions lie within {scale:.2g} px, so close together that forces cannot be computed: give them in "
            "another unit."
        )
    return force


@reordered
def _sum_sources(
    sources: Array, charges: Array, length: int, sites: Array, order: Index, force: Array, first: int, last: int
) -> None:
    """Write eq. (9) for some of the particles at `sites`, shape (D, N), over the first `length` sources, shape (D, M).

    The force on particle k becomes row ``order[k]``. A particle may be among the sources.
    """
    axes = len(sites)
    for i in range(first, last):
        f_z, f_y, f_x = 0.0, 0.0, 0.0
        for j in range(length):
            d_y, d_x = sites[axes - 2, i] - sources[axes - 2, j], sites[axes - 1, i] - sources[axes - 1, j]
            d_z = sites[0, i] - sources[0, j] if axes == 3 else 0.0
            squared = d_z * d_z + d_y * d_y + d_x * d_x
            squared = squared if squared > _COINCIDENT_SQUARED else 1.0
            # A root in single precision and a correction are as exact as one in double precision, and take less time.
            root = np.float64(np.float32(1.0) / np.sqrt(np.float32(squared)))
            rest = 1.0 - squared * root * root
            root *= 1.0 + rest * (0.5 + 0.375 * rest)
            cube = charges[j] * root * root * root
            f_z += cube * d_z
            f_y += cube * d_y
            f_x += cube * d_x
        force[order[i], 0] = f_z
        force[order[i], axes - 2], force[order[i], axes - 1] = f_y, f_x


class _Boxes(NamedTuple):
    """Boxes of a tree, each behind the one that it is a half of.

    Attributes
    ----------
    span : ndarray of int64, shape (B, 2)
        First of the sorted particles in each, and the one behind the last.
    half : ndarray of int64, shape (B,)
        The first of its halves, which the other one follows; 0 for a leaf.
    spots : ndarray of int64, shape (B,)
        Positions in it, those of a leaf without extent counted once; a box with no more than nodes acts by its halves.
    middle, reach : ndarray, shape (B, D)
        Center, and half of each side.
    charge : ndarray, shape (B, nodes)
        Charge on the nodes.
    """

    span: Index
    half: Index
    spots: Index
    middle: Array
    reach: Array
    charge: Array


def _sum_by_tree(sites: Array, force: Array) -> None:
    """Approximate the sums over all pairs, for particles at `sites`, shape (D, N)."""
    tree = scipy.spatial.cKDTree(sites.T, _MAX_LEAF_PARTICLES, balanced_tree=False)
    order = tree.indices.astype(np.int64)
    sites = np.ascontiguousarray(sites[:, order])
    boxes = _collect_boxes(tree, sites)
    _spread_charges(sites, boxes)
    leaves = np.flatnonzero(boxes.half == 0)
    run_in_parallel(partial(_sum_leaves, sites, order, boxes, leaves, force), len(leaves), 1)


def _collect_boxes(tree: scipy.spatial.cKDTree, sites: Array) -> _Boxes:
    """Collect the boxes of a tree, each drawn tightly around its particles at the sorted `sites`, without charges."""
    nodes: list[Any] = [tree.tree]
    half: list[int] = []
    for node in nodes:  # which grows meanwhile
        is_leaf = node.split_dim < 0
        half.append(0 if is_leaf else len(nodes))
        nodes += [] if is_leaf else [node.lesser, node.greater]
    span = np.array([(node.start_idx, node.end_idx) for node in nodes])
    low, high = (
        np.array([find_end(sites[:, start:end], axis=1) for start, end in span.tolist()])
        for find_end in (np.min, np.max)
    )
    charge = np.zeros((len(nodes), _NODES ** len(sites)))
    spots = np.zeros(len(nodes), np.int64)
    return _Boxes(span, np.array(half), spots, 0.5 * (low + high), 0.5 * (high - low), charge)


@compiled
def _append_nodes(boxes: _Boxes, k: int, sources: Array, charges: Array, length: int) -> int:
    """Append the nodes of a box to a list of sources; return the length of the list."""
    for m in range(boxes.charge.shape[1]):
        node, charges[length] = m, boxes.charge[k, m]
        for axis in range(len(sources)):
            sources[axis, length] = boxes.middle[k, axis] + boxes.reach[k, axis] * _NODE_POLYNOMIALS[1, node % _NODES]
            node //= _NODES
        length += 1
    return length


@compiled
def _append_particles(sites: Array, boxes: _Boxes, k: int, sources: Array, charges: Array, length: int) -> int:
    """Append the particles in a box to a list of sources, as one where they are at one position; return the length."""
    start, end = boxes.span[k]
    together = boxes.spots[k] == 1
    for n in range(start, start + 1 if together else end):
        charges[length] = end - start if together else 1.0
        for axis in range(len(sources)):
            sources[axis, length] = sites[axis, n]
        length += 1
    return length


@compiled
def _spread_charges(sites: Array, boxes: _Boxes) -> None:
    """Spread the particles of each leaf, and what both halves of other boxes act by, over the nodes of the box."""
    axes, nodes = len(sites), boxes.charge.shape[1]
    sources, charges = np.empty((axes, sites.shape[1])), np.empty(sites.shape[1])
    weights = np.empty((axes, _NODES))
    for k in range(len(boxes.half) - 1, -1, -1):
        half, length = boxes.half[k], 0
        boxes.spots[k] = 1 if boxes.reach[k].max() == 0.0 else boxes.span[k, 1] - boxes.span[k, 0]
        if half:
            boxes.spots[k] = boxes.spots[half] + boxes.spots[half + 1]
        if boxes.spots[k] <= nodes:
            continue
        for box in range(half, half + 2) if half else range(k, k + 1):
            if half and boxes.spots[box] > nodes:
                length = _append_nodes(boxes, box, sources, charges, length)
            else:
                length = _append_particles(sites, boxes, box, sources, charges, length)
        for n in range(length):
            for axis in range(axes):
                place = (sources[axis, n] - boxes.middle[k, axis]) / max(boxes.reach[k, axis], 1e-300)
                for m in range(_NODES):
                    here, before, weights[axis, m] = place, 1.0, 1.0 / _NODES
                    for degree in range(1, _NODES):
                        weights[axis, m] += 2.0 / _NODES * here * _NODE_POLYNOMIALS[degree, m]
                        here, before = 2.0 * place * here - before, here
            for m in range(nodes):
                node, share = m, charges[n]
                for axis in range(axes):
                    share *= weights[axis, node % _NODES]
                    node //= _NODES
                boxes.charge[k, m] += share


@compiled
def _sum_leaves(sites: Array, order: Index, boxes: _Boxes, leaves: Index, force: Array, first: int, last: int) -> None:
    """Write the force on the particles in some leaves: of the nodes of far boxes, and of the particles in others."""
    axes, stack = len(sites), np.empty(len(boxes.half), np.int64)
    sources, charges = np.empty((axes, sites.shape[1])), np.empty(sites.shape[1])
    for leaf in leaves[first:last]:
        length, top, stack[0] = 0, 1, 0
        while top > 0:
            top -= 1
            k, apart, one, other = stack[top], 0.0, 0.0, 0.0
            for axis in range(axes):
                apart += (boxes.middle[k, axis] - boxes.middle[leaf, axis]) ** 2
                one, other = one + boxes.reach[k, axis] ** 2, other + boxes.reach[leaf, axis] ** 2
            far = np.sqrt(one) + np.sqrt(other) < _MAX_OPENING_RATIO * np.sqrt(apart)
            if far and boxes.spots[k] > boxes.charge.shape[1]:
                length = _append_nodes(boxes, k, sources, charges, length)
            elif boxes.half[k] == 0:
                length = _append_particles(sites, boxes, k, sources, charges, length)
            else:
                stack[top], stack[top + 1] = boxes.half[k], boxes.half[k] + 1
                top += 2
        _sum_sources(sources, charges, length, sites, order, force, boxes.span[leaf, 0], boxes.span[leaf, 1])
