"""A run on a scene: its snapshots, its result, and how well they agree with the truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cpm_core.contours.agreement import DEFAULT_TOLERANCE, Agreement, compare_boundaries
from cpm_core.contours.contour import Contour
from cpm_core.model.state import State
from cpm_core.numerics.types import Array
from cpm_core.segmentation.engine import Engine
from docs.gallery.scenes import Scene

Facts = Mapping[str, object]
"""Measured values by name, as they are written to a JSON file."""


@dataclass(frozen=True, eq=False)
class Moment:
    """State of a run after some steps: particles (N, 2) [px], contours, and their agreement with the truth.

    `scale` 0 is the image itself. `closed` counts the true closed contours that were recovered as one closed contour,
    `closed_true` all of them. `converged` is whether the particles are at rest.
    """

    step: int
    scale: int
    particles: Array
    contours: tuple[Contour, ...]
    agreement: Agreement
    closed: int
    closed_true: int
    converged: bool

    @property
    def facts(self) -> Facts:
        """Its measured values, rounded."""
        seen = self.agreement
        distance = seen.mean_boundary_distance
        return {
            "recall": round(seen.recall, 4),
            "precision": round(seen.precision, 4),
            "mean_distance_px": round(distance, 3) if np.isfinite(distance) else None,
            "tolerance_px": seen.tolerance,
            "closed": self.closed,
            "closed_true": self.closed_true,
            "contours": len(self.contours),
            "steps": self.step,
            "particles": len(self.particles),
            "at_rest": self.converged,
        }


@dataclass(frozen=True, eq=False)
class Run:
    """A run of a scene, with snapshots at the requested steps that it reached, and its end."""

    scene: Scene
    moments: tuple[Moment, ...]
    end: Moment


_WHOLE = 0.95
"""Share of the length of two contours that each has to cover of the other to be it."""


def recovered(contours: Sequence[Contour], truth: Sequence[Contour], tolerance: float = DEFAULT_TOLERANCE) -> int:
    """Count the closed true contours that a closed contour matches: each covers 95 % of the other's length.

    Open contours do not count; boundaries within the tolerance [px] count as the same.
    """
    closed = [one for one in contours if one.closed]
    return sum(
        any(
            min(seen.recall, seen.precision) >= _WHOLE
            for seen in (compare_boundaries([one], [true], tolerance) for one in closed)
        )
        for true in truth
        if true.closed
    )


def run(scene: Scene, at: Sequence[int] = (), tolerance: float = 1.0, engine: Engine | None = None) -> Run:
    """Run a scene until the particles are at rest, with snapshots after the steps `at`.

    A contour agrees with the truth up to a distance of `tolerance` px. Without `engine` one is made of the image.
    """
    parameters = scene.parameters
    engine = engine or Engine(scene.values, parameters)

    def look(state: State) -> Moment:
        result = engine.result(state, parameters)
        seen = compare_boundaries(result.contours, scene.truth, tolerance)
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
