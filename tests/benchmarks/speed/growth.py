"""Time and memory as the work grows: the table that ``python -m tests.benchmarks.speed --growth`` prints.

Each row is measured in a process of its own, so that its peak of memory is that of this work: what is in use beyond the
input, the libraries and the compiled loops. The limit is what cannot be left out, measured in the same process: the
Fourier transforms of a field, or else to move once, at the speed at which memory is copied, what goes in and comes out.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from math import log
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy

from cpm_core.field.edge_map import edge_map
from cpm_core.model.coulomb import coulomb_force
from cpm_core.model.starts import circle, uniform_grid
from cpm_core.model.volume.starts import sphere
from cpm_core.numerics.types import Pixels
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.published.electric_field import electric_field
from cpm_core.segmentation.evolve import segment
from tests.benchmarks.speed.measurement import Patience, seconds_of
from tests.benchmarks.speed.scenes import along_curves, one_object, ring, tiled
from tests.benchmarks.speed.steps import under_way

_PATIENCE = Patience(seconds=0.5, repeats=5)

_COPIED = 1 << 27
"""Bytes that are copied to measure the speed of memory: more than fit into a cache."""

_LONG = 2.0
"""Time from which the first of several repeats is enough [s]."""


class Work(NamedTuple):
    """Something to measure: pixels, particles or voxels, and the least that it could be done with."""

    size: int
    do: Callable[[], object]
    moved: int  # bytes
    transforms: Callable[[], object] | None = None
    times: int = 1  # how often it is done at once


def _field(values: Pixels) -> Work:
    charges = edge_map(values)
    return Work(values.size, lambda: electric_field(charges), 0, partial(_transforms, values.shape, np.float64))


def _transforms(shape: tuple[int, ...], precision: type) -> None:
    """The transforms of a convolution with as many components as axes, padded to keep the borders apart."""
    padded = [scipy.fft.next_fast_len(2 * n - 1, True) for n in shape]
    spectrum = scipy.fft.rfftn(np.zeros(shape, precision), padded, workers=-1)
    for _ in shape:
        scipy.fft.irfftn(spectrum, padded, workers=-1)


def _everywhere(side: int) -> Work:
    values = tiled(side)
    run = partial(segment, values, uniform_grid(values.shape), PRESETS["automatic"])
    return Work(values.size, run, 0, partial(_transforms, values.shape, np.float32))


def _circle(side: int) -> Work:
    values = tiled(side)
    return Work(values.size, partial(segment, values, circle(one_object(values.shape), 12.0)), values.nbytes)


def _coulomb(count: int) -> Work:
    points = along_curves(count)
    return Work(len(points), partial(coulomb_force, points), 2 * points.nbytes)


def _step(side: int) -> Work:
    parameters = Parameters(scales=1)
    engine, state = under_way(side, parameters)
    count = 10

    def some() -> None:
        now = state
        for _ in range(count):
            now = engine.step(now, parameters)

    return Work(len(state.position), some, 4 * state.position.nbytes * count, times=count)


def _surface(side: int) -> Work:
    values, middle = ring(side), 0.5 * (side - 1)
    start = sphere((middle, middle + 0.28 * side, middle), 0.08 * side, 150)
    return Work(values.size, partial(segment, values, start, PRESETS["volume"]), values.nbytes)


_SIDES = (500, 1000, 2000, 4000, 6000)
ROWS: dict[str, tuple[Callable[[int], Work], tuple[int, ...]]] = {
    "field, pixels": (lambda side: _field(tiled(side)), _SIDES),
    "run from everywhere, pixels": (_everywhere, _SIDES),
    "run from a circle, pixels": (_circle, _SIDES),
    "Coulomb force, particles": (_coulomb, (1_000, 10_000, 100_000, 1_000_000)),
    "step, particles": (_step, (250, 765, 2420)),
    "field, voxels": (lambda side: _field(ring(side)), (64, 128, 256)),
    "run to a surface, voxels": (_surface, (64, 128, 256, 512)),
}


def table() -> Iterator[str]:
    """The lines of the table, each as soon as it is known."""
    yield "| what | how many | time | exponent | memory | exponent | share of the limit |"
    yield "|---|---|---|---|---|---|---|"
    for what, (_, sizes) in ROWS.items():
        fewer, before = 1, (0.0, 0.0)
        for size in sizes:
            command = [sys.executable, "-m", __spec__.name, what, str(size)]
            count, seconds, memory, least = json.loads(subprocess.check_output(command, text=True))
            cells = [what if size == sizes[0] else "", f"{count:,}"]
            for now, then, unit in zip((1e3 * seconds, memory / 1e6), before, ("ms", "MB"), strict=True):
                cells += [
                    f"{float(f'{now:.3g}'):,g} {unit}",
                    f"{log(now / then) / log(count / fewer):.2f}" if then else "",
                ]
            fewer, before = count, (1e3 * seconds, memory / 1e6)
            yield f"| {' | '.join(cells)} | {least / seconds:.2g} |"


def measured(what: str, size: int) -> tuple[int, float, int, float]:
    """How many, time [s], memory [bytes] and the limit of the time [s] of a row."""
    make, sizes = ROWS[what]
    make(sizes[1]).do()  # loads the compiled loops; few particles are summed without a tree
    work = make(size)
    Path("/proc/self/clear_refs").write_text("5")  # forgets the peak
    began = _memory("VmRSS")
    start = time.perf_counter()
    work.do()
    seconds = time.perf_counter() - start
    memory = max(_memory("VmHWM") - began, 1 << 20)
    if seconds < _LONG:
        (seconds,) = seconds_of(_PATIENCE, work.do)
    if work.transforms:
        (least,) = seconds_of(_PATIENCE, work.transforms)
    else:
        source = np.ones(_COPIED, np.uint8)
        (copied,) = seconds_of(_PATIENCE, partial(np.copyto, np.empty_like(source), source))
        least = copied * work.moved / (2 * _COPIED)
    return work.size, seconds / work.times, memory, least / work.times


def _memory(what: str) -> int:
    """Memory of this process, or its peak, in bytes."""
    found = re.search(rf"{what}:\s+(\d+) kB", Path("/proc/self/status").read_text())
    return 1024 * int(found[1]) if found else 0


if __name__ == "__main__":
    print(json.dumps(measured(sys.argv[1], int(sys.argv[2]))))
