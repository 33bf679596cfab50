"""Ground truth files: a mask or contours for an image, labels or a surface for a volume."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from cpm_core.contours.ground_truth import Truth, VolumeTruth, label_gray_levels, truth_from_contours, truth_from_mask
from cpm_core.contours.surface import label_voxels
from cpm_core.formats.common.content import AnySource, find_local_file
from cpm_core.formats.contour_file import CONTOURS_READABLE, ContourFile, read_contours, read_mask
from cpm_core.formats.contours.contents import PlaneInfo
from cpm_core.formats.surface_file import SURFACES_READABLE, read_aligned_labels, read_overlapping_parts, read_surface
from cpm_core.image.image import Image

_MAX_OVERHANG = 1.0
"""Largest distance of a vertex outside the image [px]."""


def load_truth(
    path: AnySource,
    shape: Sequence[int],
    *,
    holes: bool = True,
    spacing: Sequence[float] = (1.0, 1.0),
    unit: str | None = None,
    name: str = "",
) -> Truth:
    """Read the ground truth of an image.

    Parameters
    ----------
    path : path-like or file-like
        A mask, any image that `load_image` reads: its lowest gray level is the background, each other level an object,
        and two levels make one class. Or contours, any file that `load_contours` reads: closed ones are objects.
    shape : sequence of int
        Shape of the image that the truth belongs to, (rows, columns).
    holes : bool
        For contours: whether a contour inside another is a hole, and one inside that hole an object again; see
        `cpm_core.contours.rasterize.rasterize_mask`.
    spacing : sequence of float
        Size of a pixel along (row, col), for contours in a unit of length (drawings for CAD).
    unit : str, optional
        Unit of `spacing`.
    name : str, optional
        Name of the image, which selects among those of a COCO file.

    Returns
    -------
    Truth
        Objects and boundaries, with ``notes`` on what was left out or assumed.

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
    file, rows, cols = find_local_file(path), *map(int, shape)
    if file.suffix.lower() in CONTOURS_READABLE:
        plane = PlaneInfo((rows, cols), (float(spacing[0]), float(spacing[1])), unit, name)
        found = _read_fitting_contours(file, plane, (rows, cols))
        truth = truth_from_contours(found.contours, (rows, cols), file.name, holes=holes)
        return replace(truth, notes=found.notes)
    values, notes = read_mask(file)
    _check_truth_size(file.name, values.shape, (rows, cols))
    return replace(truth_from_mask(values, file.name), notes=notes)


def load_volume_truth(path: AnySource, volume: Image) -> VolumeTruth:
    """Read the ground truth of a volume.

    Parameters
    ----------
    path : path-like or file-like
        A label volume, any file that `load_volume` reads: its lowest gray level is the background, each other level an
        object, and two levels make one class. Or a closed surface, any file that `load_surface` reads.
    volume : Image
        The volume that the truth belongs to.

    Returns
    -------
    VolumeTruth
        Truth on the voxels of the volume. If both files state a position in space, the labels are oriented like the
        volume.

    Raises
    ------
    ValueError
        When the file cannot be read, is no label volume, or belongs to a volume of another size or place.

    Examples
    --------
    >>> volume = cpm.example("ball")
    >>> np.save("labels.npy", (volume.values > volume.values.mean()).astype(np.uint8))
    >>> cpm.load_volume_truth("labels.npy", volume)
    <VolumeTruth labels.npy, 31 x 31 x 31 voxels, 1 object>
    """
    file = find_local_file(path)
    if file.suffix.lower() in CONTOURS_READABLE:
        raise ValueError(f"{file.name} contains contours, which lie in a plane: choose labels or a surface.")
    if file.suffix.lower() in SURFACES_READABLE or read_overlapping_parts(file):
        surface, notes = read_surface(file, volume)
        if not surface.closed:
            raise ValueError(f"The surface of {file.name} is not closed, so nothing is inside: choose another one.")
        labels = label_voxels(surface, volume.shape).astype(np.int32)
        return VolumeTruth(labels, volume.spacing, volume.unit, file.name, surface, notes)
    values, notes = read_aligned_labels(file, volume)
    labels = label_gray_levels(values, file.name)
    return VolumeTruth(labels, volume.spacing, volume.unit, file.name, notes=notes)


def _read_fitting_contours(file: Path, plane: PlaneInfo, shape: tuple[int, int]) -> ContourFile:
    """Read contours; ValueError unless they fit into the image."""
    found, (rows, cols) = read_contours(file, plane), shape
    if not found.contours:
        raise ValueError(f"{file.name} contains single points, and no lines to compare with: choose other contours.")
    _check_truth_size(file.name, found.shape or shape, shape)
    beyond = np.concatenate([contour.points for contour in found.contours])
    if beyond.min() < -0.5 - _MAX_OVERHANG or (beyond > np.array([rows, cols]) - 0.5 + _MAX_OVERHANG).any():
        raise ValueError(
            f"{file.name} has contours that reach out of the image of {rows} x {cols} px: choose the ground truth "
            "of this image, in its pixels."
        )
    return found


def _check_truth_size(name: str, found: Sequence[int], wanted: tuple[int, int]) -> None:
    """Raise ValueError for a ground truth of another size than the image."""
    if tuple(found) != wanted:
        raise ValueError(
            f"{name} is for an image of {found[0]} x {found[1]} px, but this image has {wanted[0]} x {wanted[1]} px: "
            "choose the ground truth of this image."
        )
