"""Ground truth from a file: a mask, or contours."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.contours.ground_truth import Truth, truth_of_contours, truth_of_mask
from cpm_core.formats import load_image
from cpm_core.formats.contours.reading.contents import Plane
from cpm_core.formats.contours.reading.contour_file import CONTOURS_READABLE, read_contours

_BESIDE = 1.0
"""Distance that vertices may lie outside the image [px]."""


def load_truth(
    path: str | os.PathLike[str],
    shape: Sequence[int],
    *,
    holes: bool = True,
    spacing: Sequence[float] = (1.0, 1.0),
    unit: str | None = None,
) -> Truth:
    """Read the ground truth of an image.

    Parameters
    ----------
    path : path-like
        A mask, which is any image that `load_image` reads: its lowest gray level is the background, each other one an
        object, and two levels make one class. Or contours, which are any file that `load_contours` reads: closed ones
        are objects.
    shape : sequence of int
        Shape of the image that the truth belongs to, (rows, columns).
    holes : bool
        For contours: whether one inside another is a hole, and one inside that hole again an object; see
        `cpm_core.contours.rasterize.inside`.
    spacing : sequence of float
        Size of a pixel along (row, col), for contours in a unit of length (drawings for CAD).
    unit : str, optional
        Unit of `spacing`.

    Returns
    -------
    Truth
        Objects and boundaries.

    Raises
    ------
    ValueError
        When the file cannot be read, belongs to an image of another size, is a picture rather than a mask, or is
        empty.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("disk"), cpm.circle((32, 32), 8))
    >>> cpm.export(result, "truth.png")
    >>> truth = cpm.load_truth("truth.png", result.shape)
    >>> int(truth.objects.max())
    1
    """
    file, rows, cols = Path(path), *map(int, shape)
    if file.suffix.lower() in CONTOURS_READABLE:
        plane = Plane((rows, cols), (float(spacing[0]), float(spacing[1])), unit)
        return truth_of_contours(_contours(file, plane, (rows, cols)), (rows, cols), file.name, holes=holes)
    image = load_image(file)
    _check_size(file.name, image.shape, (rows, cols))
    return truth_of_mask(image.values, file.name)


def _contours(file: Path, plane: Plane, shape: tuple[int, int]) -> tuple[Contour, ...]:
    """Contours of a file that fit into an image."""
    found, (rows, cols) = read_contours(file, plane), shape
    if not found.contours:
        raise ValueError(f"{file.name} holds single points, and no lines to compare with: choose other contours.")
    _check_size(file.name, found.shape or shape, shape)
    beyond = np.concatenate([contour.points for contour in found.contours])
    if beyond.min() < -0.5 - _BESIDE or (beyond > np.array([rows, cols]) - 0.5 + _BESIDE).any():
        raise ValueError(
            f"{file.name} has contours that reach out of the image of {rows} x {cols} px: choose the ground truth "
            "of this very image, in pixels of it."
        )
    return found.contours


def _check_size(name: str, found: Sequence[int], wanted: tuple[int, int]) -> None:
    if tuple(found) != wanted:
        raise ValueError(
            f"{name} is for an image of {found[0]} x {found[1]} px, but this image has {wanted[0]} x {wanted[1]} px: "
            "choose the ground truth of this very image."
        )
