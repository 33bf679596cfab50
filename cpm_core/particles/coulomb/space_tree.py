"""Eq. (9) in space by a tree: near boxes pair by pair, far ones by a series about the middle of each leaf.

As in the plane (`fast_multipole`), particles are halved into boxes of equal numbers. Each leaf looks at the boxes from
the top down: one that is far enough for the tolerance acts on all particles of the leaf by its moments, through a
Taylor series of the fourth order (`expansions` tells which); one that is not is opened, and what is left are near
leaves, summed pair by pair in double precision. The time grows with N log N.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.particles.coulomb.direct_sum import SAME_SPOT
from cpm_core.particles.coulomb.expansions import ORDER
from cpm_core.particles.coulomb.space import pairs_in_space, space_sums

_FULLEST = 64
"""Particles in a leaf."""

_SHARE = 1.4
"""Fraction of the tolerance that one far box may use, times the root of the order of the series from the tolerance."""

_WIDEST = 0.5
"""Square of the largest sum of two radii over the distance at which a series is used, at any tolerance."""

_SAMPLES, _KEPT = 32, 24
"""Particles of the sample that tells the usual force, and how many count: those with the smallest forces."""


def _powers() -> Index:
    """Powers (a, b, c) of the terms of a series, by their order."""
    side = range(ORDER + 1)
    every = [(a, b, c) for a in side for b in side for c in side if a + b + c <= ORDER]
    return np.array(sorted(every, key=lambda term: (sum(term), term)), np.int64)


_TERMS = _powers()
_PLACE = np.full((ORDER + 2,) * 3, -1, np.int64)
_PLACE[tuple(_TERMS.T)] = np.arange(len(_TERMS))
_PRODUCTS = np.array(
    [
        (t, s, _PLACE[tuple(one + two)])
        for t, one in enumerate(_TERMS)
        for s, two in enumerate(_TERMS)
        if (one + two).sum() <= ORDER
    ],
    np.int64,
)
"""Rows of what Taylor's theorem connects: a derivative in a leaf, a moment, and the derivative of 1 / r."""


class _SpaceTree(NamedTuple):
    """Particles sorted into boxes, numbered as those of `kd_tree`; a plain tuple for the compiled loops.

    Attributes
    ----------
    points : ndarray, shape (3, N)
        Coordinates of the particles in the order of the tree.
    box : ndarray, shape (2 leaves, 5)
        Center, radius and number of particles of each box; the first row is not used.
    moments : ndarray, shape (2 leaves, terms)
        Moments of each box about its center.
    """

    points: Array
    box: Array
    moments: Array


def space_tree_sums(points: Array, tolerance: float, targets: Index) -> Array:
    """Sums of eq. (9) for the particles `targets`, shape (M,), from all the others, shape (M, 3).

    The positions, shape (N, 3), are within some units from zero; `tolerance` is the relative error over all particles
    (l2).
    """
    order, tree = _build(points)
    leaves = len(tree.box) // 2
    usual = _usual_force(points)
    allowed = (_SHARE * tolerance * min(tolerance, 1e-3) ** (1.0 / ORDER) * usual) ** 2
    wanted = np.zeros(len(points), np.bool_)
    wanted[targets] = True
    some = wanted[order]
    sorted_force = np.zeros((len(points), 3))
    share(lambda first, last: _sum_leaves(tree, some, allowed, first, last, sorted_force), leaves, 4)
    force = np.empty_like(sorted_force)
    force[order] = sorted_force
    return force[targets]


def _usual_force(points: Array) -> float:
    """Usual size of the forces, from a sample; a few particles that nearly touch do not hide the others."""
    step = np.arange(_SAMPLES)
    chosen = ((step + 0.618034 * step % 1.0) * len(points) / _SAMPLES).astype(np.int64)
    size = np.sort((space_sums(points, chosen) ** 2).sum(axis=1), kind="stable")[:_KEPT]
    return float(np.sqrt(size.mean()))


def _build(points: Array) -> tuple[Index, _SpaceTree]:
    """Order of the particles in the tree, and the tree: each box is halved by number along its longest side."""
    count, depth = len(points), 0
    while count > _FULLEST << depth:
        depth += 1
    order = np.arange(count)
    box = np.zeros((2 << depth, 5))
    for level in range(depth + 1):
        boxes = 1 << level
        bounds = count * np.arange(boxes + 1) // boxes
        here = points[order]
        low, high = np.minimum.reduceat(here, bounds[:-1]), np.maximum.reduceat(here, bounds[:-1])
        box[boxes : 2 * boxes, :3] = 0.5 * (low + high)
        box[boxes : 2 * boxes, 3] = 0.5 * np.sqrt(((high - low) ** 2).sum(axis=1))
        box[boxes : 2 * boxes, 4] = np.diff(bounds)
        if level < depth:
            of = np.repeat(np.arange(boxes), np.diff(bounds))
            key = here[np.arange(count), (high - low).argmax(axis=1)[of]]
            order = order[np.lexsort((key, of))]
    sorted_points = np.ascontiguousarray(points[order].T)
    moments = np.zeros((len(box), len(_TERMS)))
    share(lambda first, last: _gather(sorted_points, box, _TERMS, 1 + first, 1 + last, moments), len(box) - 1, 64)
    return order, _SpaceTree(sorted_points, box, moments)


@compiled
def _gather(points: Array, box: Array, terms: Index, first: int, last: int, moments: Array) -> None:
    """Moments ``sum_j (c - r_j)^(a, b, c) / (a! b! c!)`` of some boxes, from their particles."""
    count, power = points.shape[1], np.ones((3, ORDER + 1))
    for node in range(first, last):
        level = 0
        while 2 << level <= node:
            level += 1
        k = node - (1 << level)
        for i in range((count * k) >> level, (count * (k + 1)) >> level):
            for axis in range(3):
                for n in range(1, ORDER + 1):
                    power[axis, n] = power[axis, n - 1] * (box[node, axis] - points[axis, i]) / n
            for t in range(len(terms)):
                moments[node, t] += power[0, terms[t, 0]] * power[1, terms[t, 1]] * power[2, terms[t, 2]]


@compiled
def _derivatives(z: float, y: float, x: float, d: Array) -> None:
    """Derivatives of 1 / r up to the fourth order at (z, y, x), from those of the two orders below."""
    inverse = 1.0 / (z * z + y * y + x * x)
    d[0] = np.sqrt(inverse)
    for t in range(1, len(_TERMS)):
        a, b, c = _TERMS[t, 0], _TERMS[t, 1], _TERMS[t, 2]
        n = a + b + c
        one, two = 0.0, 0.0
        if a > 0:
            one += a * z * d[_PLACE[a - 1, b, c]]
        if b > 0:
            one += b * y * d[_PLACE[a, b - 1, c]]
        if c > 0:
            one += c * x * d[_PLACE[a, b, c - 1]]
        if a > 1:
            two += a * (a - 1) * d[_PLACE[a - 2, b, c]]
        if b > 1:
            two += b * (b - 1) * d[_PLACE[a, b - 2, c]]
        if c > 1:
            two += c * (c - 1) * d[_PLACE[a, b, c - 2]]
        d[t] = -inverse * ((2 * n - 1) * one + (n - 1) * two) / n


@compiled
def _sum_leaves(tree: _SpaceTree, wanted: Mask, allowed: float, first: int, last: int, force: Array) -> None:
    """Force on the particles of some leaves."""
    points, box, moments = tree.points, tree.box, tree.moments
    count, leaves = points.shape[1], len(box) // 2
    stack, near = np.empty(64 + leaves, np.int64), np.empty(leaves, np.int64)
    d, local = np.empty(len(_TERMS)), np.empty(len(_TERMS))
    for leaf in range(first, last):
        start, end = count * leaf // leaves, count * (leaf + 1) // leaves
        if not wanted[start:end].any():
            continue
        node = leaves + leaf
        for t in range(len(local)):
            local[t] = 0.0
        found, top = 0, 1
        stack[0] = 1
        while top > 0:
            top -= 1
            other = stack[top]
            z, y, x = box[node, 0] - box[other, 0], box[node, 1] - box[other, 1], box[node, 2] - box[other, 2]
            squared, reach = z * z + y * y + x * x, (box[node, 3] + box[other, 3]) ** 2
            far = squared > SAME_SPOT and reach < _WIDEST * squared
            if far and box[other, 4] ** 2 * reach**ORDER <= allowed * squared ** (ORDER + 2):
                _derivatives(z, y, x, d)
                _add_far(moments[other], d, local)
            elif other < leaves:
                stack[top], stack[top + 1] = 2 * other, 2 * other + 1
                top += 2
            else:
                near[found] = other - leaves
                found += 1
        for i in range(start, end):
            if wanted[i]:
                _evaluate(points, box[node], local, i, force)
                for n in range(found):
                    begin, stop = count * near[n] // leaves, count * (near[n] + 1) // leaves
                    f_z, f_y, f_x = pairs_in_space(points, begin, stop, points[0, i], points[1, i], points[2, i])
                    force[i, 0] += f_z
                    force[i, 1] += f_y
                    force[i, 2] += f_x


@compiled
def _add_far(moments: Array, d: Array, local: Array) -> None:
    """Add the effect of a far box to the derivatives of the potential at the middle of a leaf."""
    for n in range(len(_PRODUCTS)):
        local[_PRODUCTS[n, 0]] += moments[_PRODUCTS[n, 1]] * d[_PRODUCTS[n, 2]]


@compiled
def _evaluate(points: Array, box: Array, local: Array, i: int, force: Array) -> None:
    """Force on a particle from the derivatives of the potential at the middle of its leaf."""
    power = np.ones((3, ORDER + 1))
    for axis in range(3):
        for n in range(1, ORDER + 1):
            power[axis, n] = power[axis, n - 1] * (points[axis, i] - box[axis]) / n
    for t in range(len(_TERMS)):
        a, b, c = _TERMS[t, 0], _TERMS[t, 1], _TERMS[t, 2]
        if a + b + c == ORDER:
            break
        weight = power[0, a] * power[1, b] * power[2, c]
        force[i, 0] -= weight * local[_PLACE[a + 1, b, c]]
        force[i, 1] -= weight * local[_PLACE[a, b + 1, c]]
        force[i, 2] -= weight * local[_PLACE[a, b, c + 1]]
