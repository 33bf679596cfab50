"""The charged particles as one of the methods that are compared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from cpm_core.image.image import Image
from cpm_core.image.pyramid import most_scales
from cpm_core.objects.methods.method import ContourMethod, Start
from cpm_core.parameters import Parameters
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.evolve import Evolved, evolve

MOST_STEPS = 4000


def evolve_particles(image: Image, start: Start, parameters: Parameters) -> Iterator[Evolved]:
    """The moments of a run, which ends after `MOST_STEPS` at the latest."""
    chosen = replace(parameters, scales=min(parameters.scales, most_scales(image.shape)))
    run = evolve(image, start.points, chosen)
    for moment in run:
        if moment.step == MOST_STEPS:
            run.stop(f"stopped after {MOST_STEPS} steps")
        yield run.moment


PARTICLES = ContourMethod(
    "cpm",
    Engine.title,
    "Particles that the electric field of the edges attracts, and that repel each other along them.",
    "Jalba, Wilkinson and Roerdink (2004)",
    Parameters,
    evolve_particles,
    MOST_STEPS,
    in_volumes=True,
)
