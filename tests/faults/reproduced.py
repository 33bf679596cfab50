"""Runs whose results must be the same everywhere; as a program, it writes the vertices of each for a seed."""

import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np

import cpm_core
from cpm_core import Image, circle, partition, segment, uniform_grid
from cpm_core.parameters import PRESETS

ROOT = Path(__file__).parents[2]
ALONE = dict.fromkeys(("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
HERE = "import runpy; runpy.run_module('tests.faults.reproduced', run_name='__main__', alter_sys=True)"
ON_ONE_CORE = f"import os; os.sched_setaffinity(0, [min(os.sched_getaffinity(0))]); {HERE}"
SIDE = 128
ROW, COL = np.mgrid[:SIDE, :SIDE]
DISKS = sum((np.hypot(ROW - row, COL - col) < radius) * 120.0 for row, col, radius in ((40, 40, 22), (88, 84, 26)))
NOISE = np.random.default_rng(1).normal(0.0, 20.0, (SIDE, SIDE))


def from_a_circle(faint):
    return segment(DISKS + faint, circle((40, 40), 9), PRESETS["shape"]).contours


def from_everywhere(faint):
    return segment(DISKS + 0.2 * NOISE + faint, uniform_grid((SIDE, SIDE), 6), PRESETS["automatic"]).contours


def in_noise(faint):
    return segment(DISKS + NOISE + faint, circle((88, 84), 12), PRESETS["noisy"]).contours


def of_vessels(faint):
    curves = 60.0 * (np.abs(ROW - 64.0 - 20.0 * np.sin(COL / 20.0)) < 2.0)
    return segment(curves + 0.2 * NOISE + faint, uniform_grid((SIDE, SIDE), 6), PRESETS["vessels"]).contours


def of_skeletons(faint):
    ellipse = np.hypot((ROW - 64.0) / 18.0, (COL - 64.0) / 50.0) < 1.0
    return cpm_core.skeleton(120.0 * ellipse + 0.1 * NOISE + faint).contours


def by_clicks(faint):
    image = Image(DISKS + 0.2 * NOISE + faint)
    found = segment(image, uniform_grid((SIDE, SIDE), 8), PRESETS["automatic"])
    return partition(found).select([(40, 40)]).contours


RUNS = {run.__name__: run for run in (from_a_circle, from_everywhere, in_noise, of_vessels, of_skeletons, by_clicks)}


def vertices(seed=0):
    """The vertices of the contours of each run, by its name; each seed has images of its own."""
    faint = np.random.default_rng(seed).normal(0.0, 2.0, (SIDE, SIDE)) if seed else 0.0
    return {name: [contour.points for contour in run(faint)] for name, run in RUNS.items()}


def on_one_core(seed):
    """The same of a process that may use one core and one thread only."""
    command = [sys.executable, "-c", ON_ONE_CORE, str(seed)]
    done = subprocess.run(command, cwd=ROOT, env=os.environ | ALONE, capture_output=True, check=True)
    return pickle.loads(done.stdout)


def apart(one, other):
    """Largest distance along an axis of two sets of contours, vertex by vertex [px]; infinite for other contours."""
    if [part.shape for part in one] != [part.shape for part in other]:
        return np.inf
    return max((float(np.abs(a - b).max()) for a, b in zip(one, other, strict=True)), default=0.0)


if __name__ == "__main__":
    sys.stdout.buffer.write(pickle.dumps(vertices(int(sys.argv[1]))))
