"""Features of contours: what the image looks like along them, for comparison with one another.

Every feature is a mean along the contour. All are put on a robust scale among the contours of the image, so that they
depend neither on the exposure nor, but for how contours relate to one another, on the image.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.field.edge_map import gradient, magnitude
from cpm_core.field.interpolation import interpolate
from cpm_core.field.region_contrast import Sides
from cpm_core.numerics import polyline
from cpm_core.numerics.reproducible.gaussian import gaussian_filter
from cpm_core.numerics.types import Array, Mask

FEATURES = (
    "strength at 1 px",
    "strength",
    "strength at twice the scale",
    "strength at four times the scale",
    "gray on the dark side",
    "gray on the bright side",
    "step",
    "texture on the smoother side",
    "texture on the rougher side",
    "gray far on the dark side",
    "gray far on the bright side",
    "strength around",
    "strength against that around",
    "strength against that farther around",
    "coherence of directions around",
    "contours around",
    "length",
    "straightness",
)
"""What the columns of the features are; strengths, step, textures, contours around and length are logarithms."""

_MOST_PLACES = 48
"""Places along a contour over which features are averaged."""

_NEAR, _NEAR_SMOOTHING, _FAR = 4.0, 1.5, 15.0
"""Distance from the contour at which its sides are compared: a constant, a multiple of sigma, and farther off [px]."""

_TEXTURE, _FAR_SMOOTHING, _COHERENCE, _AROUND, _FARTHER, _DENSITY = 3.0, 5.0, 6.0, 8.0, 20.0, 12.0
"""Gaussians over which texture, gray far off, directions, strength and contours are averaged [px]."""

_STRETCH = 8
"""Number of vertices over which straightness is measured, about a dozen px."""

_CLIPPED = 3.0
"""Robust standard deviations beyond which a feature counts no further."""


def contour_features(contours: Sequence[Contour]) -> Array:
    """Features of contours on a robust scale.

    Parameters
    ----------
    contours : sequence of Contour
        All contours of an image, found in it.

    Returns
    -------
    ndarray, shape (N, len(FEATURES))
        A row for each: (feature - median) / (1.4826 x median deviation), clipped to ±3. NaN for a contour that was not
        found in an image.
    """
    return _features(tuple(contours))


@lru_cache(maxsize=1)
def _features(contours: tuple[Contour, ...]) -> Array:
    """The same, kept for the contours that were asked for last: they are shown, counted and written."""
    out = np.full((len(contours), len(FEATURES)), np.nan)
    groups: dict[tuple[int, float], list[tuple[int, Contour, Sides]]] = {}
    for index, contour in enumerate(contours):
        if isinstance(contour.sides, Sides):
            key = (id(contour.sides.values), contour.sides.smoothing)
            groups.setdefault(key, []).append((index, contour, contour.sides))
    for members in groups.values():
        rows = [_appearance([sides for _, _, sides in members]), _form([contour for _, contour, _ in members])]
        out[[index for index, _, _ in members]] = np.concatenate(rows, axis=1)
    found = usable(out)
    out[found] = robustly_scaled(out[found])
    out[~found] = np.nan
    out.flags.writeable = False
    return out


def usable(features: Array) -> Mask:
    """Which rows of features, shape (N, F), are those of contours found in an image, shape (N,)."""
    return np.asarray(np.isfinite(features).all(axis=1))


def robustly_scaled(rows: Array) -> Array:
    """Columns of an array, shape (N, F), by their median and median absolute deviation; 0 where all are equal."""
    if not len(rows):
        return rows
    off = rows - np.median(rows, axis=0)
    scale = 1.4826 * np.median(np.abs(off), axis=0)
    scale = np.where(scale > 1e-9, scale, rows.std(axis=0))
    return np.clip(off / np.where(scale > 1e-9, scale, 1.0), -_CLIPPED, _CLIPPED)


def _appearance(sides: Sequence[Sides]) -> Array:
    """All features but those of form, shape (N, F - 2), of contours found in one image, not scaled."""
    values, sigma = sides[0].values, sides[0].smoothing
    lines = [_places(one) for one in sides]
    points, normals = (np.concatenate(parts) for parts in zip(*lines, strict=True))
    owner = np.repeat(np.arange(len(sides)), [len(line) for line, _ in lines])
    count = np.bincount(owner)
    grad = gradient(values, sigma)
    edges = magnitude(grad)
    tiny = max(1e-3 * float(edges.mean()), 1e-300)

    def mean(along: Array) -> Array:
        return np.asarray(np.bincount(owner, along) / count)

    def log_mean(along: Array) -> Array:
        return np.asarray(np.log(mean(along) + tiny))

    across = normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    near, far = across * (_NEAR + _NEAR_SMOOTHING * sigma), across * _FAR
    slopes = [magnitude(gradient(values, width)) for width in (1.0, 2.0 * sigma, 4.0 * sigma)]
    around = [_blurred(edges, _AROUND), _blurred(edges, _FARTHER)]
    others = [_coherence(grad), _density(points, values.shape)]
    seen = interpolate(np.stack([slopes[0], edges, *slopes[1:], *around, *others]), points).T
    strengths, log_around = [log_mean(one) for one in seen[:4]], [log_mean(one) for one in seen[4:6]]
    beside = np.stack([_blurred(values, sigma), _texture(values)])
    dark, bright = interpolate(beside, points - near).T, interpolate(beside, points + near).T
    smooth = _blurred(values, _FAR_SMOOTHING)[None]
    columns = [
        *strengths,
        mean(dark[0]),
        mean(bright[0]),
        log_mean(np.abs(bright[0] - dark[0])),
        log_mean(np.minimum(dark[1], bright[1])),
        log_mean(np.maximum(dark[1], bright[1])),
        mean(interpolate(smooth, points - far)[:, 0]),
        mean(interpolate(smooth, points + far)[:, 0]),
        log_around[0],
        *(strengths[1] - one for one in log_around),
        mean(seen[6]),
        np.log(mean(seen[7]) + 1e-6),
    ]
    return np.stack(columns, axis=1)


def _places(sides: Sides) -> tuple[Array, Array]:
    """Places along a contour in px of the image in which it was found, and the normals there, shape (K, 2)."""
    count = len(sides.points)
    which = np.unique(np.linspace(0, count - 1, min(count, _MOST_PLACES)).round().astype(np.intp))
    return sides.points[which], sides.normals[which]


def _form(contours: Sequence[Contour]) -> Array:
    """Logarithm of the length, and straightness, shape (N, 2)."""
    return np.array([(np.log(max(contour.length, 1e-3)), _straightness(contour)) for contour in contours])


def _straightness(contour: Contour) -> float:
    """Mean of chord over arc along stretches of a contour: 1 for a straight one."""
    path = contour.path
    step = min(_STRETCH, len(path) - 1)
    if step < 1:
        return 1.0
    along = polyline.lengths_along(path)
    chord = np.linalg.norm(path[step:] - path[:-step], axis=1)
    return float((chord / np.maximum(along[step:] - along[:-step], 1e-300)).mean())


def _blurred(values: Array, width: float) -> Array:
    return gaussian_filter(values, width, truncate=3.0)


def _texture(values: Array) -> Array:
    """Local standard deviation of the gray levels."""
    shifted = values - values.mean()
    variance = _blurred(shifted * shifted, _TEXTURE) - _blurred(shifted, _TEXTURE) ** 2
    return np.sqrt(np.maximum(variance, 0.0))


def _coherence(grad: Array) -> Array:
    """Coherence of the structure tensor: 1 where all gradients around have one direction, 0 where they have all."""
    rows, both, cols = (_blurred(product, _COHERENCE) for product in (grad[0] ** 2, grad[0] * grad[1], grad[1] ** 2))
    total = rows + cols
    apart = np.sqrt((rows - cols) ** 2 + 4.0 * both**2)
    return np.where(total > 0.0, apart / np.maximum(total, 1e-300), 0.0)


def _density(points: Array, shape: tuple[int, ...]) -> Array:
    """How many of the places along contours lie around each pixel."""
    cells = np.clip(np.rint(points), 0, np.array(shape) - 1).astype(np.intp)
    counted = np.bincount(np.ravel_multi_index((cells[:, 0], cells[:, 1]), shape), minlength=shape[0] * shape[1])
    return _blurred(counted.reshape(shape).astype(float), _DENSITY)
