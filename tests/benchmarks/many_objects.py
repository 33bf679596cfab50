"""Objects of random size in noise, of known outline: what a run from everywhere finds with its shortcuts and without.

python -m tests.benchmarks.many_objects [side] [noise]

Shortcuts are those of `segmentation/finer_scale.py`: seeds that are left out, and edges that count as covered.
"""

import sys
import time

import numpy as np

from cpm_core.contours.agreement import distances_to_contours
from cpm_core.contours.contour import Contour
from cpm_core.model.starts import uniform_grid
from cpm_core.parameters import PRESETS
from cpm_core.segmentation import engine
from cpm_core.segmentation.evolve import segment

LEAST, MOST = 3.0, 40.0
NEAR = 0.3


def scene(side, noise, seed=0):
    """Gray levels, and center, radius and outline of each object; the smallest are hardly above the noise."""
    rng = np.random.default_rng(seed)
    values = 60.0 + 25.0 * np.linspace(0.0, 1.0, side)[None] + rng.normal(0.0, noise, (side, side))
    taken, truth, circle = np.zeros((side, side), bool), [], np.linspace(0.0, 2.0 * np.pi, 256, endpoint=False)
    for _ in range(side * side // 900):
        size = np.exp(rng.uniform(np.log(LEAST), np.log(MOST)))
        flat, turn, level = rng.uniform(0.7, 1.0), rng.uniform(0.0, np.pi), rng.uniform(60.0, 150.0)
        wave, phase = 0.15 * rng.uniform() * (size > 10.0), rng.uniform(0.0, 2.0 * np.pi)
        room = 1.3 * size + 7.0
        center = rng.uniform(room, side - room, 2)
        box = tuple(slice(int(at - room), int(at + room) + 1) for at in center)
        if taken[box].any():
            continue
        taken[box] = True

        def radius(angle, size=size, flat=flat, turn=turn, wave=wave, phase=phase):
            ellipse = size * flat / np.hypot(flat * np.cos(angle - turn), np.sin(angle - turn))
            return ellipse * (1.0 + wave * np.cos(3.0 * angle + phase))

        y, x = np.ogrid[box]
        away = np.hypot(y - center[0], x - center[1]) - radius(np.arctan2(y - center[0], x - center[1]))
        values[box] += level * np.clip(0.5 - away, 0.0, 1.0)
        points = center + radius(circle)[:, None] * np.stack([np.sin(circle), np.cos(circle)], axis=1)
        truth.append((center, size, Contour(points, True)))
    return np.clip(np.rint(values), 0, 255).astype(np.uint8), truth


def judged(contours, truth):
    """How many objects were found once, the radii of those that were not, and the mean distance from their outline."""
    centers = np.array([one.points.mean(axis=0) for one in contours])
    away, missed = [], []
    for center, size, outline in truth:
        near = np.flatnonzero(np.hypot(*(centers - center).T) < max(NEAR * size, 2.0))
        distances = [distances_to_contours(contours[at].points, [outline]).mean() for at in near]
        if len(distances) == 1 and distances[0] < max(NEAR * size, 1.0):
            away += distances
        else:
            missed.append(size)
    return len(away), np.sort(missed)[-5:].round(1).tolist(), float(np.mean(away))


def main(side=2000, noise=10.0):
    values, truth = scene(side, noise)
    results = []
    shortcuts = engine.drop_explained_seeds, engine.thin_seeds
    for words, used in (("without", (lambda state, _: state, lambda state: state)), ("with", shortcuts)):
        engine.drop_explained_seeds, engine.thin_seeds = used
        began = time.process_time()
        results.append(segment(values, uniform_grid(values.shape), PRESETS["automatic"]).contours)
        spent = time.process_time() - began
        found, missed, away = judged(results[-1], truth)
        print(f"{words} shortcuts: {spent:.1f} s of processor time, {len(results[-1])} contours, {found} of "
              f"{len(truth)} objects, {away:.3f} px from their outlines; largest radii missed {missed}")  # fmt: skip
    for some, others in (results, results[::-1]):
        print(
            f"at most {distances_to_contours(np.concatenate([one.points for one in some]), others).max():.3f} px apart"
        )


if __name__ == "__main__":
    main(*(kind(text) for kind, text in zip((int, float), sys.argv[1:], strict=False)))
