"""Which of several bodies around a click is meant: the numbers of `cpm_core/objects/confidence.py` are learned here.

``python tests/benchmarks/prior/meant_bodies.py [SEED [COUNT]]`` clicks in made-up volumes: the bodies of `bodies.py`,
clumps of touching nuclei and of equal balls, organs in a body in air, and brains in a skull. It learns by which numbers
the body that is meant stands out from the other candidates of its click, writes them to `confidence_bodies.json`, and
prints a line for each kind: how often the first answer overlaps the truth by 0.8, chosen by numbers learned elsewhere.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import scipy
from numpy.random import Generator

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

import cpm_core as cpm
from cpm_core.numerics.grids import compute_iou, measure_depth
from cpm_core.numerics.types import Array, Extent, Mask
from cpm_core.objects import confidence
from cpm_core.objects.body_evidence import measure_choice
from tests.benchmarks.prior.bodies import KINDS, body
from tests.benchmarks.touching_nuclei import draw_nuclei

SIDE, COUNT, FOLDS = 56, 5, 9
DECAY = 0.005
"""Weight of the squares of the numbers, for features of unit deviation."""


def clump(rng: Generator, even: bool) -> tuple[Array, Mask]:
    """Touching nuclei, also of one gray level, and one that touches another."""
    values, labels = draw_nuclei(int(rng.integers(2**30)), 9, (44, 64, 64), 0.0)
    if even:
        values = scipy.ndimage.gaussian_filter(np.where(labels > 0, 100.0, 20.0), 1.0)
    rims = [(labels == n, scipy.ndimage.binary_dilation(labels == n) & (labels != n)) for n in range(1, 10)]
    touching = [mask for mask, rim in rims if (labels[rim] > 0).sum() > 12] or [rims[0][0]]
    return values + rng.normal(0.0, rng.uniform(3.0, 26.0), labels.shape), touching[rng.integers(len(touching))]


def balls(rng: Generator) -> tuple[Array, Mask]:
    """Equal balls that touch, and one of them."""
    radius, wanted = rng.uniform(6.0, 10.0), int(rng.integers(3, 7))
    centers = [SIDE / 2.0 + rng.uniform(-3.0, 3.0, 3)]
    for _ in range(400):
        way = rng.normal(size=3)
        at = centers[rng.integers(len(centers))] + 2.0 * radius * rng.uniform(0.92, 1.0) * way / np.linalg.norm(way)
        apart = min(np.linalg.norm(at - other) for other in centers) > 1.8 * radius
        if len(centers) < wanted and apart and (at > radius + 1.0).all() and (at < SIDE - radius - 2.0).all():
            centers.append(at)
    away = np.array([_distances((SIDE,) * 3, center) for center in centers])
    inside = away.min(axis=0) < radius
    seen = scipy.ndimage.gaussian_filter(20.0 + 100.0 * inside, 0.8) + rng.normal(
        0.0, rng.uniform(2.0, 25.0), inside.shape
    )
    return seen, inside & (away.argmin(axis=0) == rng.integers(len(centers)))


def organ(rng: Generator) -> tuple[Array, Mask]:
    """A body in air with skin, fat, muscle, organs of differing gray and bones, and one of the organs."""
    shape = (48, 72, 88)
    center = np.array(shape) / 2.0 - 0.5
    axes = np.array([shape[0] * rng.uniform(0.45, 1.4), 0.43 * shape[1], 0.45 * shape[2]])
    depth = _distances(shape, center, axes)
    fat, muscle = rng.uniform(35.0, 60.0), rng.uniform(70.0, 95.0)
    inner = depth < rng.uniform(0.78, 0.9)
    tissue = np.select([inner, depth < 0.95, depth < 1.0], [rng.choice([fat, muscle]), fat, muscle], 0.0)
    ground, organs = float(tissue[inner][0]), list[Mask]()
    while len(organs) < 4:
        at = center + rng.uniform(-0.6, 0.6, 3) * np.minimum(axes, center)
        mask = _distances(shape, at, rng.uniform(5.0, 15.0) * np.exp(rng.uniform(-0.35, 0.35, 3))) < 1.0
        level, apart = rng.uniform(60.0, 130.0), not any((mask & other).any() for other in organs)
        if apart and mask.sum() > 300 and not (mask & ~inner).any() and abs(level - ground) > 14.0:
            tissue[mask] = level
            organs.append(mask)
    bone = _distances(shape, center + rng.uniform(-0.6, 0.6, 3) * np.minimum(axes, center), np.full(3, 4.0)) < 1.0
    tissue[bone & inner & ~np.any(organs, axis=0)] = rng.uniform(180.0, 255.0)
    seen = scipy.ndimage.gaussian_filter(tissue, 0.7) + rng.normal(0.0, rng.uniform(1.0, 12.0), shape)
    return seen, organs[rng.integers(len(organs))]


def brain(rng: Generator, touching: bool) -> tuple[Array, Mask]:
    """A brain of two tissues around a lesion, in bone and skin, which it may touch, cut by the end of the volume."""
    side = int(rng.integers(56, 96))
    shape = (side, int(side * rng.uniform(1.0, 1.3)), side)
    middle = np.array(shape) * (0.5 + rng.uniform(-0.12, 0.12, 3)) - 0.5
    away = _distances(shape, middle, np.array(shape) * rng.uniform(0.26, 0.38, 3))
    within = away + rng.uniform(0.0, 0.1) * _smooth(rng, shape, 0.12 * side) < 1.0
    away, folds = scipy.ndimage.distance_transform_edt(~within), _smooth(rng, shape, rng.uniform(1.5, 3.0))
    bone = side * rng.uniform(0.03, 0.06) * (1.0 + 0.25 * _smooth(rng, shape, 0.1 * side)).clip(0.4)
    level = rng.uniform(80.0, 110.0)
    values = np.where(away < bone + side * rng.uniform(0.04, 0.08), rng.uniform(115.0, 160.0), 8.0)
    gaps = _smooth(rng, shape, rng.uniform(0.03, 0.08) * side) > rng.uniform(1.0, 2.0)
    values[(away < bone) & ~(gaps & touching)], values[within] = rng.uniform(15.0, 40.0), level
    values[within & (folds > rng.uniform(0.2, 0.6))] = level + rng.uniform(15.0, 35.0)
    lesion = within & (_distances(shape, middle + rng.uniform(-0.15, 0.15, 3) * side) < side * rng.uniform(0.0, 0.09))
    values[lesion] = rng.uniform(20.0, 200.0)
    within &= ~lesion
    shade = 1.0 + 0.08 * _smooth(rng, shape, 0.3 * side)
    noise = rng.normal(0.0, rng.uniform(2.0, 10.0), shape)
    return scipy.ndimage.gaussian_filter(values, 0.7) * shade + noise, within


def _distances(shape: Extent, center: Array, axes: Array | float = 1.0) -> Array:
    return np.asarray(np.linalg.norm((np.moveaxis(np.indices(shape), 0, -1) - center) / axes, axis=-1))


def _smooth(rng: Generator, shape: Extent, sigma: float) -> Array:
    field = scipy.ndimage.gaussian_filter(rng.normal(size=shape), sigma)
    return np.asarray(field / field.std())


def volumes(seed: int) -> Iterator[tuple[str, Array, Mask]]:
    """Volumes by their kind, with the body that is meant."""
    rng = np.random.default_rng(seed)
    for kind in KINDS:
        yield kind, *body(kind, SIDE, rng)
    yield "nuclei", *clump(rng, even=False)
    yield "even", *clump(rng, even=True)
    yield "balls", *balls(rng)
    yield "organ", *organ(rng)
    yield "brain", *brain(rng, touching=False)
    yield "head", *brain(rng, touching=True)


def candidates(seed: int) -> Iterator[tuple[str, Array, Mask]]:
    """The features of all candidates of a click deep in each body, shape (N, 3), and which of them are right."""
    for kind, values, inside in volumes(seed):
        depth = measure_depth(inside)
        deep = np.argwhere(depth >= 0.5 * depth.max())
        place = deep[np.random.default_rng(seed).integers(len(deep))]
        found = [
            one
            for one in cpm.partition(cpm.Image(values)).predict_around(place[None].astype(float))
            if one.has_boundary
        ]
        ious = [compute_iou(one.mask, inside) for one in found]
        features = np.array([confidence.encode_choice(measure_choice(one)) for one in found])
        yield kind, features, np.array(ious) >= confidence.CORRECT_IOU


def learned(clicks: list[tuple[str, Array, Mask]]) -> Array:
    """The numbers that make it likeliest that right candidates are chosen (conditional logit: McFadden 1974)."""
    every = np.concatenate([features for _, features, _ in clicks])
    mean, deviation = every.mean(axis=0), every.std(axis=0)
    scaled = [
        ((features - mean) / deviation, right) for _, features, right in clicks if right.any() and not right.all()
    ]

    def loss(numbers: Array) -> float:
        odds = [(features @ numbers, right) for features, right in scaled]
        lost = [scipy.special.logsumexp(one) - scipy.special.logsumexp(one[right]) for one, right in odds]
        return float(np.mean(lost) + DECAY * np.square(numbers).sum())

    return np.asarray(scipy.optimize.minimize(loss, np.zeros(every.shape[1])).x / deviation)


def main() -> None:
    """Learn, write the numbers, and print a line for each kind."""
    seed = int(sys.argv[1]) if len(sys.argv) > 1 else 1001
    count = int(sys.argv[2]) if len(sys.argv) > 2 else COUNT
    clicks = [one for at in range(count) for one in candidates(seed + at)]
    right: dict[str, list[bool]] = {}
    for number, (kind, features, correct) in enumerate(clicks):
        numbers = learned([one for at, one in enumerate(clicks) if at % FOLDS != number % FOLDS])
        right.setdefault(kind, []).append(bool(correct[(features @ numbers).argmax()]))
    for kind, each in right.items():
        sys.stdout.write(f"{kind:10}{np.mean(each):5.2f} of {len(each)}\n")
    path = Path(confidence.__file__).with_name("confidence_bodies.json")
    origin = {
        "choice": [round(number, 2) for number in learned(clicks).tolist()],
        "features of the choice": "log of sphericity, log of volume, share of gaps",
        "clicks": len(clicks),
        "script of the choice": "tests/benchmarks/prior/meant_bodies.py",
    }
    path.write_text(json.dumps(json.loads(path.read_text("utf-8")) | origin, indent=2) + "\n", "utf-8")


if __name__ == "__main__":
    main()
