"""The classical snake: a curve in the potential of the edges."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy

from cpm_core.image.image import Image
from cpm_core.numerics.types import Array
from cpm_core.objects.methods.gray import sobel_edges
from cpm_core.objects.methods.method import ContourMethod, Start
from cpm_core.objects.methods.parametric.curve import Elasticity, Force, evolution
from cpm_core.objects.methods.settings import Settings, number
from cpm_core.objects.methods.states import CurveState

MOST_STEPS = 2500


@dataclass(frozen=True)
class SnakeSettings(Settings):
    """Parameters of the classical snake."""

    alpha: float = number(
        0.015, "α", "Tension", "Weight of the tension, which shortens the curve.",
        "More of it shrinks the curve faster, and also where there is no edge.",
        (0.0, 10.0), (0.0, 0.2), 0.005, equation="eq. (1)",
    )  # fmt: skip
    beta: float = number(
        0.1, "β", "Rigidity", "Weight of the rigidity, which keeps the curve from bending.",
        "More of it rounds corners and keeps the curve out of narrow bays.",
        (0.0, 1000.0), (0.0, 10.0), 0.05, equation="eq. (1)",
    )  # fmt: skip
    attraction: float = number(
        1.0, "w", "Attraction", "Weight of the force of the image, which pulls the curve to edges.",
        "More of it pulls harder, so that tension and rigidity count for less.",
        (0.0, 100.0), (0.0, 5.0), 0.1, equation="eq. (1)",
    )  # fmt: skip
    gamma: float = number(
        0.01, "γ", "Resistance", "How much the curve resists being moved.",
        "More of it makes the steps smaller.", (1e-4, 100.0), (0.001, 0.5), 0.001, advanced=True,
    )  # fmt: skip
    smoothing: float = number(
        2.0, "σ", "Smoothing", "Width of the Gaussian that smooths the image before its edges are found.",
        "More of it attracts the curve from farther away, and rounds corners.",
        (0.0, 50.0), (0.5, 10.0), 0.5, "px",
    )  # fmt: skip
    spacing: float = number(
        1.0, "h", "Spacing", "Distance at which the points of the curve are kept; at 0 they stay the same points.",
        "More of it gives a coarser curve.", (0.0, 20.0), (0.0, 5.0), 0.5, "px", advanced=True,
    )  # fmt: skip


def edge_force(edges: Array, attraction: float) -> Force:
    """The gradient of an edge map, shape (H, W), as a force: pieces of quadratic polynomials between the pixels."""
    rows, cols = edges.shape
    surface = scipy.interpolate.RectBivariateSpline(
        np.arange(rows), np.arange(cols), attraction * edges, kx=2, ky=2, s=0
    )

    def force(at: Array) -> Array:
        row, col = at.T
        return np.stack([surface(row, col, dx=1, grid=False), surface(row, col, dy=1, grid=False)], axis=1)

    return force


def _evolve(image: Image, start: Start, settings: SnakeSettings) -> Iterator[CurveState]:
    force = edge_force(sobel_edges(image, settings.smoothing), settings.attraction)
    elasticity = Elasticity(settings.alpha, settings.beta, settings.gamma, settings.spacing)
    curves = start.curves(settings.spacing or 1.0)
    yield from evolution(curves, force, elasticity, image.shape, MOST_STEPS)


SNAKE = ContourMethod(
    "snake",
    "Classical snake",
    "A closed curve that is pulled up the slope of the edge map, and that tension and rigidity keep short and smooth.",
    "Kass, Witkin and Terzopoulos (1988), doi:10.1007/BF00133570; the forces of scikit-image's active_contour",
    SnakeSettings,
    _evolve,
    MOST_STEPS,
)
