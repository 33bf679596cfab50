"""Graph of faces: which of them share a border, how long it is, and what lies along it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.objects.faces.basins import Labels
from cpm_core.objects.faces.crossings import Crossings
from cpm_core.objects.faces.minimum_cut import Arcs, arcs

_SIDE, _CORNER = np.pi / 8.0, np.pi / 8.0 / np.sqrt(2.0)
"""Length that a pair of pixels with a common side, or corner, stands for: of the Cauchy-Crofton formula with eight
neighbors, which measures straight lines of any direction to within 5 % [px]."""

_ON_LINE, _ON_BARRIER, _AT_CORNER = 1, 2, 4
_STEPS = ((0, 1), (1, 0), (1, 1), (1, -1))
_Pair = tuple[Single, Single]
Window = tuple[slice, slice]


@dataclass(frozen=True, eq=False)
class FaceGraph:
    """Faces and pairs of neighbors, as arrays over F faces and E pairs.

    Attributes
    ----------
    first, second : ndarray of int64, shape (E,)
        The faces of each pair, ``first < second``.
    length : ndarray, shape (E,)
        Length of their common border [px].
    strength : ndarray, shape (E,)
        Mean edge strength along it [gray levels / px].
    along : ndarray, shape (E,)
        Share of it that lies on a contour, 0 to 1.
    barred : ndarray, shape (E,)
        Share of it that lies on a barrier, 0 to 1.
    area : ndarray, shape (F,)
        Pixels of each face.
    mean, deviation : ndarray, shape (F,)
        Mean and standard deviation of its gray levels.
    rim : ndarray, shape (F,)
        Length of its border on that of the image or of the regions of interest [px].
    center : ndarray, shape (F, 2)
        Mean position of its pixels (row, col) [px].
    """

    first: Index
    second: Index
    length: Array
    strength: Array
    along: Array
    barred: Array
    area: Array
    mean: Array
    deviation: Array
    rim: Array
    center: Array

    @property
    def count(self) -> int:
        """Number of faces."""
        return len(self.area)

    @cached_property
    def arcs(self) -> Arcs:
        """The pairs as a graph to search and to cut."""
        return arcs(self.first, self.second, self.count)


def face_graph(labels: Labels, values: Array, strength: Array, lines: Crossings, barriers: Crossings) -> FaceGraph:
    """Measure faces and their borders.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
        Face of every pixel, -1 outside the regions of interest.
    values, strength : ndarray, shape (H, W)
        Image, and its edge map.
    lines, barriers : Crossings
        Where contours, and barriers, pass between pixels.
    """
    whole = (slice(0, labels.shape[0]), slice(0, labels.shape[1]))
    return _graph_in(whole, int(labels.max()) + 1, labels, values, strength, lines, barriers)


def changed_graph(
    graph: FaceGraph,
    changed: Mask,
    window: Window,
    labels: Labels,
    values: Array,
    strength: Array,
    lines: Crossings,
    barriers: Crossings,
) -> FaceGraph:
    """Measure some faces again; the rest of the graph stays.

    Parameters
    ----------
    graph : FaceGraph
        Of F faces.
    changed : ndarray of bool, shape (F + N,)
        Which faces have other pixels, the N new ones among them.
    window : tuple of slice
        Rows and columns that hold these faces and the pixels next to them.
    labels, values, strength, lines, barriers
        As for `face_graph`.
    """
    there = _graph_in(window, len(changed), labels, values, strength, lines, barriers)
    kept, new = ~_at_either_end(graph, changed), _at_either_end(there, changed)
    parts = {
        name: np.concatenate([getattr(graph, name)[kept], getattr(there, name)[new]])
        for name in ("first", "second", "length", "strength", "along", "barred")
    }
    for name in ("area", "mean", "deviation", "rim", "center"):
        measures = getattr(there, name)
        unchanged = np.flatnonzero(~changed)
        measures[unchanged] = getattr(graph, name)[unchanged]
        parts[name] = measures
    return FaceGraph(**parts)


def _at_either_end(graph: FaceGraph, chosen: Mask) -> Mask:
    """Pairs of which one face at least is chosen, shape (E,)."""
    return np.asarray(chosen[graph.first] | chosen[graph.second])


def _graph_in(
    window: Window, count: int, labels: Labels, values: Array, strength: Array, lines: Crossings, barriers: Crossings
) -> FaceGraph:
    """Graph of `count` faces by what a window shows of them."""
    face, edge = np.ascontiguousarray(labels[window]), np.ascontiguousarray(strength[window])
    on_line, on_barrier = (
        (np.ascontiguousarray(found.right[window]), np.ascontiguousarray(found.down[window]))
        for found in (lines, barriers)
    )
    sums = np.zeros((6, count))
    rows, cols = labels.shape
    _measure(face, np.array(values[window]), window[0].start, window[1].start, rows, cols, sums)
    area, gray, squares, down, right, on_border = sums
    pairs, found = _borders(face, edge, on_line, on_barrier, count)
    low, high = pairs.T
    number, strengths, along, barred, corners = found.T
    length = _SIDE * number + _CORNER * corners
    inner = (low >= 0) & (number > 0)
    outer = (low < 0) & (number > 0)
    rim = on_border + np.bincount(high[outer], length[outer], count)
    number, pixels = number[inner], np.maximum(area, 1.0)
    return FaceGraph(
        first=low[inner],
        second=high[inner],
        length=length[inner],
        strength=strengths[inner] / number,
        along=along[inner] / number,
        barred=barred[inner] / number,
        area=area,
        mean=gray / pixels,
        deviation=np.sqrt(squares / pixels),
        rim=rim,
        center=np.stack([down / pixels, right / pixels], axis=1),
    )


@compiled
def _measure(labels: Labels, values: Array, top: int, left: int, high: int, wide: int, sums: Array) -> None:
    """Area, sum of gray levels and of their squared deviations, of rows and columns, and sides on the image border.

    `labels` and `values` show the image, of `high` rows and `wide` columns, from row `top` and column `left` on.
    """
    rows, cols = labels.shape
    for r in range(rows):
        for c in range(cols):
            k = labels[r, c]
            if k < 0:
                continue
            sums[0, k] += 1.0
            sums[1, k] += values[r, c]
            y, x = r + top, c + left
            sums[3, k] += y
            sums[4, k] += x
            sums[5, k] += (y == 0) + (y == high - 1) + (x == 0) + (x == wide - 1)
    for r in range(rows):
        for c in range(cols):
            k = labels[r, c]
            if k >= 0:
                sums[2, k] += (values[r, c] - sums[1, k] / sums[0, k]) ** 2


class _Links(NamedTuple):
    """Links between pixels of different faces: the lower and the higher face, edge strength, and what lies on it."""

    low: Labels
    high: Labels
    strength: Array
    kind: NDArray[np.int8]


@compiled
def _links(labels: Labels, strength: Array, lines: _Pair, barriers: _Pair) -> _Links:
    rows, cols = labels.shape
    most = 0
    for r in range(rows):
        for c in range(cols):
            for down, right in _STEPS:
                if r + down < rows and 0 <= c + right < cols:
                    most += labels[r, c] != labels[r + down, c + right]
    found = _Links(np.empty(most, np.int32), np.empty(most, np.int32), np.empty(most), np.zeros(most, np.int8))
    at = 0
    for r in range(rows):
        for c in range(cols):
            for down, right in _STEPS:
                if not (r + down < rows and 0 <= c + right < cols) or labels[r, c] == labels[r + down, c + right]:
                    continue
                a, b = labels[r, c], labels[r + down, c + right]
                found.low[at], found.high[at] = min(a, b), max(a, b)
                found.strength[at] = max(strength[r, c], strength[r + down, c + right])
                if down and right:
                    found.kind[at] = _AT_CORNER
                else:
                    on_line, on_barrier = lines[down][r, c] >= 0.0, barriers[down][r, c] >= 0.0
                    found.kind[at] = _ON_LINE * on_line + _ON_BARRIER * on_barrier
                at += 1
    return found


@compiled
def _borders(labels: Labels, strength: Array, lines: _Pair, barriers: _Pair, count: int) -> tuple[Index, Array]:
    """Pairs of neighbors, and of each: sides, sum of strength, sides on lines, on barriers, and corners."""
    links = _links(labels, strength, lines, barriers)
    begin = np.zeros(count + 2, np.int64)
    for low in links.low:
        begin[low + 2] += 1
    for k in range(count + 1):
        begin[k + 1] += begin[k]
    place, order = begin.copy(), np.empty(len(links.low), np.int64)
    for at in range(len(links.low)):
        order[place[links.low[at] + 1]] = at
        place[links.low[at] + 1] += 1
    pairs, found = np.empty((len(order), 2), np.int64), np.zeros((len(order), 5))
    last, made = np.full(count, -1, np.int64), 0
    for low in range(-1, count):
        before = made
        for at in order[begin[low + 1] : begin[low + 2]]:
            high, kind = links.high[at], links.kind[at]
            if last[high] < before:
                last[high] = made
                pairs[made, 0], pairs[made, 1] = low, high
                made += 1
            row = found[last[high]]
            row[4] += kind == _AT_CORNER
            if kind != _AT_CORNER:
                row[0] += 1.0
                row[1] += links.strength[at]
                row[2] += (kind & _ON_LINE) > 0
                row[3] += (kind & _ON_BARRIER) > 0
    return pairs[:made], found[:made]
