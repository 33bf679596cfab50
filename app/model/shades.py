"""Shades: what is shown of an image or an edge map, one byte a pixel, made before it reaches the window."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Shades = NDArray[np.uint8]


def of_image(values: Array) -> Shades:
    """Grey values from the least, 0, to the largest, 255."""
    low, high = float(values.min()), float(values.max())
    return _bytes((values - low) * (255.0 / max(high - low, 1e-300)))


def of_edge_map(edge_map: Array) -> Shades:
    """Edge strengths from none, 0, to the largest, 255; the square root brings out weak edges, which a user judges."""
    return _bytes(255.0 * np.sqrt(np.clip(edge_map / max(float(edge_map.max()), 1e-300), 0.0, 1.0)))


def _bytes(values: Array) -> Shades:
    return np.rint(values).astype(np.uint8)
