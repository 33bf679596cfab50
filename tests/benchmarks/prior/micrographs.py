"""Made-up micrographs without stain: cells, buds, worms, grains and vesicles, and how contrast is made of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from cpm_core.numerics.types import Array, Mask, Pixels, Single
from tests.benchmarks.prior.pictures import Example, largest_part
from tests.benchmarks.prior.shapes import FULL_TURN, blob, direction, within
from tests.benchmarks.prior.textures import blurred, log_uniform, noise, texture

_MIN_AREA = 80
"""Pixels of the smallest object."""


def micrograph(rng: Generator, side: int = 176) -> Example:
    """One of many specimens of a kind, seen by one of the ways in which light makes contrast."""
    while True:
        masks = _specimens(side, rng)
        image = _SEEN[rng.integers(len(_SEEN))](masks, rng)
        hidden = np.sum(masks, axis=0) > 1
        masks = [largest_part(mask) for mask in masks]
        fitting = [
            mask
            for mask in masks
            if mask.sum() >= _MIN_AREA and mask.mean() < 0.5 and (mask & hidden).sum() < 0.2 * mask.sum()
        ]
        if fitting:
            return Example(_shown(image, rng), fitting[rng.integers(len(fitting))])


def _specimens(side: int, rng: Generator) -> list[Mask]:
    """Specimens of one kind, which keep apart, touch or lie a little over one another."""
    make = (_round, _budding, _spread, _worm, _rough)[rng.integers(5)]
    size = log_uniform(12, 80, rng)
    apart = rng.uniform(0.75, 1.4) * size
    wanted = max(int(rng.uniform(0.15, 0.9) * (side / size) ** 2), 1)
    places: list[Array] = []
    for _ in range(4 * wanted):
        place = rng.uniform(0, side, 2)
        if all(np.hypot(*(place - other)) > apart for other in places):
            places.append(place)
    return [make(side, place, size * np.exp(rng.normal(0, 0.15)), rng) for place in places[:wanted]]


def _round(side: int, middle: Array, size: float, rng: Generator) -> Mask:
    """A blood cell, an egg or a vesicle."""
    return blob(side, middle, size / 2, abs(rng.normal(0, 0.2)), 0.03, rng)


def _budding(side: int, middle: Array, size: float, rng: Generator) -> Mask:
    """A yeast with up to two buds."""
    body = blob(side, middle, 0.32 * size, abs(rng.normal(0.15, 0.15)), 0.02, rng)
    for _ in range(rng.integers(3)):
        share = rng.uniform(0.3, 0.95)
        place = middle + 0.3 * size * (0.8 + share) * direction(rng.uniform(0, FULL_TURN))
        body |= blob(side, place, 0.3 * size * share, 0.1, 0.02, rng)
    return body


def _spread(side: int, middle: Array, size: float, rng: Generator) -> Mask:
    """A cell that clings to the dish, with pointed ends."""
    angles = np.linspace(0, 2 * np.pi, 120, endpoint=False)
    radii = np.full_like(angles, 0.26 * size)
    for _ in range(rng.integers(2, 6)):
        off = (angles - rng.uniform(0, FULL_TURN) + np.pi) % (2 * np.pi) - np.pi
        radii += size * rng.uniform(0.05, 0.5) * np.exp(-((off / rng.uniform(0.12, 0.4)) ** 2))
    for order in range(2, 7):
        radii += 0.02 * size * rng.normal() * np.cos(order * angles + rng.uniform(0, FULL_TURN))
    stretch = np.exp(rng.normal(0, 0.3))
    return within(side, middle + radii[:, None] * np.c_[np.sin(angles) * stretch, np.cos(angles) / stretch])


def _worm(side: int, middle: Array, size: float, rng: Generator) -> Mask:
    """A worm, a rod or a boat, straight or bent, which narrows to its ends."""
    along = np.linspace(0, 1, 60)
    length, width = size * rng.uniform(0.9, 2.2), size * rng.uniform(0.07, 0.22)
    turning = rng.normal(0, 1.2) * (along - 0.5) + rng.normal(0, 0.5) * np.sin(
        FULL_TURN * along + rng.uniform(0, FULL_TURN)
    )
    angles = rng.uniform(0, FULL_TURN) + turning
    line = np.cumsum(np.c_[np.sin(angles), np.cos(angles)], axis=0) * length / 60
    line += middle - line.mean(axis=0)
    half = width * (1 - np.abs(2 * along - 1) ** rng.uniform(1.5, 9)) ** 0.5
    out = np.c_[np.cos(angles), -np.sin(angles)] * half[:, None]
    return within(side, np.r_[line + out, (line - out)[::-1]])


def _rough(side: int, middle: Array, size: float, rng: Generator) -> Mask:
    """A grain of pollen, with bumps or spines around."""
    angles = np.linspace(0, 2 * np.pi, 240, endpoint=False)
    bumps, height, sharpness = rng.integers(6, 30), rng.uniform(0, 0.2), rng.uniform(0.5, 3)
    radii = 0.42 * size * (1 + height * np.abs(np.cos(bumps * angles / 2 + rng.uniform(0, FULL_TURN))) ** sharpness)
    return within(side, middle + radii[:, None] * np.c_[np.sin(angles), np.cos(angles)])


def _thicknesses(masks: list[Mask], rng: Generator) -> list[Single]:
    """How much of each specimen the light passes: domes or plates, with grains in them, and nuclei in some."""
    domed, grain, coarse = rng.uniform(0.05, 1), rng.uniform(0, 0.5), rng.uniform(1.5, 6)
    with_nuclei = rng.random() < 0.5
    found = []
    for mask in masks:
        depth = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 3)
        share = depth / max(float(depth.max()), 1)
        values = np.clip(share / max(domed, 0.05), 0, 1) ** 0.6 * rng.uniform(0.75, 1.2)
        values = values * (1 + grain * noise(len(mask), coarse, rng))
        if with_nuclei:
            values = values + rng.uniform(-0.4, 0.6) * (share > rng.uniform(0.45, 0.7))
        found.append(np.asarray(values * mask, np.float32))
    return found


def _in_phase_contrast(masks: list[Mask], rng: Generator) -> NDArray[Any]:
    """Darker or brighter with thickness, in a halo of the other sign."""
    passed = np.sum(_thicknesses(masks, rng), axis=0, dtype=np.float32)
    reach = rng.uniform(2, 9)
    halo = blurred(passed, reach) - blurred(passed, 0.7)
    image = rng.uniform(0.3, 1.5) * halo - rng.uniform(-0.3, 0.6) * passed
    if rng.random() < 0.4:  # bright rims of cells that have rounded up
        image = image + rng.uniform(0.3, 1) * np.max([_rim(mask, rng.uniform(0.8, 2)) for mask in masks], axis=0)
    return image * rng.choice((-1.0, 1.0), p=(0.2, 0.8))


def _in_differential_contrast(masks: list[Mask], rng: Generator) -> NDArray[Any]:
    """The slope of the thickness along one direction: bright at one side, dark at the other."""
    passed = blurred(np.sum(_thicknesses(masks, rng), axis=0, dtype=np.float32), rng.uniform(0.6, 1.6))
    down, across = np.gradient(passed)
    row, col = direction(rng.uniform(0, FULL_TURN))
    return row * down + col * across - rng.uniform(0, 0.08) * passed


def _in_bright_field(masks: list[Mask], rng: Generator) -> NDArray[Any]:
    """Little absorbed within, and a dark rim beside a bright one where the light is bent."""
    image = -rng.uniform(0, 0.4) * np.sum(_thicknesses(masks, rng), axis=0)
    width, bright, dark = rng.uniform(0.7, 2.2), rng.uniform(0, 0.8), rng.uniform(0.2, 1)
    inside = rng.choice((-1.0, 1.0))
    for mask in masks:
        image = image - dark * _rim(mask, width) + bright * _rim(mask, width, inside * 1.8 * width)
    return np.asarray(image)


def _in_dark_field(masks: list[Mask], rng: Generator) -> NDArray[Any]:
    """Bright rims and grains on black, as in scattered light or of a dye in the membrane."""
    width = rng.uniform(0.7, 2.2)
    rims = [_rim(mask, width) * rng.uniform(0.6, 1.2) for mask in masks]
    uneven = np.clip(1 + rng.uniform(0, 0.6) * noise(len(masks[0]), 12, rng), 0.1, 2)
    return np.asarray(np.sum(rims, axis=0) * uneven + rng.uniform(0, 0.6) * np.sum(_thicknesses(masks, rng), axis=0))


def _rim(mask: Mask, width: float, inward: float = 0.0) -> Single:
    """A line along a boundary, or so many pixels inward from it."""
    within_it = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 3)
    beyond = cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 3)
    line = np.exp(-(((within_it - beyond - inward) / width) ** 2))
    return np.asarray(line, np.float32)


_SEEN: tuple[Callable[[list[Mask], Generator], NDArray[Any]], ...] = (
    _in_phase_contrast,
    _in_phase_contrast,
    _in_differential_contrast,
    _in_bright_field,
    _in_bright_field,
    _in_dark_field,
)


def _shown(image: NDArray[Any], rng: Generator) -> Pixels:
    """Gray levels of a camera, or its colors, with uneven light, dirt and noise."""
    side = len(image)
    image = image / (np.ptp(image) + 1e-6)
    image = image + 0.5 * rng.uniform(0, 0.3) * noise(side, side / 2, rng) + rng.uniform(0, 0.05) * texture(side, rng)
    for _ in range(rng.integers(12) if rng.random() < 0.5 else 0):  # dirt, out of focus
        row, col = rng.uniform(0, side, 2)
        speck = blob(side, np.array([row, col]), rng.uniform(1, 5), 0.2, 0.1, rng)
        image = image + rng.uniform(-0.4, 0.3) * blurred(speck.astype(np.float32), rng.uniform(0.7, 4))
    image = blurred(image.astype(np.float32), rng.uniform(0.3, 1.2))
    image = image + rng.normal(0, rng.uniform(0, 0.06), image.shape)
    darkest, brightest = np.percentile(image, (0.3, 99.7))
    share = np.clip((image - darkest) / (brightest - darkest + 1e-6), 0, 1) ** np.exp(rng.normal(0, 0.3))
    if rng.random() < 0.6:
        return (share * 255).astype(np.uint8)[..., None]
    dark = rng.uniform(0, 120, 3)
    bright = np.clip(rng.uniform(170, 255) + rng.normal(0, 18, 3), 0, 255)
    colors = dark + share[..., None] * (bright - dark)
    return np.clip(colors, 0, 255).astype(np.uint8)
