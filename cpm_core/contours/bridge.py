"""Bridges: where the reconstruction has joined a contour across a gap in its edge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Bridge:
    """A stretch of a contour that no particle has found.

    Attributes
    ----------
    points : ndarray of float64, shape (K, 2)
        Vertices (row, col) in px of the image, from one side of the gap to the other, both included; those of the
        contour that it belongs to.
    length : float
        Length along it [px].
    strength : float
        Mean of the edge map along it [grey levels / px].
    """

    points: NDArray[np.float64]
    length: float
    strength: float
