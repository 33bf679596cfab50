"""Label volumes of files, turned as the volume that they belong to."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cpm_core.formats.images.readers import load_volume
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array

_ASIDE = 0.5
"""How far labels may lie from where their volume lies [voxels]."""


def labels_like(file: Path, volume: Image) -> Array:
    """The values of a label volume in the order of the axes of the volume that it belongs to.

    ValueError when it cannot be read, has another size, or lies elsewhere in space.
    """
    labels = load_volume(file)
    values = _turned_as(labels, volume)
    if values.shape != volume.shape:
        found, wanted = (" x ".join(map(str, shape)) for shape in (labels.shape, volume.shape))
        raise ValueError(
            f"{file.name} has {found} voxels, but this volume has {wanted}: choose the labels of this very volume."
        )
    return values


def _turned_as(labels: Image, volume: Image) -> Array:
    """The values of labels in the order of the axes of a volume; ValueError when they lie elsewhere in space."""
    if labels.geometry is None or volume.geometry is None:
        return labels.values
    one, unit = (1.0, 1.0, 1.0), labels.unit == volume.unit
    there, here = (np.array(image.geometry.affine(one, "LPS")) for image in (labels, volume) if image.geometry)
    turn = np.linalg.solve(there[:3, :3], here[:3, :3])  # from steps in the volume to those in the labels
    axes = np.abs(turn).argmax(axis=0)  # the axis of the labels that runs along each of the volume
    lies = np.abs(turn - np.rint(turn)).max() * max(volume.shape) <= _ASIDE
    sides = np.array(labels.spacing)[axes]
    if lies and unit and np.allclose(sides, volume.spacing, rtol=1e-3):  # else the sides were set by hand
        middles = (
            image.geometry.affine(image.spacing, "LPS") @ [*(0.5 * (np.array(image.shape) - 1.0)), 1.0]
            for image in (labels, volume)
            if image.geometry
        )
        lies = bool(np.linalg.norm(np.subtract(*middles)) <= _ASIDE * max(volume.spacing))
    if not lies:
        raise ValueError(
            f"{labels.source} lies elsewhere in space than {volume.source}: choose the labels of this very volume, or "
            "save them without a place, as .npy or .tif."
        )
    backward = tuple(slice(None, None, -1) if turn[axes[axis], axis] < 0.0 else slice(None) for axis in range(3))
    return np.ascontiguousarray(labels.values.transpose(axes)[backward])
