"""Particles sorted into a tree of boxes, each of which holds half the particles of its parent.

Boxes are numbered from 1, and the children of box k are 2 k and 2 k + 1; the `leaves` boxes of the last level come
last. Box k of a level of n boxes holds the particles from N k / n to N (k + 1) / n of the sorted ones: a tree only
needs their order. Halving by number and not by length keeps the tree as deep for clusters as for a grid.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index, Mask

TOP = 3
"""Level whose boxes are shared among the cores."""

_WORTH_A_THREAD = 1000
"""Particles from which a thread pays."""


class Tree(NamedTuple):
    """Particles sorted into boxes.

    Attributes
    ----------
    y, x : ndarray, shape (N,)
        Coordinates of the particles in the order of the tree.
    order : ndarray of int64, shape (N,)
        Index of each of them.
    box : ndarray, shape (2 leaves, 4)
        Center and radius of every box, and how many particles it holds; the first row is not used.
    depth : int
        Levels below the first; there are 2^depth leaves.
    """

    y: Array
    x: Array
    order: Index
    box: Array
    depth: int


def build_tree(y: Array, x: Array, fullest: int) -> Tree:
    """Sort particles into a tree whose leaves hold at most `fullest` of them."""
    depth = 0
    while len(y) > fullest << depth:
        depth += 1
    points, order, box = np.stack([y, x]), np.arange(len(y)), np.empty((2 << depth, 4))
    top = min(depth, TOP)
    first_box = 1 << top
    _split(points, order, box, 1, 2, 0, top)
    share(
        lambda first, last: _split(points, order, box, first_box + first, first_box + last, top, depth + 1),
        first_box,
        (_WORTH_A_THREAD << top) // len(y) + 1,
    )
    return Tree(points[0], points[1], order, box, depth)


def flag_boxes(tree: Tree, wanted: Index | None) -> Mask:
    """Boxes that hold any of some particles; all boxes if none are given."""
    leaves = 1 << tree.depth
    flags = np.full(2 * leaves, wanted is None)
    if wanted is not None:
        place = np.empty_like(tree.order)
        place[tree.order] = np.arange(len(tree.order))
        flags[leaves + ((place[wanted] + 1) * leaves - 1) // len(tree.y)] = True
        for level in range(tree.depth - 1, -1, -1):
            flags[1 << level : 2 << level] = flags[2 << level : 4 << level].reshape(-1, 2).any(axis=1)
    return flags


@compiled
def _split(points: Array, order: Index, box: Array, first: int, last: int, level: int, end_level: int) -> None:
    """Measure and halve the boxes `first` to `last` - 1 of a level, and those below down to another one."""
    total, deepest = order.size, box.shape[0] // 2
    for down in range(end_level - level):
        for node in range(first << down, last << down):
            k = node - (1 << (level + down))
            start, end = (total * k) >> (level + down), (total * (k + 1)) >> (level + down)
            low_y, high_y, low_x, high_x = points[0, start], points[0, start], points[1, start], points[1, start]
            for i in range(start, end):
                low_y, high_y = min(low_y, points[0, i]), max(high_y, points[0, i])
                low_x, high_x = min(low_x, points[1, i]), max(high_x, points[1, i])
            box[node, 0], box[node, 1] = 0.5 * (low_y + high_y), 0.5 * (low_x + high_x)
            box[node, 2] = 0.5 * np.sqrt((high_y - low_y) ** 2 + (high_x - low_x) ** 2)
            box[node, 3] = end - start
            if node < deepest:
                longer = 0 if high_y - low_y > high_x - low_x else 1
                middle = (total * (2 * k + 1)) >> (level + down + 1)
                _halve(points[longer], points[1 - longer], order, start, end - 1, middle)


@compiled
def _halve(key: Array, other: Array, order: Index, low: int, high: int, middle: int) -> None:
    """Rearrange the particles from `low` to `high` so that no key before `middle` is above one behind it."""
    while low < high:
        a, b, c = key[low], key[(low + high) >> 1], key[high]
        pivot = max(min(a, b), min(max(a, b), c))
        i, j = low, high
        while i <= j:
            while key[i] < pivot:
                i += 1
            while key[j] > pivot:
                j -= 1
            if i <= j:
                key[i], key[j] = key[j], key[i]
                other[i], other[j] = other[j], other[i]
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if middle <= j:
            high = j
        elif middle >= i:
            low = i
        else:
            return
