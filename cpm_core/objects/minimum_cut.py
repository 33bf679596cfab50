"""Minimum cut of a graph between what is surely inside and what is surely outside."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.types import Array, Index, Mask

_WHOLE = 1e4
"""Whole numbers that stand for a capacity of 1."""

_TIED = 1e5
"""Capacity that no boundary exceeds."""


def minimum_cut(
    first: Index, second: Index, price: Array, leaving: Array, entering: Array, inside: Mask, outside: Mask
) -> Mask:
    """Set of nodes with the cheapest boundary.

    Parameters
    ----------
    first, second : ndarray of int64, shape (E,)
        Pairs of neighbors.
    price : ndarray, shape (E,)
        Price of parting each pair.
    leaving, entering : ndarray, shape (F,)
        Price of each node being outside, and inside.
    inside, outside : ndarray of bool, shape (F,)
        Nodes that must be inside, and outside.

    Returns
    -------
    ndarray of bool, shape (F,)
        Which nodes are inside: the smallest set of all that are cheapest.
    """
    count = len(leaving)
    source, sink = count, count + 1
    nodes = np.arange(count)
    ties = np.where(inside, _TIED, leaving), np.where(outside, _TIED, entering)
    rows = np.concatenate([first, second, np.full(count, source), nodes])
    cols = np.concatenate([second, first, nodes, np.full(count, sink)])
    capacity = np.rint(np.minimum(np.concatenate([price, price, *ties]), _TIED) * _WHOLE).astype(np.int32)
    graph = scipy.sparse.csr_array((capacity, (rows, cols)), shape=(count + 2, count + 2))
    flow = scipy.sparse.csgraph.maximum_flow(graph, source, sink).flow
    left = graph - flow
    left.data = np.where(left.data > 0, left.data, 0)
    left.eliminate_zeros()
    reached = scipy.sparse.csgraph.breadth_first_order(left, source, return_predecessors=False)
    found = np.zeros(count + 2, np.bool_)
    found[reached] = True
    return np.asarray(found[:count])
