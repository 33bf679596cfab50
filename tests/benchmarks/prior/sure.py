"""How sure an answer is: the numbers by which `cpm_core/objects/confidence.py` estimates it are learned here.

``python tests/benchmarks/prior/sure.py --outlined FOLDER... --drawn FOLDER [--objects 20] [--seed 101]`` selects
objects whose outline is known, by one to four clicks of a robot user, by a circle and by a box, and learns from what
speaks for each answer how often it is right. The images of the folders are those that the network has not learned from;
the scenes have another seed, and every twentieth drawing is enough. It writes the numbers with their origin to
`confidence.json`, and prints how well those learned from the other kinds hold on each kind.

It needs ``opencv-python-headless`` besides what `cpm_core` needs.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import scipy

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

import cpm_core as cpm
from cpm_core.numerics.grids import compute_iou, measure_depth
from cpm_core.numerics.types import Mask
from cpm_core.objects import confidence
from tests.benchmarks.prior import pictures
from tests.benchmarks.prior.drawn import clean, drawn
from tests.benchmarks.prior.nested import nested
from tests.benchmarks.prior.regression import curve, learned
from tests.benchmarks.prior.scenes import made_up

CLICKS = 4
SCENES = ("clean", "drawn", "nested", "made_up")
"""Kinds of scenes that are made up."""

SCENES_SHARE = 0.2
"""How much all scenes, whose boundaries are beyond doubt, count among all kinds, which count alike otherwise."""

Row = tuple[str, str, confidence.ConfidenceFeatures, bool]
"""Kind of image, what has been done, what speaks for the answer, and whether it is right."""


def held_out(folder: Path, chance: random.Random, most: int) -> list[pictures.Example]:
    """Objects of images of a folder that the prior has not learned from."""
    found = [
        example
        for path in pictures.held_out_labels(folder)
        for example in pictures.objects_of(path, pictures.OBJECTS_OF_AN_IMAGE, chance)
    ]
    return chance.sample(found, min(most, len(found)))


def scenes(folder: Path, outlined: Sequence[Path], most: int, seed: int) -> dict[str, list[pictures.Example]]:
    """Scenes that are made up, by their kind."""
    rng = np.random.default_rng(seed)
    grounds = pictures.photographs(outlined)
    grounds = [grounds[k] for k in rng.choice(len(grounds), min(len(grounds), most), replace=False)]
    clips = pictures.drawings(folder, random.Random(seed))
    made = (
        [clean(clips, rng) for _ in range(most)],
        [drawn(clips, grounds, rng) for _ in range(most)],
        [nested(clips, grounds, rng) for _ in range(most)],
        [made_up(rng) for _ in range(most)],
    )
    return dict(zip(SCENES, made, strict=True))


def deepest(mask: Mask) -> tuple[tuple[float, float], float]:
    """The place in a mask that is farthest from its border, and how far."""
    depth = measure_depth(mask)
    row, col = np.unravel_index(depth.argmax(), depth.shape)
    return (float(row), float(col)), float(depth.max())


def answers(example: pictures.Example, rng: np.random.Generator) -> Iterator[tuple[str, cpm.Selection]]:
    """What is selected by clicks of a robot user, the first one in the middle or anywhere, by a circle and by a box."""
    image, truth, hit = example
    values = image[..., 0] if not np.ptp(image, axis=-1).any() else image
    cut = cpm.partition(cpm.Image(values))
    where = truth if hit is None else hit
    middle, depth = deepest(where)
    rows, cols = np.nonzero(where)
    at = int(rng.integers(len(rows)))
    for first in (middle, (float(rows[at]), float(cols[at]))):
        inside, outside, chosen = [first], [], None
        for number in range(1, CLICKS + 1):
            chosen = cut.select(inside, outside, previous=chosen)
            yield f"click {number}", chosen
            missing, surplus = (deepest(part) for part in (truth & ~chosen.mask, chosen.mask & ~truth))
            if max(missing[1], surplus[1]) <= 1.0:
                break
            (inside if missing[1] > surplus[1] else outside).append(max(missing, surplus, key=lambda one: one[1])[0])
    yield "circle", cut.select(cpm.circle(middle, max(0.5 * depth, 2.0)))
    low, high = (np.argwhere(truth).min(axis=0), np.argwhere(truth).max(axis=0))
    yield "box", cut.select(box=[low + rng.integers(-3, 4, 2), high + rng.integers(-3, 4, 2)])


def rows_of(kinds: dict[str, list[pictures.Example]], seed: int) -> Iterator[Row]:
    """What speaks for each answer, and whether it is right."""
    rng = np.random.default_rng(seed)
    for kind, examples in kinds.items():
        for example in examples:
            for way, chosen in answers(example, rng):
                if chosen.features is not None:
                    yield kind, way, chosen.features, compute_iou(chosen.mask, example.mask) >= confidence.CORRECT_IOU


def main() -> None:
    """Select, learn, write and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--outlined", nargs="+", type=Path, required=True)
    parser.add_argument("--drawn", type=Path, required=True)
    parser.add_argument("--objects", type=int, default=20, help="of each kind, at most")
    parser.add_argument("--seed", type=int, default=101)
    given = parser.parse_args()
    rows = list(rows_of(scenes(given.drawn, given.outlined, given.objects, given.seed), given.seed))
    for seed, folder in enumerate(given.outlined, given.seed):
        rows += rows_of({folder.name: held_out(folder, random.Random(seed), given.objects)}, seed)
    write(rows, given.seed)


def write(rows: Sequence[Row], seed: int) -> None:
    """Learn from rows, print how well that holds on each kind if it is left out, and write the numbers."""
    signs = np.array([confidence.encode_features(row[2]) for row in rows])
    right, kind = np.array([float(row[3]) for row in rows]), np.array([row[0] for row in rows])
    counts = Counter(kind.tolist())
    kinds_alike = Counter(name in SCENES for name in counts)
    share = {True: SCENES_SHARE, False: 1.0 - SCENES_SHARE}
    weights = np.array(
        [len(rows) * share[name in SCENES] / (kinds_alike[name in SCENES] * counts[name]) for name in kind.tolist()]
    )
    for name in counts:
        out = kind == name
        numbers = learned(signs[~out], right[~out], weights[~out])
        shown = scipy.special.expit(signs[out] @ numbers[:-1] + numbers[-1])
        print(f"{name:14s} shown/right/answers  {curve(shown, right[out])}")
    origin = {
        "numbers": learned(signs, right, weights).round(3).tolist(),
        "features": "overlap, clarity, steadiness, agreement, log of places, no place, certain, mean of the first four "
        "if there is one place; offset",
        "answers": dict(counts),
        "right": {name: round(float(right[kind == name].mean()), 3) for name in counts},
        "seed": seed,
        "script": "tests/benchmarks/prior/sure.py",
        "data": "images that the network has not learned from, with their terms in prior/weights.md; scenes of Open "
        "Clip Art (public domain) and made-up shapes",
    }
    path = Path(confidence.__file__).with_suffix(".json")
    path.write_text(json.dumps(origin, indent=2) + "\n", "utf-8")


if __name__ == "__main__":
    main()
