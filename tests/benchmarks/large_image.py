"""An image of 30,000 x 30,000 px with 10^5 nuclei of known outline: made by parts, and what was found is judged.

python tests/benchmarks/large_image.py make nuclei.zarr 30000
cpm run nuclei.zarr --auto gradient --scales 1 --d-min 3 --smoothing 2 --edge-floor 0.15 --export l.zarr g.geojson t.csv
python tests/benchmarks/large_image.py judge 30000 g_*.geojson
python tests/benchmarks/large_image.py speed nuclei.zarr 12
python tests/benchmarks/large_image.py objects 2000 1024

The one before last finds the contours of so many chunks with one worker and with two. The last one draws objects of
many sizes and finds them in chunks of this side, and in one piece: between the same contours, and between those of a
run in one piece.
"""

import json
import sys
import tempfile
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import scipy

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import cpm_core as cpm
from cpm_core.chunked.chunked_contours import CONTOURS_KIND, ChunkedTask
from cpm_core.chunked.grid import ChunkedSource, build_grid
from cpm_core.chunked.image_statistics import GrayScaling, ImageStatistics
from cpm_core.chunked.run import find_contours_in_chunk, run_chunks
from cpm_core.chunked.store import RunStore
from cpm_core.cli.workers import connect_to_dask, map_until_finished, run_on_one_core
from cpm_core.contours.agreement import DEFAULT_TOLERANCE, distances_to_contours
from cpm_core.contours.contour import Contour, sample_contours
from cpm_core.formats.images.ome_zarr import create_multiscale, write_window
from cpm_core.formats.images.reading import Reading
from cpm_core.numerics.parallel import limit_cores
from tests.benchmarks.lattice import count_along, draw_part, make, print_verdict

PITCH, TILE, BLUR = 94.9, 1024, 0.8


def nucleus(place):
    """Center, level, and radius at each of some angles, of the nucleus in a place of the lattice."""
    rng = np.random.default_rng(place)
    center = (np.array(place) + 0.5) * PITCH + rng.uniform(-12.0, 12.0, 2)
    long, short, turn = rng.uniform(18.0, 26.0), rng.uniform(13.0, 18.0), rng.uniform(0.0, np.pi)
    wave, phase, level = rng.uniform(0.0, 0.06), rng.uniform(0.0, 2.0 * np.pi), rng.uniform(90.0, 190.0)

    def radius(angle):
        ellipse = long * short / np.hypot(short * np.cos(angle - turn), long * np.sin(angle - turn))
        return ellipse * (1.0 + wave * np.cos(3.0 * angle + phase))

    return center, level, radius


def paint(place):
    """What `lattice.draw_part` wants of the nucleus in a place."""
    center, level, radius = nucleus(place)
    return center, level, lambda at: 1.0 / (1.0 + np.exp((np.hypot(*at) - radius(np.arctan2(*at))) / BLUR))


def outline(place):
    """The true boundary of a nucleus."""
    center, _, radius = nucleus(place)
    angle = np.linspace(0.0, 2.0 * np.pi, 128, endpoint=False)
    return Contour(center + radius(angle)[:, None] * np.stack([np.sin(angle), np.cos(angle)], axis=1), True)


def judge(side, files):
    """Each true nucleus and the contours around its center: how many there are, and how far boundaries are apart."""
    found = {}
    for file in files:
        for feature in json.loads(Path(file).read_text())["features"]:
            if feature["properties"]["closed"]:
                points = np.array(feature["geometry"]["coordinates"][0])[:-1, ::-1] - 0.5
                place = tuple(np.clip(points.mean(axis=0) // PITCH, 0, count_along(side, PITCH) - 1).astype(int))
                found.setdefault(place, []).append(Contour(points, True))
    places = list(np.ndindex((count_along(side, PITCH),) * 2))
    away, back = [], []
    for place in places:
        mine, true = found.get(place, []), [outline(place)]
        if mine:
            away.append(distances_to_contours(sample_contours(mine), true))
        back.append(distances_to_contours(sample_contours(true), mine))
    numbers = [len(found.get(place, [])) for place in places]
    print_verdict("nuclei", numbers, np.concatenate(away), np.concatenate(back), DEFAULT_TOLERANCE, "px")


def speed(path, count):
    """Time for some chunks with one worker and with two, each after a chunk that warms it up."""
    parameters = cpm.Parameters(scales=1, d_min=3.0, smoothing=2.0, edge_floor=0.15)
    tone = GrayScaling(0.0, 255.0, 1.0, 2.0, (0, 0, 10**6, 10**6))
    whole = ImageStatistics(tone, (45.0,), (6.75,))
    source = ChunkedSource(path, Reading())
    grid = build_grid(source.levels.shape, parameters, 2.0)
    chunks = [chunk for chunk in grid.chunks if min(side.start for side in chunk.core) > 0][: count + 2]
    for workers in (1, 2):
        with tempfile.TemporaryDirectory() as folder, connect_to_dask(None, workers) as client:
            task = ChunkedTask(source, parameters, "gradient", RunStore(Path(folder)))
            work = partial(run_on_one_core, partial(find_contours_in_chunk, task, grid, whole))
            for some in (chunks[:workers], chunks[2:]):
                began = time.perf_counter()
                for _, future in map_until_finished(client, work, some):
                    future.result()
            print(f"{workers} workers: {len(some)} chunks in {time.perf_counter() - began:.1f} s", flush=True)


def of_many_sizes(side):
    """Ellipses with radii from 11 to 330 px that do not touch, some with a second one in them, and noise."""
    rng, values, known = np.random.default_rng(1), np.full((side, side), 30.0), []
    row, col = np.indices(values.shape)
    for size, count in ((330, 2), (180, 3), (90, 8), (45, 40), (22, 90), (11, 120)):
        for _ in range(count * 20):
            middle = rng.integers(size // 2, side - size // 2, 2)
            narrow, level = rng.uniform(0.6, 1.0), rng.uniform(80.0, 200.0)
            if all(np.hypot(*(middle - other)) > 1.15 * (size + far) + 6 for other, far in known):
                known.append((middle, size))
                away = np.hypot(row - middle[0], (col - middle[1]) / narrow)
                values[away < size] = level
                values[away < 0.35 * size * (rng.uniform() < 0.3)] = level + 40.0
    blurred = scipy.ndimage.gaussian_filter(values, 1.2) + rng.normal(0.0, 4.0, values.shape)
    return np.clip(np.rint(blurred), 0, 255).astype(np.uint8)


def serial(function, some, title):
    began = time.process_time()
    yield from ((at, run_on_one_core(function, job)) for at, job in enumerate(some))
    print(f"{title}: {len(some)} chunks, {time.process_time() - began:.1f} s of processor time", flush=True)


def objects(side, core):
    """How objects that are found chunk by chunk differ from those in one piece."""
    values, parameters = of_many_sizes(side), cpm.Parameters(smoothing=1.5)
    with tempfile.TemporaryDirectory() as folder:
        path, store = Path(folder) / "drawn.zarr", RunStore(Path(folder) / "chunks")
        create_multiscale(path, values.shape, values.dtype, TILE)
        write_window(path, np.s_[:, :], values)
        task = ChunkedTask(ChunkedSource(path, Reading()), parameters, "grid", store, None, True)
        found = run_chunks(task, serial, core)
        several = {}
        for contour in (one for at in range(len(found.counts)) for one in found.read_chunk_contours(at)):
            several.setdefault(contour.group, []).append(contour)
        between = replace(found, kind=CONTOURS_KIND, counts=(0,) * len(found.counts))
        same = [one for at in range(len(found.counts)) for one in between.read_chunk_contours(at)]
    with limit_cores(1):
        result = cpm.segment(cpm.Image(values), cpm.uniform_grid(values.shape), parameters)
        for title, contours in (("the same contours", same), ("those of a run in one piece", result.contours)):
            left, apart = list(several.values()), []
            whole = cpm.select_all(replace(cpm.partition(result), contours=tuple(contours)))
            for one in whole:
                nearest = min(left, key=lambda other: np.abs(box(other) - box(one.contours)).max(), default=None)
                if nearest and np.abs(box(nearest) - box(one.contours)).max() < 12.0:
                    left = [other for other in left if other is not nearest]
                    ways = ((one.contours, nearest), (nearest, one.contours))
                    apart.append(
                        max(distances_to_contours(np.concatenate([c.points for c in a]), b).max() for a, b in ways)
                    )
            print(f"{title}: {len(whole)} objects in one piece, {len(apart)} also in chunks, {len(left)} only there; "
                  f"{sum(np.array(apart) > 0.05)} differ by more than 0.05 px, at most {max(apart):.3f}")  # fmt: skip


def box(contours):
    """First and last row and column of an object."""
    return max(contours, key=lambda one: one.length).box


if __name__ == "__main__":
    if sys.argv[1] == "objects":
        objects(int(sys.argv[2]), int(sys.argv[3]))
    elif sys.argv[1] == "make":
        side = int(sys.argv[3])
        make(Path(sys.argv[2]), (side, side), TILE, 0.25, lambda window: draw_part(window, side, PITCH, 20.0, paint))
    elif sys.argv[1] == "speed":
        speed(Path(sys.argv[2]), int(sys.argv[3]))
    else:
        judge(int(sys.argv[2]), sys.argv[3:])
