"""The charged particles among the methods that are compared: their contours, and the object that is then proposed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from cpm_core.image.image import Image
from cpm_core.image.pyramid import max_scales
from cpm_core.objects.methods.method import SPACING, ContourMethod, Contours, ContourState, Start
from cpm_core.objects.partition import partition
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.evolve import RunState, evolve

MOST_STEPS = 4000
"""Largest number of steps of a run of the particles."""


def _states(
    image: Image,
    start: Start,
    parameters: Parameters,
    find: Callable[[RunState], Contours] = lambda moment: moment.contours,
) -> Iterator[ContourState]:
    """Yield the states of a run, which ends after `MOST_STEPS` at the latest."""
    chosen = replace(parameters, scales=min(parameters.scales, max_scales(image.shape)))
    run = evolve(image, start.points, chosen)
    for moment in run:
        if moment.step == MOST_STEPS:
            run.stop(f"stopped after {MOST_STEPS} steps")
        newest = run.moment
        yield ContourState(
            newest.step, partial(find, newest), newest.stop_reason, newest.converged, newest.position
        )  # fmt: skip


def _evolve_to_object(image: Image, start: Start, parameters: Parameters) -> Iterator[ContourState]:
    def find_boundaries(moment: RunState) -> Contours:
        """Find the closed boundaries of the objects of all outlines of the start, united where they overlap."""
        cut = partition(moment.result)
        chosen = [cut.select(outline) for outline in start.curves(SPACING)]
        whole = chosen[0] if len(chosen) == 1 else cut.selection_of(np.any([one.mask for one in chosen], axis=0))
        return whole.contours

    return _states(image, start, parameters, find_boundaries)


PARTICLES = ContourMethod(
    "cpm",
    Engine.title,
    "Particles that the electric field of the edges attracts, and that repel each other along them.",
    "Jalba, Wilkinson and Roerdink (2004)",
    Parameters,
    _states,
)

PROPOSED_OBJECT = ContourMethod(
    "object",
    "Object of the particles",
    "The object that is proposed for the start after a run of the charged particles: what their contours enclose "
    "beyond doubt, elsewhere what a learned prior expects.",
    "Objects of this program, on the particles of Jalba, Wilkinson and Roerdink (2004)",
    Parameters,
    _evolve_to_object,
    preset=PRESETS["shape"],
)
