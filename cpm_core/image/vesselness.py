"""A measure of vessels: the degree to which each pixel belongs to a long and thin structure.

Sato et al., "Three-dimensional multi-scale line filter for segmentation and visualization of curvilinear structures in
medical images", Medical Image Analysis 2 (1998), https://doi.org/10.1016/S1361-8415(98)80009-1. It differs from
`skimage.filters.sato` by the weight of the widths, and is 0 next to edges.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy
import skimage

from cpm_core.numerics.types import Array, Mask

_VESSEL_SIGMAS = (1.0, 2.0, 4.0)
"""Widths of the Gaussians whose second derivatives are taken [px]; a vessel responds most at a third of its width."""

_SIGMA_EXPONENT = 1.5
"""Power of sigma by which a curvature is multiplied: at 2 all widths would respond alike, and a wide vessel would hide
thin ones."""

_SIDE_DISTANCE = 2.0
"""Distance on both sides at which a line must differ from its surroundings, in sigmas."""

_CHANCE_QUANTILE = 0.98
"""Quantile of the contrast of lines of the other kind, found by chance alone, that a vessel exceeds somewhere."""

_FAINT_VESSEL_SHARE = 0.5
"""Fraction of that contrast that a vessel exceeds everywhere."""

_MIN_CHANCE_CONTRAST = 0.02
"""Least such contrast, as a fraction of the largest curvature: without noise, pixels alone make edges uneven."""

_REFLECTED_MARGIN = 5.0
"""Distance beyond the border to which the image is continued, in the largest sigma."""

_IGNORED_FRAME = 0.1
"""Border that does not decide whether vessels are dark or bright, as a fraction of each side: frames are there."""


class LineResponse(NamedTuple):
    """Response of dark lines, or of bright ones.

    Attributes
    ----------
    curvature : ndarray, shape (H, W)
        The largest answer of Sato's filter over several widths, in gray levels.
    contrast : ndarray, shape (H, W)
        The largest difference from both sides over the same widths, in gray levels: 0 at an edge, however high, since
        one of its sides is no brighter, and no darker.
    """

    curvature: Array
    contrast: Array

    def find_pixels_above_chance(self, other: LineResponse) -> Mask:
        """Find the pixels, shape (H, W), of lines with more contrast than lines of the other kind have by chance."""
        level = max(
            float(np.quantile(other.contrast, _CHANCE_QUANTILE)), _MIN_CHANCE_CONTRAST * float(self.curvature.max())
        )
        return skimage.filters.apply_hysteresis_threshold(self.contrast, _FAINT_VESSEL_SHARE * level, level)  # type: ignore[no-untyped-call]


def compute_vesselness(values: Array) -> Array:
    """Measure the vessels of an image, shape (H, W), in gray levels: large within vessels, 0 next to them.

    Vessels are the dark or the bright lines, whichever cover more of the image above chance.
    """
    middle = tuple(slice(int(_IGNORED_FRAME * n), n - int(_IGNORED_FRAME * n)) for n in values.shape)
    dark, bright = filter_lines(values)
    found = [(kind.find_pixels_above_chance(other), kind.curvature) for kind, other in ((dark, bright), (bright, dark))]
    mask, curvature = max(found, key=lambda pair: np.count_nonzero(pair[0][middle]))
    return np.where(mask, curvature, 0.0)


def filter_lines(values: Array) -> tuple[LineResponse, LineResponse]:
    """Filter an image, shape (H, W), for dark and for bright lines."""
    margin = round(_REFLECTED_MARGIN * _VESSEL_SIGMAS[-1])
    wider = np.pad(values, margin, mode="reflect", reflect_type="odd")  # a slope of light continues beyond the border
    place = np.indices(wider.shape, np.float64)
    dark, bright = (LineResponse(np.zeros_like(wider), np.zeros_like(wider)) for _ in range(2))
    for sigma in _VESSEL_SIGMAS:
        smooth = scipy.ndimage.gaussian_filter(wider, sigma, mode="nearest")
        down, right = (scipy.ndimage.correlate1d(smooth, (1.0, -2.0, 1.0), axis, mode="nearest") for axis in (0, 1))
        slope = scipy.ndimage.correlate1d(smooth, (-0.5, 0.0, 0.5), 0, mode="nearest")
        mixed = scipy.ndimage.correlate1d(slope, (-0.5, 0.0, 0.5), 1, mode="nearest")
        half = 0.5 * (down - right)
        apart, angle = np.hypot(half, mixed), 0.5 * np.arctan2(mixed, half)
        step = _SIDE_DISTANCE * sigma * np.stack([np.cos(angle), np.sin(angle)])
        for sign, across, kind in ((1.0, step, dark), (-1.0, step[::-1] * [[[-1.0]], [[1.0]]], bright)):
            np.maximum(
                kind.curvature, sigma**_SIGMA_EXPONENT * (0.5 * sign * (down + right) + apart), out=kind.curvature
            )
            beside = (
                scipy.ndimage.map_coordinates(sign * smooth, place + way, order=1, mode="nearest")
                for way in (across, -across)
            )
            bent = sign * (down + right) > 0.0  # more so across than along
            np.maximum(kind.contrast, bent * (np.minimum(*beside) - sign * smooth), out=kind.contrast)
    inner = slice(margin, -margin), slice(margin, -margin)
    return LineResponse(*(part[inner] for part in dark)), LineResponse(*(part[inner] for part in bright))
