"""Following the ridge in small steps: the compiled loops of `ridge_tracing`.

Barriers are passed as a `BarrierMap`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.field.scale_field import EDGE_END_FRACTION
from cpm_core.image.regions import BarrierMap, crosses_barrier
from cpm_core.numerics.jit import compiled, inlined
from cpm_core.numerics.types import Array, Index
from cpm_core.reconstruction.curve.ridge import Ridge, interpolate_bilinear, slope_across_edge, uphill_direction

_MAX_STEP_HALVINGS = 4
"""Largest number of times that a step is halved where the ridge bends."""

_MAX_CHORD_DEVIATION = 0.03
"""Greatest distance of the sides of a contour from the traced ridge [px]."""

_SLOPE_DIFFERENCE = 0.05
"""Half the distance of the finite difference of the slope [px]."""

_MAX_CORRECTIONS = 8
"""Greatest number of corrections of a position onto the ridge."""

_CORRECTION_TOLERANCE = 1e-4
"""Move under which a position counts as on the ridge [px]."""

_MAX_SIDEWAYS = 0.7
"""Greatest correction to the side, in steps."""

_TRACING_TURN_COSINE = 0.7
"""Cosine of the largest turn from one step to the next (45 degrees)."""

_MEETING_DISTANCE = 0.6
"""Distance from a point at which it counts as reached, in steps."""


class RidgeSearchLimits(NamedTuple):
    """Lengths of a search [px], and the least edge strengths: of a loose end, and between two points."""

    step: float
    longest: float
    loose: float
    dip: float
    fading: float
    floor: float
    faintest: float


class RidgeSeeds(NamedTuple):
    """Points on the ridge, sorted into pixels.

    Attributes
    ----------
    place, ahead : ndarray, shape (N, 2)
        Positions [px], and the direction of the ridge there; zero where there is none.
    head : ndarray of int32, shape (H, W)
        First seed of each pixel, -1 for none.
    following : ndarray of int64, shape (N,)
        Next seed of the same pixel, -1 at the end.
    """

    place: Array
    ahead: Array
    head: NDArray[np.int32]
    following: Index


@compiled
def place_on_ridge(ridge: Ridge, place: Array, ahead: Array, step: float, first: int, last: int) -> None:
    """Move seeds `first` to `last`, shape (N, 2), onto the ridge, and write its direction there, shape (N, 2)."""
    farthest = _MAX_SIDEWAYS * step
    for i in range(first, last):
        down, right = uphill_direction(ridge, place[i, 0], place[i, 1])
        found, place[i, 0], place[i, 1] = _correct_onto_ridge(ridge, place[i, 0], place[i, 1], down, right, farthest)
        if found:
            found, ahead[i, 0], ahead[i, 1] = _ridge_direction(ridge, place[i, 0], place[i, 1])


@compiled
def trace_seed_paths(
    ridge: Ridge,
    barrier_map: BarrierMap,
    seeds: RidgeSeeds,
    limits: RidgeSearchLimits,
    numbers: Index,
    met: Index,
    sign: float,
    loose: bool,
    first: int,
    last: int,
    way: Array,
    vertices: Array,
    edges: Index,
) -> tuple[int, int, int]:
    """Trace paths from some of the seeds, until all are done or the output arrays are full.

    Returns the next seed to begin with, and the numbers of added vertices, shape (M, 2), and edges, shape (E, 2). The
    new vertices are numbered from -1 downward, since the number of earlier vertices is not yet known.
    """
    added, joined = 0, 0
    while first < last and added + len(way) < len(vertices) and joined + len(way) < len(edges):
        i = numbers[first]
        steps, other = _follow_ridge(ridge, barrier_map, seeds, i, sign, limits, way)
        met[first] = other
        first += 1
        if other >= 0:
            steps += 1
            way[steps, 0], way[steps, 1] = seeds.place[other, 0], seeds.place[other, 1]
        elif not loose:
            continue
        at, one = steps - steps, i  # a literal 0 would make Numba compile the function below once more
        while at < steps:
            ahead = _last_vertex_near_line(way, at, steps)
            to = other
            if other < 0 or ahead < steps:
                to = -1 - added
                vertices[added, 0], vertices[added, 1] = way[ahead, 0], way[ahead, 1]
                added += 1
            edges[joined, 0], edges[joined, 1] = one, to
            joined += 1
            at, one = ahead, to
    return first, added, joined


@compiled
def _last_vertex_near_line(way: Array, first: int, last: int) -> int:
    """Return the last vertex up to which all vertices of a path are near the straight line."""
    for end in range(first + 2, last + 1):
        down, right = way[end, 0] - way[first, 0], way[end, 1] - way[first, 1]
        squared = max(down * down + right * right, 1e-300)
        for k in range(first + 1, end):
            a, b = way[k, 0] - way[first, 0], way[k, 1] - way[first, 1]
            t = min(max((a * down + b * right) / squared, 0.0), 1.0)
            if (a - t * down) ** 2 + (b - t * right) ** 2 > _MAX_CHORD_DEVIATION**2:
                return end - 1
    return last


@inlined
def _follow_ridge(
    ridge: Ridge, barrier_map: BarrierMap, seeds: RidgeSeeds, i: int, sign: float, limits: RidgeSearchLimits, way: Array
) -> tuple[int, int]:
    """Follow the ridge from seed `i` ahead or back to the next one.

    Writes position, edge strength and arc length to `way`, those of the seed first. Returns the number of steps and the
    seed that was met; -1 for none, and then only the steps that are valid for a loose end.
    """
    row, col = seeds.place[i, 0], seeds.place[i, 1]
    down, right = sign * seeds.ahead[i, 0], sign * seeds.ahead[i, 1]
    way[0, 0], way[0, 1], way[0, 2], way[0, 3] = row, col, interpolate_bilinear(ridge.strength, row, col), 0.0
    barred = len(barrier_map.segments) > 0
    steps, loose, behind, before = 0, 0, 0, 0
    length, under, leaving = 0.0, 0.0, False
    while length < limits.longest and steps < len(way) - 2 and not leaving:
        if down == 0.0 and right == 0.0:
            break
        found, leaving, row, col, down, right = _advance_along_ridge(ridge, row, col, down, right, sign, limits.step)
        way[steps + 1, 0], way[steps + 1, 1] = row, col
        if not found or (barred and crosses_barrier(barrier_map, way[steps], way[steps + 1])):
            break
        steps += 1
        step = np.sqrt((row - way[steps - 1, 0]) ** 2 + (col - way[steps - 1, 1]) ** 2)
        length += step
        last = interpolate_bilinear(ridge.strength, row, col)
        way[steps, 2], way[steps, 3] = last, length
        while length - way[behind + 1, 3] > limits.fading:
            behind += 1
        while length - way[before + 1, 3] > 2.0 * limits.fading:
            before += 1
        under = 0.0 if last >= limits.floor else under + step
        if last < limits.faintest or last < EDGE_END_FRACTION * way[behind, 2] or under > limits.dip:
            break
        good = last >= max(limits.floor, EDGE_END_FRACTION * way[before, 2])
        if good and length <= limits.loose and loose == steps - 1:
            loose = steps
        met = _find_met_seed(seeds, i, sign, row, col, down, right, length, limits.step)
        if met >= 0 and not (barred and crosses_barrier(barrier_map, way[steps], seeds.place[met])):
            beyond = (row - seeds.place[met, 0]) * down + (col - seeds.place[met, 1]) * right
            return steps - 1 if beyond > 0.0 else steps, met
    return loose, -1


@compiled
def _find_met_seed(
    seeds: RidgeSeeds,
    i: int,
    sign: float,
    row: float,
    col: float,
    down: float,
    right: float,
    length: float,
    step: float,
) -> int:
    """Find the seed near a position on the path with the same direction; -1 for none."""
    near = _MEETING_DISTANCE * step
    best, nearest = -1, near * near
    for k in range(int(max(row - near, 0.0) + 0.5), int(min(row + near, seeds.head.shape[0] - 1.0) + 0.5) + 1):
        for m in range(int(max(col - near, 0.0) + 0.5), int(min(col + near, seeds.head.shape[1] - 1.0) + 0.5) + 1):
            j = seeds.head[k, m]
            while j >= 0:
                squared = (seeds.place[j, 0] - row) ** 2 + (seeds.place[j, 1] - col) ** 2
                along = sign * (seeds.ahead[j, 0] * down + seeds.ahead[j, 1] * right)
                if squared < nearest and along > 0.0 and (j != i or length > 4.0 * step):
                    best, nearest = j, squared
                j = seeds.following[j]
    return best


@compiled
def _advance_along_ridge(
    ridge: Ridge, row: float, col: float, down: float, right: float, sign: float, step: float
) -> tuple[bool, bool, float, float, float, float]:
    """Advance one step along the ridge.

    Returns whether the ridge continues, whether it leaves the image (the position is then at the image border), the
    position, and the direction there.
    """
    for _ in range(_MAX_STEP_HALVINGS + 1):
        to_row, to_col = row + step * down, col + step * right
        part = _fraction_inside(ridge.strength, row, col, to_row, to_col)
        if part < 1.0:
            to_row, to_col = _clip_to_image(ridge.strength, row, col, to_row, to_col, part)
            return (
                (to_row - row) ** 2 + (to_col - col) ** 2 > _CORRECTION_TOLERANCE**2,
                True,
                to_row,
                to_col,
                down,
                right,
            )
        found, to_row, to_col = _correct_onto_ridge(ridge, to_row, to_col, -right, down, _MAX_SIDEWAYS * step)
        if found:
            found, turned_down, turned_right = _ridge_direction(ridge, to_row, to_col)
            if found and sign * (turned_down * down + turned_right * right) >= _TRACING_TURN_COSINE:
                part = _fraction_inside(ridge.strength, row, col, to_row, to_col)
                to_row, to_col = _clip_to_image(ridge.strength, row, col, to_row, to_col, part)
                return True, part < 1.0, to_row, to_col, sign * turned_down, sign * turned_right
        step *= 0.5
    return False, False, row, col, down, right


@compiled
def _fraction_inside(image: Array, row: float, col: float, to_row: float, to_col: float) -> float:
    """Return the fraction of a straight line from a position in the image that lies inside."""
    part = 1.0
    rows, cols = image.shape
    for at, to, last in ((row, to_row, rows - 1.0), (col, to_col, cols - 1.0)):
        if to < 0.0:
            part = min(part, at / (at - to))
        elif to > last:
            part = min(part, (last - at) / (to - at))
    return part


@compiled
def _clip_to_image(
    image: Array, row: float, col: float, to_row: float, to_col: float, part: float
) -> tuple[float, float]:
    """Return the end of a straight line, cut off at the image border."""
    if part < 1.0:
        to_row = min(max(row + part * (to_row - row), 0.0), image.shape[0] - 1.0)
        to_col = min(max(col + part * (to_col - col), 0.0), image.shape[1] - 1.0)
    return to_row, to_col


@compiled
def _correct_onto_ridge(
    ridge: Ridge, row: float, col: float, down: float, right: float, farthest: float
) -> tuple[bool, float, float]:
    """Move a position along a direction to zero slope; also returns whether this exists within `farthest` [px]."""
    moved = 0.0
    e = _SLOPE_DIFFERENCE
    for _ in range(_MAX_CORRECTIONS):
        before, here = slope_across_edge(ridge, row - e * down, col - e * right), slope_across_edge(ridge, row, col)
        after = slope_across_edge(ridge, row + e * down, col + e * right)
        change = (after - before) / (2.0 * e)
        if change == 0.0:
            break
        move = min(max(-here / change, -farthest), farthest)
        moved += move
        row += move * down
        col += move * right
        if abs(moved) > farthest:
            break
        if abs(move) < _CORRECTION_TOLERANCE:
            return True, row, col
    return False, row, col


@compiled
def _ridge_direction(ridge: Ridge, row: float, col: float) -> tuple[bool, float, float]:
    """Return the direction of the ridge at a position, the brighter side always on the same hand; False off a ridge."""
    e = _SLOPE_DIFFERENCE
    down = slope_across_edge(ridge, row - e, col) - slope_across_edge(ridge, row + e, col)
    right = slope_across_edge(ridge, row, col - e) - slope_across_edge(ridge, row, col + e)
    size = np.sqrt(down * down + right * right)
    # toward the brighter side the slope decreases on a ridge and increases in a trough
    if down * interpolate_bilinear(ridge.down, row, col) + right * interpolate_bilinear(ridge.right, row, col) <= 0.0:
        return False, 0.0, 0.0
    return True, -right / size, down / size
