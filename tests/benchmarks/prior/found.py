"""How sure an object found everywhere is: the numbers of `estimate_region_confidence` are learned here.

``python tests/benchmarks/prior/found.py --outlined FOLDER... [--seed 7]`` finds the candidates for objects
in images with labels, and in made-up nets, crowds, shapes, metals and rosettes, and learns which of them overlap with a
labeled object by 0.8 or more. Each kind, which is a folder, counts in proportion to the square root of its candidates.
Of kinds that the network has learned from, only images that were held out are used. It writes the numbers with their
origin to `confidence_everywhere.json`, and prints for each kind what is shown and what is right if it is left out, and
how well the objects that are then found match those labeled.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np
import scipy
import skimage

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

import cpm_core as cpm
from cpm_core.numerics.types import Array, Index
from cpm_core.objects import confidence
from cpm_core.objects.all_objects import choose_objects, find_likely_objects, predict_candidates, weigh_siblings
from cpm_core.objects.image_parts import ImageParts
from cpm_core.objects.region_evidence import RegionEvidence
from cpm_core.objects.selection import Candidate
from tests.benchmarks.prior.pictures import held_out_labels, overlaps
from tests.benchmarks.prior.regression import curve, learned

MOST = {"nuclei": 24, "embryos": 8, "strawberries": 8} | dict.fromkeys(
    ("cells_phase_t98g", "plant_nuclei_3d", "maize_kernels", "cakes_kuih"), 6
)
"""Largest number of images of a kind, where it is not `MOST_OF_OTHERS`."""

MOST_OF_OTHERS = 5

MADE_UP = 6
"""Number of made-up images of a kind."""

SIDE = 280
"""Side of made-up images [px]."""

SOURCES = (
    "nuclei (BBBC038, CC0), cats (Cornell Feline Health Center, public domain), strawberries (strawberry_coco_1, MIT), "
    "axons_sem (AxonDeepSeg, MIT), cells_phase_t98g (Usiigaci, MIT), superalloy_precipitates (NASA, MIT), "
    "chloroplasts_em (WSU PlantBio ML, MIT), plant_cells_confocal and plant_nuclei_3d (PlantSeg, EMBL, MIT), "
    "sand_gravel_grains (segmenteverygrain, Apache-2.0); embryos, flakes_2d_materials, cakes_kuih, maize_kernels, "
    "granular_ore, mushrooms_crop and nanocrystals_sem (Roboflow Universe, CC BY 4.0); "
    "made-up nets, crowds, shapes, metals and rosettes"
)
"""Images and their terms."""


class Candidates(NamedTuple):
    """Candidates of an image, with what is labeled in it."""

    kind: str
    labels: Index
    evidence: RegionEvidence
    candidates: list[Candidate]
    features: list[confidence.RegionFeatures]
    right: Array


def labeled_images(folder: Path) -> Iterator[tuple[cpm.Image, Index]]:
    """Some images of a folder, evenly among those that may be used."""
    paths = held_out_labels(folder)
    most = MOST.get(folder.name, MOST_OF_OTHERS)
    for path in paths[:: max(len(paths) // most, 1)][:most]:
        stem = path.name.removesuffix("_labels.png")
        image = next(there for ending in (".png", ".jpg") if (there := path.with_name(stem + ending)).exists())
        yield cpm.load_image(image), skimage.io.imread(path).astype(np.int64)


def made_up_nets(rng: np.random.Generator) -> tuple[cpm.Image, Index]:
    """Grains that fill the image, with lines between them or in tones of their own."""
    count = int(rng.integers(12, 80))
    bend = scipy.ndimage.gaussian_filter(rng.normal(size=(2, SIDE, SIDE)), (0, 12, 12))
    places = np.indices((SIDE, SIDE)) + rng.uniform(0, 3) * bend / bend.std()
    tree = scipy.spatial.cKDTree(rng.uniform(0, SIDE, (count, 2)))
    labels = tree.query(np.moveaxis(places, 0, -1))[1] + 1
    if rng.random() < 0.5:
        return shown(rng.uniform(60, 210, count + 1)[labels], rng), labels
    lines = np.zeros(labels.shape, bool)
    lines[:-1] |= labels[:-1] != labels[1:]
    lines[:, :-1] |= labels[:, :-1] != labels[:, 1:]
    wide = scipy.ndimage.distance_transform_edt(~lines) < rng.uniform(0.8, 2.2)
    return shown(
        np.where(wide, rng.uniform(30, 110), rng.normal(170, rng.uniform(2, 15), count + 1)[labels]), rng
    ), labels


def made_up_crowds(rng: np.random.Generator) -> tuple[cpm.Image, Index]:
    """Ellipses of similar sizes, many of which touch."""
    rows, cols = np.indices((SIDE, SIDE))
    values, labels = np.full((SIDE, SIDE), rng.uniform(15, 60)), np.zeros((SIDE, SIDE), np.int64)
    radius, wanted = rng.uniform(8, 22), int(rng.integers(15, 45))
    for _ in range(400):
        turn, (row, col), (long, short) = (
            rng.uniform(0, np.pi),
            rng.uniform(0, SIDE, 2),
            radius * rng.uniform(0.75, 1.3, 2),
        )
        along = (rows - row) * np.cos(turn) + (cols - col) * np.sin(turn)
        across = (cols - col) * np.cos(turn) - (rows - row) * np.sin(turn)
        inside = (along / long) ** 2 + (across / short) ** 2 < 1
        own = inside & (labels == 0)
        if np.count_nonzero(own) >= max(60, 0.88 * np.count_nonzero(inside)):
            labels[own] = labels.max() + 1
            values[own] += rng.uniform(60, 130)
        if labels.max() == wanted:
            break
    return shown(values if rng.random() < 0.6 else 235 - values, rng), labels


def made_up_shapes(rng: np.random.Generator) -> tuple[cpm.Image, Index]:
    """Lobed shapes that lie apart, some with a hole or a wedge cut out of them."""
    rows, cols = np.indices((SIDE, SIDE))
    values, labels = np.full((SIDE, SIDE), rng.uniform(15, 60)), np.zeros((SIDE, SIDE), np.int64)
    for _ in range(60):
        radius, (row, col) = rng.uniform(14, 50), rng.uniform(0, SIDE, 2)
        away, angle = np.hypot(rows - row, cols - col), np.arctan2(rows - row, cols - col)
        lobes = 1.0 + rng.uniform(0.0, 0.35) * np.sin(rng.integers(2, 7) * angle + rng.uniform(0, 6))
        inside = away < radius * lobes
        if (labels[away < 1.35 * radius + 6] > 0).any():
            continue
        cut = rng.random()
        if cut < 0.35:
            inside &= away > rng.uniform(0.3, 0.75) * radius * lobes
        elif cut < 0.6:
            inside &= np.cos(angle - rng.uniform(0, 6)) < rng.uniform(0.4, 0.95)
        labels[inside] = labels.max() + 1
        values[inside] += rng.uniform(60, 130)
    return shown(values if rng.random() < 0.6 else 235 - values, rng), labels


def made_up_metals(rng: np.random.Generator) -> tuple[cpm.Image, Index]:
    """Grains between dark lines that differ in contrast and have gaps, with scratches."""
    count = int(rng.integers(20, 110))
    places = np.indices((SIDE, SIDE))
    labels = scipy.spatial.cKDTree(rng.uniform(0, SIDE, (count, 2))).query(np.moveaxis(places, 0, -1))[1] + 1
    low, high = scipy.ndimage.minimum_filter(labels, 5), scipy.ndimage.maximum_filter(labels, 5)
    boundary = scipy.ndimage.morphological_gradient(labels, 2) > 0
    line = np.exp(-((scipy.ndimage.distance_transform_edt(~boundary) / rng.uniform(1.0, 2.0)) ** 2))
    pairs, number = np.unique(high * (count + 2) + low, return_inverse=True)
    contrast = rng.uniform(30, 110) * np.clip(rng.normal(1.0, rng.uniform(0.05, 0.35), len(pairs)), 0.15, 2.0)
    strength = contrast[number].reshape(labels.shape)
    where = np.argwhere(boundary)
    for row, col in where[rng.integers(0, len(where), int(rng.integers(0, 20)))].tolist():
        away = (places[0] - row) ** 2 + (places[1] - col) ** 2
        strength *= 1.0 - np.exp(-away / rng.uniform(2, 16))
    values = rng.uniform(150, 200) + rng.normal(0, rng.uniform(1, 22), count + 1)[labels] - strength * line
    for _ in range(int(rng.integers(0, 8))):
        ends = rng.integers(0, SIDE, 4).tolist()
        values[skimage.draw.line(*ends)] += rng.choice([-1.0, 1.0]) * rng.uniform(10, 50)
    return shown(values, rng), labels


def made_up_rosettes(rng: np.random.Generator) -> tuple[cpm.Image, Index]:
    """Leaves with midribs that lie over one another around a middle, on soil."""
    rows, cols = np.indices((SIDE, SIDE)) - SIDE / 2 + rng.uniform(-20, 20, (2, 1, 1))
    soil = scipy.ndimage.gaussian_filter(rng.normal(size=(SIDE, SIDE)), 2.5)
    values, labels = rng.uniform(40, 80) + 9.0 * soil / soil.std(), np.zeros((SIDE, SIDE), np.int64)
    count, largest, level = int(rng.integers(5, 14)), rng.uniform(0.2, 0.42) * SIDE, rng.uniform(110, 175)
    for number in range(count):
        turn = np.deg2rad(137.5) * number + rng.normal(0, 0.12)
        length = largest * (1.0 - 0.65 * number / count) * rng.uniform(0.85, 1.15)
        along = (rows * np.sin(turn) + cols * np.cos(turn)) / length - rng.uniform(0.05, 0.4)
        across = cols * np.sin(turn) - rows * np.cos(turn)
        half = length * rng.uniform(0.28, 0.45) * np.sqrt(np.clip(4.0 * along * (1.0 - along), 0.0, None))
        leaf = abs(across) < half
        rim = np.clip(scipy.ndimage.distance_transform_edt(leaf) / 4.0, 0.0, 1.0)
        halves = 1.0 + rng.uniform(-0.03, 0.03) * np.sign(across)
        rib = rng.uniform(8, 30) * np.exp(-((across / rng.uniform(0.9, 1.8)) ** 2))
        values *= 1.0 - rng.uniform(0.05, 0.3) * scipy.ndimage.gaussian_filter(leaf.astype(float), 2.5)
        values = np.where(leaf, level * rng.uniform(0.88, 1.08) * (0.88 + 0.12 * rim) * halves + rib, values)
        labels[leaf] = number + 1
    return shown(values, rng), labels


def shown(values: Array, rng: np.random.Generator) -> cpm.Image:
    """An image of values, blurred, unevenly lit and noisy."""
    light = scipy.ndimage.gaussian_filter(rng.normal(size=values.shape), 25)
    blurred = scipy.ndimage.gaussian_filter(values + rng.uniform(0, 10) * light / light.std(), rng.uniform(0.5, 1.2))
    return cpm.Image(np.clip(blurred + rng.normal(0, rng.uniform(2, 12), values.shape), 0, 255).round())


def parts_of(image: cpm.Image) -> ImageParts:
    """The parts of an image after a run from everywhere."""
    result = cpm.segment(image, cpm.uniform_grid(image.shape), cpm.PRESETS["automatic"])
    return ImageParts.from_partition(cpm.Partition.from_result(result))


def candidates_of(kind: str, image: cpm.Image, labels: Index) -> Candidates:
    """Candidates for the objects of an image after a run from everywhere."""
    evidence = RegionEvidence(parts_of(image))
    found = predict_candidates(evidence)
    best = np.array([overlaps(one.region.paste(labels.shape), labels).max(initial=0.0) for one in found])
    features = [evidence.measure_candidate(one) for one in found]
    found = [one._replace(strength=each.strength) for one, each in zip(found, features, strict=True)]
    return Candidates(kind, labels, evidence, found, features, (best >= confidence.CORRECT_IOU).astype(float))


def stacked(images: Sequence[Candidates]) -> tuple[Array, Array, Array]:
    """Encoded features, what is right, and weights, of the candidates of some images."""
    images = [one for one in images if one.features]
    features = np.array([confidence.encode_region(each) for one in images for each in one.features])
    weights = weigh_kinds([(one.kind, len(one.features)) for one in images])
    return features, np.concatenate([one.right for one in images]), weights


def weigh_kinds(sizes: Sequence[tuple[str, int]]) -> Array:
    """Weigh the samples of images, given by kind and number: each kind counts by the square root of its samples."""
    counts = Counter[str]()
    for kind, size in sizes:
        counts[kind] += size
    weights = np.concatenate([np.full(size, counts[kind] ** -0.5) for kind, size in sizes])
    return weights * len(weights) / weights.sum()


def beside_siblings(image: Candidates, numbers: Array) -> Array:
    """Encoded features of the candidates of an image beside those that are likely by some numbers, shape (N, 4)."""
    likely = likely_by(image, numbers).tolist()
    rated = [one._replace(confidence=each) for one, each in zip(image.candidates, likely, strict=True)]
    values = image.evidence.partition.values
    weights = weigh_siblings(rated, find_likely_objects(rated, values), values)
    return np.array(
        [confidence.encode_siblings(one.confidence, *each) for one, each in zip(rated, weights, strict=True)]
    ).reshape(-1, 4)


def likely_by(image: Candidates, numbers: Array) -> Array:
    """How likely the candidates of an image are by some numbers, shape (N,)."""
    features = np.array([confidence.encode_region(each) for each in image.features]).reshape(-1, len(numbers) - 1)
    return np.clip(scipy.special.expit(features @ numbers[:-1] + numbers[-1]), 1e-6, 0.98)


def learned_siblings(images: Sequence[Candidates], numbers: Array) -> Array:
    """The numbers by which siblings count, learned from images after the others; where there are none, none count."""
    images = [one for one in images if one.features]
    _, right, weights = stacked(images)
    return learned(np.concatenate([beside_siblings(one, numbers) for one in images]), right, weights, has_offset=False)


def score(image: Candidates, shown_as: Array) -> float:
    """F1 at an overlap of 0.5 of the objects that are chosen with some probabilities."""
    hit, count = set(), 0
    given = zip(image.candidates, shown_as.tolist(), strict=True)
    rated = (one._replace(confidence=confidence) for one, confidence in given)
    for one in choose_objects(rated, image.evidence.partition.values):
        count += 1
        overlap = overlaps(one.region.paste(image.labels.shape), image.labels)
        if overlap.max(initial=0.0) >= 0.5:
            hit.add(int(overlap.argmax()))
    return 2.0 * len(hit) / max(count + np.count_nonzero(np.bincount(image.labels.ravel())[1:]), 1)


Prepared = TypeVar("Prepared")
Maker = Callable[[np.random.Generator], tuple[cpm.Image, Index]]


def read_given(
    description: str | None, prepare: Callable[[str, cpm.Image, Index], Prepared], makers: Iterable[Maker], count: int
) -> tuple[list[Prepared], int]:
    """What is prepared of the images in the folders that the command names and of `count` of each maker; the seed."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--outlined", nargs="+", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=7)
    given = parser.parse_args()
    rng = np.random.default_rng(given.seed)
    images = [prepare(folder.name, *each) for folder in given.outlined for each in labeled_images(folder)]
    images += [prepare(make.__name__, *make(rng)) for make in makers for _ in range(count)]
    return images, given.seed


def main() -> None:
    """Find candidates, learn, print and write."""
    makers = made_up_nets, made_up_crowds, made_up_shapes, made_up_metals, made_up_rosettes
    learn_numbers(*read_given(__doc__, candidates_of, makers, MADE_UP))


def learn_numbers(images: Sequence[Candidates], seed: int) -> None:
    """Learn from images, print how well that holds on each kind if it is left out, and write the numbers."""
    kinds = dict.fromkeys(one.kind for one in images)
    for kind in kinds:
        numbers = learned(*stacked([one for one in images if one.kind != kind]))
        own, shares, right, matches = [one for one in images if one.kind == kind], [], [], []
        for one in own:
            shares.append(likely_by(one, numbers))
            right.append(one.right)
            matches.append(score(one, shares[-1]))
        shown_right = curve(np.concatenate(shares), np.concatenate(right))
        print(f"{kind:24s} F1 {np.mean(matches):.3f}  shown/right/candidates  {shown_right}")
    features, right, weights = stacked(images)
    numbers = learned(features, right, weights)
    origin = {
        "numbers": numbers.round(3).tolist(),
        "siblings": learned_siblings(images, numbers).round(3).tolist(),
        "features": f"{', '.join(confidence.RegionFeatures._fields)}, bounded times predicted_iou; offset",
        "candidates": {kind: sum(len(one.features) for one in images if one.kind == kind) for kind in kinds},
        "right": {
            kind: round(float(np.concatenate([one.right for one in images if one.kind == kind]).mean()), 3)
            for kind in kinds
        },
        "seed": seed,
        "script": "tests/benchmarks/prior/found.py",
        "data": SOURCES,
    }
    path = Path(confidence.__file__).with_name("confidence_everywhere.json")
    path.write_text(json.dumps(origin, indent=2) + "\n", "utf-8")


if __name__ == "__main__":
    main()
