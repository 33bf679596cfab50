"""Colors: how a color image is shown; the model works on gray levels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False, slots=True)
class Colors:
    """Red, green and blue of each pixel, one byte each.

    Attributes
    ----------
    samples : ndarray of uint8, shape (H, W, 3)
        From 0 to 255.
    white : float
        Gray level of the image that 255 stands for.
    """

    samples: NDArray[np.uint8]
    white: float
