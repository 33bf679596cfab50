"""Changes: the part of a frame that differs from the one before."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def changed(last: NDArray[np.uint8] | None, frame: NDArray[np.uint8]) -> tuple[int, int, int, int]:
    """Find the rectangle of a frame that has changed.

    Parameters
    ----------
    last, frame : ndarray of uint8, shape (H, W, 3)
        The frame before, None for the first one, and the frame.

    Returns
    -------
    tuple of int
        Top, left, bottom and right, the latter two beyond it: all of the first frame, and a single pixel where nothing
        has changed, for a frame cannot be empty.
    """
    if last is None:
        return 0, 0, frame.shape[0], frame.shape[1]
    differs = (last != frame).any(axis=2)
    rows, cols = np.flatnonzero(differs.any(axis=1)), np.flatnonzero(differs.any(axis=0))
    if not len(rows):
        return 0, 0, 1, 1
    return int(rows[0]), int(cols[0]), int(rows[-1]) + 1, int(cols[-1]) + 1
