"""Array types that the whole program shares; shapes and units are told where they are used."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Positions, forces, images: whatever is computed in double precision."""

Single = NDArray[np.float32]
"""Values in single precision, where that is enough and faster."""

Index = NDArray[np.int64]
"""Indices and counts."""

Mask = NDArray[np.bool_]
"""Which of some things are meant, or which pixels."""

Pixels = NDArray[np.uint8]
"""Pixels as they are shown, (H, W) or (H, W, 3)."""

Position = tuple[float, float]
"""A place (row, col) [px]."""
