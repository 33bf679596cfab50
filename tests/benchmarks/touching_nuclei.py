"""Objects that a run everywhere proposes in stacks of 40 touching nuclei; prints a table.

Run by itself: ``python tests/benchmarks/touching_nuclei.py [SEED...]``. Nuclei are ellipsoids of random sides, turns
and brightness; half of them are put against one that is there already. The stack is blurred, and noise is added. A
nucleus is *found* when a proposal overlaps it by half or more (intersection over union).
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
import scipy
from numpy.random import Generator

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from cpm_core import PRESETS, Selection, seeds_everywhere, segment
from cpm_core.numerics.types import Array, Index, Mask

COUNT, SHAPE = 40, (72, 168, 168)
RADII = 6.0, 11.0
TOUCHING = 0.5
OVERLAP = 0.04
"""Share of a nucleus up to which it is pushed into the one that it touches, and loses these voxels to."""

BLUR, NOISE = 1.2, 8.0
FOUND_IOU = 0.5


def draw_nuclei(
    seed: int, count: int = COUNT, shape: tuple[int, int, int] = SHAPE, noise: float = NOISE
) -> tuple[Array, Index]:
    """Draw touching nuclei: gray levels, and the number of the nucleus of each voxel, from 1 up."""
    rng = np.random.default_rng(seed)
    labels, gray = np.zeros(shape, np.int64), np.full(shape, 20.0)
    number = 0
    while number < count:
        body = _draw_ellipsoid(rng)
        near = _voxels_of(labels, rng.integers(1, number + 1)) if number and rng.random() < TOUCHING else None
        first = _find_place(body, labels, rng, near)
        if first is None:
            continue
        number += 1
        box = tuple(slice(at, at + side) for at, side in zip(first, body.shape, strict=True))
        own = body & (labels[box] == 0)
        labels[box][own] = number
        gray[box][own] = 20.0 + 80.0 * rng.uniform(0.7, 1.3)
    blurred = scipy.ndimage.gaussian_filter(gray, BLUR)
    return blurred + rng.normal(0.0, noise, shape), labels


def _draw_ellipsoid(rng: Generator) -> Mask:
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    half = int(RADII[1]) + 1
    places = np.stack(np.meshgrid(*[np.arange(-half, half + 1)] * 3, indexing="ij"), -1) @ turn
    body = ((places / rng.uniform(*RADII, 3)) ** 2).sum(-1) <= 1.0
    used = [np.flatnonzero(body.any(axis=tuple({0, 1, 2} - {axis}))) for axis in range(3)]
    return np.asarray(body[tuple(slice(at[0], at[-1] + 1) for at in used)])


def _voxels_of(labels: Index, number: int) -> Array:
    return np.argwhere(labels == number).mean(axis=0)


def _find_place(body: Mask, labels: Index, rng: Generator, near: Array | None) -> tuple[int, ...] | None:
    """Find the first voxel of a body: apart from all others, or where it just touches one with a known middle."""
    last = np.array(labels.shape) - body.shape
    if near is None:
        first = tuple(rng.integers(1, last).tolist())
        window = tuple(slice(max(at - 2, 0), at + side + 2) for at, side in zip(first, body.shape, strict=True))
        return None if labels[window].any() else first
    toward = rng.normal(size=3)
    toward /= np.linalg.norm(toward)
    for away in np.arange(3.0 * RADII[1], 0.0, -0.5):
        first = np.rint(near + away * toward - 0.5 * np.array(body.shape)).astype(int)
        if (first < 1).any() or (first >= last).any():
            continue
        box = tuple(slice(at, at + side) for at, side in zip(first, body.shape, strict=True))
        shared = np.count_nonzero(body & (labels[box] > 0)) / np.count_nonzero(body)
        if shared > OVERLAP:
            return None
        if shared > 0.25 * OVERLAP:
            return tuple(first.tolist())
    return None


def count_found(objects: tuple[Selection, ...], labels: Index) -> int:
    """Count the nuclei that objects overlap by half or more."""
    matches = (match_nucleus(one.mask, labels) for one in objects)
    return len({number for number, iou in matches if iou >= FOUND_IOU})


def match_nucleus(mask: Mask, labels: Index) -> tuple[int, float]:
    """Match a mask with a nucleus: the number of the nucleus, and the overlap (intersection over union)."""
    shared = np.bincount(labels[mask], minlength=2)
    shared[0] = 0
    number = int(shared.argmax())
    both = int(shared[number])
    return number, both / max(np.count_nonzero(mask) + np.count_nonzero(labels == number) - both, 1)


def main() -> None:
    """Print a line for each seed."""
    for seed in map(int, sys.argv[1:] or ("1", "2", "3")):
        values, labels = draw_nuclei(seed)
        began = time.perf_counter()
        result = segment(values, seeds_everywhere(values), PRESETS["volume"])
        ran, began = time.perf_counter() - began, time.perf_counter()
        objects = result.objects
        spent = time.perf_counter() - began
        found = count_found(objects, labels)
        sys.stdout.write(
            f"seed {seed}: {len(objects)} proposals, {found} of {COUNT} right, {ran:.1f} + {spent:.1f} s\n"
        )


if __name__ == "__main__":
    main()
