"""Figures by which to judge the surface of a run in a volume, as text."""

from __future__ import annotations

import math

from cpm_app.model.display.lengths import shown_in
from cpm_app.model.text.language import tr, written
from cpm_core import Surface
from cpm_core.numerics.types import Texts

SURFACE = tr("Surface")
CLOSED = tr("Closed")
EULER = tr("Euler number")
AREA = tr("Area")
VOLUME = tr("Volume")
SUPPORT = tr("Supported")


def figure_texts(found: Surface | None) -> tuple[tuple[str, str, str], ...]:
    """Return label, value and explanation of each figure; dashes while there is no surface.

    It takes long the first time for a surface of many triangles, which caches its measures.
    """
    texts = ("–",) * 6 if found is None else _texts(found)
    tips = (
        tr("Separate parts of the surface."),
        tr("Whether the surface is closed, so that it has an inside."),
        tr("Euler characteristic: 2 for a sphere, 0 for a ring; the sum over all parts."),
        tr("Area of the surface."),
        tr("Volume that a closed surface encloses."),
        tr("Fraction of the surface with particles nearby; the rest is interpolated."),
    )
    return tuple(zip((SURFACE, CLOSED, EULER, AREA, VOLUME, SUPPORT), texts, tips, strict=True))


def _texts(found: Surface) -> Texts:
    size = shown_in(found.spacing, found.unit)
    unit = size.unit or tr("voxels")
    parts = tr("1 part") if found.components == 1 else tr("{count} parts", count=written(f"{found.components:,}"))
    if found.left_out:
        parts = tr("{parts}, {count} left out", parts=parts, count=written(f"{found.left_out:,}"))
    edges = found.free_edges + found.nonmanifold_edges
    closed = tr("yes") if not edges else tr("no, {count} open edges", count=written(f"{edges:,}"))
    area, volume = found.area * size.factor**2, found.volume * size.factor**3
    support = "–" if math.isnan(found.unsupported) else written(f"{100.0 * (1.0 - found.unsupported):.1f} %")
    square, cube = (f"{unit}²", f"{unit}³") if size.unit else (tr("voxel faces"), unit)
    return (
        parts,
        closed,
        written(f"{found.euler:,}"),
        f"{_readable(area)} {square}",
        f"{_readable(volume)} {cube}",
        support,
    )


def _readable(value: float) -> str:
    """Format a number with four digits, or in whole units."""
    return written(f"{value:,.0f}") if value >= 1000.0 else written(f"{value:.4g}")
