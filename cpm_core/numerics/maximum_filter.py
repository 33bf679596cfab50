"""The largest value in the neighborhood of every pixel."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Values = TypeVar("Values", NDArray[np.float64], NDArray[np.bool_])


def running_maximum(values: Values, reach: int, axes: Sequence[int] | None = None) -> Values:
    r"""Maximum over a box around every pixel, cut off at the border.

    Whole arrays are compared with themselves moved by some pixels, one axis after the other, which for the small boxes
    that are needed here is several times faster than a filter that visits every pixel.

    Parameters
    ----------
    values : ndarray, shape (\*shape)
        Values on the pixels; of truth values, the maximum tells whether any is true.
    reach : int
        How far the box reaches to both sides [px].
    axes : sequence of int, optional
        Axes along which it does; all of them by default.

    Returns
    -------
    ndarray, shape (\*shape)
        Maxima.
    """
    for axis in range(values.ndim) if axes is None else axes:
        before = values
        values = before.copy()
        for shift in range(1, min(reach, values.shape[axis] - 1) + 1):
            ahead: tuple[slice, ...] = (slice(None),) * axis + (slice(shift, None),)
            behind: tuple[slice, ...] = (slice(None),) * axis + (slice(None, -shift),)
            np.maximum(values[ahead], before[behind], out=values[ahead])
            np.maximum(values[behind], before[ahead], out=values[behind])
    return values
