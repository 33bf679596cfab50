"""A volume of 1024^3 voxels with bodies of known surface: made by parts, and what was found is judged.

python tests/benchmarks/large_volume.py make bodies.zarr 1024
python tests/benchmarks/large_volume.py run bodies.zarr labels.zarr bodies.ply bodies.csv
python tests/benchmarks/large_volume.py judge 1024 bodies.ply bodies.csv

The second is cpm run bodies.zarr --auto gradient --workers 2 --export ..., with the memory of its processes sampled.
Bodies are balls, ellipsoids and tori around the points of a lattice, a third of them across seams of 256 voxels.
"""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import psutil
import scipy

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from cpm_core.numerics.grids import zero_surface
from tests.benchmarks.lattice import REACH, count_along, draw_part, make, print_verdict

PITCH, TILE, TOLERANCE = 97.0, 256, 2.0


def body(place):
    """Center of the body in a place of the lattice, its level, and its distance inside at positions from there."""
    rng = np.random.default_rng(list(place))
    center = (np.array(place) + 0.5) * PITCH + rng.uniform(-6.0, 6.0, 3)
    level, kind = rng.uniform(90.0, 190.0), rng.integers(3)
    axes = rng.permutation(3)
    long, middle, short = rng.uniform(20.0, 32.0), rng.uniform(14.0, 20.0), rng.uniform(9.0, 14.0)

    def inside(positions):
        a, b, c = (positions[axis] for axis in axes)
        if kind == 0:
            return middle - np.sqrt(a * a + b * b + c * c)
        if kind == 1:
            return short / 2.0 - np.sqrt((np.sqrt(a * a + b * b) - middle) ** 2 + c * c)
        scaled = np.maximum(np.sqrt((a / long) ** 2 + (b / middle) ** 2 + (c / short) ** 2), 1e-6)
        steep = np.sqrt((a / long**2) ** 2 + (b / middle**2) ** 2 + (c / short**2) ** 2)
        return scaled * (1.0 - scaled) / np.maximum(steep, 1e-9)  # the distance to first order

    return center, level, inside


def paint(place):
    """What `draw_part` wants of the body in a place."""
    center, level, inside = body(place)
    return center, level, lambda at: np.clip(inside(at) + 0.5, 0.0, 1.0)


def run(path, files):
    """The run, and the largest sum of the memory of its processes."""
    command = [sys.executable, "-m", "cpm_app", "run", path, "--auto", "gradient", "--workers", "2", "--export", *files]
    began, most, largest = time.perf_counter(), 0, 0
    with subprocess.Popen(command) as process:
        while process.poll() is None:
            sizes = [0]
            for one in [psutil.Process(process.pid), *psutil.Process(process.pid).children(recursive=True)]:
                try:
                    sizes.append(one.memory_info().rss)
                except psutil.Error:
                    continue
            most, largest = max(most, sum(sizes)), max(largest, *sizes)
            time.sleep(0.5)
    print(
        f"{time.perf_counter() - began:.0f} s, {most / 2**30:.2f} GiB in all, {largest / 2**30:.2f} GiB in one process"
    )


def judge(side, surface, table):
    """Each true body: how many were found around its center, and how far the surfaces are apart."""
    head, _, rest = Path(surface).read_bytes().partition(b"end_header\n")
    counts = [int(line.split()[2]) for line in head.decode().splitlines() if line.startswith("element")]
    vertices = np.frombuffer(rest, "<f4", 3 * counts[0]).reshape(-1, 3)[:, ::-1] / 0.5
    last = count_along(side, PITCH) - 1
    lattice = np.array(list(np.ndindex((last + 1,) * 3)))
    centers = np.loadtxt(table, delimiter=",", skiprows=1)[:, 3:] / 0.5
    where = (last + 1,) * 3
    number = np.bincount(_place(centers, last, where), minlength=len(lattice))
    of_vertex = _place(vertices, last, where)
    order = np.argsort(of_vertex, kind="stable")
    firsts = np.searchsorted(of_vertex[order], np.arange(len(lattice) + 1))
    rows = []
    for at, place in enumerate(lattice.tolist()):
        center, _, inside = body(place)
        own = vertices[order[firsts[at] : firsts[at + 1]]] - center
        grid = np.mgrid[-REACH : REACH + 1, -REACH : REACH + 1, -REACH : REACH + 1].astype(float)
        true = zero_surface(inside(grid).astype(np.float32))[0] - REACH
        back = scipy.spatial.KDTree(own).query(true)[0] if len(own) else np.full(len(true), np.inf)
        box = np.array([true.min(0), true.max(0)]) + center
        seam = bool((box[0] // TILE != box[1] // TILE).any())
        rows.append((number[at], seam, np.abs(inside(own.T)), back))
    for name, some in (("across seams", [r for r in rows if r[1]]), ("elsewhere", [r for r in rows if not r[1]])):
        found, away, back = np.array([r[0] for r in some]), *(np.concatenate([r[k] for r in some]) for k in (2, 3))
        print_verdict(f"bodies {name}", found, away, back, TOLERANCE, "voxels")


def _place(positions, last, where):
    """Number of the place of the lattice that each position is nearest to."""
    at = np.clip(positions // PITCH, 0, last).astype(int)
    return np.ravel_multi_index(tuple(at.T), where)


if __name__ == "__main__":
    if sys.argv[1] == "make":
        side = int(sys.argv[3])
        make(Path(sys.argv[2]), (side,) * 3, TILE, 0.5, lambda window: draw_part(window, side, PITCH, 30.0, paint))
    elif sys.argv[1] == "run":
        run(sys.argv[2], sys.argv[3:])
    else:
        judge(int(sys.argv[2]), *sys.argv[3:])
