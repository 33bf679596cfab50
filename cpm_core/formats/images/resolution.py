"""Resolution: the size of a pixel, where a file gives a plausible one."""

from __future__ import annotations

import math

MICROMETER = "µm"

PRINT_LIMIT = 10.0
"""Largest pixel size that is accepted from a plain resolution tag [µm]; see `from_density`."""

_NAMES = {
    "um": MICROMETER,
    "\u00b5m": MICROMETER,
    "\u03bcm": MICROMETER,
    "micron": MICROMETER,
    "microns": MICROMETER,
    "micrometer": MICROMETER,
    "micrometre": MICROMETER,
    "nm": "nm",
    "nanometer": "nm",
    "mm": "mm",
    "millimeter": "mm",
    "cm": "cm",
    "centimeter": "cm",
    "m": "m",
    "meter": "m",
}

_METERS = {"nm": 1e-9, MICROMETER: 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0}

Spacing = tuple[tuple[float, float], str | None]
UNKNOWN: Spacing = ((1.0, 1.0), None)


def from_sizes(row: float, col: float, unit: str) -> Spacing:
    """Spacing from the size of a pixel in a named unit; unknown when a size or the unit is not valid."""
    name = known_unit(unit)
    if name is None or not all(math.isfinite(size) and size > 0 for size in (row, col)):
        return UNKNOWN
    return (row, col), name


def factor(unit: str | None, other: str) -> float:
    """How many of another known unit one unit is; 0 where it is not known."""
    return _METERS.get(unit or "", 0.0) / _METERS[other]


def in_ascii(unit: str | None, otherwise: str) -> str:
    """A unit of length for files, as many programs take other letters for a wrong encoding."""
    return "um" if unit == MICROMETER else unit or otherwise


def known_unit(name: str) -> str | None:
    """The unit of length that is meant by a name; None for others."""
    return _NAMES.get(name.replace("\\u00B5", "\u00b5").strip().lower())


def long_name(unit: str) -> str:
    """The name of a known unit of length without a short form, such as "micrometer"."""
    return next(name for name, known in _NAMES.items() if known == unit and name.endswith("meter"))


def from_density(rows_per_meter: float, columns_per_meter: float) -> Spacing:
    """Spacing from a plain resolution tag, in pixels a meter.

    Cameras, screens and printers write 72, 96 or 300 dots an inch, regardless of the content of the picture. Only a
    finer resolution, a pixel below `PRINT_LIMIT`, is taken for the size of a pixel on the specimen.
    """
    if not (rows_per_meter > 0 and columns_per_meter > 0):
        return UNKNOWN
    row, col = 1e6 / rows_per_meter, 1e6 / columns_per_meter
    return from_sizes(row, col, MICROMETER) if max(row, col) < PRINT_LIMIT else UNKNOWN
