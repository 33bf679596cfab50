"""Drawn scenes with objects in them: silhouettes of one texture on another and of speckle, and cells that touch."""

from pathlib import Path

import numpy as np
from scipy import ndimage as ndi
from skimage import data
from skimage.io import imread
from skimage.transform import resize

_SIDE, _CELLS, _IMAGES_OF_CELLS = 256, 60, 8
_PLAIN = 80


def drawn_scenes(folder):
    """Kind, name, values and labels of each scene; without a folder of silhouettes, those of cells alone."""
    random = np.random.default_rng(5)
    paths = sorted(Path(folder).iterdir()) if folder else []
    for path in paths:
        silhouette = _cropped(imread(path).squeeze())
        size = random.uniform(90, 200) / max(silhouette.shape)
        shape = [max(int(n * size), 8) for n in silhouette.shape]
        silhouette = resize(silhouette.astype(float), shape, order=1) > 0.5
        for kind, paint in (("texture", _textured), ("speckle", _speckled)):
            side = int(max(shape) * random.uniform(1.4, 2.2))
            mask = np.zeros((side, side), bool)
            row, col = (random.integers(0, side - n + 1) for n in shape)
            mask[row : row + shape[0], col : col + shape[1]] = silhouette
            values = paint(random, mask) + random.normal(0, 3, mask.shape)
            yield kind, f"{path.stem}-{kind}", np.clip(values, 0, 255), mask.astype(int)
    for number in range(_IMAGES_OF_CELLS):
        values, labels = _cells(random)
        yield "drawn", f"cells-{number}", 255 - values if number % 3 == 2 else values, labels
    for number in range(_PLAIN):
        values, mask = _plain(random)
        yield "plain", f"plain-{number}", values, mask.astype(int)


def _plain(random):
    """A flat shape on flat ground or its outline, often without noise, cut by the border, or with a gap in the line."""
    side = int(random.integers(56, 110))
    rows, cols = np.mgrid[:side, :side]
    row, col = side * (random.uniform(0.3, 0.7, 2) if random.random() < 0.7 else random.uniform(0.05, 0.95, 2))
    axes = side * random.uniform(0.12, 0.3) * np.array([1, random.uniform(0.5, 1)])
    power = random.choice([2, 2, 8])  # an ellipse, or nearly a rectangle
    size = (np.abs((rows - row) / axes[0]) ** power + np.abs((cols - col) / axes[1]) ** power) ** (1 / power)
    mask = size <= 1
    values = 1.0 * mask
    if random.random() < 0.5:
        near, half = ndi.distance_transform_edt(mask) + ndi.distance_transform_edt(~mask), random.choice([1.0, 2.0])
        turn = np.angle(np.exp(1j * (np.arctan2(rows - row, cols - col) - random.uniform(0, 2 * np.pi))))
        values = 1.0 * (near <= half) * (np.abs(turn) > random.choice([0.0, 0.2, 0.4]))
        mask &= near > half  # what a line encloses
    values = (
        ndi.gaussian_filter(values, random.choice([0.0, 0.7, 1.5])) * random.choice([-1, 1]) * random.uniform(30, 200)
    )
    noise = random.choice([0.0, 0.0, 2.0, 10.0])
    return 127.0 + values + random.normal(0, noise, mask.shape), mask


def _cropped(mask):
    mask = (mask if mask.ndim == 2 else mask[..., 0]) > 127
    mask = ~mask if mask[0, 0] else mask
    rows, cols = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return mask[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1]


def _textured(random, mask):
    """A silhouette of one texture on another."""
    names = random.choice(["brick", "grass", "gravel"], 2)
    painted = []
    for name in names:
        texture = getattr(data, name)().astype(float)
        row, col = (random.integers(0, n - m + 1) for n, m in zip(texture.shape, mask.shape, strict=True))
        part = texture[row : row + mask.shape[0], col : col + mask.shape[1]]
        painted.append(part * random.uniform(0.3, 0.9) + random.uniform(0, 120))
    return ndi.gaussian_filter(np.where(mask, *painted), random.uniform(0.5, 1.5))


def _speckled(random, mask):
    """A dark silhouette in speckle, as in ultrasound images, with blurred boundaries and uneven light."""
    light = ndi.gaussian_filter(random.normal(size=mask.shape), mask.shape[0] / 8)
    level = np.where(mask, random.uniform(30, 70), random.uniform(90, 150))
    level = ndi.gaussian_filter(level, random.uniform(1, 4)) * (1 + 0.25 * light / light.std())
    return level * ndi.gaussian_filter(random.rayleigh(1, size=mask.shape), random.uniform(0.8, 1.6))


def _cells(random):
    """Light ellipses that touch, blurred, with noise."""
    values, labels = np.zeros((_SIDE, _SIDE)), np.zeros((_SIDE, _SIDE), int)
    rows, cols = np.mgrid[:_SIDE, :_SIDE]
    for _ in range(_CELLS):
        row, col = random.uniform(10, _SIDE - 10, 2)
        long, turn = random.uniform(8, 22), random.uniform(0, np.pi)
        wide = long * random.uniform(0.6, 1)
        along = (rows - row) * np.cos(turn) + (cols - col) * np.sin(turn)
        across = (cols - col) * np.cos(turn) - (rows - row) * np.sin(turn)
        cell = (along / long) ** 2 + (across / wide) ** 2 < 1
        if (labels[cell] > 0).mean() > 0.12:
            continue
        level = random.uniform(40, 200) * (1 + 0.2 * ndi.gaussian_filter(random.normal(size=cell.shape), 2)[cell])
        labels[cell & (labels == 0)] = labels.max() + 1
        values[cell] = np.maximum(values[cell], level)
    light = ndi.gaussian_filter(random.normal(size=values.shape), 30) * random.uniform(0, 300)
    values = ndi.gaussian_filter(values, random.uniform(0.8, 2.5)) + random.uniform(5, 30) + light
    return np.clip(values + random.normal(0, random.uniform(1, 8), values.shape), 0, 255), labels
