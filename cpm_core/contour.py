"""Contours: what the reconstruction finds and the writers write."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


def lengths_along(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Length of the way along a polygonal curve, shape (K, D), to each of its vertices [px]; the first is at 0."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


@dataclass(frozen=True, eq=False)
class Contour:
    """A polygonal curve through particles.

    Attributes
    ----------
    points : ndarray of float64, shape (K, 2)
        Vertices (row, col) in px of the image, in order along the curve.
    closed : bool
        Whether the last vertex is joined to the first; the first is not repeated.
    strength : float
        Mean of the edge map along the curve [grey levels / px].
    contrast : float
        Mean contrast of the regions on both sides, from 0 for two alike to 1 for two even ones, see `contrast`.
    junctions : tuple of two bool
        Whether the first and the last vertex lie on a junction that further contours share.
    """

    points: NDArray[np.float64]
    closed: bool
    strength: float = 0.0
    contrast: float = 0.0
    junctions: tuple[bool, bool] = (False, False)

    @property
    def path(self) -> NDArray[np.float64]:
        """Vertices with the first repeated at the end when the contour is closed."""
        return np.concatenate([self.points, self.points[:1]]) if self.closed else self.points

    @property
    def length(self) -> float:
        """Length along the curve [px]."""
        return float(np.linalg.norm(np.diff(self.path, axis=0), axis=1).sum())

    @property
    def area(self) -> float:
        """Enclosed area [px²]; 0 for an open curve."""
        if not self.closed:
            return 0.0
        row, col = self.points.T
        return 0.5 * abs(float(row @ np.roll(col, -1) - col @ np.roll(row, -1)))
