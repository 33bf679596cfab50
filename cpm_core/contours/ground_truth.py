"""Ground truth: the objects and boundaries that contours are compared with."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour
from cpm_core.contours.distances import sampled
from cpm_core.contours.graph import chains
from cpm_core.contours.measurements import containment
from cpm_core.formats import load_image
from cpm_core.formats.contours.contour_files import CONTOURS_READABLE, read_contours
from cpm_core.formats.masks.label_mask import paint
from cpm_core.numerics.types import Array, Mask

Labels = NDArray[np.int32]

_BESIDE = 1.0
"""How far vertices may lie beyond the border of the image [px]."""

_MOST_CHANGES = 0.5
"""Share of neighbouring pixels that may differ in a mask; of a picture with noise nearly all do."""

_CLEAR = 0.125
"""How far from black or white a pixel of a black and white mask may be that a lossy format has smeared."""


@dataclass(frozen=True, eq=False)
class Truth:
    """What is known to be in an image.

    Attributes
    ----------
    labels : ndarray of int32, shape (H, W)
        Which object each pixel belongs to: 0 for the background, 1, 2, ... for the objects in the order of their grey
        levels. A mask of two levels knows a single class.
    contours : tuple of Contour
        Boundaries of the objects [px]: between the pixels of a mask, or the contours of a file.
    source : str
        Name of the file, for people.
    """

    labels: Labels
    contours: tuple[Contour, ...]
    source: str = "ground truth"

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the image."""
        return self.labels.shape

    @cached_property
    def boundary(self) -> Array:
        """Points every quarter of a pixel along the boundaries, shape (K, 2) [px]."""
        return np.concatenate([np.empty((0, 2)), *map(sampled, self.contours)])

    @cached_property
    def objects(self) -> Labels:
        """The objects one by one, shape (H, W): those of a single class are what hangs together of it."""
        if self.labels.max(initial=0) > 1:
            return self.labels
        return np.asarray(scipy.ndimage.label(self.labels)[0], dtype=np.int32)


def load_truth(path: str | os.PathLike[str], shape: Sequence[int], *, holes: bool = True) -> Truth:
    """Read the ground truth of an image.

    Parameters
    ----------
    path : path-like
        A mask, which is any image that `load_image` reads: its lowest grey level is the background, each other one an
        object, and two levels make one class. Or contours, which are any file that `load_contours` reads: closed ones
        are objects.
    shape : sequence of int
        Shape of the image that it belongs to, (rows, columns).
    holes : bool
        Of contours, whether one in another is a hole of it, and one in that again an object; see `inside`.

    Returns
    -------
    Truth
        Objects and boundaries.

    Raises
    ------
    ValueError
        When the file cannot be read, belongs to an image of another size, is a picture rather than a mask, or holds
        nothing.
    """
    file, rows, cols = Path(path), *map(int, shape)
    if file.suffix.lower() in CONTOURS_READABLE:
        found = read_contours(file)
        _check_size(file.name, found.shape or (rows, cols), (rows, cols))
        beyond = np.concatenate([contour.points for contour in found.contours])
        if beyond.min() < -0.5 - _BESIDE or (beyond > np.array([rows, cols]) - 0.5 + _BESIDE).any():
            raise ValueError(
                f"{file.name} has contours that reach out of the image of {rows} x {cols} px: choose the ground truth "
                "of this very image, in pixels of it."
            )
        return truth_of_contours(found.contours, (rows, cols), file.name, holes=holes)
    image = load_image(file)
    _check_size(file.name, image.shape, (rows, cols))
    return truth_of_mask(image.values, file.name)


def truth_of_contours(
    contours: Sequence[Contour], shape: Sequence[int], source: str = "ground truth", *, holes: bool = True
) -> Truth:
    """Take contours for the truth: the closed ones are objects, each labelled as in the label mask, but for holes.

    Parameters
    ----------
    contours : sequence of Contour
        Boundaries [px].
    shape : sequence of int
        Shape of the image, (rows, columns).
    source : str
        Name for people.
    holes : bool
        Whether a contour in another is a hole of it, and one in that again an object; see `inside`.
    """
    size = (int(shape[0]), int(shape[1]))
    labels = np.where(inside(contours, size, holes=holes), paint(contours, size), 0)
    return Truth(labels.astype(np.int32), tuple(contours), source)


def truth_of_mask(values: NDArray[np.generic], source: str = "ground truth") -> Truth:
    """Take a mask for the truth.

    Parameters
    ----------
    values : ndarray of real numbers or bool, shape (H, W)
        Grey levels: the lowest is the background, each other an object.
    source : str
        Name for people.

    Returns
    -------
    Truth
        Boundaries run through the middles of the sides between pixels of different objects, cutting their corners, and
        meet where three objects do; the border of the image is none.

    Raises
    ------
    ValueError
        When all pixels are the same, or so many neighbours differ that it is no mask.
    """
    levels, index = np.unique(values, return_inverse=True)
    labels = index.reshape(values.shape).astype(np.int32)
    if len(levels) > 2 and values.dtype.kind != "b":
        span = (np.asarray(values, dtype=np.float64) - float(levels[0])) / float(levels[-1] - levels[0])
        smeared = np.minimum(span, 1.0 - span)
        if len(levels) > 8 and smeared.max() < _CLEAR:  # black and white out of a lossy format
            labels = (span > 0.5).astype(np.int32)
    if len(levels) < 2:
        raise ValueError(f"{source} has one grey level everywhere, so it tells of no object: choose another mask.")
    changes = np.mean([(np.diff(labels, axis=axis) != 0).mean() for axis in range(2)])
    if len(levels) > 2 and changes > _MOST_CHANGES:
        raise ValueError(
            f"{source} has {len(levels)} grey levels that change from pixel to pixel, so it is a picture and no mask: "
            "choose an image with one grey level for the background and one for each object."
        )
    return Truth(labels, _between(labels), source)


def inside(contours: Sequence[Contour], shape: tuple[int, ...], *, holes: bool = True) -> Mask:
    """Find the pixels inside closed contours.

    Parameters
    ----------
    contours : sequence of Contour
        Contours in px of the image.
    shape : tuple of int
        Shape of the image.
    holes : bool
        Whether a contour in another is a hole of it, and one in that again an object.

    Returns
    -------
    ndarray of bool, shape `shape`
        True where the centre of a pixel is inside.
    """
    labels = paint(contours, shape)
    if not holes:
        return labels > 0
    around = containment(contours)
    solid = [False]
    for index, contour in enumerate(contours):
        if contour.closed:
            depth, outer = 0, around[index]
            while outer is not None:
                depth, outer = depth + 1, around[outer]
            solid.append(depth % 2 == 0)
    return np.asarray(np.array(solid)[labels])


def _check_size(name: str, found: Sequence[int], wanted: tuple[int, int]) -> None:
    if tuple(found) != wanted:
        raise ValueError(
            f"{name} is for an image of {found[0]} x {found[1]} px, but this image has {wanted[0]} x {wanted[1]} px: "
            "choose the ground truth of this very image."
        )


def _between(labels: Labels) -> tuple[Contour, ...]:
    """Boundaries between pixels of different labels.

    Around each corner of four pixels up to four sides divide labels. Two of them are joined; three or four meet in the
    corner.
    """
    rows, cols = labels.shape
    upright, level = labels[:, :-1] != labels[:, 1:], labels[:-1] != labels[1:]
    # numbers of the middles of upright sides, of level sides, and of corners
    first = np.arange(rows * (cols - 1)).reshape(rows, cols - 1)
    second = first.size + np.arange((rows - 1) * cols).reshape(rows - 1, cols)
    corner = first.size + second.size + np.arange((rows - 1) * (cols - 1))
    sides = np.stack([first[:-1], first[1:], second[:, :-1], second[:, 1:]], axis=-1).reshape(-1, 4)
    divide = np.stack([upright[:-1], upright[1:], level[:, :-1], level[:, 1:]], axis=-1).reshape(-1, 4)
    count = divide.sum(axis=1)
    pairs = sides[count == 2][divide[count == 2]].reshape(-1, 2)
    many = count > 2
    rays = np.stack([sides[many], np.repeat(corner[many, None], 4, axis=1)], axis=-1)[divide[many]]
    used, edges = np.unique(np.concatenate([pairs, rays]), return_inverse=True)
    return chains(_places(used, rows, cols), edges.reshape(-1, 2).astype(np.int64))


def _places(numbers: NDArray[np.integer], rows: int, cols: int) -> Array:
    """Where the middles of sides and the corners of these numbers are [px]."""
    upright, level = rows * (cols - 1), (rows - 1) * cols
    kind = np.searchsorted([upright, upright + level], numbers, side="right")
    offset = numbers - np.array([0, upright, upright + level])[kind]
    width = np.array([cols - 1, cols, cols - 1])[kind]
    half = np.array([(0.0, 0.5), (0.5, 0.0), (0.5, 0.5)])[kind]
    return np.asarray(np.stack([offset // width, offset % width], axis=1) + half)
