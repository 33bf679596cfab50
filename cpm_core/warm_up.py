"""Compiling the kernels of the model before their first use: small scenes that call each kernel once."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.field.edge_map import gradient_in_window, smoothed_gradient
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.field.scale_field import build_scale_field, limit_field
from cpm_core.image.denoising import remove_noise
from cpm_core.image.image import Image
from cpm_core.image.regions import Regions
from cpm_core.methods import CONTOUR_METHODS, Start, run_method
from cpm_core.model.plane import motion
from cpm_core.model.plane.repulsion import mesh_force
from cpm_core.model.starts import circle
from cpm_core.model.volume import motion as volume_motion
from cpm_core.model.volume.starts import sphere
from cpm_core.numerics.jit import tell_compiled
from cpm_core.numerics.types import Callback
from cpm_core.objects.boundaries.crossings import find_crossings
from cpm_core.objects.boundaries.snapping import snap_to_contours
from cpm_core.objects.partition import Partition
from cpm_core.objects.volume_partition import VolumePartition
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.reconstruction import find_contours
from cpm_core.results.result import Result
from cpm_core.segmentation.engine import Engine

_IMAGE = 255.0 * (np.hypot(*(np.indices((32, 32)) - 15.5)) < 9.0)
_TALL = np.zeros((512, 4))
"""Rows of which several threads take some each."""

_REGIONS = Regions(interest=(((1, 1), (1, 30), (30, 30), (30, 1)),), barriers=(((5.3, 2.2), (6.1, 28.4)),))
_TWO_SCALES = Parameters(scales=2)
_CHARGES = (PlacedCharge((4.0, 4.0), 1.0),)
_CHARGES_IN_VOLUME = (PlacedCharge((4.0, 4.0, 4.0), 1.0),)
_STEPS = 12

_MOST_STEPS = 60
"""Steps in which a run in the small volume ends, and one in the small image continues to the finer scale."""


def step_once() -> None:
    """Run the kernels of the steps of a run, and of its energy."""
    smoothed_gradient(_TALL, 1.0)
    engine = Engine(_IMAGE, _TWO_SCALES)
    state = engine.start(circle((15.5, 15.5), 5.0))
    for _ in range(_MOST_STEPS):
        state = engine.step(state, _TWO_SCALES)
    engine.energies(state, _TWO_SCALES)


def contours_once() -> None:
    """Run the kernels of the reconstruction, and of the forces of many particles."""
    mesh_force(circle((15.5, 15.5), 5.0), _IMAGE.shape, 4.0)  # which more particles than these would need
    _contours()


def objects_once() -> None:
    """Run the kernels of the choice of objects: of clicks, of places that correct it, of a start."""
    cut = Partition.from_result(_contours())
    mask = cut.select([(15.0, 15.0)]).mask
    missing, wrong = np.argwhere(~mask)[0], np.argwhere(mask)[-1]
    cut.select([(15.0, 15.0), missing], [wrong, (15.0, 19.0)])
    cut.select(circle((15.5, 15.5), 5.0))
    snap_to_contours(mask, find_crossings([], mask.shape), 1.0)


def extras_once() -> None:
    """Run the kernels of regions, barriers, placed charges, forces, denoising, and of the level sets next to them."""
    engine = Engine(_IMAGE, _TWO_SCALES, _REGIONS)
    state = engine.step(engine.start(circle((15.5, 15.5), 5.0)), _TWO_SCALES, _CHARGES)
    engine.forces(state, _TWO_SCALES, _CHARGES)
    engine.energies(state, _TWO_SCALES, _CHARGES)
    remove_noise(_IMAGE)
    Image(np.stack([_IMAGE, _IMAGE, 255.0 - _IMAGE], axis=-1).astype(np.uint8))
    start = Start((circle((15.5, 15.5), 5.0),))
    run_method(CONTOUR_METHODS["geodesic"], Image(_IMAGE), start, max_steps=_STEPS)


def large_once() -> None:
    """Run the kernels of a large image: its fields are in single precision, and made for windows of it."""
    slopes = partial(gradient_in_window, _IMAGE, 1.0)
    smoothed_gradient(_TALL, 1.0, np.float32)
    whole = build_scale_field(_IMAGE, 1.0, 0.0, slopes=slopes)
    part = limit_field(whole, np.ones(_IMAGE.shape, bool), whole.floor)
    _ = part.packed
    find_contours(circle((15.5, 15.5), 9.0), part, _TWO_SCALES)


def volume_once() -> None:
    """Run the kernels of a run in a volume, with and without placed charges, of its forces and of its surface."""
    image = np.round(200.0 * np.clip(6.5 - np.linalg.norm(np.indices((20, 20, 20)) - 9.5, axis=0), 0.0, 1.0))
    parameters = PRESETS["volume"]
    engine = Engine(image, parameters)
    state = engine.start(sphere((9.5, 9.5, 9.5), 4.0, count=100))
    for _ in range(_MOST_STEPS):
        state = engine.step(state, parameters)
    engine.result(state, parameters)
    engine.forces(engine.step(state, parameters, _CHARGES_IN_VOLUME), parameters, _CHARGES_IN_VOLUME)
    engine.energies(state, parameters, _CHARGES_IN_VOLUME)


@cache
def bodies_once() -> None:
    """Run the kernels of clicks in a volume, the first one and one that corrects it."""
    cut = VolumePartition(Image(100.0 * (np.linalg.norm(np.indices((20, 20, 20)) - 9.5, axis=0) < 5.0)))
    cut.select([(9.5, 9.5, 9.5)], [(1.0, 1.0, 1.0)])


def _contours() -> Result:
    """Contours of particles that lie on the edge of the disk."""
    engine = Engine(_IMAGE, _TWO_SCALES)
    return engine.result(engine.start(circle((15.5, 15.5), 9.0)), _TWO_SCALES)


Part = Callback

FIRST: tuple[Part, ...] = (step_once, contours_once)
"""What a first run on an image needs, what it begins with first."""

LATER: tuple[Part, ...] = (objects_once, large_once, extras_once)
"""All else that is done with images."""

VOLUMES: tuple[Part, ...] = (volume_once,)
"""What a run in a volume needs."""

_KERNELS: Mapping[Part, int] = {step_once: 12, contours_once: 6, volume_once: 13}
"""Number of kernels that a part compiles, for the share that is done."""


def _never() -> bool:
    return False


def warm_up(
    canceled: Callable[[], bool] = _never,
    on_progress: Callable[[float], object] | None = None,
    parts: Sequence[Part] = (*FIRST, *LATER),
) -> None:
    """Call every kernel of some parts once on small images; this may happen in a background thread.

    The first time this compiles the kernels and stores them in Numba's cache; later it loads them. After each that is
    compiled `on_progress` is called with the fraction that is done. No part begins once `canceled()` is true.
    """
    whole, counted = sum(_KERNELS.get(part, 0) for part in parts), count(1)

    def tell() -> None:
        if on_progress is not None:
            on_progress(min(next(counted) / max(whole, 1), 1.0))

    with tell_compiled(tell):
        for part in parts:
            if not canceled():
                part()


def warm_up_runs(canceled: Callable[[], bool], on_progress: Callable[[float], object]) -> None:
    """Prepare what a run on an image begins with; a thread prepares the rest while the program is used."""
    begin, *others = FIRST
    warm_up(canceled, on_progress, (begin,))
    _warm_up_meanwhile(canceled, (*others, *LATER))


def warm_up_volumes(
    canceled: Callable[[], bool] = _never, on_progress: Callable[[float], object] | None = None
) -> None:
    """Prepare what a run in a volume needs; a thread prepares clicks in it meanwhile."""
    _warm_up_meanwhile(canceled, (bodies_once,))
    warm_up(canceled, on_progress, VOLUMES)


def _warm_up_meanwhile(canceled: Callable[[], bool], parts: Sequence[Part]) -> None:
    """Start a thread that prepares some parts while the program is used."""
    threading.Thread(target=warm_up, args=(canceled,), kwargs={"parts": parts}, name="cpm-compile").start()


def is_compiled(*, volume: bool = False) -> bool:
    """Whether the kernels of a run, on an image or in a volume, are in Numba's cache and need not be compiled."""
    kernel: Any = volume_motion._move_turn if volume else motion._move_sorted
    folder = kernel.stats.cache_path
    return folder is not None and any(Path(folder).glob(f"*.{kernel.__name__}-*.nbi"))
