"""Color: red, green, blue and alpha become one gray level."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.formats.images.decoded import full_scale

WEIGHTS = (0.2125, 0.7154, 0.0721)
"""Share of red, green and blue in the luminance (ITU-R BT.709)."""


def to_gray(samples: NDArray[Any], alpha: NDArray[Any] | None = None) -> tuple[NDArray[Any], tuple[str, ...]]:
    """Reduce the samples of each pixel to its gray level.

    Parameters
    ----------
    samples : ndarray, shape (H, W, 1) or (H, W, 3)
        Gray, or red, green and blue.
    alpha : ndarray, shape (H, W), optional
        Opacity from 0 to the full scale of its type. What is transparent shows white, as on paper.

    Returns
    -------
    values : ndarray, shape (H, W)
        Gray levels in the range of `samples`; gray samples that are opaque come back as they are.
    notes : tuple of str
        What was changed.
    """
    notes: list[str] = []
    first = samples[..., 0]
    if samples.shape[-1] == 1:
        gray = first
    elif np.array_equal(first, samples[..., 1]) and np.array_equal(first, samples[..., 2]):
        gray = first
        notes.append("Its three colour channels are the same; one was taken.")
    else:
        gray = samples.astype(np.float64) @ np.array(WEIGHTS)
        notes.append("Colour was turned into luminance.")
    if alpha is not None:
        opacity = alpha.astype(np.float64) / full_scale(alpha)
        if np.any(opacity != 1.0):
            gray = gray * opacity + full_scale(samples) * (1.0 - opacity)
            notes.append("Transparent parts were laid on white.")
    return gray, tuple(notes)
