"""How sure an answer is: the few numbers by which `cpm_core/objects/confidence.py` estimates it are learned here.

``python tests/benchmarks/prior/sure.py --outlined FOLDER... --drawn FOLDER [--objects 60] [--seed 101]`` selects objects
whose outline is known, by one to four clicks of a robot user, by a circle and by a box, and learns from what speaks for
each answer how often it is right. The images of the folders are those that were held out when the weights of the prior
were grown, and the scenes have another seed. It writes the numbers with their origin, and prints how well they hold on
each kind when they are learned from the others.

It needs ``opencv-python-headless`` besides what `cpm_core` needs.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import scipy

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

import cpm_core as cpm
from cpm_core.numerics.types import Array, Mask
from cpm_core.objects import confidence
from tests.benchmarks.prior import pictures
from tests.benchmarks.prior.drawn import drawn
from tests.benchmarks.prior.nested import nested
from tests.benchmarks.prior.scenes import made_up

CLICKS = 4
TIGHT = 1e-2
"""How much large numbers are held back."""

Row = tuple[str, str, confidence.Signs, bool]
"""Kind of image, what has been done, what speaks for the answer, and whether it is right."""


def held_out(folder: Path, chance: random.Random, most: int) -> list[pictures.Example]:
    """Objects of images of a folder that the prior has not learned from."""
    labeled = sorted(folder.glob("*_labels.png"))[:: pictures.HELD_OUT]
    found = [example for path in labeled for example in pictures.objects_of(path, chance)]
    return chance.sample(found, min(most, len(found)))


def scenes(folder: Path, outlined: Sequence[Path], most: int, seed: int) -> dict[str, list[pictures.Example]]:
    """Scenes that are made up, by their kind."""
    rng = np.random.default_rng(seed)
    grounds = pictures.photographs(outlined)
    grounds = [grounds[k] for k in rng.choice(len(grounds), min(len(grounds), most), replace=False)]
    clips = pictures.drawings(folder, random.Random(seed))
    return {
        "drawn": [drawn(clips, grounds, rng) for _ in range(most)],
        "nested": [nested(clips, grounds, rng) for _ in range(most)],
        "made_up": [made_up(rng) for _ in range(most)],
    }


def deepest(mask: Mask) -> tuple[tuple[float, float], float]:
    """The place in a mask that is farthest from its border, and how far."""
    depth = scipy.ndimage.distance_transform_edt(np.pad(mask, 1))[1:-1, 1:-1]
    row, col = np.unravel_index(depth.argmax(), depth.shape)
    return (float(row), float(col)), float(depth.max())


def overlap(one: Mask, other: Mask) -> float:
    return float(np.count_nonzero(one & other)) / max(np.count_nonzero(one | other), 1)


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


def rows_of(kinds: dict[str, list[pictures.Example]], seed: int) -> list[Row]:
    """What speaks for each answer, and whether it is right."""
    rng, found = np.random.default_rng(seed), []
    for kind, examples in kinds.items():
        for example in examples:
            for way, chosen in answers(example, rng):
                if chosen.signs is not None:
                    right = overlap(chosen.mask, example.mask) >= confidence.RIGHT
                    found.append((kind, way, chosen.signs, right))
        print(kind, len(examples), flush=True)
    return found


def learned(features: Array, right: Array, weights: Array) -> Array:
    """Numbers of a logistic regression, the offset last, by Newton's method."""
    wide = np.column_stack([features, np.ones(len(features))])
    numbers, tight = np.zeros(wide.shape[1]), TIGHT * weights.sum() * np.eye(wide.shape[1])
    tight[-1, -1] = 0.0
    for _ in range(50):
        likely = scipy.special.expit(wide @ numbers)
        slope = wide.T @ (weights * (right - likely)) - tight @ numbers
        bend = wide.T @ (wide * (weights * likely * (1.0 - likely))[:, None]) + tight
        numbers += np.linalg.solve(bend, slope)
    return numbers


def curve(shown: Array, right: Array) -> str:
    """Share of right answers among those shown as so and so sure, and how many there are."""
    cells = []
    for low, high in zip((0.0, 0.2, 0.4, 0.6, 0.8), (0.2, 0.4, 0.6, 0.8, 1.01), strict=True):
        on = (shown >= low) & (shown < high)
        cells.append(f"{shown[on].mean():.2f}/{right[on].mean():.2f}/{on.sum()}" if on.any() else "-")
    return "  ".join(cells)


def main() -> None:
    """Select, learn, write and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--outlined", nargs="+", type=Path, required=True)
    parser.add_argument("--drawn", type=Path, required=True)
    parser.add_argument("--objects", type=int, default=60, help="of each kind, at most")
    parser.add_argument("--seed", type=int, default=101)
    parser.add_argument("--rows", type=Path, help="where what was selected is kept, or is read if it is there")
    given = parser.parse_args()
    import pickle  # noqa: PLC0415

    if given.rows is not None and given.rows.exists():
        rows = pickle.loads(given.rows.read_bytes())
    else:
        chance = random.Random(given.seed)
        kinds = {folder.name: held_out(folder, chance, given.objects) for folder in given.outlined}
        rows = rows_of(kinds | scenes(given.drawn, given.outlined, given.objects, given.seed), given.seed)
        if given.rows is not None:
            given.rows.write_bytes(pickle.dumps(rows))


if __name__ == "__main__":
    main()
