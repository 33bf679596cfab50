"""The geodesic active contour: a curve that is short in a metric of edges, with a balloon and an area term."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cpm_core.field.edge_map import gradient
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array
from cpm_core.objects.methods.gray import unit_edges
from cpm_core.objects.methods.level_sets.evolution import FrontState, Speeds, evolution
from cpm_core.objects.methods.method import ContourMethod, Start
from cpm_core.objects.methods.settings import Settings, number

MOST_STEPS = 4000


@dataclass(frozen=True)
class GeodesicSettings(Settings):
    """Parameters of the geodesic active contour."""

    balloon: float = number(
        0.3, "c", "Balloon", "Constant pressure that drives it on: outwards, or inwards from around the object.",
        "More of it drives the contour on faster, and over edges.",
        (-20.0, 20.0), (-2.0, 2.0), 0.1, equation="w₀ of eq. (2)",
    )  # fmt: skip
    curvature: float = number(
        0.2, "w₁", "Smoothness", "Weight of the curvature, which shortens the contour.",
        "More of it keeps the contour out of gaps, bays and noise.",
        (0.0, 20.0), (0.0, 2.0), 0.05, equation="w₁ of eq. (2)",
    )  # fmt: skip
    pull: float = number(
        1.0, "w₂", "Pull to edges", "Weight of the pull back to edges that the contour has begun to cross.",
        "More of it holds the contour on edges against the balloon; at 0 they only slow it down.",
        (0.0, 100.0), (0.0, 20.0), 0.5,
    )  # fmt: skip
    area: float = number(
        0.0, "w₃", "Area", "Weight of the area in the metric of edges, which attracts the contour from farther away.",
        "More of it moves the contour to edges at some distance.",
        (0.0, 20.0), (0.0, 1.0), 0.05, advanced=True,
    )  # fmt: skip
    exponent: float = number(
        1.0, "m", "Exponent", "Exponent of the factor by which edges slow the contour down.",
        "More of it also stops the contour at weak edges and at noise; less lets it cross them.",
        (0.1, 20.0), (0.5, 8.0), 0.5, equation="m of eq. (2)",
    )  # fmt: skip
    contrast: float = number(
        0.05, "k", "Edge contrast", "Edge strength that counts as an edge, as a fraction of the largest.",
        "More of it lets the contour cross weak edges.",
        (1e-4, 10.0), (0.01, 1.0), 0.01,
    )  # fmt: skip
    smoothing: float = number(
        1.5, "σ", "Smoothing", "Width of the Gaussian that smooths the image before its edges are found.",
        "More of it removes noise and rounds corners.", (0.0, 50.0), (0.5, 8.0), 0.5, "px",
    )  # fmt: skip


def stopping(image: Image, settings: GeodesicSettings) -> Array:
    """The factor by which edges slow a contour down, shape (H, W), from 1 in flat regions to nearly 0 on edges."""
    strength = unit_edges(image, settings.smoothing) / settings.contrast
    return np.asarray((1.0 + strength) ** -settings.exponent)


def _evolve(image: Image, start: Start, settings: GeodesicSettings) -> Iterator[FrontState]:
    factor = stopping(image, settings)
    slope = gradient(factor, 0.0)
    inside = start.mask(image.shape)
    pressure = start.onward * settings.balloon * factor
    if settings.area > 0.0:  # g + x . grad g / 2 of Siddiqi et al., with the places x from the center of the start
        center = np.argwhere(inside).mean(axis=0) if inside.any() else np.zeros(2)
        away = np.indices(image.shape) - center[:, None, None]
        pressure = pressure - settings.area * (factor + 0.5 * (away * slope).sum(axis=0))
    speeds = Speeds(settings.curvature * factor, pressure, -settings.pull * slope)
    yield from evolution(inside, speeds, MOST_STEPS)


GEODESIC = ContourMethod(
    "gac",
    "Geodesic active contour",
    "A level set that edges slow down and pull back, with a balloon that drives it on.",
    "Caselles, Kimmel and Sapiro (1997), doi:10.1023/A:1007979827043; area term of Siddiqi et al. (1998), "
    "doi:10.1109/83.661193",
    GeodesicSettings,
    _evolve,
    MOST_STEPS,
)
