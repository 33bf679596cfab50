"""Compiling the model's loops ahead of their first use.

The first time ever takes many seconds of two cores: one process compiles what a step needs and another the rest, while
this one only waits, so that a window beside it moves freely. Numba cannot compile in two threads at once, nor may two
processes keep loops in one folder, where each could overwrite what the other has noted of a loop that both compile;
therefore each has a folder of its own, from which this one takes over what is new to it.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.denoising import clean
from cpm_core.image.regions import Regions
from cpm_core.numerics import jit_cache
from cpm_core.numerics.parallel import cores
from cpm_core.parameters import Parameters
from cpm_core.particles.initialization import circle
from cpm_core.particles.state import State
from cpm_core.segmentation.engine import Engine

_ROW, _COL = np.indices((32, 32))
_DISK = 255.0 * (np.hypot(_ROW - 15.5, _COL - 15.5) < 9.0)
_REGIONS = Regions(interest=(((1, 1), (1, 30), (30, 30), (30, 1)),), barriers=(((5.3, 2.2), (6.1, 28.4)),))
_PARAMETERS = Parameters(scales=2)
_CHARGES = (PlacedCharge((4.0, 4.0), 1.0),)
_STEPS = 12

_LOOK_EVERY = 0.05
"""Time between two looks at whether the other processes are done [s]."""


def warm_up(unwanted: Callable[[], bool] = lambda: False) -> None:
    """Run every compiled loop once on a small disk.

    The first time ever this compiles them, in other processes where there is a second core, and keeps them on disk;
    later it loads them. It may run in a thread of its own while a window is being shown.

    Parameters
    ----------
    unwanted : callable
        Asked while other processes compile; these are ended, and nothing else is done, as soon as it is true.
    """
    folder = jit_cache.folder_of_this_package()
    if folder is not None and cores() > 1 and not any(folder.rglob("*.nbi")):
        _compile_aside(folder, unwanted)
    if unwanted():
        return
    engine, state = step_once()
    engine.result(state, _PARAMETERS)
    engine.energies(state, _PARAMETERS, _CHARGES)
    clean(_DISK)


def step_once() -> tuple[Engine, State]:
    """Run the loops of a step, with placed charges too, and those that tell its forces."""
    engine = Engine(_DISK, _PARAMETERS, _REGIONS)
    state = engine.start(circle((15.5, 15.5), 5.0))
    for _ in range(_STEPS):
        state = engine.step(state, _PARAMETERS)
    engine.forces(engine.step(state, _PARAMETERS, _CHARGES), _PARAMETERS, _CHARGES)
    return engine, state


def reconstruct_once() -> None:
    """Run the loops of the reconstruction and of the energies, and those that clean an image."""
    clean(_DISK)
    engine = Engine(_DISK, _PARAMETERS, _REGIONS)
    state = engine.start(circle((15.5, 15.5), 9.0))
    engine.result(state, _PARAMETERS)
    engine.energies(state, _PARAMETERS, _CHARGES)


def end_with_the_caller() -> None:
    """End this process as soon as the one that has started it is gone, however that came to its end."""

    def watch() -> None:
        os.read(0, 1)  # nothing is ever sent, so that this lasts until the other end is closed
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _compile_aside(folder: Path, unwanted: Callable[[], bool]) -> None:
    """Let other processes compile, and take over what they have kept.

    Where there can be none, as in a frozen program, nothing is lost but time: whatever is not kept is compiled here.
    """
    asides = [folder / f"aside-{os.getpid()}-{part.__name__}" for part in (step_once, reconstruct_once)]
    processes = []
    try:
        for part, aside in zip((step_once, reconstruct_once), asides, strict=True):
            processes.append(_other_process(part.__name__, aside))
        while any(process.poll() is None for process in processes) and not unwanted():
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
    code = f"from cpm_core.segmentation import warm_up; warm_up.end_with_the_caller(); warm_up.{part}()"
    return subprocess.Popen(
        # -P: nothing is imported from the folder that the user happens to be in
        [sys.executable, "-P", "-c", code],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(found_in), "NUMBA_CACHE_DIR": str(aside)},
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),  # Windows would open a console
    )
