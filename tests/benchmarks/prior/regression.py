"""Logistic regression, and how well what it shows holds."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.types import Array

TIGHT = 1e-3
"""How much large numbers are held back."""


def learned(features: Array, right: Array, weights: Array, *, has_offset: bool = True) -> Array:
    """Numbers of a logistic regression, the offset last, which may be held at 0, by Newton's method.

    Those of features that vary less are held back less, as their unit does not matter.
    """
    wide = np.column_stack([features, np.ones(len(features))]) if has_offset else features
    numbers, tight = np.zeros(wide.shape[1]), TIGHT * weights.sum() * np.diag(wide.var(axis=0))
    for _ in range(50):
        likely = scipy.special.expit(wide @ numbers)
        slope = wide.T @ (weights * (right - likely)) - tight @ numbers
        bend = wide.T @ (wide * (weights * likely * (1.0 - likely))[:, None]) + tight
        numbers += np.linalg.solve(bend, slope)
    return numbers if has_offset else np.append(numbers, 0.0)


def curve(shown: Array, right: Array) -> str:
    """Share of right answers among those shown as so and so sure, and how many there are."""
    cells = []
    for low, high in zip((0.0, 0.2, 0.4, 0.6, 0.8), (0.2, 0.4, 0.6, 0.8, 1.01), strict=True):
        on = (shown >= low) & (shown < high)
        cells.append(f"{shown[on].mean():.2f}/{right[on].mean():.2f}/{on.sum()}" if on.any() else "-")
    return "  ".join(cells)
