"""Regression of an image on its gray levels.

Where noise replaces pixels by random gray levels, the gray levels of the objects are more frequent than the others.
These levels identify a region; the levels between them are noise and carry no information, whatever their height.
"""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.types import Array

_LEVELS = 256
"""Classes of gray levels."""

_PRIOR = 16.0
"""Pixels of the mean gray level that are added to each class."""


def expected(values: Array, estimate: Array) -> Array:
    r"""Replace each gray level of a noisy image by the mean of an estimate over the pixels that have it.

    `estimate` is an image without most of the noise. All arrays have the shape (\*shape), and `values` must not be
    constant. The result is scaled so that the steps between regions keep their height.
    """
    low, high = float(values.min()), float(values.max())
    classes = np.rint((values - low) * ((_LEVELS - 1) / (high - low))).astype(np.intp)
    mean = float(estimate.mean())
    count = np.bincount(classes.ravel(), minlength=_LEVELS)
    total = np.bincount(classes.ravel(), estimate.ravel() - mean, _LEVELS)
    fitted = (total / (count + _PRIOR))[classes]
    fitted -= fitted.mean()
    steps = float((fitted * estimate).sum())
    if steps <= 0.0:
        return values
    return np.asarray(values.mean() + fitted * (float(((values - values.mean()) * estimate).sum()) / steps))
