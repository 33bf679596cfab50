"""Algorithm 1, part 1: from gray levels to the Lorentz force, in the plane and in space by the same lines.

Names are the symbols of the paper. What its text leaves open is an argument: how the field is computed, exactly or by
PPPM, and how it is normalized.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
import scipy

from cpm_core.field.convolution import convolved_field
from cpm_core.field.edge_map import vector_magnitudes
from cpm_core.field.scale_field import unit_vectors
from cpm_core.numerics.types import Array
from cpm_core.published.pppm import pppm_field


def fixed_charges(f: Array, sigma: float) -> Array:
    r"""Return the charge ``e = -|grad(G_sigma * f)|`` of every pixel of gray levels, shape (\*shape)."""
    f_smooth = scipy.ndimage.gaussian_filter(np.asarray(f, float), sigma, mode="nearest")  # line 1
    g = gradient_map(f_smooth)  # line 2
    return -vector_magnitudes(g)  # line 3


FIELDS: Mapping[str, Callable[[Array], Array]] = MappingProxyType(
    {"exact": lambda e: np.asarray(convolved_field(-e, 2.0)), "pppm": lambda e: pppm_field(-e)}
)
r"""How the field ``E``, shape (D, \*shape), is computed from charges, lines 4 and 5: by eq. (8), or by PPPM."""


def minima_charges(e_field: Array) -> Array:
    r"""Return a charge of -1 at each local minimum of the size of a field, shape (D, \*shape) (section 5.3, step 2).

    A minimum has, in its neighborhood of five pixels a side, at least 95 % of points with a value as large or larger.
    """
    size = vector_magnitudes(e_field)
    values = np.lib.stride_tricks.sliding_window_view(np.pad(size, 2, mode="edge"), (5,) * size.ndim)
    around = tuple(range(size.ndim, 2 * size.ndim))
    share = (values >= np.expand_dims(size, around)).mean(axis=around)
    return np.where(share >= 0.95, -1.0, 0.0)


def gradient_map(values: Array) -> Array:
    r"""Return the gradient, shape (D, \*shape), of values of shape (\*shape), by central differences."""
    return np.stack([np.gradient(values, axis=axis) for axis in range(values.ndim)])


def _divide_by_largest(vectors: Array) -> Array:
    return vectors / max(float(vector_magnitudes(vectors).max(initial=0.0)), 1e-300)


def _divide_by_mean(vectors: Array) -> Array:
    return vectors / max(float(vector_magnitudes(vectors).mean()), 1e-300) if vectors.size else vectors


NORMALIZATIONS: Mapping[str, Callable[[Array], Array]] = MappingProxyType(
    {"unit": unit_vectors, "largest": _divide_by_largest, "mean": _divide_by_mean}
)
r"""How forces, shape (D, \*shape), are normalized: to unit vectors, or by the largest or the mean of their lengths."""
