"""Fit what ranks the candidates around clicks to outlines that people have drawn, and to drawn scenes.

    python tests/benchmarks/ranking/fit_ranking.py --data FOLDER... [--silhouettes FOLDER]
        [--left-out 8] [--kept FILE] [--clicks]

Each FOLDER holds images, and beside each NAME.png a NAME_mask.png (one object) or NAME_labels.png (a label an object);
a folder of silhouettes is for drawn scenes. A simulated person draws circles of some sizes in each object; all
candidates are described, and their overlaps with the outline are measured. Trees are grown on them (LightGBM is needed)
and written to `cpm_core/objects/candidates/trees.json`.
`--left-out 8` tells first what they reach on images that they were not grown on, an eighth of the images of each folder
at a time. `--kept` keeps the candidates in a file, or takes them from it. `--clicks` fits the weights for clicks
instead, and prints them: into the middle of each object, then into the middle of the largest wrong place.
"""

import argparse
import json
import pickle
import sys
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from drawn_scenes import drawn_scenes
from scipy import ndimage as ndi
from scipy.optimize import minimize

from cpm_core import PRESETS, circle, load_image, partition, segment
from cpm_core.objects.candidates import choice, ranking, trees

CLICKS, LEAST_AREA, MOST_OBJECTS, CHANGED_OBJECTS, RUNS = 6, 150, 17, 8, 3
PENALTY = 0.05
ROUNDS, LEAVES, RATE, BAGS, SHARPNESS, SLOPE, LEAST_CURVATURE = 60, 6, 0.1, 4, 5.0, 20.0, 0.05
GROWN = {
    "min_data_in_leaf": 80, "lambda_l2": 1.0, "feature_fraction": 0.3, "bagging_fraction": 0.7, "bagging_freq": 1,
    "max_bin": 63, "verbose": -1, "num_threads": 1, "num_leaves": LEAVES, "learning_rate": RATE,
}  # fmt: skip
DRAWN = {"texture": 0.2, "speckle": 0.2, "drawn": 0.2, "plain": 1.0}
"""Drawn scenes, and their shares beside the one of a folder."""


class Group(NamedTuple):
    """The candidates around one click: kind of image, image, whether a run has been made, features, and overlaps."""

    kind: str
    name: str
    run: bool
    features: np.ndarray
    overlaps: np.ndarray


def outlined(folders):
    """Kind, name, values and labels of images with outlines."""
    for folder in folders:
        for path in sorted(Path(folder).rglob("*_mask.png")) + sorted(Path(folder).rglob("*_labels.png")):
            values = load_image(path.with_name(path.name.rsplit("_", 1)[0] + ".png")).gray("luminance")
            labels = load_image(path).gray("luminance") if path.name.endswith("_mask.png") else whole_labels(path)
            yield Path(folder).name, path.stem, values, labels.astype(int) if labels.max() > 1 else labels > 0


def whole_labels(path):
    """Labels, which may be more than 255."""
    return np.asarray(load_image(path).values)


def overlap(one, other):
    """Intersection over union."""
    return np.count_nonzero(one & other) / max(np.count_nonzero(one | other), 1)


def depth_of(mask):
    """Distance of each pixel to the outside, the border of the image counting as outside."""
    return ndi.distance_transform_edt(np.pad(mask, 1))[1:-1, 1:-1]


def next_click(found, truth):
    """The pixel deepest in what is missing or too much, and whether it lies inside."""
    depths = [depth_of(wrong) for wrong in (truth & ~found, found & ~truth)]
    inside = depths[0].max() >= depths[1].max()
    depth = depths[0 if inside else 1]
    return np.unravel_index(depth.argmax(), depth.shape), inside


class Watch:
    """Keeps the candidates of each choice, and lets some follow the truth."""

    def __init__(self, seed, *, guided=False):
        self.first, self.starts, self.changes = [], [], []
        self.image, self.truth, self.run, self.guided = ("", ""), None, False, guided
        self.random, self._best = np.random.default_rng(seed), choice._best

    def __enter__(self):
        choice._best = self._watched
        return self

    def __exit__(self, *_):
        choice._best = self._best

    def _watched(self, situation):
        found = choice.described(situation)
        masks = [choice.mask_of(situation, each.candidate) for each in found]
        overlaps = np.array([overlap(mask, self.truth) for mask in masks])
        several = len(situation.inside) >= choice.SEVERAL
        kept = self.changes if situation.chosen is not None else self.starts if several else self.first
        kept.append(Group(*self.image, self.run, np.array([each.features for each in found]), overlaps))
        if self.guided and self.random.random() < 0.5:
            return masks[int(self.random.choice(np.argsort(-overlaps)[:10]))]
        if several:  # so that trees need not be there to grow the first ones
            return masks[int(np.argmax(overlaps))]
        return self._best(situation)


def collect(data, seed):
    """Candidates of drawn starts."""
    with Watch(seed) as watch:
        for kind, name, values, labels in data:
            watch.image = kind, name
            faces = partition(values)
            alone = labels.max() == 1
            numbers = large(labels, watch.random, MOST_OBJECTS)
            for k, number in enumerate(numbers):
                watch.truth = labels == number
                depth = depth_of(watch.truth)
                middle = np.unravel_index(depth.argmax(), depth.shape)
                for size in (0.35, 0.5, 0.65, 0.85) if alone else (0.5, 0.75):
                    near = np.argwhere(depth >= min(size * depth.max() + 1, depth.max()))
                    at = middle if size == 0.5 else near[watch.random.integers(0, len(near))]
                    faces.select(circle(at, max(0.98 * size * depth.max(), 2.0)), previous=nothing(faces))
                if k < RUNS and kind not in DRAWN:
                    watch.run = True
                    start = circle(middle, max(0.5 * depth.max(), 2.0))
                    partition(segment(values, start, PRESETS["shape"])).select(start)
                    watch.run = False
            sys.stderr.write(f"{kind} {name}: {len(watch.starts)} starts\n")
    return watch.starts


def nothing(faces):
    """An empty selection, so that what was chosen before does not count."""
    return faces.selection_of(np.zeros(faces.shape, bool))


def large(labels, random, most):
    """Numbers of some objects that are large enough, spread over all."""
    sizes = np.bincount(labels.ravel().astype(int))
    numbers = np.flatnonzero(sizes >= LEAST_AREA)
    numbers = numbers[numbers > 0]
    spread = numbers[:: max(1, len(numbers) // 3)][:3]
    rest = random.permutation(np.setdiff1d(numbers, spread))
    return [*spread, *rest[: most - len(spread)]]


def collect_clicks(data, *, guided, seed):
    """Candidates of first clicks, and of further ones."""
    with Watch(seed, guided=guided) as watch:
        for kind, name, values, labels in data:
            faces = partition(values)
            for number in large(labels, watch.random, CHANGED_OBJECTS):
                watch.image, watch.truth = (kind, name), labels == number
                places, chosen = ([], []), nothing(faces)
                for _ in range(CLICKS):
                    place, inside = next_click(chosen.mask, watch.truth)
                    places[0 if inside else 1].append(place)
                    chosen = faces.select(*places, previous=chosen)
    return watch.first, watch.changes


def shares(groups):
    """Weight of each group: the same for each folder, less for drawn scenes; roots within an image."""
    counts: dict[Any, float] = {}
    for group in groups:
        counts[group.name] = counts.get(group.name, 0) + 1
    weights = np.array([counts[group.name] ** -0.5 for group in groups])
    kinds = np.array([group.kind for group in groups])
    for kind in set(kinds):
        weights[kinds == kind] *= DRAWN.get(kind, 1.0) / weights[kinds == kind].sum()
    return weights / weights.mean()


def grown(groups):
    """Trees that maximize the expected overlap, a candidate being taken with the probability of a softmax."""
    lightgbm = import_module("lightgbm")
    features = np.concatenate([group.features for group in groups])
    overlaps = np.concatenate([group.overlaps for group in groups])
    counts = np.array([len(group.overlaps) for group in groups])
    first, of = np.cumsum(counts) - counts, np.repeat(np.arange(len(counts)), counts)
    weight = shares(groups)[of]

    def objective(score, _):
        sharp = SHARPNESS * score
        share = np.exp(sharp - np.maximum.reduceat(sharp, first)[of])
        share /= np.add.reduceat(share, first)[of]
        expected = np.add.reduceat(share * overlaps, first)[of]
        slope = -SHARPNESS * SLOPE * weight * share * (overlaps - expected)
        return slope, 0.5 * np.abs(slope) + LEAST_CURVATURE * weight

    data = lightgbm.Dataset(features, label=overlaps, free_raw_data=False)
    return [lightgbm.train(GROWN | {"objective": objective, "seed": k}, data, ROUNDS) for k in range(BAGS)]


def stored(models):
    """Trees as `trees_of` takes them, all of a forest in one list of nodes."""
    nodes: dict[str, list] = {key: [] for key in ("roots", "feature", "value", "left", "right")}

    def add(node):
        place = len(nodes["feature"])
        leaf = "leaf_value" in node
        nodes["feature"].append(-1 if leaf else node["split_feature"])
        nodes["value"].append(float(f"{node['leaf_value'] if leaf else node['threshold']:.6g}"))
        nodes["left"].append(0)
        nodes["right"].append(0)
        if not leaf:
            nodes["left"][place], nodes["right"][place] = add(node["left_child"]), add(node["right_child"])
        return place

    for model in models:
        nodes["roots"] += [add(tree["tree_structure"]) for tree in model.dump_model()["tree_info"]]
    return {"features": list(choice.START), **nodes}


def judged(groups, parts):
    """Print the mean overlap of what is taken in images left out, beside the best candidate's."""
    names = sorted({(group.kind, group.name) for group in groups})
    place = {name: k for kind in {kind for kind, _ in names} for k, name in enumerate(n for n in names if n[0] == kind)}
    found: dict[Any, list] = {}
    for part in range(parts):
        forest = trees.trees_of(stored(grown([g for g in groups if place[g.kind, g.name] % parts != part])))
        for group in groups:
            if place[group.kind, group.name] % parts == part:
                taken = group.overlaps[int(np.argmax(forest.scores(group.features)))]
                found.setdefault((group.run, group.kind), []).append((taken, group.overlaps.max()))
    for (run, kind), rows in sorted(found.items()):
        both = np.array(rows)
        dice = (2 * both / (1 + both)).mean(axis=0)
        sys.stdout.write(f"{'run ' if run else ''}{kind}: {len(rows)}, overlap {both.mean(axis=0)}, Dice {dice}\n")


def fitted(names, groups):
    """Weights that maximize the same, the score being linear."""
    every = np.concatenate([group.features for group in groups])
    mean, deviation = every.mean(axis=0), every.std(axis=0) + 1e-9
    standard = [(np.clip((g.features - mean) / deviation, -3.0, 3.0), g.overlaps) for g in groups]

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


def fit_clicks(data):
    """Print the weights for clicks, half of the first round following the truth."""
    known: dict[str, list] = {"FIRST": [], "CHANGES": []}
    for number in range(2):
        groups = collect_clicks(data, guided=number == 0, seed=number)
        for name, found in zip(known, groups, strict=True):
            known[name] += found
            setattr(choice, name, fitted(getattr(ranking, name).weights, known[name]))
    for name in known:
        sys.stdout.write(f"{name}\n")
        for feature, row in getattr(choice, name).weights.items():
            sys.stdout.write(f'    "{feature}": ({", ".join(f"{value:.3f}" for value in row)}),\n')


def main():
    """Write the trees, or print weights."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", nargs="+", required=True)
    parser.add_argument("--silhouettes")
    parser.add_argument("--left-out", type=int)
    parser.add_argument("--kept", type=Path)
    parser.add_argument("--clicks", action="store_true")
    arguments = parser.parse_args()
    data = outlined(arguments.data)
    if arguments.clicks:
        return fit_clicks(list(data))
    if arguments.kept and arguments.kept.exists():
        groups = pickle.loads(arguments.kept.read_bytes())
    else:
        groups = collect([*data, *drawn_scenes(arguments.silhouettes)], seed=0)
        if arguments.kept:
            arguments.kept.write_bytes(pickle.dumps(groups))
    if arguments.left_out:
        judged(groups, arguments.left_out)
    forest = {"grown on": sorted({group.kind for group in groups}), "start": stored(grown(groups))}
    trees.TREES_FILE.write_text(json.dumps(forest, separators=(",", ":")) + "\n", encoding="utf-8")
    return None


if __name__ == "__main__":
    main()
