"""Table of the measures that a user has drawn in an image."""

from __future__ import annotations

from collections.abc import Iterable

from cpm_core.formats.contours.contour_csv import encode_csv_rows
from cpm_core.formats.images.resolution import name_column
from cpm_core.image.image import Image
from cpm_core.numerics.types import Place
from cpm_core.shapes import Measure, Oval


def encode_measures_table(measures: Iterable[Measure], image: Image, channel: str = "luminance") -> bytes:
    """Tabulate measures, one per row: ``number``, ``measure``, what it measures with the unit, and its ``place``.

    Columns are named after what they have and its unit: ``length_mm``, ``angle_deg``, ``area_mm2``, ``mean_HU`` and
    ``deviation_HU`` (``mean_gray`` where gray levels have no unit), ``pixels``. Lengths are in px where the size of a
    pixel is not known. Cells of what a measure does not measure are empty. The place is the center and the radii of an
    ellipse, else the points [px of the image].
    """
    unit, gray = image.unit or "px", "HU" if image.is_ct else "gray"
    rows = []
    for number, shape in enumerate(measures, start=1):
        found = shape.measure(image, channel)
        rows.append({
            "number": number,
            "measure": shape.title,
            name_column("length", unit): _format(found.length),
            "angle_deg": _format(found.angle),
            name_column("area", f"{unit}²"): _format(found.area),
            f"mean_{gray}": _format(found.mean),
            f"deviation_{gray}": _format(found.deviation),
            "pixels": "" if found.pixels is None else found.pixels,
            "place": "; ".join(" ".join(f"{at:.6g}" for at in place) for place in _list_places(shape)),
        })  # fmt: skip
    return encode_csv_rows(rows, ("number", "measure"))


def _list_places(shape: Measure) -> tuple[Place, ...]:
    return (shape.center, shape.radii) if isinstance(shape, Oval) else shape.points


def _format(value: float | None) -> str:
    return "" if value is None else f"{value:.7g}"
