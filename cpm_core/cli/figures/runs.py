"""A run on a scene: what it found, how it came there, and how well it agrees with the truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cpm_core.cli.figures.scenes import Scene
from cpm_core.contours.agreement import Agreement, agreement, recovered
from cpm_core.contours.contour import Contour
from cpm_core.particles.state import State
from cpm_core.segmentation.engine import Engine

Facts = Mapping[str, object]
"""Measured figures by name, as they go into a JSON file."""


@dataclass(frozen=True, eq=False)
class Moment:
    """What a run has found at some step.

    Attributes
    ----------
    step : int
        Steps done.
    scale : int
        Scale that the particles are on: 0 is the image itself.
    particles : ndarray, shape (N, 2)
        Positions [px].
    contours : tuple of Contour
        Contours through them.
    agreement : Agreement
        Of the contours with the truth.
    closed, closed_true : int
        True closed contours that were found as one, and all of them.
    converged : bool
        Whether the particles have come to rest.
    """

    step: int
    scale: int
    particles: NDArray[np.float64]
    contours: tuple[Contour, ...]
    agreement: Agreement
    closed: int
    closed_true: int
    converged: bool

    @property
    def facts(self) -> Facts:
        """Its figures, rounded to what they are good for."""
        seen = self.agreement
        return {
            "recall": round(seen.recall, 4),
            "precision": round(seen.precision, 4),
            "mean_distance_px": rounded(seen.mean_boundary_distance),
            "tolerance_px": seen.tolerance,
            "closed": self.closed,
            "closed_true": self.closed_true,
            "contours": len(self.contours),
            "steps": self.step,
            "particles": len(self.particles),
            "at_rest": self.converged,
        }


def rounded(distance: float) -> float | None:
    """A distance to three digits [px]; None when it is infinite, for want of a contour."""
    return round(distance, 3) if np.isfinite(distance) else None


@dataclass(frozen=True, eq=False)
class Run:
    """A run from its start to its end.

    Attributes
    ----------
    scene : Scene
        What it began with.
    moments : tuple of Moment
        At the steps that were asked for, as far as it came.
    end : Moment
        Its outcome.
    """

    scene: Scene
    moments: tuple[Moment, ...]
    end: Moment


def run(scene: Scene, at: Sequence[int] = (), tolerance: float = 1.0, engine: Engine | None = None) -> Run:
    """Let particles flow in a scene until they are at rest.

    Parameters
    ----------
    scene : Scene
        Image, truth, start and parameters.
    at : sequence of int
        Steps to look at on the way.
    tolerance : float
        Distance up to which a contour agrees with the truth [px].
    engine : Engine, optional
        What steps the particles; one of the scene's image when left out.
    """
    parameters = scene.parameters
    engine = engine or Engine(scene.values, parameters)

    def look(state: State) -> Moment:
        result = engine.result(state, parameters)
        seen = agreement(result.contours, scene.truth, tolerance)
        closed = recovered(result.contours, scene.truth, tolerance), sum(one.closed for one in scene.truth)
        return Moment(
            state.step, state.scale, result.particles, result.contours, seen, *closed, converged=result.converged
        )

    state, moments = engine.start(scene.seeds), []
    while not state.stop_reason:
        state = engine.step(state, parameters)
        if state.step in at:
            moments.append(look(state))
    return Run(scene, tuple(moments), look(state))
