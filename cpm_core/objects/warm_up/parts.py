"""The parts in which the loops are compiled: scenes that are small and call each loop once."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cpm_core.contours.result import Result
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.denoising import clean
from cpm_core.image.image import Image
from cpm_core.image.regions import Regions
from cpm_core.model.coverage import cover, no_coverage
from cpm_core.model.plane.repulsion import mesh_force
from cpm_core.model.starts import circle
from cpm_core.model.volume.starts import sphere
from cpm_core.numerics.loop_cache.folders import has_loops
from cpm_core.objects.methods import CONTOUR_METHODS, Start, run_method
from cpm_core.objects.partition import partition
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.segmentation.engine import Engine

_ROW, _COL = np.indices((32, 32))
_IMAGE = 255.0 * (np.hypot(_ROW - 15.5, _COL - 15.5) < 9.0)
_REGIONS = Regions(interest=(((1, 1), (1, 30), (30, 30), (30, 1)),), barriers=(((5.3, 2.2), (6.1, 28.4)),))
_PARAMETERS = Parameters(scales=2)
_CHARGES = (PlacedCharge((4.0, 4.0), 1.0),)
_CHARGES_IN_VOLUME = (PlacedCharge((4.0, 4.0, 4.0), 1.0),)
_STEPS = 12

_MOST_STEPS = 60
"""Steps in which a run in the small volume ends, and one in the small image goes on to the finer scale."""


def step_once() -> None:
    """Run the loops of the steps of a run, and of its energy."""
    engine = Engine(_IMAGE, _PARAMETERS)
    state = engine.start(circle((15.5, 15.5), 5.0))
    for _ in range(_MOST_STEPS):
        state = engine.step(state, _PARAMETERS)
    engine.energies(state, _PARAMETERS)


def contours_once() -> None:
    """Run the loops of the reconstruction, and before it some that steps have to wait for otherwise.

    The steps have more loops than a reconstruction, and both are compiled at the same time.
    """
    places = circle((15.5, 15.5), 5.0)
    mesh_force(places, _IMAGE.shape, 4.0)  # which more particles than these would need
    cover(no_coverage(_IMAGE.shape), places, np.ones(len(places), bool), 1)
    _contours()


def objects_once() -> None:
    """Run the loops of the choice of objects: of clicks, of a face that they cut, of a start."""
    faces = partition(_contours())
    mask = faces.select([(15.0, 15.0)]).mask
    missing, wrong = np.argwhere(~mask)[0], np.argwhere(mask)[-1]
    faces.select([(15.0, 15.0), missing], [wrong, (15.0, 19.0)])
    faces.select(circle((15.5, 15.5), 5.0))


def extras_once() -> None:
    """Run the loops of regions, barriers, placed charges, forces, denoising, and of the level sets beside them."""
    engine = Engine(_IMAGE, _PARAMETERS, _REGIONS)
    state = engine.step(engine.start(circle((15.5, 15.5), 5.0)), _PARAMETERS, _CHARGES)
    engine.forces(state, _PARAMETERS, _CHARGES)
    engine.energies(state, _PARAMETERS, _CHARGES)
    clean(_IMAGE)
    start = Start((circle((15.5, 15.5), 5.0),))
    run_method(CONTOUR_METHODS["gac"], Image(_IMAGE), start, max_steps=_STEPS)


def volume_once() -> None:
    """Run the loops of a run in a volume, with and without placed charges, of its forces and of its surface."""
    image = np.round(200.0 * np.clip(6.5 - np.linalg.norm(np.indices((20, 20, 20)) - 9.5, axis=0), 0.0, 1.0))
    parameters = PRESETS["volume"]
    engine = Engine(image, parameters)
    state = engine.start(sphere((9.5, 9.5, 9.5), 4.0, count=100))
    for _ in range(_MOST_STEPS):
        state = engine.step(state, parameters)
    engine.result(state, parameters)
    engine.forces(engine.step(state, parameters, _CHARGES_IN_VOLUME), parameters, _CHARGES_IN_VOLUME)
    engine.energies(state, parameters, _CHARGES_IN_VOLUME)


def _contours() -> Result:
    """Contours of particles that lie on the edge of the disk."""
    engine = Engine(_IMAGE, _PARAMETERS)
    return engine.result(engine.start(circle((15.5, 15.5), 9.0)), _PARAMETERS)


class Part(NamedTuple):
    """Loops that are compiled together.

    `modules` are those with the loops that take longest: when these are kept, the others are taken to be kept as well;
    `loops` is about the number of loops, from which progress is told.
    """

    once: Callable[[], object]
    modules: tuple[str, ...]
    loops: int

    @property
    def name(self) -> str:
        """Where the function is found: module:function."""
        return f"{self.once.__module__}:{self.once.__name__}"

    def is_kept(self) -> bool:
        """Whether the loops need not be compiled."""
        return all(has_loops(module) for module in self.modules)


FIRST = (
    Part(step_once, ("cpm_core.model.plane.motion", "cpm_core.model.plane.births"), 41),
    Part(contours_once, ("cpm_core.reconstruction.curve.ridge_tracing_kernels", "cpm_core.contours.graph.paths"), 29),
)
"""What a first run on an image needs."""

LATER = (
    Part(objects_once, ("cpm_core.objects.minimum_cut", "cpm_core.objects.candidates.features"), 66),
    Part(extras_once, ("cpm_core.field.placed_charges", "cpm_core.objects.methods.level_sets"), 40),
)
"""All else that is done with images."""

VOLUMES = (Part(volume_once, ("cpm_core.model.volume.motion", "cpm_core.model.volume.births"), 120),)
"""What a run in a volume needs."""
