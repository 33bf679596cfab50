"""Which merged basins may be objects: the numbers of `MergedBasins.find_regions` are learned here.

``python tests/benchmarks/prior/basins.py --outlined FOLDER... [--seed 7]`` merges the basins in images with labels, and
in made-up nets, crowds, shapes and leaves, after a run from everywhere, and learns which nodes of the tree overlap with
a labeled object by 0.6 or more. Each kind, which is a folder, counts in proportion to the square root of its nodes. It
writes the numbers with their origin to `merged_basins.json`, and prints for each kind what share of the objects is
found with an overlap of 0.5 or more by all nodes, and by those that a rule keeps that has not seen this kind, and how
many these are.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

import cpm_core as cpm
from cpm_core.numerics.grids import running_maximum
from cpm_core.numerics.types import Array, Index
from cpm_core.objects import merged_basins
from cpm_core.objects.merged_basins import MIN_OBJECT_AREA, MergedBasins
from tests.benchmarks.prior.found import (
    SIDE,
    made_up_crowds,
    made_up_nets,
    made_up_shapes,
    parts_of,
    read_given,
    shown,
    weigh_kinds,
)
from tests.benchmarks.prior.regression import learned

RIGHT = 0.6
"""Overlap from which a node is right."""

MADE_UP = 4
"""Number of made-up images of a kind."""

FEATURES = (
    "log of edge strength, share on contours, strongest boundary inside, next boundary to be crossed, "
    "log of roundness, log of area, share on the border of the image, log of variation; offset"
)

SOURCES = (
    "nuclei (BBBC038, CC0), strawberries (strawberry_coco_1, MIT), axons_sem (AxonDeepSeg, MIT), cells_phase_t98g "
    "(Usiigaci, MIT), superalloy_precipitates and melt_pools (NASA, MIT), chloroplasts_em (WSU PlantBio ML, MIT), "
    "plant_cells_confocal and plant_nuclei_3d (PlantSeg, EMBL, MIT), sand_gravel_grains (segmenteverygrain, "
    "Apache-2.0), spinal_cord_mr (Spinal Cord Toolbox, MIT), tomato_leaves (ai-for-greenhouses, Apache-2.0), cutouts3d "
    "(Fluent Emoji, Microsoft, MIT), cutouts_freedoom (Freedoom, BSD-3); embryos, flakes_2d_materials, cakes_kuih, "
    "maize_kernels, granular_ore, mushrooms_crop, nanocrystals_sem, plants_pots, strawberry_plant_parts, "
    "electronic_parts and desk_objects (Roboflow Universe, CC BY 4.0); made-up nets, crowds, shapes and leaves"
)
"""Images and their terms."""


class Nodes(NamedTuple):
    """Merged basins of an image: kind, tree, encoded features, overlaps with each labeled object, shape (N, L)."""

    kind: str
    tree: MergedBasins
    signs: Array
    overlaps: Array

    @property
    def large(self) -> Index:
        """The nodes that are large enough."""
        return np.flatnonzero(self.tree.area >= MIN_OBJECT_AREA)


def made_up_leaves(rng: np.random.Generator) -> tuple[cpm.Image, Index]:
    """One leaf with veins, which covers much of the image, on soil."""
    rows, cols = np.indices((SIDE, SIDE))
    row, col = rng.uniform(0.4 * SIDE, 0.6 * SIDE, 2)
    turn, length, width = rng.uniform(0, np.pi), rng.uniform(0.37, 0.55) * SIDE, rng.uniform(0.2, 0.33) * SIDE
    along = (rows - row) * np.cos(turn) + (cols - col) * np.sin(turn)
    across = (cols - col) * np.cos(turn) - (rows - row) * np.sin(turn)
    place = along / length
    inside = (abs(place) < 1) & (abs(across) < width * (1 - place**2) * (1 - 0.3 * place))
    veins = (abs(across) < 2) | ((0.8 * abs(across) + along) % rng.uniform(18, 30) < 3)
    level = rng.uniform(80, 170)
    soil = level + rng.choice([-1.0, 1.0]) * rng.uniform(30, 70)
    leaf = level + 8 * texture(3, rng) + 6 * texture(20, rng) + rng.uniform(-30, 30) * veins
    ground = soil + 12 * texture(8, rng) + 8 * texture(2, rng)
    return shown(np.where(inside, leaf, ground), rng), inside.astype(np.int64)


def texture(size: float, rng: np.random.Generator) -> Array:
    """Noise of a size, of unit variance."""
    noise = scipy.ndimage.gaussian_filter(rng.normal(size=(SIDE, SIDE)), size)
    return noise / noise.std()


def nodes_of(kind: str, image: cpm.Image, labels: Index) -> Nodes:
    """Merged basins of an image."""
    parts = parts_of(image)
    tree = MergedBasins.from_edges(parts.edge_strength, running_maximum(parts.lines, 1), parts.gray_span)
    common = np.zeros((len(tree.parent), int(labels.max()) + 1))
    np.add.at(common, (tree.labels.ravel(), labels.ravel()), 1.0)
    tree.accumulate(common, np.add)
    areas = np.bincount(labels.ravel(), minlength=common.shape[1])
    overlaps = common / np.maximum(tree.area[:, None] + areas - common, 1.0)
    there = np.flatnonzero(areas[1:]) + 1
    return Nodes(kind, tree, tree.encode_nodes(parts.partition.values, parts.gray_span), overlaps[:, there])


def learned_from(images: Sequence[Nodes]) -> Array:
    """The numbers that are learned from images."""
    signs = np.concatenate([one.signs[one.large] for one in images])
    right = np.concatenate([one.overlaps[one.large].max(axis=1) >= RIGHT for one in images]).astype(float)
    return learned(signs, right, weigh_kinds([(one.kind, len(one.large)) for one in images]))


def main() -> None:
    """Merge basins, learn, print and write."""
    makers = made_up_nets, made_up_crowds, made_up_shapes, made_up_leaves
    images, seed = read_given(__doc__, nodes_of, makers, MADE_UP)
    kinds = list(dict.fromkeys(one.kind for one in images))
    for kind in kinds:
        numbers = learned_from([one for one in images if one.kind != kind])
        own = [one for one in images if one.kind == kind]
        kept = [one.tree.find_likely(one.signs @ numbers[:-1] + numbers[-1]) for one in own]
        pairs = list(zip(own, kept, strict=True))
        every = np.mean([(one.overlaps.max(axis=0) >= 0.5).mean() for one in own])
        found = np.mean([(one.overlaps[on].max(axis=0, initial=0.0) >= 0.5).mean() for one, on in pairs])
        print(f"{kind:24s} all nodes {every:.2f}  kept {found:.2f}, {np.mean([len(on) for on in kept]):.0f} of them")
    shares = {
        kind: np.concatenate([one.overlaps[one.large].max(axis=1) for one in images if one.kind == kind])
        for kind in kinds
    }
    origin = {
        "numbers": learned_from(images).round(3).tolist(),
        "features": FEATURES,
        "nodes": {kind: len(overlaps) for kind, overlaps in shares.items()},
        "right": {kind: round(float((overlaps >= RIGHT).mean()), 3) for kind, overlaps in shares.items()},
        "seed": seed,
        "script": "tests/benchmarks/prior/basins.py",
        "data": SOURCES,
    }
    path = Path(merged_basins.__file__).with_suffix(".json")
    path.write_text(json.dumps(origin, indent=2) + "\n", "utf-8")


if __name__ == "__main__":
    main()
