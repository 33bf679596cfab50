"""A measure of vessels: how much each pixel belongs to something long and thin.

Sato et al., "Three-dimensional multi-scale line filter for segmentation and visualization of curvilinear structures in
medical images", Medical Image Analysis 2 (1998), https://doi.org/10.1016/S1361-8415(98)80009-1. In the plane it
differs from `skimage.filters.sato`, whose import alone takes longer than a run, by the weight of the widths.
"""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.types import Array

_SIGMAS = (1.0, 2.0, 4.0)
"""Widths of the Gaussians whose second derivatives are taken [px]; a vessel answers most to a third of its width."""

_NORMALIZATION = 1.5
"""Power of sigma that a curvature is multiplied by: with 2 all widths would answer alike, and a wide vessel would hide
thin ones."""

_MARGIN = 5.0
"""Distance beyond the border to which the image is continued, in the largest sigma."""

_RIM = 0.1
"""Border that does not decide whether vessels are dark or bright, as a fraction of each side: frames are there."""


def vesselness(values: Array) -> Array:
    r"""Vessel measure of an image, shape (\*shape), in gray levels: large within vessels, 0 next to them.

    The largest answer of Sato's filter over several widths. Whether vessels are darker or brighter than what is around
    them is taken from the image: the answer with the larger mean cube counts, in which few strong lines weigh most.
    """
    margin = round(_MARGIN * _SIGMAS[-1])
    wider = np.pad(values, margin, mode="reflect", reflect_type="odd")  # a slope of light continues beyond the border
    curvatures = [_curvatures(wider, sigma) for sigma in _SIGMAS]
    inner = (slice(margin, -margin),) * values.ndim
    dark = np.maximum(np.max([highest[inner] for _, highest in curvatures], axis=0), 0.0)
    bright = np.maximum(np.max([-lowest[inner] for lowest, _ in curvatures], axis=0), 0.0)
    middle = tuple(slice(int(_RIM * n), n - int(_RIM * n)) for n in values.shape)
    return np.asarray(dark if (dark[middle] ** 3).mean() >= (bright[middle] ** 3).mean() else bright)


def _curvatures(values: Array, sigma: float) -> tuple[Array, Array]:
    r"""Curvature of the smoothed image across bright and across dark lines, normalized, each shape (\*shape).

    In the plane the smallest and the largest eigenvalue of the Hessian. In a volume the second smallest and second
    largest, since the curvature of a tube is high in both directions across it.
    """
    axes = values.ndim
    smooth = scipy.ndimage.gaussian_filter(values, sigma, mode="nearest")
    hessian = np.empty((*values.shape, axes, axes))
    for i in range(axes):
        hessian[..., i, i] = scipy.ndimage.correlate1d(smooth, (1.0, -2.0, 1.0), i, mode="nearest")
        slope = scipy.ndimage.correlate1d(smooth, (-0.5, 0.0, 0.5), i, mode="nearest")
        for j in range(i + 1, axes):
            mixed = scipy.ndimage.correlate1d(slope, (-0.5, 0.0, 0.5), j, mode="nearest")
            hessian[..., i, j] = hessian[..., j, i] = mixed
    if axes > 2:
        eigenvalues = np.linalg.eigvalsh(hessian)
    else:  # many times as fast as LAPACK
        first, last, mixed = hessian[..., 0, 0], hessian[..., 1, 1], hessian[..., 0, 1]
        middle, half = 0.5 * (first + last), 0.5 * (first - last)
        apart = np.sqrt(half * half + mixed * mixed)
        eigenvalues = np.stack([middle - apart, middle + apart], axis=-1)
    eigenvalues *= sigma**_NORMALIZATION
    return np.asarray(eigenvalues[..., axes - 2], float), np.asarray(eigenvalues[..., 1 - axes], float)
