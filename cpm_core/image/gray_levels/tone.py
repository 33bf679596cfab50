"""The tone of an image: gray levels on a power scale, so that edges among dark and among bright ones count alike.

A detector counts photons: an object that is ten times as bright as another has edges ten times as strong, though they
are no clearer. Photographs are stored on such a scale already.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from cpm_core.numerics.types import Array

_DARKEST, _BRIGHTEST = 0.1, 99.9
"""Percentiles that count as the ends of the gray levels, so that a few specks do not move them."""

_MIDDLE, _END = 0.2, 0.35
"""Distances of the median from the middle of the gray levels, as fractions of their range: up to the first one nothing
is changed, from the second one on the image counts as objects on a background."""

_ON_DARK, _ON_BRIGHT = 0.5, 0.7
"""Exponents on a dark background, where the square root gives counted photons the same noise everywhere, and on a
bright one."""


def automatic_gamma(values: Array) -> float:
    r"""Exponent that suits the gray levels of an image, shape (\*shape): from 1/2 to 1.

    Where most pixels are almost as dark as the darkest, or as bright as the brightest, the image shows objects on a
    background. Their brightness differs by factors, and the exponent is 1/2 on a dark background, 0.7 on a bright one.
    Where the median is in the middle of the gray levels, the exponent is 1.
    """
    ends = (_DARKEST, 50.0, _BRIGHTEST)
    low, median, high = (float(level) for level in np.percentile(values, ends))
    if high <= low:
        return 1.0
    aside = (median - low) / (high - low) - 0.5
    share = min(max((abs(aside) - _MIDDLE) / (_END - _MIDDLE), 0.0), 1.0)
    return 1.0 - (1.0 - (_ON_DARK if aside < 0.0 else _ON_BRIGHT)) * share


def toned(values: Array, gamma: float | Literal["auto"]) -> Array:
    r"""Gray levels on a power scale, ``low + range * ((I - low) / range)**gamma``, within the same range.

    Parameters
    ----------
    values : ndarray, shape (\*shape)
        Image.
    gamma : float or "auto"
        Exponent; ``"auto"`` takes `automatic_gamma`. With 1 the image itself is returned.

    Returns
    -------
    ndarray, shape (\*shape)
        Image with the same darkest and brightest gray level.
    """
    exponent = automatic_gamma(values) if gamma == "auto" else float(gamma)
    low, high = float(values.min()), float(values.max())
    if exponent == 1.0 or high <= low:
        return values
    return np.asarray(low + (high - low) * ((values - low) / (high - low)) ** exponent)
