"""Measures in words, and what they measure in an image, found once for all that show it."""

from __future__ import annotations

from weakref import WeakKeyDictionary

from cpm_app.model.display.lengths import format_measured, preferred_pixel_size
from cpm_app.model.text.language import localize_number
from cpm_core import Image
from cpm_core.shapes import Measure, MeasuredValues

_MAX_KNOWN_VALUES = 1000
"""Number of measures after which those of an image are forgotten, as a drag makes many."""

_known_values: WeakKeyDictionary[Image, dict[tuple[Measure, str], MeasuredValues]] = WeakKeyDictionary()


def measure_in_image(shape: Measure, image: Image, channel: str) -> MeasuredValues:
    """Measure in a channel of an image."""
    known = _known_values.setdefault(image, {})
    if (shape, channel) not in known:
        if len(known) >= _MAX_KNOWN_VALUES:
            known.clear()
        known[shape, channel] = shape.measure(image, channel)
    return known[shape, channel]


def describe_measure(shape: Measure, image: Image, channel: str) -> str:
    """Describe what a measure measures, in the preferred unit: length, angle, or mean, deviation and area."""
    found, size = measure_in_image(shape, image, channel), preferred_pixel_size(image.spacing, image.unit)
    unit = size.unit or "px"
    parts = []
    if found.length is not None:
        parts.append(f"{format_measured(size.factor * found.length)} {unit}")
    if found.angle is not None:
        parts.append(localize_number(f"{found.angle:.1f}°"))
    if found.mean is not None and found.deviation is not None:
        gray = f"{format_measured(found.mean)} ± {format_measured(found.deviation, 3)}"
        parts.append(f"{gray} HU" if image.is_ct else gray)
    if found.area is not None:
        parts.append(f"{format_measured(size.factor**2 * found.area)} {unit}²")
    return ", ".join(parts)
