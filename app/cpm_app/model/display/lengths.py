"""Lengths in readable units, the scale bar, and round numbers.

One rule holds wherever a measured length or area is shown: `preferred_pixel_size` gives the size of a pixel in the unit
that the user prefers. What the user sets, such as parameters, is in px.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from cpm_app.model.text.language import localize_number, tr
from cpm_core.image import KNOWN_UNITS, ScaleBar, fit_scale_bar
from cpm_core.numerics.types import Sides, frozen

_PIXEL_UNIT = "px"
"""Name of the unit in which lengths need no size of a pixel."""

_IMAGE_UNIT = "image"
"""Name of the preference for the unit of the image."""

UNIT_TITLES = {
    _IMAGE_UNIT: tr("In the unit of the image"),
    _PIXEL_UNIT: tr("In px"),
    "nm": tr("In nm"),
    "µm": tr("In µm"),
    "mm": tr("In mm"),
    "cm": tr("In cm"),
}
"""Titles of the units that the user can prefer, by name."""

_preferred_unit = _IMAGE_UNIT


def prefer_unit(name: str) -> None:
    """Show lengths in a unit of `UNIT_TITLES`."""
    global _preferred_unit  # noqa: PLW0603  # one for all windows, as the language is
    _preferred_unit = name


@frozen
class PixelSize:
    """Size of a pixel in a unit, which is None for px; lengths in the unit of the image times `factor` are in it."""

    spacing: Sides
    unit: str | None
    factor: float = 1.0


def preferred_pixel_size(spacing: Sequence[float], unit: str | None) -> PixelSize:
    """Return the size of a pixel in the preferred unit.

    It stays in the unit of the image where that is no unit of length, and where lengths in px would depend on the
    direction because pixels are not square.
    """
    sizes = tuple(float(size) for size in spacing)
    if _preferred_unit == _PIXEL_UNIT and len(set(sizes)) == 1:
        return PixelSize((1.0,) * len(sizes), None, 1.0 / sizes[0])
    if unit in KNOWN_UNITS and _preferred_unit in KNOWN_UNITS:
        factor = KNOWN_UNITS[unit] / KNOWN_UNITS[_preferred_unit]
        return PixelSize(tuple(size * factor for size in sizes), _preferred_unit, factor)
    return PixelSize(sizes, unit)


def find_scale_bar(max_length: float, spacing: float, unit: str | None) -> ScaleBar:
    """Find the longest scale bar of round length, in a readable unit or in the preferred one; see `fit_scale_bar`."""
    return fit_scale_bar(max_length, spacing, unit, keep_unit=_preferred_unit != _IMAGE_UNIT)


def format_pixel_size(spacing: Sequence[float], unit: str | None) -> str:
    """Format the size of a pixel or voxel in the preferred unit; empty where it is unknown and equal along all axes."""
    size = preferred_pixel_size(spacing, unit)
    if size.unit is None and len(set(size.spacing)) == 1:
        return ""
    sides = " × ".join(localize_number(f"{side:.4g}") for side in size.spacing)
    return f"{sides} {size.unit}" if size.unit else sides


def format_length(pixels: float, spacing: float, unit: str | None) -> str:
    """Format a length in its unit, with four digits, or in whole pixels."""
    return localize_number(f"{pixels * spacing:.4g} {unit}") if unit else localize_number(f"{pixels:.0f} {_PIXEL_UNIT}")


def format_measured_length(pixels: float, spacing: Sequence[float], unit: str | None, decimals: int = 1) -> str:
    """Format a measured length in the preferred unit; in px where pixels are not square or their size is unknown."""
    size = preferred_pixel_size(spacing, unit)
    if size.unit is None or len(set(size.spacing)) > 1:
        return localize_number(f"{pixels:,.{decimals}f} {_PIXEL_UNIT}")
    return f"{format_measured(pixels * size.spacing[0])} {size.unit}"


def format_measured(value: float, digits: int = 4) -> str:
    """Format a number with some digits at least, and never with an exponent where it is large."""
    return localize_number(f"{value:,.0f}" if abs(value) >= 10 ** (digits - 1) else f"{value:.{digits}g}")


def round_up(value: float) -> float:
    """Return the smallest round number (1, 2 or 5 times a power of ten) that is not below a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    return next((factor * power for factor in (1.0, 2.0, 5.0) if factor * power >= value), 10.0 * power)


_SUPERSCRIPT_DIGITS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def format_scientific(value: float) -> str:
    """Format a very small or very large number, such as 3.1·10⁻⁴."""
    digits, _, exponent = f"{value:.1e}".partition("e")
    return f"{digits}·10{str(int(exponent)).translate(_SUPERSCRIPT_DIGITS)}"
