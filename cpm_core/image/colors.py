"""Colors for display, and the channels of a color image; the model works on the gray levels of one of them."""

from __future__ import annotations

import re

import numpy as np
import skimage

from cpm_core.numerics.grids import run_in_bands
from cpm_core.numerics.types import Array, Numbers, Pixels, Texts, record
from cpm_core.parameters.choices import CHOICE_PARAMETERS, check_choice
from cpm_core.parameters.formatting import quote_value


def check_color(what: str, color: str) -> None:
    """Raise a `ValueError` unless a color has the form "#rrggbb"; `what` names its owner."""
    if color and not re.fullmatch("#[0-9A-Fa-f]{6}", color):
        raise ValueError(
            f'The color of {what} is {quote_value(color)} but must be "#rrggbb", two hexadecimal digits each for red, '
            "green and blue, or empty."
        )


_PRIMARY_COLORS = ("red", "green", "blue")
"""Names of the channels of a color image."""

LUMINANCE_WEIGHTS = (0.2125, 0.7154, 0.0721)
"""Share of red, green and blue in the luminance (ITU-R BT.709)."""

LUMINANCE_NOTE = "Color was turned into luminance."
"""Note on an image whose colors were reduced to luminance."""

LUMINANCE_CHOICE = "luminance"
"""Choice of the luminance in `COLOR_CHOICES`, and name of that channel."""

CONTRAST_CHOICE = "contrast"
"""Choice of the channel whose gray levels vary the most, in place of the name of a channel."""

COLOR_CHOICES = (LUMINANCE_CHOICE, *_PRIMARY_COLORS, CONTRAST_CHOICE)
"""Ways to make gray levels of colors."""

_STAIN_NAMES = ("hematoxylin", "eosin", "dab")
"""Names of the channels of `skimage.color.rgb2hed`."""

_MIN_LIGHT = 1e-6
"""Least light that `rgb2hed` distinguishes; it measures stains in units of its logarithm."""


@record
class Colors:
    """Red, green and blue of each pixel, one byte each.

    Attributes
    ----------
    samples : ndarray of uint8, shape (H, W, 3)
        From 0 to 255.
    white : float
        Gray level of the image that 255 stands for.
    """

    samples: Pixels
    white: float


def extract_channel(luminance: Array, colors: Colors | None, channel: str) -> Array:
    """Extract the gray levels of one of the channels of `Parameters.channel`, shape (H, W).

    Parameters
    ----------
    luminance : ndarray, shape (H, W)
        The gray levels of the image: the answer for the channel "luminance", and for an image without colors.
    colors : Colors, optional
        Its colors.
    channel : str
        Name of the channel. A stain's channel is the light that this stain alone transmits: dark where there is much.

    Returns
    -------
    ndarray of float64
        In the range of the file, computed from the colors for display: 8 bits each, also where the file has 16.

    Raises
    ------
    ValueError
        When there is no channel of this name.
    """
    check_choice(CHOICE_PARAMETERS["channel"], channel)
    if colors is None or channel == "luminance":
        return luminance
    if channel in _PRIMARY_COLORS:
        return np.multiply(colors.samples[..., _PRIMARY_COLORS.index(channel)], colors.white / 255.0, dtype=np.float64)
    light = np.empty(colors.samples.shape[:2])
    for row, line in zip(light, colors.samples, strict=True):  # without three more images of eight bytes a sample
        row[:] = colors.white * _MIN_LIGHT ** skimage.color.rgb2hed(line)[..., _STAIN_NAMES.index(channel)]
    return light


ReducedSamples = tuple[Numbers, Colors | None, Texts]
"""Gray levels of pixels of several samples, their colors where they have any, and notes on the conversion."""


def full_scale(values: Numbers) -> float:
    """Return the gray level of white: the largest value of an integer type, else 1 or the largest value."""
    if values.dtype.kind == "b":
        return 1.0
    if values.dtype.kind in "ui":
        return float(np.iinfo(values.dtype).max)
    return float(np.fmax.reduce(values, axis=None, initial=1.0))  # without NaN


def reduce_to_gray(samples: Numbers, alpha: Numbers | None = None, white: float | None = None) -> ReducedSamples:
    """Reduce the samples of each pixel to its gray level.

    Parameters
    ----------
    samples : ndarray, shape (H, W, 1) or (H, W, 3)
        Gray, or red, green and blue.
    alpha : ndarray, shape (H, W), optional
        Opacity from 0 to the full scale of its type. Transparent parts become white, as on paper.
    white : float, optional
        Value of white; by default that of the type of `samples`.

    Returns
    -------
    ReducedSamples
        Gray levels in the range of `samples`, of opaque gray samples unchanged, and the channels of colored ones.
    """
    said: list[str] = []
    count, shape = samples.shape[-1], samples.shape[:2]
    alike = all(np.array_equal(line[:, 0], line[:, other]) for line in samples for other in range(1, count))
    white = full_scale(samples) if white is None else white
    if not alike:
        said.append(LUMINANCE_NOTE)
    elif count > 1:
        said.append("Its three color channels are the same; one was taken.")
    opaque = alpha is None or bool(np.all(alpha == full_scale(alpha)))
    if not opaque:
        said.append("Transparent parts were laid on white.")
    if alike and opaque:
        return samples[..., 0], None, tuple(said)
    gray = np.empty(shape)
    in_bytes = opaque and samples.dtype == np.uint8  # these are the colors
    colors = None if alike else Colors(samples if in_bytes else np.empty((*shape, count), np.uint8), white)

    def reduce_rows(first: int, end: int) -> None:  # without more images of eight bytes a sample
        line = samples[first:end]
        if alpha is not None and not opaque:
            opacity = alpha[first:end, :, None] / full_scale(alpha)
            line = line * opacity + white * (1.0 - opacity)
        gray[first:end] = line[..., 0] if colors is None else compute_luminance(line)
        if colors is not None and not in_bytes:
            shares = np.asarray(np.clip(line, 0.0, white), float) / white
            colors.samples[first:end] = np.rint(np.nan_to_num(255.0 * shares))

    run_in_bands(reduce_rows, shape[0])
    gray.flags.writeable = False  # an image takes them over
    return gray, colors, tuple(said)


def compute_luminance(channels: Numbers) -> Array:
    """Compute the luminance, shape (...), of red, green and blue, shape (..., 3), in their range."""
    gray = np.zeros(channels.shape[:-1])
    for channel, weight in enumerate(LUMINANCE_WEIGHTS):
        gray += np.float64(weight) * channels[..., channel]  # of half precision too
    return gray


def gray_from_color(luminance: Numbers, colors: Colors, color: str) -> tuple[Array, str]:
    """Compute gray levels, shape (H, W), by another one of `COLOR_CHOICES` than luminance, and say so in a sentence."""
    varies = ""
    if color == CONTRAST_CHOICE:
        spread = [float(colors.samples[..., place].std(dtype=np.float64)) for place in range(len(_PRIMARY_COLORS))]
        color, varies = _PRIMARY_COLORS[int(np.argmax(spread))], ", which varies the most"
    return extract_channel(luminance, colors, color), f"The channel {color} of its colors was taken{varies}."


def check_color_choice(given: object) -> str:
    """Check the choice of how gray levels are made of color; raise ValueError unless it is in `COLOR_CHOICES`."""
    if not isinstance(given, str) or given not in COLOR_CHOICES:
        raise ValueError(f"color is {quote_value(given)} but must be one of {', '.join(COLOR_CHOICES)}.")
    return given
