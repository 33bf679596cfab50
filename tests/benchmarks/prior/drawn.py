"""Scenes of drawings on a ground: shapes of real things, in looks that shall not matter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from cpm_core.numerics.types import Mask, Pixels, Single
from tests.benchmarks.prior.pictures import Example, largest_part
from tests.benchmarks.prior.textures import blurred, fading, ground, log_uniform, noise, speckle, texture


def drawn(drawings: Sequence[Example], photographs: Sequence[Pixels], rng: Generator, side: int = 160) -> Example:
    """Up to four drawings, as they are or filled otherwise, on a ground; one of them is the object."""
    while True:
        image, masks = _pasted(drawings, photographs, side, rng)
        if not masks:
            continue
        mask = largest_part(masks[rng.integers(len(masks))])
        if mask.sum() >= 100:
            return Example(np.clip(image, 0, 255).astype(np.uint8), mask)


def clean(drawings: Sequence[Example], rng: Generator, side: int = 160) -> Example:
    """The shape of one drawing, even, on even ground, a little blurred and with little noise: beyond doubt."""
    while True:
        _, cover = _placed(drawings[rng.integers(len(drawings))], side, rng)
        mask = largest_part(cover > 0.5)
        if mask.sum() < 300:
            continue
        image = 90 + rng.uniform(40, 120) * rng.choice((-0.7, 1)) * blurred(cover, rng.uniform(0.5, 1.5))
        image = image + rng.normal(0, rng.uniform(0, 8), image.shape)
        return Example(np.clip(image, 0, 255).astype(np.uint8)[..., None], mask)


def _pasted(
    drawings: Sequence[Example], photographs: Sequence[Pixels], side: int, rng: Generator
) -> tuple[NDArray[Any], list[Mask]]:
    """Drawings on a ground, with their visible parts."""
    image = ground(photographs, side, rng)
    masks: list[Mask] = []
    in_gray = rng.random() < 0.5
    look = rng.random()
    for _ in range(rng.choice((1, 1, 2, 3, 4))):
        colors, cover = _placed(drawings[rng.integers(len(drawings))], side, rng)
        mask = cover > 0.5
        if mask.sum() < 120:
            continue
        if rng.random() < 0.3:
            look = rng.random()
        colors = _filled_otherwise(colors, mask, image[mask].mean(0), look, photographs, rng)
        if rng.random() < 0.3:
            colors = colors + (noise(side, side / 2, rng) * rng.uniform(5, 35))[..., None]
        soft = blurred(cover, rng.uniform(0.4, 1.2) if rng.random() < 0.75 else rng.uniform(1.2, 3.5))
        if rng.random() < 0.2:
            image = _shaded(image, cover, rng)
        if rng.random() < 0.15:
            soft = soft * fading(side, rng)
        image = image * (1 - soft[..., None]) + colors * soft[..., None]
        masks = [before & ~mask for before in masks] + [mask]
    masks = [mask for mask in masks if mask.sum() >= 120 and mask.mean() < 0.6]
    return (_taken(image, in_gray, rng) if masks else image), masks


def _placed(drawing: Example, side: int, rng: Generator) -> tuple[Single, Single]:
    """A drawing turned, stretched, mirrored and moved: its colors, and the share of each pixel that it covers."""
    colors, mask, _ = drawing
    height, width = mask.shape
    scale = side * log_uniform(0.2, 0.85, rng) / max(height, width)
    turn = rng.normal(0, 0.25) if rng.random() < 0.8 else rng.uniform(-3.1, 3.1)
    stretch = np.exp(rng.normal(0, 0.15))
    cosine, sine = np.cos(turn), scale * np.sin(turn)
    matrix = np.array([[scale * stretch * cosine, -sine, 0], [sine, scale / stretch * cosine, 0]])
    if rng.random() < 0.5:
        matrix[:, 0] *= -1
    middle = rng.uniform(0.25, 0.75, 2) * side
    matrix[:, 2] = middle - matrix[:, :2] @ [width / 2, height / 2]
    if scale < 0.7:
        colors = blurred(colors, 0.4 / scale)
    cover = cv2.warpAffine(mask.astype(np.float32), matrix, (side, side), flags=cv2.INTER_LINEAR)
    colors = cv2.warpAffine(colors, matrix, (side, side), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return colors.astype(np.float32), cover


def _filled_otherwise(
    colors: Single,
    mask: Mask,
    behind: NDArray[Any],
    look: float,
    photographs: Sequence[Pixels],
    rng: Generator,
) -> NDArray[Any]:
    """Colors of a drawing in one of four looks, three of them near what lies behind it, so that it stands out less."""
    side = len(mask)
    if look < 0.3:  # as drawn
        return colors
    if look < 0.5:  # weaker
        weaker = (colors - colors[mask].mean(0)) * rng.uniform(0.15, 0.8)
        return weaker + behind + rng.normal(0, 30) + rng.normal(0, 12, 3)
    if look < 0.8:  # the texture of a photograph, with light and shade of the drawing
        photograph = ground(photographs, side, rng)
        photograph = (photograph - photograph.mean((0, 1))) * rng.uniform(0.3, 1.2)
        light = blurred(colors.mean(-1), rng.uniform(2, 8))
        light = (light - light[mask].mean()) * rng.uniform(0, 0.5)
        tint = rng.normal(0, 40) + rng.normal(0, 15, 3) * (rng.random() < 0.6)
        return photograph + light[..., None] + behind + tint
    # even, or shaded toward the rim
    depth = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 3)
    gray = texture(side, rng) * rng.uniform(0, 18) + rng.normal(0, 30) * np.exp(-depth / rng.uniform(2, 15))
    away = rng.choice((-1, 1)) * rng.uniform(12, 110)
    return np.repeat(gray[..., None], 3, axis=2) + behind + away + rng.normal(0, 15, 3)


def _shaded(image: NDArray[Any], cover: Single, rng: Generator) -> NDArray[Any]:
    """An image with the shadow that a drawing casts on it."""
    shadow = blurred(cover, rng.uniform(2, 8))
    matrix = np.array([[1, 0, rng.normal(0, 8)], [0, 1, rng.normal(4, 6)]], np.float32)
    shadow = cv2.warpAffine(shadow, matrix, cover.shape)
    return image * (1 - shadow[..., None] * rng.uniform(0.2, 0.6))


def _taken(image: NDArray[Any], in_gray: bool, rng: Generator) -> NDArray[Any]:
    """An image as a camera might take it: with speckle, noise, without color, or of low contrast."""
    side = len(image)
    if rng.random() < 0.25:
        image = image * (1 + rng.uniform(0.05, 0.4) * speckle(side, rng) * 2)
    if rng.random() < 0.4:
        image = image + rng.normal(0, rng.uniform(2, 20), image.shape)
    if in_gray:
        image = np.repeat(image.mean(-1, keepdims=True), 3, axis=2)
    if rng.random() < 0.3:
        image = (image - 128) * rng.uniform(0.3, 1) + 128
    return image
