"""Scenes without drawings: regions that a method finds in photographs by itself, and shapes that are made up."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import cv2
import numpy as np
import skimage
from numpy.random import Generator
from numpy.typing import NDArray

from cpm_core.numerics.types import Mask, Pixels
from tests.benchmarks.prior.pictures import Example, filled, largest_part
from tests.benchmarks.prior.shapes import shape
from tests.benchmarks.prior.textures import blurred, fading, log_uniform, noise, speckle, texture


def regions(photographs: Sequence[Pixels], count: int, rng: Generator) -> list[Example]:
    """Regions of photographs that Felzenszwalb's method finds at random scales, of things and of their parts.

    They teach what edges and colors hold together, on images whose objects nobody has outlined.
    """
    found: list[Example] = []
    while len(found) < count:
        found += _regions_of(photographs[rng.integers(len(photographs))], rng)
    return found[:count]


def _regions_of(photograph: Pixels, rng: Generator) -> Iterator[Example]:
    """Up to four regions of a photograph, those that are no mere fringes."""
    height, width = photograph.shape[:2]
    scale = min(1, 256 / max(height, width) * rng.uniform(0.7, 1.3))
    size = (max(int(width * scale), 32), max(int(height * scale), 32))
    image = cv2.resize(photograph, size, interpolation=cv2.INTER_AREA)
    labels = skimage.segmentation.felzenszwalb(
        image, scale=log_uniform(60, 1500, rng), sigma=rng.uniform(0.5, 1.5), min_size=60
    )
    areas = np.bincount(labels.ravel())
    fitting = [label for label, area in enumerate(areas) if 150 <= area < 0.4 * labels.size]
    for label in rng.permutation(fitting)[:4]:
        opened = cv2.morphologyEx((labels == label).astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
        mask = largest_part(opened > 0)
        if not mask.any():
            continue
        whole, outlines = filled(mask)
        area, perimeter = mask.sum(), sum(len(outline) for outline in outlines)
        if area < 0.6 * whole.sum() or 4 * math.pi * area / perimeter**2 < 0.08:
            continue
        # small holes are faults of the method, large ones are holes
        yield Example(image, whole if area >= 0.9 * whole.sum() else mask)


def made_up(rng: Generator, side: int = 160) -> Example:
    """A scene of textured shapes, one of which is the object."""
    while True:
        image, masks = _textured_shapes(side, rng)
        fitting = [mask for mask in masks if mask.sum() >= 120 and mask.mean() < 0.5]
        if not fitting:
            continue
        darkest, brightest = np.percentile(image, (0.5, 99.5))
        image = np.clip((image - darkest) / (brightest - darkest + 1e-6) * 255, 0, 255).astype(np.uint8)
        mask = largest_part(fitting[rng.integers(len(fitting))])
        if mask.sum() >= 100:
            return Example(image, mask)


def _textured_shapes(side: int, rng: Generator) -> tuple[NDArray[Any], list[Mask]]:
    """Up to six shapes on a ground, in color or gray, with their visible parts."""
    gray = texture(side, rng) * rng.uniform(0.05, 1)
    in_color = rng.random() < 0.5
    image = np.repeat(gray[..., None], 3, axis=2)
    if in_color:
        image = image + rng.normal(0, 0.7, 3)
    count = rng.integers(1, 7)
    alike = rng.random() < 0.5
    look = _look(in_color, rng)
    masks: list[Mask] = []
    for _ in range(count):
        mask = shape(side, rng)
        if mask.sum() < 120:
            continue
        if not alike:
            look = _look(in_color, rng)
        image = _painted(image, mask, look, rng)
        masks = [before & ~mask for before in masks] + [mask]
    if rng.random() < 0.4:
        image = image + noise(side, side / 2, rng)[..., None] * rng.uniform(0, 1)
    if rng.random() < 0.3:
        image = image * (1 + rng.uniform(0.1, 0.5) * speckle(side, rng))
    image = image + rng.normal(0, rng.uniform(0, 0.35), image.shape)
    if not in_color:
        image = np.repeat(image.mean(-1, keepdims=True), 3, axis=2)
    return image, masks


def _look(in_color: bool, rng: Generator) -> tuple[float, NDArray[Any], float]:
    """Brightness and tint of a shape, and how much texture it has."""
    return rng.normal(0, 1.2), rng.normal(0, 0.8, 3) * in_color, rng.uniform(0, 0.8)


def _painted(image: NDArray[Any], mask: Mask, look: tuple[float, NDArray[Any], float], rng: Generator) -> NDArray[Any]:
    """An image with a shape on it, which is blurred, and may be a mere line or fade in places."""
    brightness, tint, roughness = look
    side = len(image)
    inside = brightness + texture(side, rng) * roughness
    if rng.random() < 0.25:  # a shaded rim, or light from one side
        depth = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 3)
        inside = inside + rng.normal() * np.exp(-depth / rng.uniform(2, 12))
    sigma = rng.uniform(0.3, 2.5) if rng.random() < 0.7 else rng.uniform(2, 5)
    cover = blurred(mask.astype(np.float32), sigma)
    if rng.random() < 0.15:  # nothing but a line around it
        line = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
        cover = blurred(line.astype(np.float32), 0.8)
    if rng.random() < 0.3:
        cover = cover * fading(side, rng)
    cover = cover[..., None]
    return image * (1 - cover) + (inside[..., None] + tint) * cover
