"""Minimum cut: the cheapest boundary between what is surely inside and what is surely outside.

The algorithm of Dinitz (1970): as long as a way leads from inside to outside, all shortest ones are filled with flow.
What flow can still reach from inside is the smallest of the cheapest sets.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask

_WHOLE = 2.0**20
"""Whole numbers that stand for a price of 1: flows are sums of whole numbers, so that none gets lost in rounding."""

_MOST = 2.0**40
"""Largest price, and that of a tied node."""


class Arcs(NamedTuple):
    """A graph of N nodes and E links as 2 E arcs, those that leave a node side by side.

    Attributes
    ----------
    begin : ndarray of int64, shape (N + 1,)
        First arc of each node.
    head : ndarray of int64, shape (2 E,)
        Node that an arc leads to.
    back : ndarray of int64, shape (2 E,)
        The arc in the opposite direction.
    link : ndarray of int64, shape (2 E,)
        The link that an arc belongs to.
    """

    begin: Index
    head: Index
    back: Index
    link: Index


def arcs(first: Index, second: Index, count: int) -> Arcs:
    """Arcs of a graph of `count` nodes with links between `first` and `second`, shape (E,)."""
    links = len(first)
    tail, head = np.concatenate([first, second]), np.concatenate([second, first])
    order = np.argsort(tail, kind="stable")
    place = np.empty_like(order)
    place[order] = np.arange(2 * links)
    back = place[np.roll(np.arange(2 * links), links)][order]
    begin = np.searchsorted(tail[order], np.arange(count + 1))
    return Arcs(begin, head[order], back, order % max(links, 1))


def minimum_cut(graph: Arcs, price: Array, leaving: Array, entering: Array) -> Mask:
    """Set of nodes for which the sum of all prices to be paid is least.

    Parameters
    ----------
    graph : Arcs
        The graph.
    price : ndarray, shape (E,)
        Price of each link between a node inside and one outside.
    leaving, entering : ndarray, shape (N,)
        Price of each node being outside, and of its being inside; infinite for one that must not.

    Returns
    -------
    ndarray of bool, shape (N,)
        Which nodes are inside: the smallest of all sets that are cheapest.
    """
    capacity = np.rint(np.minimum(price * _WHOLE, _MOST)).astype(np.int64)[graph.link]
    excess = np.rint(np.minimum(leaving * _WHOLE, _MOST)) - np.rint(np.minimum(entering * _WHOLE, _MOST))
    return _cut(graph, capacity, excess.astype(np.int64))


class FreePart:
    """Part of a graph in which nodes are free to be inside or outside, while all others stay where they are.

    Parameters
    ----------
    first, second : ndarray of int64, shape (E,)
        The links of the graph.
    price : ndarray, shape (E,)
        Price of each.
    free : ndarray of bool, shape (N,)
        Which nodes are free.
    inside : ndarray of bool, shape (N,)
        Which nodes are inside, as far as they are not free.
    """

    def __init__(self, first: Index, second: Index, price: Array, free: Mask, inside: Mask) -> None:
        self._free, self._inside = free, inside
        count = int(np.count_nonzero(free))
        number = np.cumsum(free) - 1
        within = free[first] & free[second]
        self._graph = arcs(number[first[within]], number[second[within]], count)
        self._price = price[within]
        self._leaving, self._entering = np.zeros(count), np.zeros(count)
        for own, other in ((first, second), (second, first)):  # a link to a node that stays is a price of the free one
            ends = free[own] & ~free[other]
            to_inside = inside[other[ends]]
            nodes, prices = number[own[ends]], price[ends]
            self._leaving += np.bincount(nodes, prices * to_inside, count)
            self._entering += np.bincount(nodes, prices * ~to_inside, count)

    def cut(self, leaving: Array, entering: Array) -> Mask:
        """As `minimum_cut` of the whole graph, for the prices of all its nodes, shape (N,)."""
        found = self._inside.copy()
        own = self._leaving + leaving[self._free], self._entering + entering[self._free]
        found[self._free] = minimum_cut(self._graph, self._price, *own)
        return found


@compiled
def _cut(graph: Arcs, capacity: Index, excess: Index) -> Mask:
    """Fill the graph with flow; `capacity` and `excess` become what is left of them."""
    count = len(excess)
    level, order, way = np.empty(count, np.int64), np.empty(count, np.int64), np.empty(count, np.int64)
    while True:
        sources = _measure(graph, capacity, excess, level, order)
        if sources == 0:
            inside: Mask = level >= 0
            return inside
        _fill(graph, capacity, excess, level, order[:sources], way)


@compiled
def _measure(graph: Arcs, capacity: Index, excess: Index, level: Index, order: Index) -> int:
    """Lengths of the shortest ways from inside, -1 for none; return how many nodes they begin at, if one leads outside.

    These nodes are the first ones in the order.
    """
    begin, head, _, _ = graph
    last = 0
    for i in range(len(excess)):
        level[i] = -1
        if excess[i] > 0:
            level[i], order[last] = 0, i
            last += 1
    sources, first, leads_out = last, 0, False
    while first < last:
        i = order[first]
        first += 1
        leads_out |= excess[i] < 0
        for a in range(begin[i], begin[i + 1]):
            if capacity[a] > 0 and level[head[a]] < 0:
                level[head[a]], order[last] = level[i] + 1, head[a]
                last += 1
    return sources if leads_out else 0


@compiled
def _fill(graph: Arcs, capacity: Index, excess: Index, level: Index, sources: Index, way: Index) -> None:
    """Fill all shortest ways from some nodes with flow."""
    begin, head, back, _ = graph
    at = begin.copy()
    for root in sources:
        i, depth = root, 0
        while excess[root] > 0:
            if excess[i] < 0:
                flow = min(excess[root], -excess[i])
                for a in way[:depth]:
                    flow = min(flow, capacity[a])
                for a in way[:depth]:
                    capacity[a] -= flow
                    capacity[back[a]] += flow
                excess[root] -= flow
                excess[i] += flow
                i, depth = root, 0
            elif at[i] < begin[i + 1]:
                a = at[i]
                if capacity[a] > 0 and level[head[a]] == level[i] + 1:
                    i, way[depth] = head[a], a
                    depth += 1
                else:
                    at[i] += 1
            elif depth:
                depth -= 1
                i = head[back[way[depth]]]
                at[i] += 1
            else:
                break
