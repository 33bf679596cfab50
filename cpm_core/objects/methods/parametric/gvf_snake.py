"""The GVF snake: a curve in the field of gradient vector flow."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy

from cpm_core.image.image import Image
from cpm_core.numerics.types import Array
from cpm_core.objects.methods.gray import unit_edges
from cpm_core.objects.methods.method import ContourMethod, Start
from cpm_core.objects.methods.parametric.curve import Elasticity, Force, evolution
from cpm_core.objects.methods.parametric.gvf_field import evened, gradient_vector_flow
from cpm_core.objects.methods.settings import Settings, number
from cpm_core.objects.methods.states import CurveState

MOST_STEPS = 2000


@dataclass(frozen=True)
class GvfSnakeSettings(Settings):
    """Parameters of the GVF snake."""

    mu: float = number(
        0.02, "μ", "Smoothness of the field", "How much the field is smoothed, against how closely it follows edges.",
        "More of it carries the edges farther and evens out noise.",
        (1e-4, 100.0), (0.01, 1.0), 0.01, equation="gradient vector flow",
    )  # fmt: skip
    alpha: float = number(
        0.0, "α", "Tension", "Weight of the tension, which shortens the curve.",
        "More of it keeps the curve out of bays.", (0.0, 10.0), (0.0, 1.0), 0.01, equation="eq. (1)",
    )  # fmt: skip
    beta: float = number(
        0.0, "β", "Rigidity", "Weight of the rigidity, which keeps the curve from bending.",
        "More of it rounds corners.", (0.0, 1000.0), (0.0, 5.0), 0.05, equation="eq. (1)",
    )  # fmt: skip
    attraction: float = number(
        0.6, "κ", "Attraction", "Weight of the field, whose vectors all have the length 1.",
        "More of it moves the curve faster, and overcomes tension and rigidity.",
        (0.0, 100.0), (0.0, 3.0), 0.05,
    )  # fmt: skip
    smoothing: float = number(
        1.0, "σ", "Smoothing", "Width of the Gaussian that smooths the image before its edges are found.",
        "More of it removes noise and rounds corners.", (0.0, 50.0), (0.5, 8.0), 0.5, "px",
    )  # fmt: skip
    spacing: float = number(
        1.0, "h", "Spacing", "Distance at which the points of the curve are kept.",
        "More of it gives a coarser curve.", (0.2, 20.0), (0.5, 5.0), 0.5, "px", advanced=True,
    )  # fmt: skip


def field_force(field: Array, attraction: float) -> Force:
    """A field on the pixels, shape (2, H, W), as a force, linear between the pixels."""

    def force(at: Array) -> Array:
        parts = [scipy.ndimage.map_coordinates(part, at.T, order=1, mode="nearest") for part in field]
        return attraction * np.stack(parts, axis=1)

    return force


def _evolve(image: Image, start: Start, settings: GvfSnakeSettings) -> Iterator[CurveState]:
    field = evened(gradient_vector_flow(unit_edges(image, settings.smoothing), settings.mu))
    elasticity = Elasticity(settings.alpha, settings.beta, 1.0, settings.spacing)
    force = field_force(field, settings.attraction)
    yield from evolution(start.curves(settings.spacing), force, elasticity, image.shape, MOST_STEPS)


GVF_SNAKE = ContourMethod(
    "gvf",
    "GVF snake",
    "A closed curve in the field of gradient vector flow, which carries the edges far into flat regions.",
    "Xu and Prince (1998), doi:10.1109/83.661186",
    GvfSnakeSettings,
    _evolve,
    MOST_STEPS,
)
