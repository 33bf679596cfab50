"""Surfaces in volumes beside morphological geodesic active contours, from the same sphere; prints a table.

Run by itself: ``python tests/benchmarks/volume_peers.py [VOLUME LEVEL]``. The volume is a torus of 128 x 128 x 128
voxels, or 128 voxels each way around the widest place of a volume in a file, whose true surface is then that of its
largest part above a gray level. *Covered* is the share of the true surface with a vertex or the middle of a triangle
within 2 voxels; *precise* is the share of these within 1.5 voxels of the true surface. The peer runs until it covers
as much as ours to a hundredth, or covers no more; what it costs to measure that does not count. Compilation is left
out. Times are of the clock and, in brackets, of the processor.
"""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import scipy
from skimage.measure import marching_cubes
from skimage.segmentation import inverse_gaussian_gradient, morphological_geodesic_active_contour

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from cpm_core import PRESETS, Surface, load_volume, segment, sphere
from cpm_core.numerics.types import Array, Mask

SIDE, COUNT = 128, 625
COVERED, PRECISE = 2.0, 1.5
EVERY, PATIENCE, MOST = 10, 4, 1000
"""Iterations between two looks at the peer, looks without gain after which it ends, and the most iterations."""

GAIN = 0.001
SETTINGS = ((1, 0.35), (0, 0.35), (1, 0.5), (0, 0.5))
"""Smoothing of the peer, and its threshold: it grows where the inverse of the gradient is above."""

CONTRAST, BACKGROUND = 200.0, 20.0


def torus() -> tuple[Array, Mask, tuple[float, float, float], float]:
    """A torus with its inside, and a sphere in it."""
    middle = (SIDE - 1) / 2
    plane, row, col = (axis - middle for axis in np.ogrid[:SIDE, :SIDE, :SIDE])
    signed = np.hypot(np.hypot(row, col) - 36.0, plane) - 16.0
    noise = np.random.default_rng(0).normal(0.0, 2.0, signed.shape)
    return BACKGROUND + CONTRAST * np.clip(0.5 - signed, 0.0, 1.0) + noise, signed < 0.0, (middle, middle, 28.0), 8.0


def part_of(path: str, level: float) -> tuple[Array, Mask, tuple[float, float, float], float]:
    """The volume around the widest place of what is above a level, its largest part, and the largest ball there."""
    values = np.asarray(load_volume(path).values, float)
    inside = largest(values > level)
    depth = scipy.ndimage.distance_transform_edt(inside)
    widest = np.unravel_index(depth.argmax(), depth.shape)
    begin = [max(0, min(at - SIDE // 2, side - SIDE)) for at, side in zip(widest, values.shape, strict=True)]
    box = tuple(slice(at, at + SIDE) for at in begin)
    center = tuple(float(at - first) for at, first in zip(widest, begin, strict=True))
    return values[box], largest(inside[box]), (center[0], center[1], center[2]), max(3.0, float(depth.max()))


def largest(mask: Mask) -> Mask:
    """The largest connected part of a mask."""
    labels, _ = scipy.ndimage.label(mask, np.ones((3, 3, 3)))
    return np.asarray(labels == np.bincount(labels[mask]).argmax())


def places(vertices: Array, faces: Array) -> Array:
    """Vertices and middles of triangles."""
    return np.concatenate([vertices, vertices[faces].mean(1)])


def surface_of(inside: Mask) -> Array:
    """Places on the surface of a mask; none when there is no surface."""
    if inside.all() or not inside.any():
        return np.zeros((0, 3))
    return places(*marching_cubes(np.pad(inside, 1).astype(np.float32), 0.5)[:2]) - 1.0


def judged(found: Array, true: Array) -> tuple[float, float]:
    """Share of the true surface that is covered, and share of what is found that is precise."""
    if not len(found):
        return 0.0, 0.0
    near = scipy.spatial.KDTree(found).query(true, distance_upper_bound=COVERED)[0] < COVERED
    on = scipy.spatial.KDTree(true).query(found, distance_upper_bound=PRECISE)[0] < PRECISE
    return float(near.mean()), float(on.mean())


def timed(work: Callable[[], Surface | None]) -> tuple[Surface | None, float, float]:
    """What a piece of work gives, and its seconds by the clock and of the processor."""
    clock, processor = time.perf_counter(), time.process_time()
    done = work()
    return done, time.perf_counter() - clock, time.process_time() - processor


class Peer:
    """Morphological geodesic active contours, with a balloon force, that are watched on their way."""

    def __init__(
        self, values: Array, start: Mask, true: Array, enough: float, smoothing: int, threshold: float
    ) -> None:
        self.looks = [(0.0, 0.0)]
        self.clock = self.processor = 0.0
        self.iteration = -1
        self._true, self._enough = true, enough
        self._began = time.perf_counter(), time.process_time()
        edges = inverse_gaussian_gradient(values / values.max(), sigma=1.0)
        with contextlib.suppress(StopIteration):
            morphological_geodesic_active_contour(edges, MOST, start, smoothing, threshold, 1, self._look)

    def _look(self, inside: Array) -> None:
        self.clock += time.perf_counter() - self._began[0]
        self.processor += time.process_time() - self._began[1]
        self.iteration += 1
        if self.iteration and self.iteration % EVERY == 0:
            self.looks.append(judged(surface_of(inside > 0), self._true))
            before = max(covered for covered, _ in self.looks[: max(1, len(self.looks) - PATIENCE)])
            stuck = len(self.looks) > PATIENCE and self.looks[-1][0] < before + GAIN
            if self.looks[-1][0] >= self._enough or stuck:
                raise StopIteration
        self._began = time.perf_counter(), time.process_time()


def main() -> None:
    """Print a line for ours and one for each setting of the peer."""
    values, inside, center, radius = part_of(sys.argv[1], float(sys.argv[2])) if len(sys.argv) > 2 else torus()
    true, seeds = surface_of(inside), sphere(center, radius, COUNT)
    segment(values, seeds, PRESETS["volume"], max_steps=20)  # compiles the loops
    surface, clock, processor = timed(lambda: segment(values, seeds, PRESETS["volume"]).surface)
    assert surface is not None
    covered, precise = judged(places(surface.vertices, surface.faces), true)
    tell("ours", (covered, precise), clock, processor)
    grid = np.stack(np.indices(values.shape), -1)
    start = (np.linalg.norm(grid - center, axis=-1) <= radius).astype(np.int8)
    for smoothing, threshold in SETTINGS:
        peer = Peer(values, start, true, covered - 0.01, smoothing, threshold)
        name = f"morphological GAC {smoothing} {threshold}, {peer.iteration} it"
        tell(name, peer.looks[-1], peer.clock, peer.processor, f"  ours / it {processor / peer.processor:.2f}")


def tell(name: str, shares: tuple[float, float], clock: float, processor: float, more: str = "") -> None:
    """Write a line of the table."""
    covered, precise = shares
    text = f"{name:36} covered {covered:.3f} precise {precise:.3f} {clock:6.1f} s ({processor:.1f} s){more}\n"
    sys.stdout.write(text)
    sys.stdout.flush()


if __name__ == "__main__":
    main()
