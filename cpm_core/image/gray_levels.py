"""Gray levels that can be computed with: without values that stand for no data, and in a range for single precision."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, Literal, NamedTuple

import numpy as np
import scipy
import skimage

from cpm_core.numerics.grids import Window, first_pixel, run_in_bands, whole_window
from cpm_core.numerics.types import Array, Extent, Index, Mask, Numbers

NO_DATA_VALUE = float(np.finfo(np.float64).min)
"""Gray level with which a reader marks pixels without data."""

_MIN_NO_DATA = 9e36
"""Size from which a value that occurs often, far from all others, stands for no data: 9.97e36, 3.4e38, 1.8e308."""

_MAX_LEVEL_WITH_NO_DATA = 1e-6
"""Largest gray level of an image with such values, as a fraction of `_MIN_NO_DATA`."""

_MAX_SPAN = 1e15
"""Largest span of gray levels, and the inverse of the smallest, that fields of single precision allow."""

_KNOWN_RIM = 2
"""Number of pixels up to which a known pixel lies next to an unknown one."""


def make_usable(values: Array, ends: tuple[float, float]) -> tuple[Array, tuple[str, ...]]:
    r"""Fill pixels without data from their surroundings, and bring extreme gray levels into a range for fields.

    A single value of 9e36 or more, far beyond all others, stands for no data: geographic and medical programs write it.
    Its replacement changes so slowly that it makes no edges. Gray levels whose span is above 1e15 or below 1e-15 are
    divided by a power of ten.

    Parameters
    ----------
    values : ndarray, shape (\*shape)
        Gray levels.
    ends : tuple of float
        Least and largest of them.

    Returns
    -------
    values : ndarray, shape (\*shape)
        Gray levels that fields can be computed of.
    notes : tuple of str
        What was changed, one sentence each.
    """
    notes: list[str] = []
    low, high = ends
    absent = _find_no_data(values) if max(-low, high) >= _MIN_NO_DATA else None
    if absent is not None:
        values = _fill_no_data(np.where(absent, 0.0, values), ~absent)
        notes.append(no_data_note(int(absent.sum())))
        low, high = float(values.min()), float(values.max())
    half = high / 2.0 - low / 2.0
    if half > 0.0 and not 1.0 / _MAX_SPAN <= 2.0 * half <= _MAX_SPAN:
        power = min(max(math.floor(math.log10(half)), -300), 307)
        values = values / 10.0**power
        notes.append(f"Its gray levels were divided by 1e{power:+d}, because they span {2.0 * half:.3g}."
                     if math.isfinite(2.0 * half) else f"Its gray levels were divided by 1e{power:+d}.")  # fmt: skip
    return values, tuple(notes)


def no_data_note(count: int) -> str:
    """Format the note on a number of pixels without data."""
    what = "1 pixel has" if count == 1 else f"{count} pixels have"
    return f"{what} no data, filled from around: contours there mean nothing."


def _find_no_data(values: Array) -> Mask | None:
    """Find the pixels without data; None when there are none."""
    absent = np.abs(values) >= _MIN_NO_DATA
    others = values[~absent]
    kinds = np.unique(values[absent])
    if len(kinds) != 1 or not others.size or np.abs(others).max() > _MAX_LEVEL_WITH_NO_DATA * _MIN_NO_DATA:
        return None
    if np.ptp(others) == 0.0 and kinds[0] != NO_DATA_VALUE:
        return None
    return absent


def _fill_no_data(values: Array, known: Mask) -> Array:
    """Replace unknown pixels by means of known ones next to unknown ones, of more of them the farther away they are.

    Known pixels beyond that rim would put the brightness of an object at some distance next to the background.
    """
    beside = known & scipy.ndimage.binary_dilation(~known, iterations=_KNOWN_RIM)
    return np.where(known, values, _spread_known_values(np.where(beside, values, 0.0), beside))


def _spread_known_values(values: Array, known: Mask) -> Array:
    """Spread the known values over all unknown pixels, together over those that lie together."""
    if known.all():
        return values
    weight = skimage.measure.block_reduce(known.astype(float), 2, np.sum)  # type: ignore[no-untyped-call]
    total = skimage.measure.block_reduce(values * known, 2, np.sum)  # type: ignore[no-untyped-call]
    coarse = _spread_known_values(total / np.maximum(weight, 1.0), weight > 0.0)
    between = skimage.transform.resize(coarse, values.shape, order=1, mode="edge", anti_aliasing=False)  # type: ignore[no-untyped-call]
    return np.where(known, values, between)


SPECK_REACH = 2
"""Distance of the pixels around a pixel that a speck on it, of up to three pixels a side, does not cover [px]."""

_RIM_WIDTH = 3
"""Width of the rim of an image that does not decide on its gray levels [px]."""

_MIN_SIDE_WITH_RIM = 32
"""Length of an axis from which an image may have a rim at its ends [px]."""

_EXAMINED_AT_ONCE = 4096
"""Number of the brightest pixels that are examined together."""


class GrayEnds(NamedTuple):
    """Least and largest gray level of an image, and of what is no speck in it; see `find_gray_ends`."""

    darkest: float
    dark: float
    bright: float
    brightest: float

    @property
    def usable(self) -> tuple[float, float]:
        """The least and the largest gray level that count; those of specks only as far as they change little."""
        span = self.bright - self.dark
        if span <= 0.0:  # there is nothing but specks
            return self.darkest, self.brightest
        return (
            self.darkest if self.darkest >= self.dark - span else self.dark,
            self.brightest if self.brightest <= self.bright + span else self.bright,
        )


def find_gray_ends(values: Array, part: Window | None = None, inside: Window | None = None) -> GrayEnds:
    r"""Find the ends of the gray levels of an image, shape (\*shape), or of the pixels in a part of it.

    A hot or dead pixel of a camera, a cosmic ray or the rim of a scan would decide which edges are strong. What is no
    speck lies `inside` the rim, and has a gray level in common with at least two of the pixels two apart, as any line
    has that passes through.
    """
    part, inside = part or whole_window(values.shape), inside or find_inside_rim(values.shape)
    own, flip = values[part], np.negative if values.dtype.kind == "f" else np.invert
    within = tuple(
        slice(start := max(here.start, free.start), max(min(here.stop, free.stop), start))
        for here, free in zip(part, inside, strict=True)
    )
    dark, bright = math.inf, -math.inf
    if values[within].size:
        dark = float(flip(_find_bright_end(flip(values), within, inside)))
        bright = float(_find_bright_end(values, within, inside))
    return GrayEnds(float(own.min()), dark, bright, float(own.max()))


def find_inside_rim(shape: Extent) -> Window:
    """Return the window of an image of this shape without the pixels next to its border, along its long axes."""
    rims = [_RIM_WIDTH if n >= _MIN_SIDE_WITH_RIM else 0 for n in shape]
    return tuple(slice(rim, n - rim) for rim, n in zip(rims, shape, strict=True))


def merge_gray_ends(parts: Iterable[GrayEnds]) -> GrayEnds:
    """Merge the ends of the gray levels of all parts of an image to those of the whole."""
    darkest, dark, bright, brightest = zip(*parts, strict=True)
    return GrayEnds(min(darkest), min(dark), max(bright), max(brightest))


def _find_bright_end(values: Array, part: Window, inside: Window) -> Any:
    """Return the largest gray level in a part of an image of what is no speck."""
    own = values[part]
    bright, count = own.min(), _EXAMINED_AT_ONCE
    # few pixels are brighter than the faintest of three in a row, of which the middle one can be no speck
    line = own[..., ::SPECK_REACH]
    if line.shape[-1] > SPECK_REACH:
        bright = np.minimum(np.minimum(line[..., :-2], line[..., 2:]), line[..., 1:-1]).max()
    rest = np.flatnonzero(own > bright)
    while len(rest):
        level = own.ravel()[rest]
        first = np.argpartition(level, -min(count, len(rest)))[-count:]
        places = np.stack(np.unravel_index(rest[first], own.shape), axis=1) + first_pixel(part)
        bright = max(bright, np.minimum(level[first], _second_largest_around(values, places, inside)).max())
        rest = np.delete(rest, first)
        rest, count = rest[own.ravel()[rest] > bright], 4 * count
    return bright


def _second_largest_around(values: Array, places: Index, inside: Window) -> Array:
    """Return the second largest of the gray levels two pixels from places, shape (N, D), as shape (N,)."""
    around = np.argwhere(np.ones((2 * SPECK_REACH + 1,) * values.ndim)) - SPECK_REACH
    at = places[:, None] + around[np.abs(around).max(axis=1) == SPECK_REACH]
    low, end = np.array([(side.start, side.stop) for side in inside]).T
    known = ((at >= low) & (at < end)).all(axis=-1)
    levels = values[tuple(np.moveaxis(np.where(known[..., None], at, places[:, None]), -1, 0))]
    return np.partition(np.where(known, levels, levels.min()), -2, axis=1)[:, -2]


def limit_to_usable(values: Array, ends: tuple[float, float]) -> Array:
    r"""Limit gray levels, shape (\*shape), to those that count, `GrayEnds.usable`."""
    low, high = (values.dtype.type(end) for end in ends)
    return values if values.min() >= low and values.max() <= high else np.clip(values, low, high)


def limit_specks(values: Array) -> Array:
    r"""Limit the gray levels of an image, shape (\*shape), so that no speck decides which edges are strong.

    Specks of up to three pixels a side that differ from all else by more than all else spans are limited to that span.
    """
    return limit_to_usable(values, find_gray_ends(values).usable)


_SAMPLE_SIZE = 1 << 20
"""Largest number of gray levels that percentiles are taken of; sorting all of them takes longer than a frame."""

_MIN_SHADES = 16
"""Least number of gray levels of a picture next to which a single other level is padding; masks have fewer."""


def sample_values(values: Array) -> Array:
    """Return gray levels of any shape, or of many every n-th along each axis, to take percentiles of."""
    step = math.ceil((values.size / _SAMPLE_SIZE) ** (1.0 / values.ndim))
    return values[(slice(None, None, step),) * values.ndim]


def find_shown_range(values: Array) -> tuple[float, float]:
    r"""Find the gray levels, of values of shape (\*shape), that are shown as black and as white.

    That is all of them but specks (`find_gray_ends`) and a single level at either end, as of padding, that are farther
    from all else than all else spans.
    """
    low, high = float(values.min()), float(values.max())
    sample = sample_values(values)
    usual = np.percentile(sample, [_LOW_PERCENTILE, _HIGH_PERCENTILE])
    if max(usual[0] - low, high - usual[1]) > usual[1] - usual[0]:
        low, high = find_gray_ends(values).usable
        span = high - low
        low = float(values.min(where=values >= low - span, initial=values.dtype.type(high)))
        high = float(values.max(where=values <= high + span, initial=values.dtype.type(low)))
    if len(np.unique(sample)) < _MIN_SHADES:
        return low, high
    darkest, brightest = values.dtype.type(low), values.dtype.type(high)
    first = float(values.min(where=values > darkest, initial=brightest))
    last = float(values.max(where=values < brightest, initial=darkest))
    absent = darkest if first - low > high - first > 0.0 else brightest if high - last > last - low > 0.0 else None
    if absent is None:
        return low, high
    usual_level = values.dtype.type(np.median(sample[sample != absent]))
    return find_shown_range(np.where(values == absent, usual_level, values))  # padding may hide specks


_LOW_PERCENTILE = 0.1
"""Percentile that counts as the lowest gray level, so that a few specks do not move it."""

_HIGH_PERCENTILE = 99.9
"""Percentile that counts as the highest gray level."""

_CENTRAL_MEDIAN = 0.2
"""Distance of the median from the middle of the range of gray levels, as a fraction of it, without any change."""

_OFF_CENTER_MEDIAN = 0.35
"""Distance of the median from the middle from which on the image counts as objects on a background."""

_GAMMA_ON_DARK = 0.5
"""Exponent on a dark background, where the square root gives counted photons the same noise everywhere."""

_GAMMA_ON_BRIGHT = 0.7
"""Exponent on a bright background."""


def automatic_gamma(values: Array) -> float:
    r"""Choose the exponent that suits the gray levels of an image, shape (\*shape): from 1/2 to 1.

    Where most pixels are almost as dark as the darkest, or as bright as the brightest, the image shows objects on a
    background. Their brightness differs by factors, and the exponent is 1/2 on a dark background, 0.7 on a bright one.
    Where the median is in the middle of the gray levels, the exponent is 1.
    """
    ends = (_LOW_PERCENTILE, 50.0, _HIGH_PERCENTILE)
    low, median, high = (float(level) for level in np.percentile(values, ends))
    if high <= low:
        return 1.0
    aside = (median - low) / (high - low) - 0.5
    share = min(max((abs(aside) - _CENTRAL_MEDIAN) / (_OFF_CENTER_MEDIAN - _CENTRAL_MEDIAN), 0.0), 1.0)
    return 1.0 - (1.0 - (_GAMMA_ON_DARK if aside < 0.0 else _GAMMA_ON_BRIGHT)) * share


def apply_gamma(values: Array, gamma: float | Literal["auto"]) -> Array:
    r"""Put gray levels on a power scale, ``low + range * ((I - low) / range)**gamma``, within the same range.

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
    if values.dtype.kind == "u":  # few gray levels, in images large enough to be kept in few bytes per pixel
        table = apply_gamma(np.maximum(np.arange(high + 1.0), low), exponent)
        shown: Numbers = np.empty(values.shape, np.float32)

        def look_up(first: int, end: int) -> None:
            shown[first:end] = table[values[first:end]]

        run_in_bands(look_up, len(values))
        return shown
    return apply_power(values, low, high, exponent)


def apply_power(values: Array, low: float, high: float, exponent: float) -> Array:
    """Put gray levels of any shape on a power scale within a range; see `apply_gamma`."""
    return low + (high - low) * ((values - low) / (high - low)) ** exponent
