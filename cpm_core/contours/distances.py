"""How well contours agree with a boundary that is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour, lengths_along
from cpm_core.numerics.types import Array

SPACING = 0.25
"""Distance from sample to sample along the curves that are compared [px]."""

_WHOLE = 0.95
"""Share of each other's length that a closed contour and a true one must cover for the one to be the other."""

_PIECE = 1.0
"""Length that sides are cut down to, so that the nearest can be found by their middles [px]."""


@dataclass(frozen=True)
class Measures:
    """Agreement of contours with the truth.

    Attributes
    ----------
    recall : float
        Share of the true boundary's length with a contour within the tolerance; 1 when there is no boundary.
    precision : float
        Share of the contours' length that lies within the tolerance of the true boundary; 1 when there is no contour.
    distance : float
        Mean distance of the contours from the true boundary [px], all along them, wrong ones included; NaN when there
        is no contour or no boundary.
    closed : int
        True closed contours of which one closed contour was found: each covers 95 % of the other.
    wanted : int
        True closed contours.
    contours : int
        Contours found.
    """

    recall: float
    precision: float
    distance: float
    closed: int
    wanted: int
    contours: int

    @property
    def f(self) -> float:
        """Harmonic mean of recall and precision."""
        both = self.recall + self.precision
        return 2.0 * self.recall * self.precision / both if both else 0.0


def compare(contours: Sequence[Contour], truth: Sequence[Contour], tolerance: float = 1.0) -> Measures:
    """Measure contours against the true boundary.

    Parameters
    ----------
    contours : sequence of Contour
        What was found.
    truth : sequence of Contour
        The boundary, open and closed lines of it.
    tolerance : float
        Distance up to which two curves are taken for the same [px].

    Returns
    -------
    Measures
        Lengths are those of points every `SPACING` along the curves; distances are to the curves themselves.

    Raises
    ------
    ValueError
        When the tolerance is not above 0.
    """
    if not tolerance > 0.0:
        raise ValueError(f"tolerance is {tolerance:g} px but must be above 0.")
    found, true = _Lines(contours), _Lines(truth)
    missed, away = found.distance(true.samples), true.distance(found.samples)
    return Measures(
        recall=_share(missed, tolerance),
        precision=_share(away, tolerance),
        distance=float(away.mean()) if len(away) and len(missed) else float("nan"),
        closed=sum(_recovered(one, contours, tolerance) for one in truth if one.closed),
        wanted=sum(one.closed for one in truth),
        contours=len(contours),
    )


def distance_to(points: Array, contours: Sequence[Contour]) -> Array:
    """Distance of points to the nearest of some contours.

    Parameters
    ----------
    points : ndarray, shape (N, 2)
        Places (row, col) [px].
    contours : sequence of Contour
        Lines to measure to, closed ones with the side from their last vertex to their first.

    Returns
    -------
    ndarray, shape (N,)
        Distances to the lines, not to their vertices [px]; infinite when there are none.
    """
    return _Lines(contours).distance(np.asarray(points, dtype=float))


def sampled(contour: Contour, spacing: float = SPACING) -> Array:
    """Points evenly along a contour.

    Parameters
    ----------
    contour : Contour
        Line to follow.
    spacing : float
        Largest distance from one to the next along the line [px].

    Returns
    -------
    ndarray, shape (N, 2)
        The middles of N equal parts of its length.
    """
    path = contour.path
    length = lengths_along(path)
    count = max(1, int(np.ceil(length[-1] / spacing)))
    at = (np.arange(count) + 0.5) * length[-1] / count
    return np.stack([np.interp(at, length, path[:, axis]) for axis in range(2)], axis=1)


class _Lines:
    """Polygonal lines that many distances are measured to."""

    def __init__(self, contours: Sequence[Contour]) -> None:
        none = np.empty((0, 2))
        self.samples = np.concatenate([none, *map(sampled, contours)])
        paths = [contour.path for contour in contours]
        a = np.concatenate([none, *(path[:-1] for path in paths)])
        b = np.concatenate([none, *(path[1:] for path in paths)])
        pieces = np.maximum(1, np.ceil(np.linalg.norm(b - a, axis=1) / _PIECE)).astype(int)
        side = np.repeat(np.arange(len(a)), pieces)
        nth = (np.arange(len(side)) - np.repeat(np.cumsum(pieces) - pieces, pieces))[:, None]
        along = ((b - a) / pieces[:, None])[side]
        self._start, self._along = a[side] + nth * along, along
        self._tree = scipy.spatial.cKDTree(self._start + 0.5 * along) if len(side) else None

    def distance(self, points: Array) -> Array:
        """Distance of points, shape (N, 2), to the nearest line."""
        least = np.full(len(points), np.inf)
        if self._tree is None or not len(points):
            return least
        left, near = np.arange(len(points)), 4
        while len(left):
            near = min(near, self._tree.n)
            middles, pieces = map(np.asarray, self._tree.query(points[left], k=np.arange(1, near + 1)))
            least[left] = self._to_pieces(points[left], pieces).min(axis=1)
            # A piece that was not looked at has its middle beyond the last one, and reaches half its length nearer.
            left = left[middles[:, -1] - 0.5 * _PIECE < least[left]] if near < self._tree.n else left[:0]
            near *= 4
        return least

    def _to_pieces(self, points: Array, pieces: NDArray[np.intp]) -> Array:
        start, along = self._start[pieces], self._along[pieces]
        off = points[:, None, :] - start
        t = np.clip((off * along).sum(axis=-1) / np.maximum((along * along).sum(axis=-1), 1e-300), 0.0, 1.0)
        return np.asarray(np.linalg.norm(off - t[..., None] * along, axis=-1))


def _share(distances: Array, tolerance: float) -> float:
    return float((distances <= tolerance).mean()) if len(distances) else 1.0


def _recovered(true: Contour, contours: Sequence[Contour], tolerance: float) -> bool:
    """Whether one closed contour goes all along a true one and nowhere else."""
    line, samples = _Lines([true]), sampled(true)
    return any(
        _share(line.distance(sampled(one)), tolerance) >= _WHOLE
        and _share(_Lines([one]).distance(samples), tolerance) >= _WHOLE
        for one in contours
        if one.closed
    )
