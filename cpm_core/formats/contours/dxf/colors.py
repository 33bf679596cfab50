"""The numbered colors of DXF, and units by their numbers there."""

from __future__ import annotations

import colorsys
import math

from cpm_core.formats.contours.appearance import RGB

BY_BLOCK, BY_LAYER = 0, 256
BLACK_OR_WHITE = 7
"""Number of the color that is black on white paper and white on a dark screen."""

_NAMED = {
    1: (255, 0, 0),
    2: (255, 255, 0),
    3: (0, 255, 0),
    4: (0, 255, 255),
    5: (0, 0, 255),
    6: (255, 0, 255),
    BLACK_OR_WHITE: (255, 255, 255),
    8: (128, 128, 128),
    9: (192, 192, 192),
}
_GRAYS = {250: 0, 251: 101, 252: 102, 253: 153, 254: 204, 255: 255}
_VALUES = (255, 165, 127, 76, 38)
"""Brightness of the colors whose last digits are 0, 2, 4, 6 and 8; odd ones are half as saturated."""

UNITS: dict[int, tuple[float, str]] = {
    1: (25.4, "mm"),
    2: (304.8, "mm"),
    4: (1.0, "mm"),
    5: (1.0, "cm"),
    6: (1.0, "m"),
    7: (1000.0, "m"),
    9: (0.0254, "mm"),
    10: (914.4, "mm"),
    11: (0.1, "nm"),
    12: (1.0, "nm"),
    13: (1.0, "µm"),
    14: (100.0, "mm"),
}
"""Number of a unit in the header (``$INSUNITS``) -> how many of a unit that images have it is."""

NUMBER_OF: dict[str, int] = {"nm": 12, "µm": 13, "mm": 4, "cm": 5, "m": 6}
"""Unit of an image -> its number in the header."""


def color(number: int) -> RGB:
    """Red, green and blue of a numbered color, 1 to 255."""
    if number in _NAMED:
        return _NAMED[number]
    if number in _GRAYS:
        return (_GRAYS[number],) * 3
    shade, digit = divmod(number, 10)
    value = _VALUES[digit // 2]
    full = colorsys.hsv_to_rgb((shade - 1) / 24.0, 1.0, 1.0)
    lightest = 0.5 if digit % 2 else 0.0  # odd numbers are half way to gray of the same brightness
    red, green, blue = (int(value * (lightest + (1.0 - lightest) * part)) for part in full)
    return red, green, blue


def nearest(wanted: RGB) -> int:
    """Number of the color nearest to one; black and white have the same."""
    if wanted == (0, 0, 0):
        return BLACK_OR_WHITE
    return min(range(1, 256), key=lambda number: math.dist(color(number), wanted))
