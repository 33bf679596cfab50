"""Fit the weights of `cpm_core.objects.candidates.ranking` to outlines that people have drawn.

    python tests/benchmarks/fit_ranking.py --data FOLDER [--rounds 2]

FOLDER holds images, and beside each NAME.png a NAME_mask.png (one object) or NAME_labels.png (a label an object). A
simulated person clicks into the middle of each object, then into the middle of the largest wrong place, and draws a
circle of half its depth in the object. Half of the first round follows the truth; a further round follows the weights
of the one before.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
from scipy import ndimage as ndi
from scipy.optimize import minimize

from cpm_core import circle, load_image, partition
from cpm_core.objects.candidates import choice, ranking

CLICKS, MOST_OBJECTS, LEAST_AREA = 6, 8, 150
PENALTY = 0.05
TABLES = ("FIRST", "CHANGES", "START")


def objects(folder):
    """Images and masks of their objects."""
    for path in sorted(Path(folder).rglob("*_mask.png")) + sorted(Path(folder).rglob("*_labels.png")):
        values = load_image(path.with_name(path.name.rsplit("_", 1)[0] + ".png")).values
        labels = load_image(path).values.astype(int)
        numbers = [n for n in np.unique(labels)[1:] if np.count_nonzero(labels == n) >= LEAST_AREA]
        yield values, [labels == n for n in numbers[:: max(1, len(numbers) // MOST_OBJECTS)][:MOST_OBJECTS]]


def overlap(one, other):
    """Intersection over union."""
    return np.count_nonzero(one & other) / max(np.count_nonzero(one | other), 1)


def next_click(found, truth):
    """The pixel deepest in what is missing or too much, and whether it lies inside."""
    depths = [ndi.distance_transform_edt(np.pad(wrong, 1))[1:-1, 1:-1] for wrong in (truth & ~found, found & ~truth)]
    inside = depths[0].max() >= depths[1].max()
    depth = depths[0 if inside else 1]
    return np.unravel_index(depth.argmax(), depth.shape), inside


def collect(data, *, guided, seed):
    """Candidates of all clicks: pairs of features and overlaps, for first and for further clicks, and for starts."""
    groups, random, best = ([], [], []), np.random.default_rng(seed), choice._best

    def watched(situation):
        found = choice.described(situation)
        gains = np.array([overlap(choice.mask_of(situation, each.candidate), truth) for each in found])
        features = np.array([each.features for each in found])
        several = len(situation.inside) >= choice._SEVERAL
        groups[(2 if several else 0) if situation.chosen is None else 1].append((features, gains))
        if guided and random.random() < 0.5:
            return choice.mask_of(situation, found[int(random.choice(np.argsort(-gains)[:10]))].candidate)
        return best(situation)

    choice._best = watched
    try:
        for values, truths in data:
            faces = partition(values)
            for truth in truths:
                places, chosen = ([], []), None
                for _ in range(CLICKS):
                    before = np.zeros_like(truth) if chosen is None else chosen.mask
                    place, inside = next_click(before, truth)
                    places[0 if inside else 1].append(place)
                    chosen = faces.select(*places, previous=chosen)
                depth = ndi.distance_transform_edt(truth)
                center = np.unravel_index(depth.argmax(), depth.shape)
                faces.select(circle(center, max(0.5 * depth.max(), 2.0)))
    finally:
        choice._best = best
    return groups


def fitted(names, groups):
    """Weights that maximize the expected overlap, a candidate being taken with the probability of a softmax."""
    every = np.concatenate([features for features, _ in groups])
    mean, deviation = every.mean(axis=0), every.std(axis=0) + 1e-9
    standard = [(np.clip((x - mean) / deviation, -3.0, 3.0), y) for x, y in groups]

    def loss(weights):
        value, slope = 0.0, np.zeros_like(weights)
        for x, y in standard:
            score = x @ weights
            share = np.exp(score - score.max())
            share /= share.sum()
            value -= share @ y
            slope -= x.T @ (share * (y - share @ y))
        count = len(weights)
        return value / len(standard) + 0.5 * PENALTY * weights @ weights / count, (
            slope / len(standard) + PENALTY * weights / count
        )

    weights = minimize(loss, np.zeros(every.shape[1]), jac=True, method="L-BFGS-B").x
    rows = zip(mean.tolist(), deviation.tolist(), weights.tolist(), strict=True)
    return ranking.Ranking(dict(zip(names, rows, strict=True)))


def main():
    """Print both tables of weights."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", required=True)
    parser.add_argument("--rounds", type=int, default=2)
    arguments = parser.parse_args()
    data, known = list(objects(arguments.data)), {name: [] for name in TABLES}
    for number in range(arguments.rounds):
        groups = collect(data, guided=number == 0, seed=number)
        for name, found in zip(TABLES, groups, strict=True):
            known[name] += found
            setattr(choice, name, fitted(getattr(ranking, name).weights, known[name]))
    for name in TABLES:
        found = getattr(choice, name)
        sys.stdout.write(f"{name}\n")
        for feature, row in found.weights.items():
            sys.stdout.write(f'    "{feature}": ({", ".join(f"{value:.3f}" for value in row)}),\n')


if __name__ == "__main__":
    main()
