"""Scenes of objects in objects that are seen through, such as bones in flesh and nuclei in cells, and of clusters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from cpm_core.numerics.types import Mask, Pixels
from tests.benchmarks.prior.pictures import Example, largest_part
from tests.benchmarks.prior.shapes import limbs, moved, smooth_shape
from tests.benchmarks.prior.textures import blurred, ground, noise, texture


def nested(drawings: Sequence[Example], photographs: Sequence[Pixels], rng: Generator, side: int = 192) -> Example:
    """One of the inner objects, or the outer one, where it may be pointed at only beside the inner ones."""
    while True:
        outer, inner = _arranged(drawings, side, rng)
        visible: list[Mask] = []
        for mask in inner:
            visible = [before & ~mask for before in visible] + [mask]
        visible = [mask for mask in visible if mask.sum() >= 60]
        if not visible:
            continue
        image, visible = _seen_through(outer, visible, photographs, rng)
        if outer is not None and rng.random() < 0.3:
            within = np.any(visible, axis=0)
            beside = outer & ~_changed(cv2.dilate, within, 3)
            if beside.sum() > 60:
                return Example(image, outer | within, beside)
        mask = largest_part(visible[rng.integers(len(visible))])
        if mask.sum() >= 50:
            return Example(image, mask)


def _arranged(drawings: Sequence[Example], side: int, rng: Generator) -> tuple[Mask | None, list[Mask]]:
    """An outer object, if any, and those in it: limbs with bones, shapes in a shape, or a cluster."""
    kind = rng.random()
    if kind < 0.4:
        return limbs(side, rng)
    if kind < 0.75:
        return _shapes_in_shape(drawings, side, rng)
    return None, _cluster(drawings, side, rng)


def _shapes_in_shape(drawings: Sequence[Example], side: int, rng: Generator) -> tuple[Mask, list[Mask]]:
    outer = smooth_shape(side, drawings, side * rng.uniform(0.5, 0.9), rng)
    inner = []
    for _ in range(rng.integers(1, 9)):
        mask = smooth_shape(side, drawings, side * rng.uniform(0.08, 0.3), rng)
        inner.append(moved(mask, *rng.normal(0, 0.2 * side, 2)))
    core = _changed(cv2.erode, outer, 5)
    return outer, [mask & core for mask in inner]


def _cluster(drawings: Sequence[Example], side: int, rng: Generator) -> list[Mask]:
    """Objects of about one size that touch; most of them are ellipses."""
    size = side * rng.uniform(0.12, 0.3)
    middle = rng.uniform(0.3, 0.7, 2) * side
    masks = []
    for _ in range(rng.integers(3, 14)):
        if rng.random() < 0.2:
            rng.random()  # decides nothing; without it, later scenes would not be those that the weights are from
            mask = smooth_shape(side, drawings, size * rng.uniform(0.7, 1.3), rng)
        else:
            ellipse = np.zeros((side, side), np.uint8)
            axes = (int(size / 2 * rng.uniform(0.8, 1.3)) + 1, int(size / 2 * rng.uniform(0.6, 1)) + 1)
            cv2.ellipse(ellipse, (side // 2, side // 2), axes, rng.uniform(0, 180), 0, 360, 1, -1)
            mask = ellipse > 0
        masks.append(moved(mask, *(middle - side / 2 + rng.normal(0, size * 1.1, 2))))
    return masks


def _seen_through(
    outer: Mask | None, inner: Sequence[Mask], photographs: Sequence[Pixels], rng: Generator
) -> tuple[Pixels, list[Mask]]:
    """An image to which each object adds its thickness, and the inner objects as they can be seen in it."""
    side = len(inner[0])
    if rng.random() < 0.8:
        image = texture(side, rng) * rng.uniform(1, 10) + (noise(side, side / 2, rng) * rng.uniform(0, 12))
    else:
        image = ground(photographs, side, rng).mean(-1)
    outer_look, inner_look = rng.random(), rng.random()
    amount = rng.uniform(25, 80)
    inner_amount = rng.uniform(0.3, 1.6) * amount * rng.choice((1, 1, 1, -1))
    apart = rng.random() < 0.5
    if outer is not None:
        image = image + _thickness(outer, amount, outer_look, rng)
    visible = []
    for mask in inner:
        clear = _changed(cv2.erode, mask, 3) if outer is None and apart else mask
        visible.append(clear)
        image = image + _thickness(clear, inner_amount * rng.uniform(0.8, 1.2), inner_look, rng)
        if outer is None and rng.random() < 0.5:
            rim = cv2.morphologyEx(clear.astype(np.uint8), cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
            image = image + rim * inner_amount * rng.uniform(-0.6, 0.4)
    return _taken(image, rng), visible


def _thickness(mask: Mask, amount: float, look: float, rng: Generator) -> NDArray[Any]:
    """What an object adds to gray levels: more in its middle, more at its rim, or the same everywhere."""
    depth = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 3)
    values = np.ones_like(depth)
    if look < 0.4:
        values = np.minimum(depth / (depth.max() + 1e-6), rng.uniform(0.2, 0.9))
        values = np.sqrt(values / values.max())
    elif look < 0.6:
        values = 0.5 + np.exp(-depth / rng.uniform(1.5, 5))
    return values * mask * amount * (1 + texture(len(mask), rng) * rng.uniform(0, 0.15))


def _taken(image: NDArray[Any], rng: Generator) -> Pixels:
    """Gray levels as they are recorded: blurred, with noise, another contrast, and sometimes a tint."""
    blur = blurred(image.astype(np.float32), rng.uniform(0.5, 2))
    image = blur + rng.normal(0, rng.uniform(0, 8), image.shape)
    darkest, brightest = np.percentile(image, (0.3, 99.7))
    image = np.clip((image - darkest) / (brightest - darkest + 1e-6), 0, 1) ** np.exp(rng.normal(0, 0.3))
    image = np.repeat((image * 255)[..., None], 3, axis=2)
    if rng.random() < 0.3:
        image = image * rng.uniform(0.5, 1, 3) + rng.uniform(0, 60, 3)
    return np.clip(image, 0, 255).astype(np.uint8)


def _changed(operation: Callable[[Pixels, Pixels], Pixels], mask: Mask, size: int) -> Mask:
    """A mask eroded or dilated by a square."""
    return operation(mask.astype(np.uint8), np.ones((size, size), np.uint8)).astype(np.bool_)
