"""How sure a body of a volume is: the numbers by which `cpm_core/objects/confidence.py` estimates it are learned here.

``python tests/benchmarks/prior/sure_bodies.py [SEED]`` runs in made-up volumes of touching nuclei and of `bodies`, more
or less noisy, and learns from what speaks for each body that is found how often it is right. It writes the numbers with
their origin to `confidence_bodies.json`, and prints how well they hold in volumes that they have not been learned from.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

from cpm_core import PRESETS, seeds_everywhere, segment
from cpm_core.numerics.types import Array, Index
from cpm_core.objects import confidence
from cpm_core.objects.body_evidence import measure_body
from tests.benchmarks.prior.bodies import KINDS, body
from tests.benchmarks.prior.regression import curve, learned
from tests.benchmarks.touching_nuclei import draw_nuclei, match_nucleus

NOISES = 8.0, 26.0, 44.0
SIDE = 44
NUCLEI, STACK = 8, (40, 72, 72)
FOLDS = 3


def volumes(seed: int) -> Iterator[tuple[str, Array, Index, bool]]:
    """Volumes by their kind, with the numbers of the bodies, and whether these are all that there are."""
    for noise in NOISES:
        yield "nuclei", *draw_nuclei(seed, NUCLEI, STACK, noise), True
    rng = np.random.default_rng(seed)
    for kind in KINDS:
        values, inside = body(kind, SIDE, rng)
        yield "bodies", values, inside.astype(np.int64), False


def answers(seed: int) -> Iterator[tuple[str, Array, bool]]:
    """The kind of each body that is found, what speaks for it, and whether it is right."""
    for kind, values, labels, complete in volumes(seed):
        for one in segment(values, seeds_everywhere(values), PRESETS["volume"]).objects:
            mask = one.mask
            if complete or 2 * np.count_nonzero(labels[mask]) > np.count_nonzero(mask):
                right = match_nucleus(mask, labels)[1] >= confidence.CORRECT_IOU
                yield kind, confidence.encode_body(measure_body(one)), right


def main() -> None:
    """Learn, write the numbers, and print a line for each part that was left out."""
    seed = int(sys.argv[1]) if len(sys.argv) > 1 else 201
    parts = [list(answers(seed + at)) for at in range(FOLDS)]
    features, right = (np.array([row[at] for part in parts for row in part], float) for at in (1, 2))
    fold = np.repeat(np.arange(FOLDS), [len(part) for part in parts])
    shown = np.empty(len(right))
    for at in range(FOLDS):
        numbers = learned(features[fold != at], right[fold != at], np.ones(np.count_nonzero(fold != at)))
        shown[fold == at] = 1.0 / (1.0 + np.exp(-features[fold == at] @ numbers[:-1] - numbers[-1]))
    sys.stdout.write(f"shown/right/count: {curve(shown, right)}\n")
    kinds = np.array([row[0] for part in parts for row in part])
    origin = {
        "numbers": [round(number, 3) for number in learned(features, right, np.ones(len(right))).tolist()],
        "features": "log of steadiness, solidity, log of volume, share at the end of the volume; offset",
        "answers": {kind: int(np.count_nonzero(kinds == kind)) for kind in np.unique(kinds).tolist()},
        "right": {kind: round(float(right[kinds == kind].mean()), 3) for kind in np.unique(kinds).tolist()},
        "seed": seed,
        "script": "tests/benchmarks/prior/sure_bodies.py",
        "data": "made-up volumes",
    }
    path = Path(confidence.__file__).with_name("confidence_bodies.json")
    path.write_text(json.dumps(json.loads(path.read_text("utf-8")) | origin, indent=2) + "\n", "utf-8")


if __name__ == "__main__":
    main()
