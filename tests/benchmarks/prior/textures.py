"""Textures: smooth noise of one grain or several, and grounds for objects."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from cpm_core.numerics.types import Pixels, Single


def log_uniform(low: float, high: float, rng: Generator) -> float:
    """A number whose logarithm is uniformly distributed."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def noise(side: int, grain: float, rng: Generator) -> Single:
    """Smooth noise, shape (side, side), interpolated between normal values about `grain` pixels apart."""
    count = max(int(side / grain), 2) + 2
    nodes = rng.standard_normal((count, count)).astype(np.float32)
    return cv2.resize(nodes, (side, side), interpolation=cv2.INTER_CUBIC)


def texture(side: int, rng: Generator) -> Single:
    """Noise of one to three grains, sometimes with stripes, shape (side, side)."""
    values = np.zeros((side, side), np.float32)
    for _ in range(rng.integers(1, 4)):
        values += noise(side, log_uniform(1.2, side / 2, rng), rng) * rng.uniform(0.2, 1)
    if rng.random() < 0.15:
        angle = rng.uniform(0, np.pi)
        rows, cols = np.mgrid[:side, :side]
        stripes = np.sin((rows * np.sin(angle) + cols * np.cos(angle)) * rng.uniform(0.15, 1.5))
        values += stripes * rng.uniform(0.3, 1)
    return values


def ground(photographs: Sequence[Pixels], side: int, rng: Generator) -> NDArray[Any]:
    """What lies behind objects: a part of a photograph, or a texture; gray levels, shape (side, side, 3)."""
    if rng.random() < 0.25:
        gray = texture(side, rng) * rng.uniform(5, 45) + rng.uniform(20, 230)
        return np.repeat(gray[..., None], 3, axis=2) + rng.normal(0, 15, 3) * (rng.random() < 0.5)
    photograph = photographs[rng.integers(len(photographs))]
    height, width = photograph.shape[:2]
    square = int(min(height, width) * rng.uniform(0.35, 1))
    top, left = rng.integers(height - square + 1), rng.integers(width - square + 1)
    part = photograph[top : top + square, left : left + square]
    values = cv2.resize(part, (side, side), interpolation=cv2.INTER_LINEAR).astype(np.float32)
    if rng.random() < 0.5:
        values = values[:, ::-1]
    if rng.random() < 0.2:
        values = cv2.GaussianBlur(values, (0, 0), rng.uniform(1, 4))
    return values


def blurred(values: NDArray[Any], sigma: float) -> NDArray[Any]:
    """Gaussian blur by so many pixels."""
    return cv2.GaussianBlur(values, (0, 0), sigma)


def speckle(side: int, rng: Generator) -> NDArray[Any]:
    """Blurred noise that gray levels are multiplied by, shape (side, side, 1)."""
    return blurred(rng.standard_normal((side, side)).astype(np.float32), rng.uniform(0.5, 2))[..., None]


def fading(side: int, rng: Generator) -> NDArray[Any]:
    """Shares between 0 and 1 that hide an object in places, shape (side, side)."""
    return 1 / (1 + np.exp(-(noise(side, side / 3, rng) + 1) * 3))
