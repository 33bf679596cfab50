"""Minimum cut: the cheapest boundary between what is surely inside and what is surely outside.

The algorithm of Boykov and Kolmogorov (2004), DOI 10.1109/TPAMI.2004.60, written from the paper: two trees grow from
inside and outside until they touch, the path between them is filled with flow, and the branches that this cuts off are
attached again. On graphs of neighbors in the plane it is far faster than algorithms with better bounds.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask

_WHOLE = 2.0**20
"""Whole numbers that stand for a price of 1: flows are sums of whole numbers, so that none gets lost in rounding."""

_MOST = 2.0**40
"""Largest price, and that of a tied node."""

_FREE, _INSIDE, _OUTSIDE = 0, 1, 2
_NONE, _TERMINAL, _ORPHAN = -1, -2, -3


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
    begin, head, back, _ = graph
    count = len(excess)
    tree = np.zeros(count, np.int8)
    parent, stamp, depth = np.full(count, _NONE), np.zeros(count, np.int64), np.zeros(count, np.int64)
    active, waiting = np.empty(count + 1, np.int64), np.zeros(count, np.bool_)
    orphans = np.empty(count + 1, np.int64)
    ends = np.zeros(4, np.int64)  # first and behind the last of the active nodes, and of the orphans
    for i in range(count):
        if excess[i] != 0:
            tree[i] = _INSIDE if excess[i] > 0 else _OUTSIDE
            parent[i], depth[i] = _TERMINAL, 1
            _append(active, ends, 0, i)
            waiting[i] = True
    now = 0
    while ends[0] != ends[1]:
        i = active[ends[0]]
        if tree[i] == _FREE:
            waiting[i] = False
            _drop(active, ends, 0)
            continue
        touching = _NONE
        for a in range(begin[i], begin[i + 1]):
            j = head[a]
            if (capacity[a] if tree[i] == _INSIDE else capacity[back[a]]) == 0:
                continue
            if tree[j] == _FREE:
                tree[j], parent[j], stamp[j], depth[j] = tree[i], back[a], stamp[i], depth[i] + 1
                if not waiting[j]:
                    waiting[j] = True
                    _append(active, ends, 0, j)
            elif tree[j] != tree[i]:
                touching = a if tree[i] == _INSIDE else back[a]
                break
            elif stamp[j] <= stamp[i] and depth[j] > depth[i] + 1:
                parent[j], stamp[j], depth[j] = back[a], stamp[i], depth[i] + 1
        if touching == _NONE:
            waiting[i] = False
            _drop(active, ends, 0)
            continue
        now += 1
        _augment(graph, capacity, excess, parent, orphans, ends, touching)
        while ends[2] != ends[3]:
            orphan = orphans[ends[2]]
            _drop(orphans, ends, 2)
            _adopt(graph, capacity, tree, parent, stamp, depth, active, waiting, orphans, ends, orphan, now)
    inside: Mask = tree == _INSIDE
    return inside


@compiled
def _append(ring: Index, ends: Index, which: int, node: int) -> None:
    ring[ends[which + 1]] = node
    ends[which + 1] = (ends[which + 1] + 1) % len(ring)


@compiled
def _drop(ring: Index, ends: Index, which: int) -> None:
    ends[which] = (ends[which] + 1) % len(ring)


@compiled
def _augment(
    graph: Arcs, capacity: Index, excess: Index, parent: Index, orphans: Index, ends: Index, touching: int
) -> None:
    """Send flow from inside to outside through an arc between the trees."""
    head, back = graph.head, graph.back
    flow = capacity[touching]
    i = head[back[touching]]
    while parent[i] != _TERMINAL:
        flow = min(flow, capacity[back[parent[i]]])
        i = head[parent[i]]
    flow = min(flow, excess[i])
    j = head[touching]
    while parent[j] != _TERMINAL:
        flow = min(flow, capacity[parent[j]])
        j = head[parent[j]]
    flow = min(flow, -excess[j])
    capacity[touching] -= flow
    capacity[back[touching]] += flow
    for side, first in ((0, head[back[touching]]), (1, head[touching])):
        i = first
        while True:
            a = parent[i]
            if a == _TERMINAL:
                excess[i] += flow if side else -flow
                if excess[i] == 0:
                    parent[i] = _ORPHAN
                    _append(orphans, ends, 2, i)
                break
            up, down = (a, back[a]) if side else (back[a], a)
            capacity[up] -= flow
            capacity[down] += flow
            following = head[a]
            if capacity[up] == 0:
                parent[i] = _ORPHAN
                _append(orphans, ends, 2, i)
            i = following


@compiled
def _origin(graph: Arcs, parent: Index, stamp: Index, depth: Index, node: int, now: int) -> int:
    """Length of the way from a node to its terminal; 0 if it hangs on an orphan. Marks the nodes on the way."""
    head = graph.head
    i, steps = node, 0
    while True:
        if stamp[i] == now:
            steps += depth[i]
            break
        a = parent[i]
        steps += 1
        if a == _TERMINAL:
            stamp[i], depth[i] = now, 1
            break
        if a < 0:
            return 0
        i = head[a]
    i, left = node, steps
    while stamp[i] != now:
        stamp[i], depth[i] = now, left
        left -= 1
        i = head[parent[i]]
    return steps


@compiled
def _adopt(
    graph: Arcs,
    capacity: Index,
    tree: NDArray[np.int8],
    parent: Index,
    stamp: Index,
    depth: Index,
    active: Index,
    waiting: Mask,
    orphans: Index,
    ends: Index,
    node: int,
    now: int,
) -> None:
    """Attach an orphan to a neighbor of its tree, or set it free and make orphans of its children."""
    begin, head, back, _ = graph
    best, nearest = _NONE, 0
    for a in range(begin[node], begin[node + 1]):
        j = head[a]
        if tree[j] == tree[node] and (capacity[back[a]] if tree[node] == _INSIDE else capacity[a]) > 0:
            steps = _origin(graph, parent, stamp, depth, j, now)
            if steps > 0 and (best == _NONE or steps < nearest):
                best, nearest = a, steps
    parent[node] = best
    if best != _NONE:
        stamp[node], depth[node] = now, nearest + 1
        return
    stamp[node] = 0
    for a in range(begin[node], begin[node + 1]):
        j = head[a]
        if tree[j] != tree[node]:
            continue
        if (capacity[back[a]] if tree[node] == _INSIDE else capacity[a]) > 0 and not waiting[j]:
            waiting[j] = True
            _append(active, ends, 0, j)
        if parent[j] >= 0 and head[parent[j]] == node:
            parent[j] = _ORPHAN
            _append(orphans, ends, 2, j)
    tree[node] = _FREE
