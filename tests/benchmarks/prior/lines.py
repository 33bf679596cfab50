"""Scenes of lines: thin objects such as cracks and neurites, and cells or grains between lines."""

from __future__ import annotations

import cv2
import numpy as np
import scipy
from numpy.random import Generator
from numpy.typing import NDArray

from cpm_core.numerics.types import Mask, Single
from tests.benchmarks.prior.pictures import Example
from tests.benchmarks.prior.textures import blurred, fading, log_uniform, noise, texture

_MIN_AREA = 100
"""Pixels of the smallest object."""

_SUBPIXELS = 4
"""Places in a pixel at which lines of fractional width are drawn."""


def thin(rng: Generator, side: int = 160) -> Example:
    """A winding, branching line on a ground, among others that it does not touch."""
    while True:
        masks: list[Mask] = []
        for _ in range(rng.integers(1, 4)):
            mask = _branches(side, rng)
            taken = cv2.dilate(np.any(masks, axis=0).astype(np.uint8), np.ones((5, 5))) > 0 if masks else np.zeros(0)
            if mask.sum() >= _MIN_AREA and not (masks and (mask & taken).any()):
                masks.append(mask)
        if not masks:
            continue
        image = _ground(side, rng)
        contrast = rng.choice((-1, 1)) * log_uniform(0.6, 2.5, rng)
        for mask in masks:
            cover = blurred(mask.astype(np.float32), rng.uniform(0.4, 1.2))
            cover = cover * fading(side, rng) if rng.random() < 0.3 else cover
            image = image + contrast * cover * (1 + 0.3 * noise(side, side / 6, rng))
        return Example(_finished(image, rng), masks[rng.integers(len(masks))])


def tiled(rng: Generator, side: int = 160) -> Example:
    """One of many cells or grains that fill the plane, with lines between them that have gaps, or other grays."""
    while True:
        size = log_uniform(12, 60, rng)
        count = int((side / size) ** 2) + 3
        seeds = rng.uniform(-0.2 * side, 1.2 * side, (2 * count, 2))
        places = np.indices((side, side)).reshape(2, -1).T + 0.0
        sway = size * rng.uniform(0, 0.35)
        places += sway * np.stack([noise(side, size * 0.7, rng).ravel() for _ in range(2)], 1)
        distance, nearest = scipy.spatial.cKDTree(seeds).query(places * [1, rng.uniform(0.6, 1.6)], 2)
        labels = nearest[:, 0].reshape(side, side)
        gap = blurred((distance[:, 1] - distance[:, 0]).reshape(side, side).astype(np.float32), 0.5)
        width = log_uniform(0.8, 5, rng)
        rim = np.exp(-((gap / width) ** 2))
        mask = labels == rng.choice(np.unique(labels))
        if rng.random() < 0.4:
            mask &= gap > width
        _, parts, sizes, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
        if len(sizes) < 2:
            continue
        mask = parts == 1 + sizes[1:, cv2.CC_STAT_AREA].argmax()
        if not _MIN_AREA <= mask.sum() < 0.4 * mask.size:
            continue
        image = _ground(side, rng) * rng.uniform(0.1, 0.6)
        has_lines = rng.random() < 0.8
        if has_lines:
            holes = (noise(side, size * rng.uniform(0.2, 0.6), rng) > rng.uniform(0.8, 2.5)).astype(np.float32)
            image = image + rng.choice((-1, 1)) * log_uniform(0.8, 2.5, rng) * rim * (1 - blurred(holes, 1.0))
        if not has_lines or rng.random() < 0.5:
            image = image + rng.normal(0, rng.uniform(0.4, 1.2), 2 * count).astype(np.float32)[labels]
        return Example(_finished(image, rng), mask)


def _branches(side: int, rng: Generator) -> Mask:
    """A line of one to twelve pixels' width that winds, and branches up to six times."""
    fine = side * _SUBPIXELS
    drawn = np.zeros((fine, fine), np.uint8)
    width, wind = log_uniform(1.2, 9, rng), rng.uniform(0.02, 0.35)
    starts = [(rng.uniform(0.1, 0.9, 2) * side, rng.uniform(0, 6.3), width)]
    for number in range(rng.integers(1, 8)):
        place, angle, wide = starts[number % len(starts)]
        angle += rng.normal(0, 0.8) if number else 0.0
        step = 3.0
        for done in range(rng.integers(8, 60)):
            ahead = place + step * np.array([np.sin(angle), np.cos(angle)])
            ends = [tuple(int(each) for each in np.round(at[::-1] * _SUBPIXELS)) for at in (place, ahead)]
            cv2.line(drawn, ends[0], ends[1], 1, max(round(wide * _SUBPIXELS), 1))
            place, angle = ahead, angle + rng.normal(0, wind)
            wide = float(np.clip(wide * np.exp(rng.normal(0, 0.04)), 1, 12))
            if done % 7 == 3:
                starts.append((place, angle, max(0.8 * wide, 1)))
        rng.shuffle(starts[1:])
    return cv2.resize(drawn * 255, (side, side), interpolation=cv2.INTER_AREA) > 127


def _ground(side: int, rng: Generator) -> Single:
    """A textured ground of about unit variation at most."""
    return np.asarray(texture(side, rng) * rng.uniform(0.05, 0.8), np.float32)


def _finished(image: NDArray[np.floating], rng: Generator) -> NDArray[np.uint8]:
    """Gray levels, shape (side, side, 1), with uneven light and noise."""
    side = len(image)
    if rng.random() < 0.3:
        image = image + noise(side, side / 2, rng) * rng.uniform(0, 0.8)
    image = image + rng.normal(0, rng.uniform(0, 0.4), image.shape)
    if rng.random() < 0.2:
        image = blurred(image.astype(np.float32), rng.uniform(0.5, 1.5))
    darkest, brightest = np.percentile(image, (0.5, 99.5))
    return np.clip((image - darkest) / (brightest - darkest + 1e-6) * 255, 0, 255).astype(np.uint8)[..., None]
