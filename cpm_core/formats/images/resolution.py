"""Resolution: the size of a pixel, if a file states a plausible one."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Sequence

from cpm_core.numerics.real_numbers import MAX_SIDE_RATIO

MICROMETER = "µm"

PRINT_LIMIT = 10.0
"""Upper bound of a pixel size from a plain resolution tag [µm]; see `spacing_from_density`."""

_METERS_PER_UNIT = {"nm": 1e-9, MICROMETER: 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0}
"""Units in which lengths are kept -> length of each [m]."""

_UNIT_NAMES: dict[str, tuple[float, str]] = {
    **dict.fromkeys(("pm", "picometer"), (1e-3, "nm")),
    **dict.fromkeys(("å", "angstrom", "ångstrom", "angström", "ångström"), (0.1, "nm")),
    **dict.fromkeys(("nm", "nanometer"), (1.0, "nm")),
    **dict.fromkeys(("um", "\u03bcm", "micron", "micrometer"), (1.0, MICROMETER)),
    **dict.fromkeys(("thou",), (25.4, MICROMETER)),
    **dict.fromkeys(("mm", "millimeter"), (1.0, "mm")),
    **dict.fromkeys(("in", "inch", "inche"), (25.4, "mm")),
    **dict.fromkeys(("cm", "centimeter"), (1.0, "cm")),
    **dict.fromkeys(("dm", "decimeter"), (10.0, "cm")),
    **dict.fromkeys(("ft", "foot", "feet"), (0.3048, "m")),
    **dict.fromkeys(("yd", "yard"), (0.9144, "m")),
    **dict.fromkeys(("m", "meter"), (1.0, "m")),
    **dict.fromkeys(("km", "kilometer"), (1000.0, "m")),
}
"""Name of a unit, as `_normalize_name` spells it -> its length in the unit in which such lengths are kept, and that."""

_ESCAPED_LETTER = re.compile(r"\\u([0-9a-f]{4})", re.IGNORECASE)
"""A letter as ImageJ writes it in a description."""

Spacing = tuple[tuple[float, float], str | None]
"""Size of a pixel along (row, col), and its unit."""

UNKNOWN_SPACING: Spacing = ((1.0, 1.0), None)
"""Spacing of an image whose pixel size is unknown."""


def spacing_from_sizes(sizes: Sequence[float], units: Sequence[str]) -> tuple[tuple[float, ...], str | None]:
    """Return the spacing of pixel sizes, each in a named unit, in the unit of the last one.

    A size without a unit is in that of the others. Sizes in one unit that is not known, as where none is named, keep
    their ratio: the last one becomes 1, without a unit. Invalid sizes, those in several units that are not all known,
    and ratios above `MAX_SIDE_RATIO`, become 1 each.
    """
    if all(math.isfinite(size) and size > 0.0 for size in sizes):
        named = next(filter(None, units), "")
        known = [found for unit in units if (found := _find_length(unit or named)) is not None]
        if len(known) == len(sizes):
            last = known[-1][1]
            factors = [factor * conversion_factor(unit, last) for factor, unit in known]
            return tuple(size * factor for size, factor in zip(sizes, factors, strict=True)), last
        alike = max(sizes) <= MAX_SIDE_RATIO * min(sizes)
        if not known and alike and len({unit or named for unit in units}) == 1:
            return tuple(size / sizes[-1] for size in sizes), None
    return (1.0,) * len(sizes), None


def conversion_factor(unit: str | None, other: str) -> float:
    """Return the factor that converts a unit to another known one; 0 for an unknown unit."""
    return _METERS_PER_UNIT.get(unit or "", 0.0) / _METERS_PER_UNIT[other]


def ascii_unit(unit: str | None, default: str) -> str:
    """Return a unit in ASCII, because many programs misread other letters in files."""
    return "um" if unit == MICROMETER else unit or default


def name_column(name: str, unit: str) -> str:
    """Name a column after what it has and the unit of that, such as ``area_um2``; without a unit, the name alone."""
    power = {"²": "2", "³": "3"}.get(unit[-1:], "")
    return f"{name}_{ascii_unit(unit.rstrip('²³'), '')}{power}" if unit else name


def find_unit(name: str) -> str | None:
    """Return the unit with this name in which lengths are kept; None if there is none."""
    factor, unit = _find_length(name) or (0.0, None)
    return unit if factor == 1.0 else None


def _find_length(name: str) -> tuple[float, str] | None:
    """Return the length of a named unit in a unit in which lengths are kept, and that; None for an unknown name."""
    return _UNIT_NAMES.get(_normalize_name(name))


def _normalize_name(name: str) -> str:
    """Spell the name of a unit in one way: lower case, singular, meter, one letter for µ and one for Å."""
    text = _ESCAPED_LETTER.sub(lambda found: chr(int(found[1], 16)), name)
    text = unicodedata.normalize("NFKC", text).casefold().strip().rstrip(".")
    return text.removesuffix("s").replace("metre", "meter")


def long_unit_name(unit: str) -> str:
    """Return the long name of a unit in which lengths are kept, such as "micrometer"."""
    return next(name for name, known in _UNIT_NAMES.items() if known == (1.0, unit) and name.endswith("meter"))


def spacing_from_density(rows_per_meter: float, columns_per_meter: float) -> Spacing:
    """Return the spacing of a plain resolution tag, in pixels per meter.

    Cameras, screens and printers write 72, 96 or 300 dots per inch regardless of the content. Only a finer resolution,
    with pixels below `PRINT_LIMIT`, is taken for the pixel size on the specimen; of any other only the ratio counts.
    """
    if not (rows_per_meter > 0 and columns_per_meter > 0):
        return UNKNOWN_SPACING
    row, col = 1e6 / rows_per_meter, 1e6 / columns_per_meter
    unit = MICROMETER if max(row, col) < PRINT_LIMIT else ""
    (row, col), known = spacing_from_sizes((row, col), (unit, unit))
    return (row, col), known
