"""Real numbers: the check of arrays that callers give."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.numerics.types import Array


def real_numbers(values: ArrayLike) -> Array:
    """Values in double precision, not copied if they are; ValueError when they are complex, text or objects.

    NumPy's own conversion drops the imaginary parts.
    """
    given = np.asarray(values)
    if given.size and given.dtype.kind not in "buif":
        raise ValueError(f"The values are of type {given.dtype} but must be real numbers.")
    return given.astype(np.float64, copy=False)
