"""Resolution: the size of a pixel, if a file states a plausible one."""

from __future__ import annotations

import math

MICROMETER = "µm"

PRINT_LIMIT = 10.0
"""Upper bound of a pixel size from a plain resolution tag [µm]; see `spacing_from_density`."""

_UNIT_NAMES = {
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
"""Names of units -> units."""

_METERS_PER_UNIT = {"nm": 1e-9, MICROMETER: 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0}
"""Length of each unit [m]."""

Spacing = tuple[tuple[float, float], str | None]
"""Size of a pixel along (row, col), and its unit."""

UNKNOWN_SPACING: Spacing = ((1.0, 1.0), None)
"""Spacing of an image whose pixel size is unknown."""


def spacing_from_sizes(row: float, col: float, unit: str) -> Spacing:
    """Return the spacing of pixel sizes in a named unit; unknown if a size or the unit is invalid."""
    name = find_unit(unit)
    if name is None or not all(math.isfinite(size) and size > 0 for size in (row, col)):
        return UNKNOWN_SPACING
    return (row, col), name


def conversion_factor(unit: str | None, other: str) -> float:
    """Return the factor that converts a unit to another known one; 0 for an unknown unit."""
    return _METERS_PER_UNIT.get(unit or "", 0.0) / _METERS_PER_UNIT[other]


def ascii_unit(unit: str | None, default: str) -> str:
    """Return a unit in ASCII, because many programs misread other letters in files."""
    return "um" if unit == MICROMETER else unit or default


def find_unit(name: str) -> str | None:
    """Return the unit of length with this name; None if there is none."""
    return _UNIT_NAMES.get(name.replace("\\u00B5", "\u00b5").strip().lower())


def long_unit_name(unit: str) -> str:
    """Return the long name of a unit of length, such as "micrometer"."""
    return next(name for name, known in _UNIT_NAMES.items() if known == unit and name.endswith("meter"))


def spacing_from_density(rows_per_meter: float, columns_per_meter: float) -> Spacing:
    """Return the spacing of a plain resolution tag, in pixels per meter.

    Cameras, screens and printers write 72, 96 or 300 dots per inch regardless of the content. Only a finer resolution,
    with pixels below `PRINT_LIMIT`, is taken for the pixel size on the specimen.
    """
    if not (rows_per_meter > 0 and columns_per_meter > 0):
        return UNKNOWN_SPACING
    row, col = 1e6 / rows_per_meter, 1e6 / columns_per_meter
    return spacing_from_sizes(row, col, MICROMETER) if max(row, col) < PRINT_LIMIT else UNKNOWN_SPACING
