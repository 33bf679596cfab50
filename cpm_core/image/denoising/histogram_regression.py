"""What grey levels tell of the region that a pixel lies in, more than by their height.

Where noise replaces pixels, the grey levels of objects that have kept theirs are more frequent than others, and tell
much; levels between them are noise and tell nothing, however high they are.
"""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.types import Array

_LEVELS = 256
"""Classes of grey levels."""

_PRIOR = 16.0
"""Pixels of the mean grey level that each class is taken to have besides its own."""


def expected(values: Array, estimate: Array) -> Array:
    r"""Replace each grey level by the mean of an estimate of the image over all pixels that have it.

    Parameters
    ----------
    values : ndarray, shape (\*shape)
        Noisy image, not constant.
    estimate : ndarray, shape (\*shape)
        What is held for the image without noise.

    Returns
    -------
    ndarray, shape (\*shape)
        The regression of the estimate on the grey levels, scaled so that steps between regions keep their height.
    """
    low, high = float(values.min()), float(values.max())
    classes = np.rint((values - low) * ((_LEVELS - 1) / (high - low))).astype(np.intp)
    mean = float(estimate.mean())
    count = np.bincount(classes.ravel(), minlength=_LEVELS)
    total = np.bincount(classes.ravel(), estimate.ravel() - mean, _LEVELS)
    told = (total / (count + _PRIOR))[classes]
    told -= told.mean()
    steps = float((told * estimate).sum())
    if steps <= 0.0:
        return values
    return np.asarray(values.mean() + told * (float(((values - values.mean()) * estimate).sum()) / steps))
