"""Outline of an object: its closed boundary, to a fraction of a pixel, and the stretches that follow no contour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour
from cpm_core.field.edge_map import edge_map
from cpm_core.field.interpolation import interpolate_field
from cpm_core.field.region_contrast import MeanContrast
from cpm_core.numerics import polyline
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.polyline import step_lengths
from cpm_core.numerics.types import Array, Arrays, Index, Mask, Single, record
from cpm_core.objects.boundaries.boundary_guides import BoundaryGuides
from cpm_core.objects.boundaries.crossings import Crossings

_ROW_STEPS = np.array([0, 1, 0, -1])
"""Rows of the steps to the right, down, left and up."""

_COL_STEPS = np.array([1, 0, -1, 0])
"""Columns of these steps."""

VERTEX_FREE = 0
"""Kind of a vertex placed by the edge map alone."""

VERTEX_ON_LINE = 1
"""Kind of a vertex on a line that crosses its link."""

VERTEX_ON_BORDER = 2
"""Kind of a vertex on the image border."""

_MIN_LINK_POSITION = 0.02
"""Lowest position of a vertex on its link, as a fraction of the link."""

_MAX_LINK_POSITION = 0.98
"""Highest position of a vertex on its link, as a fraction of the link."""

_SMOOTHING_SWEEPS = 12
"""Number of sweeps in which vertices are smoothed."""

_EDGE_WEIGHT = 4.0
"""Weight of the position of a strong edge, against 1 for the smoothness of the line."""

_MIDDLE_WEIGHT = 0.3
"""Weight of the middle of the link, against 1 for the smoothness of the line."""


class BoundaryLinks(NamedTuple):
    """Links between a mask and the outside, in the order of its outlines.

    Attributes
    ----------
    row, col : ndarray of int64, shape (N,)
        The true pixel of each link.
    direction : ndarray of int64, shape (N,)
        Step to the other pixel: 0 right, 1 down, 2 left, 3 up.
    first_link : ndarray of int64, shape (L + 1,)
        First link of each outline.
    """

    row: Index
    col: Index
    direction: Index
    first_link: Index


def trace_outlines(mask: Mask) -> BoundaryLinks:
    """Trace the outlines of a mask, shape (H, W), clockwise; pixels that share only a corner are apart."""
    wide = np.pad(mask, 1)
    return BoundaryLinks(*_trace_links(wide, sum(int(np.count_nonzero(np.diff(wide, axis=axis))) for axis in range(2))))


@compiled
def _trace_links(mask: Mask, total: int) -> tuple[Index, Index, Index, Index]:
    """Trace the fields of `BoundaryLinks` around a mask with a margin of one pixel; positions are without the margin.

    `total` is the number of links.
    """
    rows, cols = mask.shape
    seen = np.zeros((4, rows, cols), np.bool_)
    row, col, way = np.empty(total, np.int64), np.empty(total, np.int64), np.empty(total, np.int64)
    begin = np.zeros(total + 1, np.int64)
    at, lines = 0, 0
    for r in range(rows):
        for c in range(cols):
            if not mask[r, c]:
                continue
            for d in range(4):
                if seen[d, r, c] or mask[r + _ROW_STEPS[d], c + _COL_STEPS[d]]:
                    continue
                i, j, k = r, c, d
                while not seen[k, i, j]:
                    seen[k, i, j] = True
                    row[at], col[at], way[at] = i - 1, j - 1, k
                    at += 1
                    turn = (k + 1) % 4
                    if not mask[i + _ROW_STEPS[turn], j + _COL_STEPS[turn]]:
                        k = turn
                        continue
                    i, j = i + _ROW_STEPS[turn], j + _COL_STEPS[turn]
                    if mask[i + _ROW_STEPS[k], j + _COL_STEPS[k]]:
                        i, j, k = i + _ROW_STEPS[k], j + _COL_STEPS[k], (k + 3) % 4
                lines += 1
                begin[lines] = at
    return row, col, way, begin[: lines + 1]


def place_vertices(
    links: BoundaryLinks, crossings: Crossings, strength: Array, strong: float
) -> tuple[Array, NDArray[np.int8]]:
    """Place the vertices of outlines, shape (N, 2) [px], and tell what each lies on, shape (N,).

    Where a line crosses a link the vertex is there; at the border of the image half a pixel beyond the pixel; elsewhere
    at the largest edge strength on the link, the more exactly the stronger that edge is, so that weak edges leave the
    outline smooth.
    """
    place, target, weight = (np.empty(len(links.row)) for _ in range(3))
    kind = np.empty(len(links.row), np.int8)
    _find_targets(links, crossings.right, crossings.down, strength, strong, target, weight, kind)
    place[:] = target
    _smooth_vertices(links, place, target, weight, kind)
    out = np.stack(
        [links.row + place * _ROW_STEPS[links.direction], links.col + place * _COL_STEPS[links.direction]], axis=1
    )
    return out, kind


@compiled
def _find_targets(
    links: BoundaryLinks,
    right: Single,
    down: Single,
    strength: Array,
    strong: float,
    target: Array,
    weight: Array,
    kind: NDArray[np.int8],
) -> None:
    """Find the target of each vertex on its link, from the true pixel, its weight, and what the vertex lies on."""
    rows, cols = strength.shape
    for n in range(len(links.row)):
        r, c, d = links.row[n], links.col[n], links.direction[n]
        y, x = r + _ROW_STEPS[d], c + _COL_STEPS[d]
        kind[n], weight[n] = VERTEX_ON_BORDER, 0.0
        if not (0 <= y < rows and 0 <= x < cols):
            target[n] = 0.5
            continue
        crossings = right if d % 2 == 0 else down
        crossing = crossings[min(r, y), min(c, x)]
        if crossing >= 0.0:
            kind[n] = VERTEX_ON_LINE
            target[n] = min(max(crossing if d < 2 else 1.0 - crossing, _MIN_LINK_POSITION), _MAX_LINK_POSITION)
            continue
        kind[n] = VERTEX_FREE
        target[n], top = _find_edge_peak(strength, r, c, _ROW_STEPS[d], _COL_STEPS[d])
        edge = _EDGE_WEIGHT * min(top / strong, 1.0) ** 2
        weight[n] = edge + _MIDDLE_WEIGHT
        target[n] = (edge * target[n] + _MIDDLE_WEIGHT * 0.5) / weight[n]


@compiled
def _find_edge_peak(strength: Array, r: int, c: int, down: int, right: int) -> tuple[float, float]:
    """Find the place and size of the largest edge strength between a pixel and its neighbor.

    The edge strength across a blurred edge is a Gaussian, whose logarithm is a parabola through three samples.
    """
    rows, cols = strength.shape
    y, x = r + down, c + right
    at = 0.0 if strength[r, c] >= strength[y, x] else 1.0
    i, j = (r, c) if at == 0.0 else (y, x)
    before = np.log(strength[min(max(i - down, 0), rows - 1), min(max(j - right, 0), cols - 1)] + 1e-12)
    middle = np.log(strength[i, j] + 1e-12)
    after = np.log(strength[min(max(i + down, 0), rows - 1), min(max(j + right, 0), cols - 1)] + 1e-12)
    bend = before - 2.0 * middle + after
    shift = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    return min(max(at + min(max(shift, -1.0), 1.0), _MIN_LINK_POSITION), _MAX_LINK_POSITION), strength[i, j]


@compiled
def _smooth_vertices(links: BoundaryLinks, place: Array, target: Array, weight: Array, kind: NDArray[np.int8]) -> None:
    """Move free vertices on their links, so that the line bends little and stays near strong edges."""
    for line in range(len(links.first_link) - 1):
        first, count = links.first_link[line], links.first_link[line + 1] - links.first_link[line]
        if count < 8:
            continue
        for _ in range(_SMOOTHING_SWEEPS):
            for k in range(count):
                n = first + k
                if kind[n] != VERTEX_FREE:
                    continue
                wanted = 0.0
                for shift, factor in ((-2, -1.0), (-1, 4.0), (1, 4.0), (2, -1.0)):
                    m = first + (k + shift) % count
                    d = links.direction[m]
                    y = links.row[m] + place[m] * _ROW_STEPS[d] - links.row[n]
                    x = links.col[m] + place[m] * _COL_STEPS[d] - links.col[n]
                    wanted += factor / 6.0 * (y * _ROW_STEPS[links.direction[n]] + x * _COL_STEPS[links.direction[n]])
                mixed = (weight[n] * target[n] + wanted) / (weight[n] + 1.0)
                place[n] = min(max(mixed, _MIN_LINK_POSITION), _MAX_LINK_POSITION)


OBJECT_SMOOTHING = 1.0
"""Sigma of the edge map of objects [px]."""

_MAX_IGNORED_GAP = 2.0
"""Length up to which a stretch off the contours is no gap [px]."""


@record
class ObjectOutline:
    """A closed boundary.

    Attributes
    ----------
    contour : Contour
        The boundary.
    bridged : ndarray of bool, shape (K,)
        Whether the segment from each vertex to the next one follows no contour.
    """

    contour: Contour
    bridged: Mask

    @property
    def gaps(self) -> Arrays:
        """Stretches that follow no contour, each of shape (K, 2)."""
        path, bridged = self.contour.path, self.bridged
        if bridged.all():
            return (path,)
        start = int(np.argmin(bridged))
        path = np.concatenate([path[start:-1], path[: start + 1]])
        ends = np.flatnonzero(np.diff(np.roll(bridged, -start).astype(int), prepend=0, append=0))
        stretches = (path[begin : end + 1] for begin, end in ends.reshape(-1, 2).tolist())
        return tuple(stretch for stretch in stretches if polyline.path_length(stretch) > _MAX_IGNORED_GAP)


def compute_outlines(mask: Mask, guides: BoundaryGuides) -> tuple[ObjectOutline, ...]:
    """Compute the closed boundaries of the true pixels of a mask, shape (H, W), the longest first."""
    links = trace_outlines(mask)
    points, kind = place_vertices(links, guides.lines, guides.strength, guides.strong_edge_level)
    limit = np.array(mask.shape)[:, None] - 1
    found = []
    for begin, end in zip(links.first_link[:-1].tolist(), links.first_link[1:].tolist(), strict=True):
        part = slice(begin, end)
        row, col, way = links.row[part], links.col[part], links.direction[part]
        beyond = np.clip(np.stack([row + _ROW_STEPS[way], col + _COL_STEPS[way]]), 0, limit)
        free = (kind[part] == VERTEX_FREE) & ~guides.near_lines[row, col] & guides.interest[beyond[0], beyond[1]]
        vertices = points[part]
        edge = kind[part] == VERTEX_ON_BORDER
        corner = edge & np.roll(edge, -1) & (way != np.roll(way, -1))
        if corner.any():  # an object in the corner of the image has a corner
            pixel = np.stack([row, col], axis=1)
            places = vertices + np.roll(vertices, -1, axis=0) - pixel
            after = np.flatnonzero(corner) + 1
            vertices = np.insert(vertices, after, places[corner], axis=0)
            free = np.insert(free, after, False)
        found.append(_build_outline(vertices, free, guides))
    return tuple(sorted(found, key=lambda outline: -outline.contour.length))


def measure_strengths(values: Array, paths: Sequence[Array]) -> list[float]:
    """Measure the mean edge strength along paths, each of shape (K, 2) [px], as that of the boundaries of objects."""
    if not paths:
        return []
    strength = edge_map(values, OBJECT_SMOOTHING)[None]
    return [float(interpolate_field(strength, polyline.sample_path(path, 1.0)).mean()) for path in paths]


def _build_outline(points: Array, free: Mask, guides: BoundaryGuides) -> ObjectOutline:
    """Build the outline through vertices, with its strength, contrast and gaps."""
    path = np.concatenate([points, points[:1]])
    lengths = step_lengths(path)
    middle = 0.5 * (path[1:] + path[:-1])
    strength = float(interpolate_field(guides.strength[None], middle)[:, 0] @ lengths / lengths.sum())
    along = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    sides = MeanContrast(guides.values, points, along[:, ::-1] * (-1.0, 1.0), OBJECT_SMOOTHING)
    bridged = free & np.roll(free, -1)
    row, col = points.T
    hole = float(col @ np.roll(row, -1) - np.roll(col, -1) @ row) < 0.0  # the pixels are on the right hand
    contour = Contour(points, True, strength, measure_contrast=sides, hole=hole)
    found = ObjectOutline(contour, bridged)
    return replace(found, contour=replace(contour, bridged=sum(map(polyline.path_length, found.gaps))))
