"""``cpm bench``: measures how long whole runs and their parts take on this machine."""

from __future__ import annotations

import argparse
import os
import platform
import time
from collections.abc import Iterator
from statistics import median
from timeit import repeat

import numpy as np

from cpm_core.cli.output import print_json
from cpm_core.model.starts import circle, uniform_grid
from cpm_core.numerics.types import Array, Callback, JsonDict
from cpm_core.parameters import PRESETS
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.evolve import segment

_DISK_PITCH = 64
"""Distance between the centers of neighboring disks of the scene [px]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("--quick", action="store_true", help="Measure a smaller scene once.")


def run_benchmarks(arguments: argparse.Namespace) -> None:
    """Measure, and print each time as soon as it is known."""
    began, machine = time.perf_counter(), describe_machine()
    values, repeats = _build_scene(2 if arguments.quick else 6), 1 if arguments.quick else 5
    rows: list[JsonDict] = []
    for what, work in _list_measurements(values):
        work()  # compiles
        rows.append({"what": what, "value": 1e3 * median(repeat(work, number=1, repeat=repeats)), "unit": "ms"})
        if not arguments.json:
            print(f"{what:44}{rows[-1]['value']:10.1f} ms", flush=True)
    if arguments.json:
        facts = {"machine": machine, "quick": arguments.quick, "seconds": time.perf_counter() - began}
        print_json(arguments.name, facts | {"measurements": rows})
    else:
        print(", ".join(f"{name} {value}" for name, value in machine.items()))


def describe_machine() -> dict[str, str | int | None]:
    """Return what times depend on: cores, processor, system and libraries."""
    from importlib.metadata import version  # noqa: PLC0415 - takes long, and every command imports this module

    return {
        "cores": os.cpu_count(),
        "processor": platform.machine(),
        "system": platform.system(),
        "python": platform.python_version(),
        **{name: version(name) for name in ("numpy", "scipy", "scikit-image", "numba")},
    }


def _build_scene(side: int) -> Array:
    """Return gray levels of side x side bright disks on a noisy background."""
    row, col = np.indices((side * _DISK_PITCH, side * _DISK_PITCH)) % _DISK_PITCH - _DISK_PITCH / 2
    disks = np.clip(20.5 - np.hypot(row, col), 0.0, 1.0)
    return 50.0 + 150.0 * disks + np.random.default_rng(0).normal(0.0, 2.0, disks.shape)


def _list_measurements(values: Array) -> Iterator[tuple[str, Callback]]:
    """Yield a title and a function for each measurement; the function does once what is timed."""
    size, automatic = " x ".join(map(str, values.shape)), PRESETS["automatic"]
    grid = uniform_grid(values.shape)
    yield f"{size} px, starts everywhere", lambda: segment(values, grid, automatic)
    yield f"{size} px, circle in one object", lambda: segment(values, circle((_DISK_PITCH / 2, _DISK_PITCH / 2), 12.0))
    yield f"{size} px, all fields", lambda: Engine(values, automatic)
    engine = Engine(values, automatic)
    state = engine.start(grid)
    for _ in range(50):
        state = engine.step(state, automatic)
    yield f"{size} px, one step of {state.count} particles", lambda: engine.step(state, automatic)
