"""Eq. (9) by a fast multipole method.

The particles are sorted into a tree. From its top down, each box examines the boxes that its parent has left undecided:
one that is far enough acts on it by the series of `expansions`, one that is not is opened, and those that a leaf is
left with are near and summed pair by pair. Every box thus meets a number of others that does not depend on N.

What is far enough follows from the tolerance. For a box of M particles at a distance d, a series of order p leaves out
less than about M theta^p / d^2, theta being the sum of the two radii over d. This is compared with the usual force
between these particles, from a sample (`usual_force`). So the error stays small against the forces also where most of
the forces on a particle cancel; and where all of them do, everything is near, and the sum is exact.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import reordered
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.particles.coulomb.direct_sum import SAME_SPOT, pairs_of, usual_force
from cpm_core.particles.coulomb.expansions import INVERSE, ORDER, ROWS, SIDE, Boxes, add_far, gather_moments, hand_down
from cpm_core.particles.coulomb.kd_tree import TOP, Tree, build_tree, flag_boxes

_FULLEST = 32
"""Particles in a leaf: with 16 the series take more time, with 64 the pairs do."""

_SHARE = 1.4
"""Fraction of the tolerance that one far box may use, times the root of the order of the series from the tolerance: the
smaller that is, the more boxes share it. At a tolerance of 1e-3 all of them together use 0.2 of it on curves, 0.3 on a
grid, less in clouds, and 0.8 at most, on equally spaced rings, where errors add up alike for all particles."""

_WIDEST = 0.7
"""Square of the largest theta at which a series is used, at any tolerance."""

_BRANCH = 6
"""Levels of the subtrees that are processed one after the other, so that lists stay short."""

_LEAST_RADIUS = 1e-15
"""Radius of the smallest leaf whose own unit of length is used: in a smaller one, single precision could not represent
the squared distance of the farthest particle."""


def tree_force(y: Array, x: Array, tolerance: float, wanted: Index | None) -> Array:
    """Sums of eq. (9) for the particles `wanted`, shape (M,), or for all of them, from all the others, shape (M, 2).

    The coordinates y and x, shape (N,), are on the unit square; `tolerance` is the relative error over all particles
    (l2).
    """
    tree = build_tree(y, x, _FULLEST)
    moments = _all_moments(tree)
    usual, single = usual_force(tree.y, tree.x, tolerance)
    allowed = (_SHARE * tolerance * min(tolerance, 1e-3) ** (1.0 / ORDER) * usual) ** 2
    flags = flag_boxes(tree, wanted)
    force = np.empty((len(y), 2))
    branches = 1 << max(tree.depth - _BRANCH, min(tree.depth, TOP))
    longest = ((2 << _BRANCH) + tree.depth) << tree.depth

    def work(first: int, last: int) -> None:
        lists = np.empty((2, longest), np.int32)
        for root in range(branches + first, branches + last):
            if flags[root]:
                _work_on_branch(tree, root, moments, allowed, single, flags, lists, force)

    share(work, branches, 1)
    return force if wanted is None else force[wanted]


def _all_moments(tree: Tree) -> Array:
    leaves = 1 << tree.depth
    moments = np.empty((2 * leaves, ROWS))
    top = min(tree.depth, TOP)
    rows = (tree.y, tree.x, tree.box, moments)
    first_box = 1 << top
    share(
        lambda a, b: gather_moments(*rows, first_box + a, first_box + b, tree.depth - top, leaves, SIDE), first_box, 1
    )
    if top:
        gather_moments(*rows, 1, 2, top - 1, leaves, SIDE)
    return moments


def _work_on_branch(
    tree: Tree,
    root: int,
    moments: Array,
    allowed: float,
    single: bool,
    flags: Mask,
    lists: NDArray[np.int32],
    force: Array,
) -> None:
    """Force on the particles of the leaves under a box."""
    leaves = 1 << tree.depth
    level = root.bit_length() - 1
    path = np.array([root >> k for k in range(level, 0, -1)], dtype=np.int64)
    boxes = np.concatenate([path, *(np.arange(root << k, (root + 1) << k) for k in range(tree.depth - level + 1))])
    above = np.searchsorted(boxes, boxes >> 1)
    far, near = lists
    far_end, near_end = np.zeros((2, len(boxes) + 1), np.int64)
    _decide(tree.box, boxes, above, flags, leaves, allowed, far, far_end, near, near_end)
    local = np.zeros((len(boxes), ROWS))
    add_far(tree.box, moments, boxes, far, far_end, local, SIDE)
    hand_down(tree.box, boxes, above, local, SIDE)
    _sum_near(tree.y, tree.x, tree.order, tree.box, boxes, flags, leaves, near, near_end, local, SIDE, single, force)


@reordered
def _decide(
    box: Array,
    boxes: Index,
    above: Index,
    flags: Mask,
    leaves: int,
    allowed: float,
    far: Boxes,
    far_end: Index,
    near: Boxes,
    near_end: Index,
) -> None:
    """Write which boxes are far from each of `boxes`, and which are left to its children or, for a leaf, near."""
    stack = np.empty(4 * leaves, np.int32)
    found, left = 0, 0
    for v in range(boxes.size):
        node = boxes[v]
        top = 0
        if node == 1:
            stack[0], top = 1, 1
        elif flags[node]:
            for n in range(near_end[above[v]], near_end[above[v] + 1]):
                stack[top] = near[n]
                top += 1
        y, x, radius = box[node, 0], box[node, 1], box[node, 2]
        while top > 0:
            top -= 1
            other = stack[top]
            d_y, d_x, reach = y - box[other, 0], x - box[other, 1], radius + box[other, 2]
            squared, reach, mass = d_y * d_y + d_x * d_x, reach * reach, box[other, 3]
            if (
                squared > SAME_SPOT
                and reach < _WIDEST * squared
                and mass * mass * reach**ORDER <= allowed * squared ** (ORDER + 2)
            ):
                far[found] = other
                found += 1
            elif reach == 0.0 and squared <= SAME_SPOT:
                continue  # All at one position.
            elif other < leaves and (node >= leaves or box[other, 2] > radius):
                stack[top], stack[top + 1] = 2 * other + 1, 2 * other
                top += 2
            else:
                near[left] = other
                left += 1
        far_end[v + 1], near_end[v + 1] = found, left


@reordered
def _sum_near(
    y: Array,
    x: Array,
    order: Index,
    box: Array,
    boxes: Index,
    flags: Mask,
    leaves: int,
    near: Boxes,
    near_end: Index,
    local: Array,
    side: int,
    single: bool,
    force: Array,
) -> None:
    """Force on the particles of some leaves, from the derivatives at their centers and from the leaves near them."""
    widest = y.size // leaves + 1
    u, v, f = np.empty((side, widest)), np.empty((side, widest)), np.empty((2, widest))
    near_y, near_x = np.empty(y.size), np.empty(y.size)
    for row in range(boxes.size):
        node = boxes[row]
        if node < leaves or not flags[node]:
            continue
        # Lengths in about radii of the leaf, of which single precision has the most; powers of two round nothing.
        scale = math.ldexp(1.0, -math.frexp(box[node, 2])[1]) if box[node, 2] > _LEAST_RADIUS else 1.0
        count = 0
        for n in range(near_end[row], near_end[row + 1]):
            k = near[n] - leaves
            for j in range(y.size * k // leaves, y.size * (k + 1) // leaves):
                near_y[count], near_x[count] = scale * y[j], scale * x[j]
                count += 1
        start, end = y.size * (node - leaves) // leaves, y.size * (node - leaves + 1) // leaves
        for i in range(end - start):
            u[0, i], v[0, i], f[0, i], f[1, i] = 1.0, 1.0, 0.0, 0.0
            for n in range(1, side):
                u[n, i] = u[n - 1, i] * ((y[start + i] - box[node, 0]) * INVERSE[n])
                v[n, i] = v[n - 1, i] * ((x[start + i] - box[node, 1]) * INVERSE[n])
        for a in range(side - 1):
            for b in range(side - 1 - a):
                l_y, l_x = local[row, (a + 1) * side + b], local[row, a * side + b + 1]
                for i in range(end - start):
                    weight = u[a, i] * v[b, i]
                    f[0, i] -= l_y * weight
                    f[1, i] -= l_x * weight
        for i in range(end - start):
            f_y, f_x = pairs_of(near_y[:count], near_x[:count], scale * y[start + i], scale * x[start + i], single)
            force[order[start + i], 0] = f[0, i] + scale * scale * f_y
            force[order[start + i], 1] = f[1, i] + scale * scale * f_x
