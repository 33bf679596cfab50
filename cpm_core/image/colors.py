"""Colors: how a color image is shown, and its channels; the model works on the gray levels of one of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from skimage.color import rgb2hed

from cpm_core.numerics.types import Array
from cpm_core.parameters.choices import CHOICES, check_choice

_PRIMARIES = ("red", "green", "blue")
CONTRAST = "contrast"
"""What is asked for in place of the name of a channel when that shall be taken whose gray levels vary the most."""

_STAINS = ("hematoxylin", "eosin", "dab")

_DARKEST = 1e-6
"""Least light that `rgb2hed` distinguishes; it measures stains in units of its logarithm."""


@dataclass(frozen=True, eq=False, slots=True)
class Colors:
    """Red, green and blue of each pixel, one byte each.

    Attributes
    ----------
    samples : ndarray of uint8, shape (H, W, 3)
        From 0 to 255.
    white : float
        Gray level of the image that 255 stands for.
    """

    samples: NDArray[np.uint8]
    white: float


def channel_of(luminance: Array, colors: Colors | None, channel: str) -> Array:
    """Gray levels of one of the channels of `Parameters.channel`, shape (H, W).

    Parameters
    ----------
    luminance : ndarray, shape (H, W)
        The gray levels of the image: the answer for the channel "luminance", and for an image without colors.
    colors : Colors, optional
        Its colors.
    channel : str
        Name of the channel. That of a stain is the light that the stain alone lets through: dark where there is much.

    Returns
    -------
    ndarray of float64
        In the range of the file, computed from the colors for display: 8 bits each, also where the file has 16.

    Raises
    ------
    ValueError
        When there is no channel of this name.
    """
    check_choice(CHOICES["channel"], channel)
    if colors is None or channel == "luminance":
        return luminance
    if channel in _PRIMARIES:
        return np.multiply(colors.samples[..., _PRIMARIES.index(channel)], colors.white / 255.0, dtype=np.float64)
    return _through_stain(colors, _STAINS.index(channel))


def most_contrast(colors: Colors) -> str:
    """The channel, red, green or blue, whose gray levels vary the most: their standard deviation is the largest."""
    spread = [float(colors.samples[..., place].std(dtype=np.float64)) for place in range(len(_PRIMARIES))]
    return _PRIMARIES[int(np.argmax(spread))]


def _through_stain(colors: Colors, stain: int) -> Array:
    """Light that a stain alone lets through, from 0 to white."""
    light = np.empty(colors.samples.shape[:2])
    for row, line in zip(light, colors.samples, strict=True):  # without three more images of eight bytes a sample
        row[:] = colors.white * _DARKEST ** rgb2hed(line)[..., stain]
    return light
