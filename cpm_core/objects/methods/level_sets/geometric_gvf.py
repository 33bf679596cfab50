"""The geometric GVF contour, eq. (3): a level set in the field of gradient vector flow."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cpm_core.image.image import Image
from cpm_core.objects.methods.gray import unit_edges
from cpm_core.objects.methods.level_sets.evolution import FrontState, Speeds, evolution
from cpm_core.objects.methods.method import ContourMethod, Start
from cpm_core.objects.methods.parametric.gvf_field import evened, gradient_vector_flow
from cpm_core.objects.methods.settings import Settings, number

MOST_STEPS = 4000


@dataclass(frozen=True)
class GeometricGvfSettings(Settings):
    """Parameters of the geometric GVF contour."""

    mu: float = number(
        0.02, "μ", "Smoothness of the field", "How much the field is smoothed, against how closely it follows edges.",
        "More of it carries the edges farther and evens out noise.",
        (1e-4, 100.0), (0.01, 1.0), 0.01, equation="gradient vector flow",
    )  # fmt: skip
    curvature: float = number(
        0.02, "w", "Smoothness", "Weight of the curvature, which shortens the contour.",
        "More of it keeps the contour out of gaps, bays and noise.",
        (0.0, 20.0), (0.0, 2.0), 0.05, equation="w of eq. (3)",
    )  # fmt: skip
    pressure: float = number(
        0.5, "w₀", "Pressure", "Constant pressure that drives it on: outwards, or inwards from around the object.",
        "More of it drives the contour over places where the field does not, and into gaps.",
        (-20.0, 20.0), (-1.0, 1.0), 0.05,
    )  # fmt: skip
    evenness: float = number(
        0.5, "e", "Evenness", "How far the vectors of the field are made equally long: from 0, as the equation gives "
        "them, to 1, all of the length 1.",
        "More of it moves the contour also far from edges, and holds it better against the pressure in gaps.",
        (0.0, 1.0), (0.0, 1.0), 0.1,
    )  # fmt: skip
    smoothing: float = number(
        2.0, "σ", "Smoothing", "Width of the Gaussian that smooths the image before its edges are found.",
        "More of it removes noise and rounds corners.", (0.0, 50.0), (0.5, 8.0), 0.5, "px",
    )  # fmt: skip


def _evolve(image: Image, start: Start, settings: GeometricGvfSettings) -> Iterator[FrontState]:
    field = evened(gradient_vector_flow(unit_edges(image, settings.smoothing), settings.mu), settings.evenness)
    curvature, pressure = (
        np.full(image.shape, float(weight)) for weight in (settings.curvature, start.onward * settings.pressure)
    )
    yield from evolution(start.mask(image.shape), Speeds(curvature, pressure, field), MOST_STEPS)


GEOMETRIC_GVF = ContourMethod(
    "geometric_gvf",
    "Geometric GVF contour",
    "A level set that the field of gradient vector flow carries to edges; its contours can divide and merge.",
    "Xu, Yezzi and Prince (2000), doi:10.1109/ACSSC.2000.911003",
    GeometricGvfSettings,
    _evolve,
    MOST_STEPS,
)
