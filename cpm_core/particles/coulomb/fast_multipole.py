"""Eq. (9) by a fast multipole method.

The particles are sorted into a tree. From its top down, each box looks at the boxes that the one above it has left
undecided: one that is far enough acts on it by the series of `expansions`, one that is not is opened, and what a leaf
is left with is near and summed pair by pair. Every box so meets a number of others that does not depend on N.

What is far enough follows from the tolerance. Of a box of M particles at a distance d, a series of order p leaves out
less than about M theta^p / d^2, theta being the sum of the two radii over d. This is compared with the force that is
usual among these particles, which a sample tells (`usual_force`). So the error stays small beside the forces also where
most of what acts on a particle cancels; and where all of it does, everything is near, and the sum is exact.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.particles.coulomb.direct_sum import SAME_SPOT, usual_force
from cpm_core.particles.coulomb.expansions import ORDER, ROWS, SIDE, add_far, gather_moments, hand_down
from cpm_core.particles.coulomb.kd_tree import TOP, Tree, flag_boxes, plant
from cpm_core.particles.coulomb.near_field import sum_near

Boxes = NDArray[np.int32]

_FULLEST = 32
"""Particles that a leaf may hold: with 16 the series take the more time, with 64 the pairs do."""

_SHARE = 1.4
"""Part of the tolerance that one far box may take, times the root of the order of the series from the tolerance: the
smaller that is, the more boxes share it. At a tolerance of 1e-3 all of them together take 0.2 of it on curves, 0.3 on a
grid, less in clouds, and 0.8 at most, on equally spaced rings, where errors add up alike for all particles."""

_WIDEST = 0.7
"""Square of the largest theta at which a series is used, whatever the tolerance."""

_BRANCH = 6
"""Levels of the branches of the tree that are worked on one after the other, so that lists stay short."""


def tree_force(y: Array, x: Array, tolerance: float, wanted: Index | None) -> Array:
    """Force on some particles from all the others.

    Parameters
    ----------
    y, x : ndarray, shape (N,)
        Coordinates of the particles, on the unit square; they are sorted anew.
    tolerance : float
        Relative error that is allowed, as a mean over the particles (l2).
    wanted : ndarray of int64, shape (M,), optional
        Indices of the particles whose force is wanted.

    Returns
    -------
    ndarray, shape (N, 2) or (M, 2)
        Sums of eq. (9).
    """
    tree = plant(y, x, _FULLEST)
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
    sum_near(tree.y, tree.x, tree.order, tree.box, boxes, flags, leaves, near, near_end, local, SIDE, single, force)


@compiled
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
    """Write which boxes are far from each of `boxes`, and which are left for those below it or, for a leaf, near."""
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
                continue  # All on one spot.
            elif other < leaves and (node >= leaves or box[other, 2] > radius):
                stack[top], stack[top + 1] = 2 * other + 1, 2 * other
                top += 2
            else:
                near[left] = other
                left += 1
        far_end[v + 1], near_end[v + 1] = found, left
