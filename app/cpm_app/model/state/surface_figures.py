"""Figures by which to judge the surface of a run in a volume, as text."""

from __future__ import annotations

import math

from cpm_app.model.display.lengths import format_measured, preferred_pixel_size
from cpm_app.model.text.language import localize_number, tr
from cpm_core import Surface
from cpm_core.numerics.types import Texts

SURFACE_LABEL = tr("Surface")
VOLUME_LABEL = tr("Volume")


def format_surface_figures(found: Surface | None) -> tuple[tuple[str, str, str], ...]:
    """Return label, value and explanation of each figure; dashes while there is no surface.

    It takes long the first time for a surface of many triangles, which caches its measures.
    """
    texts = ("–",) * 6 if found is None else _format_figure_values(found)
    figures = (
        (SURFACE_LABEL, tr("Separate parts of the surface; touching objects count as one part.")),
        (tr("Closed"), tr("Whether the surface is closed, so that it has an inside.")),
        (tr("Euler number"), tr("Euler characteristic: 2 for a sphere, 0 for a ring; the sum over all parts.")),
        (tr("Area"), tr("Area of the surface.")),
        (VOLUME_LABEL, tr("Volume that a closed surface encloses.")),
        (tr("Supported"), tr("Fraction of the surface with particles nearby; the rest is interpolated.")),
    )
    return tuple((label, text, tip) for (label, tip), text in zip(figures, texts, strict=True))


def _format_figure_values(found: Surface) -> Texts:
    size = preferred_pixel_size(found.spacing, found.unit)
    unit = size.unit or tr("voxels")
    edges = found.free_edges + found.nonmanifold_edges
    closed = tr("yes") if not edges else tr("no, {count} open edges", count=localize_number(f"{edges:,}"))
    area, volume = found.area * size.factor**2, found.volume * size.factor**3
    support = "–" if math.isnan(found.unsupported) else localize_number(f"{100.0 * (1.0 - found.unsupported):.1f} %")
    square, cube = (f"{unit}²", f"{unit}³") if size.unit else (tr("voxel faces"), unit)
    return (
        _count_parts(found),
        closed,
        localize_number(f"{found.euler:,}"),
        f"{format_measured(area)} {square}",
        f"{format_measured(volume)} {cube}",
        support,
    )


def describe_surface(found: Surface | None) -> str:
    """Describe in a sentence how many parts the surface has that a run has found."""
    if found is None or not found.components:
        return tr("No surface was found.")
    return tr("A surface was found: {parts}.", parts=_count_parts(found))


def _count_parts(found: Surface) -> str:
    """Count the parts of a surface, and those that were left out."""
    count = localize_number(f"{found.components:,}")
    parts = tr("1 part") if found.components == 1 else tr("{count} parts", count=count)
    if not found.left_out:
        return parts
    return tr("{parts}, {count} left out", parts=parts, count=localize_number(f"{found.left_out:,}"))
