"""Fewer triangles for nearly the same surface: edges are contracted, the cheapest first.

The cost of an edge is the sum of the squared distances of its new vertex from the planes of the triangles that have
become part of it (Garland and Heckbert 1997, DOI 10.1145/258734.258849), each weighted by its area. An edge is
contracted only if its ends have no neighbors in common but the two beside it: so the surface stays manifold and keeps
its Euler characteristic (the link condition; Dey, Edelsbrunner, Guha and Nekhayev 1999). Nor may a triangle turn over
or become a needle.
"""

from __future__ import annotations

import heapq

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask

_TURN = 0.3
"""Least cosine of the angle by which a triangle turns."""

_NEEDLE = 0.06
"""Least ratio of area to squared sides, 1 for equal sides, unless the triangle is thinner already."""

_MOST_AROUND = 20
"""Most triangles around a vertex."""

_TOWARD_MIDDLE = 1e-3
"""Weight of the middle of an edge where the planes leave the place of the new vertex open, as in a flat region."""

_LATER = 2.0
"""Factor on the cost of an edge that may not be contracted yet."""

_PER_LENGTH = 1e-4
"""Weight of the length of an edge in its cost, which decides in flat regions."""


def contracted(places: Array, faces: Index, count: int, farthest: float) -> tuple[Array, Index]:
    """Vertices and triangles of a manifold surface with `count` triangles, or more where no edge may be contracted.

    Parameters
    ----------
    places : ndarray, shape (N, 3)
        Vertices, in a unit that is the same along all axes.
    faces : ndarray of int64, shape (F, 3)
        Triangles. Vertices at free edges stay where they are.
    count : int
        Number of triangles that is wanted.
    farthest : float
        Largest distance of a new vertex from the planes of the triangles it stands for (root of the mean square).
    """
    middle = places.mean(0)
    moved, corners = places - middle, faces.copy()
    following, first = _corners_of(faces, len(places))
    _contract(moved, corners, following, first, _at_border(faces, len(places)), count, farthest)
    left = corners[corners[:, 0] >= 0]
    used, number = np.unique(left, return_inverse=True)
    return moved[used] + middle, number.reshape(-1, 3).astype(np.int64)


def _at_border(faces: Index, count: int) -> Mask:
    """Which vertices lie at a free edge."""
    ends = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, triangles = np.unique(ends, axis=0, return_counts=True)
    border = np.zeros(count, np.bool_)
    border[edges[triangles == 1]] = True
    return border


def _corners_of(faces: Index, count: int) -> tuple[Index, Index]:
    """Lists of the corners at each vertex: the following corner, -1 at the end, and the first of each vertex."""
    vertex = faces.ravel()
    order = np.argsort(vertex, kind="stable")
    following, first = np.full(len(vertex), -1), np.full(count, -1)
    same = vertex[order[1:]] == vertex[order[:-1]]
    following[order[:-1][same]] = order[1:][same]
    begins = np.concatenate([[True], ~same]) if len(order) else np.zeros(0, bool)
    first[vertex[order[begins]]] = order[begins]
    return following, first


@compiled
def _contract(
    places: Array, faces: Index, following: Index, first: Index, fixed: Mask, count: int, farthest: float
) -> None:
    """Contract edges until `count` triangles are left; the others are -1."""
    quadrics = np.zeros((len(places), 10))
    for f in range(len(faces)):
        _add_plane(places, faces, f, quadrics)
    version, mark, place = np.zeros(len(places), np.int64), np.zeros(len(places), np.int64), np.empty(3)
    waiting = [(0.0, 0, 0, 0)]
    for f in range(len(faces)):
        for k in range(3):
            u, v = faces[f, k], faces[f, (k + 1) % 3]
            if u < v:  # the other triangle has the edge the other way round
                waiting.append((_cost(places, quadrics, fixed, u, v, place), u, v, 0))
    heapq.heapify(waiting)
    left, refused = len(faces), 0
    while left > count and refused < len(waiting):
        cost, u, v, then = heapq.heappop(waiting)
        if u == v or version[u] < 0 or version[v] < 0 or version[u] + version[v] != then or (fixed[u] and fixed[v]):
            continue
        if fixed[v]:
            u, v = v, u
        _cost(places, quadrics, fixed, u, v, place)
        if _is_far(quadrics, u, v, place, farthest):
            continue
        if not _allowed(places, faces, following, first, mark, u, v, place):
            heapq.heappush(waiting, (_LATER * cost, u, v, then))  # its surroundings may change
            refused += 1
            continue
        refused = 0
        left -= _merge(faces, following, first, u, v)
        for k in range(3):
            places[u, k] = place[k]
        for k in range(10):
            quadrics[u, k] += quadrics[v, k]
        version[u], version[v] = version[u] + 1, -1
        corner = first[u]
        while corner >= 0:
            f, k = corner // 3, corner % 3
            w = faces[f, (k + 1) % 3]
            waiting_cost = _cost(places, quadrics, fixed, u, w, place)
            heapq.heappush(waiting, (waiting_cost, u, w, version[u] + version[w]))
            corner = following[corner]


@compiled
def _add_plane(places: Array, faces: Index, f: int, quadrics: Array) -> None:
    """Add the plane of a triangle, weighted by its area, to its vertices."""
    a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
    plane = np.empty(4)
    length = _normal(places[a], places[b], places[c], plane)
    if length == 0.0:
        return
    for k in range(3):
        plane[k] /= length
    plane[3] = -(plane[0] * places[a, 0] + plane[1] * places[a, 1] + plane[2] * places[a, 2])
    at = 0
    for i in range(4):
        for j in range(i, 4):
            part = 0.5 * length * plane[i] * plane[j]
            for k in range(3):
                quadrics[faces[f, k], at] += part
            at += 1


@compiled
def _normal(a: Array, b: Array, c: Array, normal: Array) -> float:
    """Normal of a triangle, as long as twice its area, and its length."""
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        normal[k] = (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i])
    return float(np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2))


@compiled
def _cost(places: Array, quadrics: Array, fixed: Mask, u: int, v: int, place: Array) -> float:
    """Cost of the contraction of an edge, and the best place of the vertex that is left."""
    q = quadrics[u] + quadrics[v]
    size = q[0] + q[4] + q[7]
    length = 0.0
    for k in range(3):
        place[k] = 0.5 * (places[u, k] + places[v, k])
        length += (places[u, k] - places[v, k]) ** 2
    if fixed[u] or fixed[v]:
        for k in range(3):
            place[k] = places[u, k] if fixed[u] else places[v, k]
    else:
        _solve(q, _TOWARD_MIDDLE * size + 1e-300, place)
    return float(_off(q, place) + _PER_LENGTH * size * length)


@compiled
def _is_far(quadrics: Array, u: int, v: int, place: Array, farthest: float) -> bool:
    """Whether a place is too far from the planes of both ends of an edge."""
    q = quadrics[u] + quadrics[v]
    return bool(_off(q, place) > farthest * farthest * (q[0] + q[4] + q[7]))


@compiled
def _off(q: Array, place: Array) -> float:
    """Sum of the squared distances of a place from planes, each weighted by its area."""
    x, y, z = place[0], place[1], place[2]
    off = q[0] * x * x + q[4] * y * y + q[7] * z * z + q[9]
    off += 2.0 * (q[1] * x * y + q[2] * x * z + q[5] * y * z + q[3] * x + q[6] * y + q[8] * z)
    return float(max(off, 0.0))


@compiled
def _solve(q: Array, pull: float, place: Array) -> None:
    """Move a place to where a quadric, with a pull back to it, is least."""
    a, b, c, d, e, f = q[0] + pull, q[1], q[2], q[4] + pull, q[5], q[7] + pull
    r, s, t = pull * place[0] - q[3], pull * place[1] - q[6], pull * place[2] - q[8]
    aa, bb, cc = d * f - e * e, c * e - b * f, b * e - c * d
    dd, ee, ff = a * f - c * c, b * c - a * e, a * d - b * b
    whole = a * aa + b * bb + c * cc
    place[0] = (aa * r + bb * s + cc * t) / whole
    place[1] = (bb * r + dd * s + ee * t) / whole
    place[2] = (cc * r + ee * s + ff * t) / whole


@compiled
def _allowed(
    places: Array, faces: Index, following: Index, first: Index, mark: Index, u: int, v: int, place: Array
) -> bool:
    """Whether an edge may be contracted to a vertex at a place."""
    around = shared = beside = 0
    corner = first[u]
    while corner >= 0:
        f, k = corner // 3, corner % 3
        around += 1
        beside += faces[f, (k + 1) % 3] == v or faces[f, (k + 2) % 3] == v
        mark[faces[f, (k + 1) % 3]] = mark[faces[f, (k + 2) % 3]] = 1
        corner = following[corner]
    fine = True
    corner = first[v]
    while corner >= 0:
        f, k = corner // 3, corner % 3
        around += 1
        for w in (faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]):
            if mark[w] == 1 and w != u:
                mark[w] = 2
                shared += 1
                fine = fine and _count(following, first, w) > 3
        corner = following[corner]
    corner = first[u]
    while corner >= 0:
        f, k = corner // 3, corner % 3
        mark[faces[f, (k + 1) % 3]] = mark[faces[f, (k + 2) % 3]] = 0
        corner = following[corner]
    if not fine or shared != beside or around - 2 * beside > _MOST_AROUND:
        return False
    return _stays(places, faces, following, first, u, v, place) and _stays(places, faces, following, first, v, u, place)


@compiled
def _count(following: Index, first: Index, v: int) -> int:
    """Number of triangles around a vertex."""
    count = 0
    corner = first[v]
    while corner >= 0:
        count += 1
        corner = following[corner]
    return count


@compiled
def _stays(places: Array, faces: Index, following: Index, first: Index, u: int, v: int, place: Array) -> bool:
    """Whether no triangle at u, but those of the edge to v, turns over or becomes a needle when u moves to a place."""
    before, after = np.empty(3), np.empty(3)
    corner = first[u]
    while corner >= 0:
        f, k = corner // 3, corner % 3
        b, c = faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
        corner = following[corner]
        if v in (b, c):
            continue
        old = _normal(places[u], places[b], places[c], before)
        new = _normal(place, places[b], places[c], after)
        along = before[0] * after[0] + before[1] * after[1] + before[2] * after[2]
        if along <= _TURN * old * new:
            return False
        old, new = (
            old / _sides(places[u], places[b], places[c]),
            new / _sides(place, places[b], places[c]),
        )
        if new < _NEEDLE and new < old:
            return False
    return True


@compiled
def _sides(a: Array, b: Array, c: Array) -> float:
    """Sum of the squared sides of a triangle, in units in which it is twice the area when all are equal."""
    total = 1e-300
    for k in range(3):
        total += (a[k] - b[k]) ** 2 + (b[k] - c[k]) ** 2 + (c[k] - a[k]) ** 2
    return float(total / np.sqrt(12.0))


@compiled
def _merge(faces: Index, following: Index, first: Index, u: int, v: int) -> int:
    """Let v become u; return the number of triangles that are gone."""
    gone = 0
    corner = first[v]
    while corner >= 0:
        f, k = corner // 3, corner % 3
        then = following[corner]
        if faces[f, (k + 1) % 3] == u or faces[f, (k + 2) % 3] == u:
            for other in range(3):
                if other != k:
                    _unlink(following, first, faces[f, other], 3 * f + other)
            for other in range(3):
                faces[f, other] = -1
            gone += 1
        else:
            faces[f, k] = u
            following[corner], first[u] = first[u], corner
        corner = then
    first[v] = -1
    return gone


@compiled
def _unlink(following: Index, first: Index, v: int, corner: int) -> None:
    """Take a corner out of the list of a vertex."""
    if first[v] == corner:
        first[v] = following[corner]
        return
    at = first[v]
    while following[at] != corner:
        at = following[at]
    following[at] = following[corner]
