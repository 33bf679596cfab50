"""Scenes of stained tissue: nuclei, glands around a lumen, and fibers, in the colors of two stains."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from cpm_core.numerics.types import Array, Mask, Pixels, Single
from tests.benchmarks.prior.pictures import Example, largest_part
from tests.benchmarks.prior.shapes import FULL_TURN, blob
from tests.benchmarks.prior.textures import blurred, log_uniform, noise, texture

_ABSORPTION = {
    "hematoxylin": (0.65, 0.70, 0.29),
    "eosin": (0.07, 0.99, 0.11),
    "diaminobenzidine": (0.27, 0.57, 0.78),
}
"""What each stain absorbs of red, green and blue (Ruifrok and Johnston, 2001)."""

_MIN_AREA = 60
"""Pixels of the smallest object."""


def tissue(rng: Generator, side: int = 160) -> Example:
    """One of many nuclei, which touch and differ in stain, or a gland or its lumen where there is one."""
    while True:
        size = log_uniform(9, 34, rng)
        gland, lumen = _gland(side, size, rng) if rng.random() < 0.35 else (np.zeros((side, side), np.bool_),) * 2
        nuclei = _nuclei(side, size, gland, lumen, rng)
        large = [mask for mask in (gland, lumen) if _MIN_AREA <= mask.sum() < 0.5 * mask.size]
        fitting = [mask for mask in nuclei if mask.sum() >= _MIN_AREA]
        if large and (not fitting or rng.random() < 0.15):
            fitting = large
        if not fitting:
            continue
        mask = largest_part(fitting[rng.integers(len(fitting))])
        if mask.sum() < _MIN_AREA:
            continue
        image = _stained(nuclei, gland, lumen, size, rng)
        if mask is gland or (mask & gland).sum() > 0.9 * gland.sum() > 0:
            return Example(image, mask, mask & ~np.any([*nuclei, lumen], axis=0))
        return Example(image, mask)


def _gland(side: int, size: float, rng: Generator) -> tuple[Mask, Mask]:
    """A gland and the lumen in it."""
    middle = rng.uniform(0.25, 0.75, 2) * side
    radius = min(size * rng.uniform(1.8, 4), 0.4 * side)
    gland = blob(side, middle, radius, rng.uniform(0, 0.4), 0.12, rng)
    depth = cv2.distanceTransform(gland.astype(np.uint8), cv2.DIST_L2, 3)
    return gland, depth + 1.5 * noise(side, size, rng) > size * rng.uniform(1.1, 1.6)


def _nuclei(side: int, size: float, gland: Mask, lumen: Mask, rng: Generator) -> list[Mask]:
    """Visible parts of nuclei: along the rim of a gland, and scattered, most of them apart from one another."""
    crowding, slenderness = rng.uniform(0.55, 1.3), rng.uniform(0, 0.5) if rng.random() < 0.7 else rng.uniform(0.5, 1.2)
    usual_turn, turns = rng.uniform(0, FULL_TURN), rng.choice((0.3, 3.0))
    depth = cv2.distanceTransform(gland.astype(np.uint8), cv2.DIST_L2, 3)
    rim = np.argwhere((depth > 0.35 * size) & (depth < 0.6 * size))
    places: list[Array] = []
    wanted = int(rng.uniform(0.15, 0.9) * (side / size) ** 2)
    for number in range(4 * wanted):
        in_rim = len(rim) > 0 and number % 2 == 0
        place = rim[rng.integers(len(rim))] + 0.0 if in_rim else rng.uniform(0, side, 2)
        row, col = np.clip(place.astype(int), 0, side - 1)
        if lumen[row, col] or (gland[row, col] and not in_rim):
            continue
        if all(np.hypot(*(place - other)) > crowding * size for other in places):
            places.append(place)
    masks: list[Mask] = []
    for place in places[:wanted]:
        turn = usual_turn + rng.normal(0, turns)
        stretch = abs(rng.normal(slenderness, 0.15))
        nucleus = blob(side, place, 0.5 * size * np.exp(rng.normal(0, 0.18)), stretch, 0.06, rng, turn) & ~lumen
        masks = [before & ~nucleus for before in masks] + [nucleus]
    return masks


def _stained(nuclei: list[Mask], gland: Mask, lumen: Mask, size: float, rng: Generator) -> Pixels:
    """The light that comes through tissue: each stain absorbs by its amount, as Beer and Lambert say."""
    side = len(gland)
    fibers = texture(side, rng) * rng.uniform(0.05, 0.25) + noise(side, 3 * size, rng) * rng.uniform(0, 0.25)
    counter = np.clip(rng.uniform(0.2, 0.8) + fibers, 0.02, None)
    counter = counter * np.where(gland, rng.uniform(0.7, 1.4), 1)
    gaps = noise(side, size * rng.uniform(1, 3), rng) > rng.uniform(0.9, 3)  # tears and fat
    counter = counter * (1 - blurred((gaps | lumen).astype(np.float32), 0.8) * rng.uniform(0.75, 1))
    main = np.full((side, side), rng.uniform(0.02, 0.3), np.float32) + np.abs(fibers) * rng.uniform(0, 0.6)
    main = main * (1 - 0.8 * blurred(lumen.astype(np.float32), 0.8))
    usual, spread, grain = rng.uniform(0.5, 1.6), rng.uniform(0.05, 0.35), rng.uniform(0.05, 0.5)
    hollow = rng.uniform(0, 0.9) if rng.random() < 0.5 else 0.0
    blur = rng.uniform(0.5, 1.6)
    for mask in nuclei:
        if not mask.any():
            continue
        pale = hollow * rng.uniform(0.5, 1)
        main = _with_nucleus(main, mask, usual * np.exp(rng.normal(0, spread)), pale, grain, blur, rng)
    ways = rng.choice(("diaminobenzidine", "hematoxylin", "eosin"), p=(0.15, 0.1, 0.75))
    spectra = [np.array(_ABSORPTION[name]) + rng.normal(0, 0.09, 3) for name in ("hematoxylin", ways)]
    if rng.random() < 0.15:
        spectra.reverse()  # the other stain shows the nuclei
    absorbed = main[..., None] * np.abs(spectra[0]) + counter[..., None] * np.abs(spectra[1])
    light = rng.uniform(215, 255, 3) * np.exp(-absorbed * rng.uniform(0.6, 1.3))
    light = light * (1 + noise(side, side / 2, rng)[..., None] * rng.uniform(0, 0.06))
    light = blurred(light.astype(np.float32), rng.uniform(0.3, 1.3)) + rng.normal(0, rng.uniform(0, 8), light.shape)
    return np.clip(light, 0, 255).astype(np.uint8)


def _with_nucleus(
    main: Single, mask: Mask, amount: float, pale: float, grain: float, blur: float, rng: Generator
) -> NDArray[Any]:
    """An amount of stain with a nucleus in it, which has grains of chromatin, and may be pale but for its rim."""
    depth = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 3)
    inside = amount * (1 - pale * np.clip(depth / 3 - 0.4, 0, 1))
    inside = inside * np.clip(1 + grain * noise(len(mask), rng.uniform(2, 5), rng), 0.1, 2.5)
    cover = blurred(mask.astype(np.float32), blur)
    return np.asarray(main * (1 - cover) + inside * cover, np.float32)
