"""Compiling the loops of the model before their first use.

The first compilation takes many seconds on two cores: one process compiles the loops of a step and another the rest.
The calling process only waits, so that its window stays responsive. Numba cannot compile in two threads at once, and
two processes must not share a cache folder, where each could overwrite entries of the other. Therefore each process has
its own folder, from which the calling process copies new entries.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from cpm_core.contours.result import Result
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.denoising import clean
from cpm_core.image.image import Image
from cpm_core.image.regions import Regions
from cpm_core.numerics import jit_cache
from cpm_core.numerics.parallel import cores
from cpm_core.objects.partition import partition
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.particles.initialization import circle
from cpm_core.particles.state import State
from cpm_core.particles.volume_starts import sphere
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.methods import CONTOUR_METHODS, Start, run_method

_ROW, _COL = np.indices((32, 32))
_IMAGE = 255.0 * (np.hypot(_ROW - 15.5, _COL - 15.5) < 9.0)
_REGIONS = Regions(interest=(((1, 1), (1, 30), (30, 30), (30, 1)),), barriers=(((5.3, 2.2), (6.1, 28.4)),))
_PARAMETERS = Parameters(scales=2)
_CHARGES = (PlacedCharge((4.0, 4.0), 1.0),)
_CHARGES_IN_VOLUME = (PlacedCharge((4.0, 4.0, 4.0), 1.0),)
_STEPS = 12

_MOST_STEPS = 60
"""Steps in which a run in the small volume ends."""

_LAWS_OF_VOLUMES = "space"
"""Name of the modules of loops for volumes."""

_LOOK_EVERY = 0.05
"""Interval at which the other processes are polled [s]."""


def warm_up(canceled: Callable[[], bool] = lambda: False) -> None:
    """Run every compiled loop once on an image of a small disk; this may happen in a background thread.

    The first time this compiles the loops, in other processes where there is a second core, and stores them in the
    cache; later it loads them. When `canceled()` becomes true the other processes are ended and nothing else is done.
    """
    folder = jit_cache.folder_of_this_package()
    if folder is not None and cores() > 1 and not jit_cache.has_loops(folder):
        _compile_aside(folder, (step_once, reconstruct_once), canceled)
    if canceled():
        return
    engine, state = step_once()
    _choose(engine.result(state, _PARAMETERS))
    engine.energies(state, _PARAMETERS, _CHARGES)
    clean(_IMAGE)
    front_once()


def warm_up_volumes(canceled: Callable[[], bool] = lambda: False) -> None:
    """Run every compiled loop of volumes once on a small ball, as `warm_up` does those of images."""
    folder = jit_cache.folder_of_this_package()
    if folder is not None and cores() > 1 and not any(folder.rglob(f"{_LAWS_OF_VOLUMES}.*.nbi")):
        _compile_aside(folder, (volume_once,), canceled)
    if not canceled():
        volume_once()


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


def step_once() -> tuple[Engine, State]:
    """Run the loops of a step, with and without placed charges, and those of its forces."""
    engine = Engine(_IMAGE, _PARAMETERS, _REGIONS)
    state = engine.start(circle((15.5, 15.5), 5.0))
    for _ in range(_STEPS):
        state = engine.step(state, _PARAMETERS)
    engine.forces(engine.step(state, _PARAMETERS, _CHARGES), _PARAMETERS, _CHARGES)
    return engine, state


def reconstruct_once() -> None:
    """Run the loops of denoising, the reconstruction, the choice of objects and the energies."""
    clean(_IMAGE)
    engine = Engine(_IMAGE, _PARAMETERS, _REGIONS)
    state = engine.start(circle((15.5, 15.5), 9.0))
    _choose(engine.result(state, _PARAMETERS))
    engine.energies(state, _PARAMETERS, _CHARGES)
    front_once()


def front_once() -> None:
    """Run the loops of the level sets that the particles are compared with."""
    start = Start((circle((15.5, 15.5), 5.0),))
    run_method(CONTOUR_METHODS["gac"], Image(_IMAGE), start, max_steps=_STEPS)


def _choose(result: Result) -> None:
    """Run the loops of the choice of objects: of a first click, of further ones, and of a face that clicks cut."""
    faces = partition(result)
    mask = faces.select([(15.0, 15.0)]).mask
    missing, wrong = np.argwhere(~mask)[0], np.argwhere(mask)[-1]
    faces.select([(15.0, 15.0), missing], [wrong, (15.0, 19.0)])


def end_with_the_caller() -> None:
    """End this process when the one that has started it ends, for any reason."""

    def watch() -> None:
        os.read(0, 1)  # nothing is ever sent: this blocks until the other end is closed
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _compile_aside(folder: Path, parts: Sequence[Callable[[], object]], canceled: Callable[[], bool]) -> None:
    """Compile in other processes and copy their caches; what they cannot compile is compiled by the caller."""
    asides = [folder / f"{jit_cache.ASIDE}{os.getpid()}-{part.__name__}" for part in parts]
    processes = []
    try:
        for part, aside in zip(parts, asides, strict=True):
            processes.append(_other_process(part.__name__, aside))
        while any(process.poll() is None for process in processes) and not canceled():
            time.sleep(_LOOK_EVERY)
        for process, aside in zip(processes, asides, strict=True):
            if process.poll() is not None:
                jit_cache.take_over(aside, folder)
    except OSError:
        pass
    finally:
        for process in processes:
            process.kill()
            process.communicate()
        for aside in asides:
            shutil.rmtree(aside, ignore_errors=True)


def _other_process(part: str, aside: Path) -> subprocess.Popen[bytes]:
    if getattr(sys, "frozen", False) or not sys.executable:
        raise FileNotFoundError("there is no interpreter to start")
    found_in = [str(Path(__file__).parents[2]), *filter(None, [os.environ.get("PYTHONPATH")])]
    code = f"from cpm_core.objects import warm_up; warm_up.end_with_the_caller(); warm_up.{part}()"
    return subprocess.Popen(
        # -P: nothing is imported from the current folder of the user
        [sys.executable, "-P", "-c", code],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(found_in), "NUMBA_CACHE_DIR": str(aside)},
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),  # Windows would open a console
    )
