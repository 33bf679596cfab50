"""Made-up ultrasound images: layers of tissue in speckle, and lesions with what lies behind them."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.special import expit

from cpm_core.numerics.types import Mask, Pixels
from tests.benchmarks.prior.pictures import Example, largest_part
from tests.benchmarks.prior.shapes import FULL_TURN, blob, within
from tests.benchmarks.prior.textures import blurred, noise

_MIN_AREA = 150
"""Pixels of the smallest object."""


def sonogram(rng: Generator, side: int = 192) -> Example:
    """A lesion, cyst or chamber among layers of tissue."""
    while True:
        echo = _layers(side, rng)
        masks: list[Mask] = []
        for _ in range(rng.choice((1, 1, 1, 2, 3))):
            mask = _lesion(side, rng)
            if not any((mask & other).any() for other in masks):
                masks.append(mask)
                echo = _with_lesion(echo, mask, rng)
        fitting = [mask for mask in map(largest_part, masks) if mask.sum() >= _MIN_AREA and mask.mean() < 0.5]
        if fitting:
            return Example(_scanned(echo, rng), fitting[rng.integers(len(fitting))])


def _layers(side: int, rng: Generator) -> NDArray[Any]:
    """How strongly tissue echoes: layers of skin, fat, gland and muscle, with bright sheets between them and within."""
    rows = np.arange(side)[:, None] + rng.uniform(1, 12) * noise(side, side / rng.uniform(1, 4), rng)
    ends = np.sort(rng.uniform(0, side, rng.integers(1, 6)))
    echo = np.full((side, side), rng.uniform(0.2, 0.6), np.float32)
    for end in ends:
        echo = np.where(rows > end, rng.uniform(0.12, 0.65), echo)
        echo = echo + rng.uniform(0, 0.5) * np.exp(-(((rows - end) / rng.uniform(1, 4)) ** 2))
    for _ in range(rng.integers(12)):  # strands
        at, thick = rng.uniform(0, side), rng.uniform(0.8, 3)
        strand = np.exp(-(((rows + rng.normal(0, 0.3) * np.arange(side) - at) / thick) ** 2))
        echo = echo + rng.uniform(0, 0.35) * strand * np.clip(noise(side, side / 3, rng), 0, 1)
    return np.asarray(blurred(np.clip(echo, 0.02, None).astype(np.float32), rng.uniform(0.5, 2)))


def _lesion(side: int, rng: Generator) -> Mask:
    """A smooth oval, lobes that run together, or an outline with spikes."""
    middle, radius = rng.uniform(0.2, 0.8, 2) * side, side * rng.uniform(0.05, 0.28)
    kind = rng.random()
    if kind < 0.45:
        return blob(side, middle, radius, rng.uniform(0, 0.8), 0.05, rng, turn=np.pi / 2 + rng.normal(0, 0.3))
    if kind < 0.75:
        lobes = [
            blob(side, middle + rng.normal(0, 0.5 * radius, 2), radius * rng.uniform(0.4, 0.8), 0.3, 0.08, rng)
            for _ in range(rng.integers(2, 5))
        ]
        return np.any([blob(side, middle, 0.7 * radius, 0.4, 0.08, rng), *lobes], axis=0)
    angles = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    radii, spikes = np.full_like(angles, 0.8 * radius), rng.uniform(0.1, 0.45)
    for order in range(2, 22):
        radii += radius * spikes * rng.normal() / order * np.cos(order * angles + rng.uniform(0, FULL_TURN))
    ends = np.clip(radii, 0.3 * radius, None)[:, None] * np.c_[np.sin(angles) * rng.uniform(0.6, 1.2), np.cos(angles)]
    return within(side, middle + ends)


def _with_lesion(echo: NDArray[Any], mask: Mask, rng: Generator) -> NDArray[Any]:
    """Fewer echoes within, uneven ones, a rim that is bright or fuzzy, and behind it a shadow or brighter tissue."""
    side = len(mask)
    depth = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 3)
    beyond = cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 3)
    cover = expit((depth - beyond) / rng.uniform(0.5, 3))
    fuzzy = np.clip(cover + rng.uniform(0, 0.5) * noise(side, 8, rng) * np.exp(-((depth - beyond) ** 2) / 40), 0, 1)
    share = rng.uniform(0.02, 0.5) if rng.random() < 0.85 else rng.uniform(1.5, 3)
    inner = (
        share
        * float(np.median(echo[mask]))
        * np.clip(1 + rng.uniform(0, 0.7) * noise(side, rng.uniform(4, 25), rng), 0.1, 3)
    )
    echo = echo * (1 - fuzzy) + inner * fuzzy
    if rng.random() < 0.5:
        echo = echo + rng.uniform(0, 0.4) * np.exp(-(((beyond - depth) / rng.uniform(1.5, 6)) ** 2))
    if rng.random() < 0.6:
        passed = np.cumsum(mask, axis=0) / max(int(mask.sum(axis=0).max()), 1)
        behind = blurred((passed * (1 - cover)).astype(np.float32), rng.uniform(1, 6))
        behind[: int(np.nonzero(mask.any(axis=1))[0][0])] = 0
        echo = echo * np.exp(rng.uniform(-1.8, 0.8) * behind)
    return np.asarray(echo, np.float32)


def _scanned(echo: NDArray[Any], rng: Generator) -> Pixels:
    """Gray levels in an image of one channel: speckle, wider across the beam than along it, and the logarithm of it."""
    side = len(echo)
    across, along = rng.uniform(0.8, 3.5), rng.uniform(0.5, 1.6)
    waves = rng.standard_normal((2, side, side)).astype(np.float32)
    waves = np.stack([cv2.GaussianBlur(wave, (0, 0), sigmaX=across, sigmaY=along) for wave in waves])
    amplitude = np.hypot(*waves)
    amplitude = (amplitude / amplitude.mean()) ** rng.uniform(0.3, 1)
    fading = np.exp(-rng.uniform(-0.3, 1.2) * np.linspace(0, 1, side)[:, None] + 0.2 * noise(side, side / 2, rng))
    seen = np.clip(echo, 1e-3, None) * amplitude * fading
    shown = np.log1p(seen * rng.uniform(3, 30))
    shown = blurred(shown.astype(np.float32), rng.uniform(0.3, 0.9))
    darkest, brightest = np.percentile(shown, (1, 99.7))
    share = np.clip((shown - darkest) / (brightest - darkest + 1e-6), 0, 1) ** np.exp(rng.normal(0.1, 0.3))
    return (share * 255).astype(np.uint8)[..., None]
