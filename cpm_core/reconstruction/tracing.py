"""Tracing the crest of the edges from point to point.

The crest is where the edge map is largest along the image gradient: where its slope in that direction is zero, and
falling. Such a zero line is a smooth curve without forks, and the gradient across it gives it a direction, bright on
one side all along. So each point has one point that follows it, which is found by walking along the crest in steps much
shorter than anything that outlives the smoothing: curves that run a pixel apart on both sides of a slit are never taken
for one, and no corner is cut, however far apart the points lie.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.kernels import compiled
from cpm_core.level import FAINTEST, Level
from cpm_core.neighbors import Cells, block, build_cells, squared_distance
from cpm_core.walls import Walls, crosses

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_STEP, _STEP_OF_SPACING = 0.4, 0.2
"""Length of a step: so much [px], and at most so much of the spacing."""

_HALVINGS = 4
"""Times that a step may be halved where the crest bends."""

_LONGEST, _LOOSE = 10.0, 5.0
"""Length, in d_min, of the crest between two points at most, and beyond a last one."""

_LONGEST_AT_REST = 50.0
"""The former at the end of a run: along a limb of two pixels the electric field has one place of rest for both sides,
and particles leave one of them empty."""

_DIP = 2.5
"""Length, in d_min, over which the crest between two points may be under the floor: a longer one is a gap."""

_DEVIATION = 0.03
"""Distance from the traced crest that the sides of a contour keep [px]."""

_PROBE, _DIFFERENCE = 0.3, 0.05
"""Distance on either side at which the slope of the edge map is read, and over which the slope's own is [px]."""

_ITERATIONS, _DONE = 8, 1e-4
"""Corrections of a place until it is on the crest, to so much [px]."""

_SIDEWAYS = 0.7
"""How far to the side a step may lead, in steps."""

_TURN = 0.7
"""Cosine of the largest turn from one step to the next (45 degrees)."""

_MEETING = 0.6
"""Distance from a point, in steps, at which it counts as reached."""

_FADING = 1.6
"""Length over which an edge must not fade to less than `FAINTEST`, in d_min / 2 [px]; for a loose end twice as much, as
a sudden end is blurred to."""


class _Ridge(NamedTuple):
    """What the crest is made of, shapes (H, W): the edge map, its spline, and the gradient's two parts."""

    strength: Array
    spline: Array
    down: Array
    right: Array


class _Reach(NamedTuple):
    """Lengths of a search [px], and the weakest edge strengths: of a loose end, and between two points."""

    step: float
    longest: float
    loose: float
    dip: float
    fading: float
    floor: float
    faintest: float


def trace(points: Array, level: Level, d_min: float, at_rest: bool = False) -> tuple[Array, Index]:
    """Join points on the crest along it.

    Parameters
    ----------
    points : ndarray, shape (N, 2)
        Distinct points on the crest, `crest` [px].
    level : Level
        Fields of the scale.
    d_min : float
        Spacing of particles [px]. From a point up to ten of it are walked to the next one, and five of it are kept
        where there is none.
    at_rest : bool
        Whether no more particles will come, so that up to fifty of it are walked.

    Returns
    -------
    vertices : ndarray, shape (M, 2)
        The points first, then what is needed between and beyond them for the contours to keep to the crest.
    edges : ndarray of int64, shape (E, 2)
        Pairs of vertices.
    """
    reach = _Reach(
        step=min(_STEP, _STEP_OF_SPACING * d_min),
        longest=(_LONGEST_AT_REST if at_rest else _LONGEST) * d_min,
        loose=_LOOSE * d_min,
        dip=_DIP * d_min,
        fading=0.5 * _FADING * d_min,
        floor=level.floor,
        faintest=FAINTEST * level.floor,
    )
    down, right = (np.ascontiguousarray(part) for part in level.gradient)
    ridge = _Ridge(np.ascontiguousarray(level.edge_map), np.ascontiguousarray(level.spline), down, right)
    return _trace(ridge, level.walls, np.ascontiguousarray(points, dtype=float), reach)


@compiled
def _trace(ridge: _Ridge, walls: Walls, seeds: Array, reach: _Reach) -> tuple[Array, Index]:
    """Ways from every seed to the next one, and loose ways from those that have none."""
    count = len(seeds)
    extent = np.array(ridge.strength.shape, dtype=np.int64)
    seeds = seeds.copy()
    ahead = np.zeros((count, 2))
    for i in range(count):
        down, right = _bilinear(ridge.down, seeds[i, 0], seeds[i, 1]), _bilinear(ridge.right, seeds[i, 0], seeds[i, 1])
        size = max(np.sqrt(down * down + right * right), 1e-300)
        if _correct(ridge, seeds[i], down / size, right / size, _SIDEWAYS * reach.step):
            _direction(ridge, seeds[i], ahead[i])
        for k in range(2):
            seeds[i, k] = min(max(seeds[i, k], 0.0), ridge.strength.shape[k] - 1.0)
    cells = build_cells(seeds, count, extent, max(1.0, reach.step))
    way = np.empty((int(2.0 * reach.longest / reach.step) + 2, 2))
    following = np.full(count, -1, np.int64)
    followed = np.zeros(count, np.bool_)
    vertices, edges = np.empty((2 * count + 16, 2)), np.empty((2 * count + 16, 2), np.int64)
    vertices[:count] = seeds
    filled = np.array([count, 0], dtype=np.int64)
    for i in range(count):
        steps, met = _follow(ridge, walls, cells, ahead, i, 1.0, reach, way)
        if met >= 0:
            following[i], followed[met] = met, True
            vertices, edges = _add(vertices, edges, filled, i, way, steps, met)
    for i in range(count):
        if not followed[i]:
            steps, met = _follow(ridge, walls, cells, ahead, i, -1.0, reach, way)
            if met >= 0:
                following[met] = i
            vertices, edges = _add(vertices, edges, filled, i, way, steps, met)
    for i in range(count):
        if following[i] < 0:
            steps, met = _follow(ridge, walls, cells, ahead, i, 1.0, reach, way)
            vertices, edges = _add(vertices, edges, filled, i, way, steps, met)
    return vertices[: filled[0]].copy(), edges[: filled[1]].copy()


@compiled
def _follow(
    ridge: _Ridge, walls: Walls, cells: Cells, ahead: Array, i: int, sign: float, reach: _Reach, way: Array
) -> tuple[int, int]:
    """Walk from seed `i` ahead, or back, to the next one.

    Returns the number of places written to `way` and the seed that was met; -1 for none, and then only places that are
    good for a loose end.
    """
    place, towards = cells.position[i].copy(), sign * ahead[i]
    steps, loose, behind, before = 0, 0, 0, 0
    length, under, leaving = 0.0, 0.0, False
    strengths, lengths = np.empty(len(way) + 1), np.empty(len(way) + 1)
    strengths[0], lengths[0] = _bilinear(ridge.strength, place[0], place[1]), 0.0
    while length < reach.longest and steps < len(way) and not leaving:
        if towards[0] == 0.0 and towards[1] == 0.0:
            break
        found, leaving = _advance(ridge, place, towards, sign, reach.step, way[steps])
        if not found or crosses(walls, place, way[steps]):
            break
        length += np.sqrt(squared_distance(way[steps], place))
        place[:] = way[steps]
        steps += 1
        last = _bilinear(ridge.strength, place[0], place[1])
        strengths[steps], lengths[steps] = last, length
        while length - lengths[behind + 1] > reach.fading:
            behind += 1
        while length - lengths[before + 1] > 2.0 * reach.fading:
            before += 1
        under = 0.0 if last >= reach.floor else under + length - lengths[steps - 1]
        if last < reach.faintest or last < FAINTEST * strengths[behind] or under > reach.dip:
            break
        good = last >= max(reach.floor, FAINTEST * strengths[before])
        if good and length <= reach.loose and loose == steps - 1:
            loose = steps
        met = _meets(cells, ahead, i, sign, place, towards, length, reach.step)
        if met >= 0 and not crosses(walls, place, cells.position[met]):
            beyond = place - cells.position[met]
            return steps - 1 if beyond[0] * towards[0] + beyond[1] * towards[1] > 0.0 else steps, met
    return loose, -1


@compiled
def _meets(
    cells: Cells, ahead: Array, i: int, sign: float, place: Array, towards: Array, length: float, step: float
) -> int:
    """Seed that lies at a place on the way and has the same direction; -1 for none."""
    best, nearest = -1, (_MEETING * step) ** 2
    for n in range(block(cells, place, 1, cells.around)):
        j = cells.head[cells.around[n]]
        while j >= 0:
            squared = squared_distance(cells.position[j], place)
            along = sign * (ahead[j, 0] * towards[0] + ahead[j, 1] * towards[1])
            if squared < nearest and along > 0.0 and (j != i or length > 4.0 * step):
                best, nearest = j, squared
            j = cells.following[j]
    return best


@compiled
def _advance(ridge: _Ridge, start: Array, towards: Array, sign: float, step: float, out: Array) -> tuple[bool, bool]:
    """One step along the crest, to `out`; `towards` is turned.

    Returns whether the crest goes on, and whether it leaves the image, at whose border `out` then is.
    """
    turned = np.empty(2)
    for _ in range(_HALVINGS + 1):
        for k in range(2):
            out[k] = start[k] + step * towards[k]
        if _cut(ridge, start, out):
            return squared_distance(start, out) > _DONE**2, True
        if (
            _correct(ridge, out, -towards[1], towards[0], _SIDEWAYS * step)
            and _direction(ridge, out, turned)
            and sign * (turned[0] * towards[0] + turned[1] * towards[1]) >= _TURN
        ):
            for k in range(2):
                towards[k] = sign * turned[k]
            return True, _cut(ridge, start, out)
        step *= 0.5
    return False, False


@compiled
def _cut(ridge: _Ridge, start: Array, end: Array) -> bool:
    """Cut a straight way at the border of the image; tell whether it led beyond."""
    part = 1.0
    for k in range(2):
        last = ridge.strength.shape[k] - 1.0
        if end[k] < 0.0:
            part = min(part, start[k] / (start[k] - end[k]))
        elif end[k] > last:
            part = min(part, (last - start[k]) / (end[k] - start[k]))
    if part == 1.0:
        return False
    for k in range(2):
        inside = start[k] + max(part, 0.0) * (end[k] - start[k])
        end[k] = min(max(inside, 0.0), ridge.strength.shape[k] - 1.0)
    return True


@compiled
def _correct(ridge: _Ridge, place: Array, down: float, right: float, farthest: float) -> bool:
    """Move a place along a direction to where the slope is zero; tell whether there is such a place within reach."""
    moved = 0.0
    e = _DIFFERENCE
    for _ in range(_ITERATIONS):
        row, col = place[0], place[1]
        before, after = _slope(ridge, row - e * down, col - e * right), _slope(ridge, row + e * down, col + e * right)
        change = (after - before) / (2.0 * e)
        if change == 0.0:
            return False
        move = min(max(-_slope(ridge, row, col) / change, -farthest), farthest)
        moved += move
        place[0] += move * down
        place[1] += move * right
        if abs(moved) > farthest:
            return False
        if abs(move) < _DONE:
            return True
    return False


@compiled
def _direction(ridge: _Ridge, place: Array, out: Array) -> bool:
    """Direction of the crest at a place on it, with the brighter side always on the same hand; False if it is none."""
    row, col, e = place[0], place[1], _DIFFERENCE
    down = _slope(ridge, row - e, col) - _slope(ridge, row + e, col)
    right = _slope(ridge, row, col - e) - _slope(ridge, row, col + e)
    size = np.sqrt(down * down + right * right)
    out[:] = 0.0
    # towards the brighter side the slope falls on a crest; in a trough it rises
    if down * _bilinear(ridge.down, row, col) + right * _bilinear(ridge.right, row, col) <= 0.0:
        return False
    out[0], out[1] = -right / size, down / size
    return True


@compiled
def _slope(ridge: _Ridge, row: float, col: float) -> float:
    """Difference of the edge map on both sides of a place, along the image gradient."""
    down, right = _bilinear(ridge.down, row, col), _bilinear(ridge.right, row, col)
    size = np.sqrt(down * down + right * right)
    if size == 0.0:
        return 0.0
    down *= _PROBE / size
    right *= _PROBE / size
    difference: float = _cubic(ridge.spline, row + down, col + right) - _cubic(ridge.spline, row - down, col - right)
    return difference


@compiled
def _bilinear(values: Array, row: float, col: float) -> float:
    """Bilinear interpolation; beyond the border as on it."""
    rows, cols = values.shape
    row, col = min(max(row, 0.0), rows - 1.0), min(max(col, 0.0), cols - 1.0)
    i, j = min(int(row), max(rows - 2, 0)), min(int(col), max(cols - 2, 0))
    s, t = row - i, col - j
    k, m = min(i + 1, rows - 1), min(j + 1, cols - 1)
    above = (1.0 - t) * values[i, j] + t * values[i, m]
    below = (1.0 - t) * values[k, j] + t * values[k, m]
    mixed: float = (1.0 - s) * above + s * below
    return mixed


@compiled
def _cubic(spline: Array, row: float, col: float) -> float:
    """Value of a cubic spline, from its coefficients."""
    rows, cols = spline.shape
    row, col = min(max(row, 0.0), rows - 1.0), min(max(col, 0.0), cols - 1.0)
    i, j = int(row), int(col)
    total = 0.0
    for k in range(4):
        line = spline[_mirrored(i + k - 1, rows)]
        along = 0.0
        for m in range(4):
            along += _weight(col - j, m) * line[_mirrored(j + m - 1, cols)]
        total += _weight(row - i, k) * along
    return total


@compiled
def _weight(t: float, k: int) -> float:
    """Cubic B-spline at a distance of `t + 1 - k` pixels."""
    if k == 0:
        return (1.0 - t) ** 3 / 6.0
    if k == 1:
        return (3.0 * t**3 - 6.0 * t**2 + 4.0) / 6.0
    if k == 2:
        return (-3.0 * t**3 + 3.0 * t**2 + 3.0 * t + 1.0) / 6.0
    return t**3 / 6.0


@compiled
def _mirrored(i: int, count: int) -> int:
    """Index of a pixel, or of its mirror image at the outermost ones."""
    i = abs(i)
    if i >= count:
        i = 2 * (count - 1) - i
    return min(max(i, 0), count - 1)


@compiled
def _add(vertices: Array, edges: Index, filled: Index, i: int, way: Array, steps: int, met: int) -> tuple[Array, Index]:
    """Join seed `i` to the one met, or to the last place of the way, by as few of its places as will do."""
    if steps == 0 and met < 0:
        return vertices, edges
    path = np.empty((steps + 2, 2))
    path[0] = vertices[i]
    path[1 : steps + 1] = way[:steps]
    last = steps
    if met >= 0:
        path[steps + 1] = vertices[met]
        last = steps + 1
    while filled[0] + steps > len(vertices):
        vertices = np.concatenate((vertices, np.empty_like(vertices)))
    while filled[1] + steps + 1 > len(edges):
        edges = np.concatenate((edges, np.empty_like(edges)))
    at, one = 0, i
    while at < last:
        ahead = at + 1
        while ahead < last and _straight(path, at, ahead + 1):
            ahead += 1
        other = met
        if met < 0 or ahead < last:
            other = filled[0]
            vertices[other] = path[ahead]
            filled[0] += 1
        edges[filled[1], 0], edges[filled[1], 1] = one, other
        filled[1] += 1
        at, one = ahead, other
    return vertices, edges


@compiled
def _straight(path: Array, first: int, last: int) -> bool:
    """Whether all places of a path between two of them lie next to the straight way from one to the other."""
    down, right = path[last, 0] - path[first, 0], path[last, 1] - path[first, 1]
    squared = max(down * down + right * right, 1e-300)
    for k in range(first + 1, last):
        a, b = path[k, 0] - path[first, 0], path[k, 1] - path[first, 1]
        t = min(max((a * down + b * right) / squared, 0.0), 1.0)
        if (a - t * down) ** 2 + (b - t * right) ** 2 > _DEVIATION**2:
            return False
    return True
