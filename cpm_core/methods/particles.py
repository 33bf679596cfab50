"""The charged particles among the methods that are compared: their contours, and the object that is then proposed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from cpm_core.image.image import Image
from cpm_core.image.pyramid import max_scales
from cpm_core.methods.method import START_SPACING, ContourMethod, Contours, ContourState, Start
from cpm_core.objects.partition import Partition
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.evolve import RunState, evolve

MAX_PARTICLE_STEPS = 4000
"""Largest number of steps of a run of the particles."""


def _iterate_states(
    image: Image,
    start: Start,
    parameters: Parameters,
    find: Callable[[RunState], Contours] = lambda moment: moment.contours,
) -> Iterator[ContourState]:
    """Yield the states of a run, which ends after `MAX_PARTICLE_STEPS` at the latest."""
    chosen = replace(parameters, scales=min(parameters.scales, max_scales(image.shape)))
    run = evolve(image, start.points, chosen)
    for moment in run:
        if moment.step == MAX_PARTICLE_STEPS:
            run.stop(f"stopped after {MAX_PARTICLE_STEPS} steps")
        newest = run.moment
        yield ContourState(
            newest.step, partial(find, newest), newest.stop_reason, newest.converged, newest.position
        )  # fmt: skip


def _evolve_to_object(image: Image, start: Start, parameters: Parameters) -> Iterator[ContourState]:
    def find_boundaries(moment: RunState) -> Contours:
        """Find the closed boundaries of the objects of all outlines of the start, united where they overlap."""
        cut = Partition.from_result(moment.result)
        chosen = [cut.select(outline) for outline in start.sample_curves(START_SPACING)]
        whole = chosen[0] if len(chosen) == 1 else cut.build_selection(np.any([one.mask for one in chosen], axis=0))
        return whole.contours

    return _iterate_states(image, start, parameters, find_boundaries)


PARTICLE_METHOD = ContourMethod(
    "cpm",
    Engine.title,
    "Particles that the electric field of the edges attracts, and that repel each other along them.",
    "Jalba, Wilkinson and Roerdink (2004)",
    Parameters,
    _iterate_states,
)

PROPOSED_OBJECT = ContourMethod(
    "object",
    "Object of the particles",
    "The object that is proposed for the start after a run of the charged particles: what their contours enclose "
    "beyond doubt, elsewhere what the network predicts.",
    "Objects of this program, on the particles of Jalba, Wilkinson and Roerdink (2004)",
    Parameters,
    _evolve_to_object,
    preset=PRESETS["shape"],
)
