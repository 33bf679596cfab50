"""Pools: as many scenes as are needed to grow the prior, made up beforehand."""

from __future__ import annotations

import random
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from tests.benchmarks.prior.drawn import drawn
from tests.benchmarks.prior.lines import thin, tiled
from tests.benchmarks.prior.micrographs import micrograph
from tests.benchmarks.prior.nested import nested
from tests.benchmarks.prior.pictures import Example, drawings, photographs, samples
from tests.benchmarks.prior.radiographs import radiograph
from tests.benchmarks.prior.scenes import made_up, regions
from tests.benchmarks.prior.sonograms import sonogram
from tests.benchmarks.prior.tissue import tissue

REGIONS, REGIONS_OF_SAMPLES, MADE_UP, DRAWN, NESTED, THIN, TILED = 1400, 300, 3000, 7000, 2500, 1500, 1500
TISSUE, RADIOGRAPHS, MICROGRAPHS, SONOGRAMS = 2000, 2000, 2500, 1500
"""How many there are of each."""

SEED, SEED_OF_SAMPLES, SEED_OF_DRAWINGS, SEED_OF_LINES, SEED_OF_TISSUE, SEED_OF_CELLS, SEED_OF_BONES = (
    5,
    6,
    11,
    12,
    13,
    14,
    15,
)
"""Seeds of scenes without drawings, of the regions of scikit-image's samples, of scenes with drawings, of lines, of
tissue, of micrographs and sonograms, and of radiographs."""

_GROUND = 200
"""Pixels along each side of photographs that become grounds."""


def pools(outlined: Sequence[Path], drawn_folders: Sequence[Path]) -> dict[str, list[Example]]:
    """All scenes that are made up, by their kind.

    Parameters
    ----------
    outlined : sequence of Path
        Folders of images. Those held out are among them, as their outlines are not read here.
    drawn_folders : sequence of Path
        Folders of drawings on transparent ground.
    """
    images = photographs(outlined)
    grounds = [cv2.resize(image, (_GROUND, _GROUND)) for image in images]
    chance = random.Random(SEED_OF_DRAWINGS)
    clips = [clip for folder in drawn_folders for clip in drawings(folder, chance)]
    found = regions(images, REGIONS, np.random.default_rng(SEED))
    found += regions(samples(), REGIONS_OF_SAMPLES, np.random.default_rng(SEED_OF_SAMPLES))
    rng = np.random.default_rng(SEED)
    shapes = [made_up(rng) for _ in range(MADE_UP)]
    rng = np.random.default_rng(SEED_OF_DRAWINGS)
    pasted = [_slim(drawn(clips, grounds, rng)) for _ in range(DRAWN)]
    rng = np.random.default_rng(SEED_OF_DRAWINGS)
    seen_through = [_slim(nested(clips, grounds, rng)) for _ in range(NESTED)]
    rng = np.random.default_rng(SEED_OF_LINES)
    lines, tiles = [thin(rng) for _ in range(THIN)], [tiled(rng) for _ in range(TILED)]
    rng = np.random.default_rng(SEED_OF_TISSUE)
    sections = [tissue(rng) for _ in range(TISSUE)]
    rng = np.random.default_rng(SEED_OF_BONES)
    exposures = [radiograph(rng) for _ in range(RADIOGRAPHS)]
    rng = np.random.default_rng(SEED_OF_CELLS)
    cells, lesions = [micrograph(rng) for _ in range(MICROGRAPHS)], [sonogram(rng) for _ in range(SONOGRAMS)]
    scenes = {"regions": found, "made_up": shapes, "drawn": pasted, "nested": seen_through}
    scenes |= {"thin": lines, "tiled": tiles, "tissue": sections, "radiographs": exposures}
    return scenes | {"micrographs": cells, "sonograms": lesions}


def _slim(example: Example) -> Example:
    """An example of one channel, a third of the memory, if all its channels are equal."""
    gray = not np.ptp(example.image, axis=-1).any()
    return example._replace(image=example.image[..., :1].copy()) if gray else example
