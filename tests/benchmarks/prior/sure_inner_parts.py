"""How sure an inner part of a body is: the numbers of `cpm_core/objects/confidence.py` are learned here.

``python tests/benchmarks/prior/sure_inner_parts.py [SEED [COUNT]]`` looks for parts in the bodies of made-up volumes of
`bodies.body_with_parts`, COUNT of each kind, learns from what speaks for each part how often it is right, and writes
the numbers with their origin to `confidence_bodies.json`. It prints how well numbers that were learned without a kind
hold on this kind in as many volumes of other seeds. With ``--runs`` it writes nothing, and prints how well the numbers
hold on the parts that runs propose.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import scipy

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

import cpm_core as cpm
from cpm_core.image.region import Region
from cpm_core.numerics.grids import compute_iou
from cpm_core.numerics.types import Array, Mask
from cpm_core.objects import confidence
from cpm_core.objects.body_evidence import measure_inner_part
from tests.benchmarks.prior.bodies import INNER_KINDS, body_with_parts
from tests.benchmarks.prior.regression import curve, learned

SEEDS_APART = 10_000
"""Distance between the seeds of the volumes to learn from and those to measure in."""

MOST_OF_BODY = 0.5
"""Share of a body above which an object is no part of it, but the rest."""


def is_right(mask: Mask, parts: list[Mask]) -> bool:
    """Whether a part is one of those that are there."""
    return max((compute_iou(mask, part) for part in parts), default=0.0) >= confidence.CORRECT_IOU


def answers(first: int, count: int) -> Iterator[tuple[int, Array, bool]]:
    """The kind of each part found, what speaks for it, and whether it is right."""
    for seed in range(first, first + count):
        for kind, name in enumerate(INNER_KINDS):
            values, inside, parts = body_with_parts(name, np.random.default_rng([seed, kind]))
            whole = Region.from_mask(inside)
            for one in cpm.VolumePartition(cpm.Image(values)).find_parts_in(whole):
                yield kind, confidence.encode_inner(measure_inner_part(one, whole)), is_right(one.mask, parts)


def columns(first: int, count: int) -> tuple[Array, Array, Array]:
    """The same as arrays: kinds, features, right."""
    kinds, features, right = zip(*answers(first, count), strict=True)
    return np.array(kinds), np.array(features), np.array(right, float)


def proposed(first: int, count: int) -> Iterator[tuple[float, bool]]:
    """How sure each part is that a run in one of the volumes proposes, and whether it is right."""
    for seed in range(first, first + count):
        for kind, name in enumerate(INNER_KINDS):
            values, inside, parts = body_with_parts(name, np.random.default_rng([seed, kind]))
            for one in cpm.segment(values, cpm.seeds_everywhere(values), cpm.PRESETS["volume"]).objects:
                mask = one.mask
                within = np.count_nonzero(mask & inside)
                if 0.5 * np.count_nonzero(mask) < within < MOST_OF_BODY * np.count_nonzero(inside):
                    yield one.confidence, is_right(mask, parts)


def main() -> None:
    """Learn, write the numbers, and print; or measure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seed", type=int, nargs="?", default=1)
    parser.add_argument("count", type=int, nargs="?", default=45)
    parser.add_argument("--runs", action="store_true")
    given = parser.parse_args()
    if given.runs:
        shown, right = (np.array(column, float) for column in zip(*proposed(given.seed, given.count), strict=True))
        print(curve(shown, right))
        return
    kinds, features, right = columns(given.seed, given.count)
    own_kinds, own_features, own_right = columns(given.seed + SEEDS_APART, given.count)
    shown = np.empty(len(own_right))
    for kind, name in enumerate(INNER_KINDS):
        others, own = kinds != kind, own_kinds == kind
        numbers = learned(features[others], right[others], np.ones(np.count_nonzero(others)))
        shown[own] = np.minimum(scipy.special.expit(own_features[own] @ numbers[:-1] + numbers[-1]), 0.98)
        print(f"{name:10}{curve(shown[own], own_right[own])}")
    print(f"{'all':10}{curve(shown, own_right)}")
    high = (shown >= 0.8) & (shown < 0.95)
    print(f"0.80 to 0.95: {shown[high].mean():.3f} shown, {own_right[high].mean():.3f} right of {high.sum()}")
    origin = {
        "inner": [round(number, 3) for number in learned(features, right, np.ones(len(right))).tolist()],
        "features of inner parts": "log of contrast, sharpness, log of unevenness, log of volume, sphericity; offset",
        "inner parts": {name: int(np.count_nonzero(kinds == kind)) for kind, name in enumerate(INNER_KINDS)},
        "right inner parts": {
            name: round(float(right[kinds == kind].mean()), 3) for kind, name in enumerate(INNER_KINDS)
        },
        "seed of inner parts": given.seed,
        "script of inner parts": "tests/benchmarks/prior/sure_inner_parts.py",
    }
    path = Path(confidence.__file__).with_name("confidence_bodies.json")
    path.write_text(json.dumps(json.loads(path.read_text("utf-8")) | origin, indent=2) + "\n", "utf-8")


if __name__ == "__main__":
    main()
