"""Clicks: which faces the places that a user has clicked stand for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.objects.faces.faces import Faces, Ground, split

_RADIUS = 3.0
"""Distance from a click up to which faces are clicked as well [px]."""

_ASIDE = 1.5
"""Distance by which a click on a contour is moved to where the image is smoother [px]."""


@dataclass(frozen=True, eq=False)
class Clicked:
    """Faces that clicks have chosen.

    Attributes
    ----------
    faces : Faces
        The faces, of which those that were clicked as both have been cut.
    inside, outside : ndarray of bool, shape (F,)
        Faces that must be inside, and outside.
    within, beyond : ndarray of int64, shape (M, 2) and (K, 2)
        The pixels that were clicked as inside, and as outside.
    remark : str
        What was unusual, in one sentence, or empty.
    """

    faces: Faces
    inside: Mask
    outside: Mask
    within: Index
    beyond: Index
    remark: str


def as_places(given: ArrayLike) -> Array:
    """Places as an array of shape (N, 2); `ValueError` when they are none."""
    places = np.asarray(given, dtype=float)
    if places.size == 0:
        return np.empty((0, 2))
    places = np.atleast_2d(places)
    if places.ndim != 2 or places.shape[1] != 2:
        raise ValueError(f"the places have the shape {places.shape} but must be (N, 2), rows and columns.")
    if not np.isfinite(places).all():
        raise ValueError("some places are not finite: give numbers of rows and columns.")
    return places


def clicked(faces: Faces, ground: Ground, inside: Array, outside: Array, newer: Mask | None = None) -> Clicked:
    """Find the faces that places stand for.

    Parameters
    ----------
    faces : Faces
        All faces.
    ground : Ground
        What they were cut along.
    inside, outside : ndarray, shape (M, 2) and (K, 2)
        Places [px].
    newer : ndarray of bool, shape (M,), optional
        Which places inside count where the same pixel has been clicked as both; by default none.
    """
    remark = _words(inside, outside, ground)
    within, beyond = _rounded(inside, ground), _rounded(outside, ground)
    same = (within[:, None] == beyond[None]).all(axis=2)
    if same.any():
        remark = "The same place has been said to be inside and outside; what was said last counts."
        kept = newer if newer is not None else np.zeros(len(within), np.bool_)
        within, beyond = within[kept | ~same.any(axis=1)], beyond[~(same & kept[:, None]).any(axis=0)]
    within, beyond = (pixels[ground.interest[tuple(pixels.T)]] for pixels in (within, beyond))
    near_in, near_out = _smoothest(within, ground), _smoothest(beyond, ground)
    faces = split(faces, ground, near_in, near_out)
    tied, barred = _touched(faces, ground, near_in), _touched(faces, ground, near_out)
    sure_in, sure_out = _at(faces, near_in), _at(faces, near_out)
    return Clicked(
        faces,
        (tied & ~barred) | (sure_in & ~sure_out),
        (barred & ~tied & ~sure_in) | sure_out,
        within,
        beyond,
        remark,
    )


def _words(inside: Array, outside: Array, ground: Ground) -> str:
    """One sentence on unusual places."""
    if not len(inside):
        return "No place has been said to be inside."
    every = np.concatenate([inside, outside])
    if ((every < -0.5) | (every > np.array(ground.values.shape) - 0.5)).any():
        return "A place outside the image counts as the nearest one in it."
    if not ground.interest[tuple(_rounded(every, ground).T)].all():
        return "A place outside the regions of interest counts for nothing."
    return ""


def _rounded(places: Array, ground: Ground) -> Index:
    limit = np.array(ground.values.shape) - 1
    return np.rint(np.clip(places, 0, limit)).astype(np.int64)


def _smoothest(pixels: Index, ground: Ground) -> Index:
    """The pixels, shape (N, 2); of one next to a contour the smoothest one near it."""
    pixel = pixels.copy()
    if not len(pixel):
        return pixel
    on_line = ground.beside[tuple(pixel.T)]
    near = np.clip(pixel[on_line][:, None] + _disk(_ASIDE), 0, np.array(ground.values.shape) - 1)
    smoothest = ground.strength[near[..., 0], near[..., 1]].argmin(axis=1)
    pixel[on_line] = near[np.arange(len(near)), smoothest]
    return pixel


def _at(faces: Faces, pixel: Index) -> Mask:
    """Faces of pixels, shape (F,)."""
    found = np.zeros(faces.graph.count + 1, np.bool_)
    found[faces.labels[tuple(pixel.T)]] = True
    return found[:-1]


def _touched(faces: Faces, ground: Ground, pixel: Index) -> Mask:
    """Faces within `_RADIUS` of pixels, on the same side of contours, shape (F,)."""
    shape = np.array(faces.labels.shape)
    disk = _disk(_RADIUS)
    near = np.clip(pixel[:, None] + disk, 0, shape - 1)
    weak = ~ground.beside[near[..., 0], near[..., 1]]
    free = weak.all(axis=1)
    return _at(faces, near[free].reshape(-1, 2)) | _at(faces, pixel)


def _disk(radius: float) -> Index:
    """Steps to the pixels within a radius, shape (N, 2)."""
    reach = np.arange(-int(radius), int(radius) + 1)
    steps = np.stack(np.meshgrid(reach, reach, indexing="ij"), axis=-1).reshape(-1, 2)
    return np.asarray(steps[np.linalg.norm(steps, axis=1) <= radius])
