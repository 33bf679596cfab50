"""Surface files: reads triangles of any known format, which the suffix of a file chooses, and label volumes."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from cpm_core.contours.ground_truth import labels_of
from cpm_core.contours.surface import Surface, surface_of_labels
from cpm_core.formats.common.content import AnyPath, content_of, decoding
from cpm_core.formats.images.readers import load_volume
from cpm_core.formats.meshes import obj, ply, stl, vtk
from cpm_core.formats.meshes.coordinates import place_of
from cpm_core.formats.meshes.triangles import Triangles
from cpm_core.image.geometry import Convention
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array

_LOG = logging.getLogger(__name__)

_READERS: dict[str, tuple[str, Callable[[bytes], Triangles]]] = {
    ".ply": ("triangles of MeshLab, Blender and others", ply.read),
    ".stl": ("triangles for printing", stl.read),
    ".obj": ("triangles of drawing programs", obj.read),
    ".vtk": ("poly data of ParaView and 3D Slicer", vtk.read),
}

SURFACES_READABLE: dict[str, str] = {suffix: what for suffix, (what, _) in _READERS.items()}
"""Suffixes of files that surfaces can be read from -> what they are; volumes are read as labels."""

_HEAD = 4096
"""Bytes at the beginning of a file that give its coordinates and its unit."""

_ASIDE = 0.5
"""How far labels may lie from where their volume lies [voxels]."""

_MOST_LABELS = 100_000
"""Largest label that is the number of an object."""


def load_surface(
    path: AnyPath,
    image: Image | None = None,
    *,
    space: Convention | None = None,
    warn: Callable[[str], object] = _LOG.warning,
) -> Surface:
    """Read a surface from a file of triangles, or the surfaces of the objects of a label volume.

    Parameters
    ----------
    path : path-like
        A file with one of the suffixes `SURFACES_READABLE`, written by `export` or by another program. Or a volume of
        labels, which is 0 outside: the surface runs between its voxels.
    image : Image, optional
        The volume that the surface belongs to: its vertices come back in voxels of it. Without it a voxel is as large
        as a unit of the file.
    space : {"LPS", "RAS"}, optional
        Where x, y and z of the file point; by default as the file says, and LPS where it does not.
    warn : callable, optional
        Called with a sentence for what was assumed; by default a warning is logged.

    Returns
    -------
    Surface
        Its triangles, turned outward; `Surface.numbers` are those of the objects where the file has them.

    Raises
    ------
    ValueError
        When the file cannot be read, holds no triangles, or none in the volume; one sentence with its name and what to
        do.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("ball"), cpm.sphere((15, 15, 15), 4, 60), cpm.PRESETS["volume"])
    >>> cpm.export(result, "ball.ply")
    >>> surface = cpm.load_surface("ball.ply", result.image)
    >>> bool(np.abs(surface.vertices - result.surface.vertices).max() < 0.001), surface.closed
    (True, True)
    """
    surface, notes = read_surface(path, image, space)
    for note in notes:
        warn(f"{Path(path).name}: {note}")
    return surface


def read_surface(
    path: AnyPath, image: Image | None = None, space: Convention | None = None
) -> tuple[Surface, tuple[str, ...]]:
    """Read a surface, with what was assumed; see `load_surface`."""
    file = Path(path)
    if file.suffix.lower() not in SURFACES_READABLE:
        return _of_labels(file, image), ()
    return decode_surface(content_of(file), file.name, image, space)


def decode_surface(
    content: bytes, name: str, image: Image | None = None, space: Convention | None = None
) -> tuple[Surface, tuple[str, ...]]:
    """The same of the content of a file of triangles."""
    with decoding(name, "is damaged, or no surface of this kind: write it again."):
        found = _READERS[Path(name).suffix.lower()][1](content)
    place, notes = place_of(content[:_HEAD].decode("latin-1"), image, space)
    faces = found.faces[:, ::-1] if place.mirrored else found.faces
    try:
        surface = Surface(place.voxels(found.points), faces, place.spacing, place.unit, numbers=found.numbers)
    except ValueError as error:
        raise ValueError(f"{name} cannot be used. {error}") from error
    if surface.volume < 0.0 and surface.closed:
        surface = replace(surface, faces=surface.faces[:, ::-1])
    used = surface.vertices[np.unique(surface.faces)]
    if not len(used):
        raise ValueError(f"{name} holds no triangles: choose another file.")
    if image is not None and not ((used >= -0.5) & (used <= np.array(image.shape) - 0.5)).all(axis=1).any():
        raise ValueError(
            f"The surface of {name} lies outside the volume {image.source}: choose the surface of this very volume, in "
            "its unit, and say whether it is in LPS or RAS."
        )
    return surface, notes


def _of_labels(file: Path, image: Image | None) -> Surface:
    """The surfaces of the objects of a label volume, halfway between voxels; whole numbers are kept."""
    volume = image or load_volume(file)
    values = volume.values if image is None else labels_like(file, image)
    labels = labels_of(values, file.name)
    if values.min() == 0 and values.max() <= _MOST_LABELS and not (values % 1.0).any():
        labels = values.astype(np.int32)
    return surface_of_labels(labels, volume.spacing, volume.unit)


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
    from nibabel.orientations import apply_orientation, inv_ornt_aff, io_orientation

    if labels.geometry is None or volume.geometry is None:
        return labels.values
    measured = labels.unit == volume.unit and np.allclose(sorted(labels.spacing), sorted(volume.spacing), rtol=1e-3)
    sides = (labels.spacing, volume.spacing) if measured else 2 * ((1.0, 1.0, 1.0),)  # else they were set by hand
    there, here = labels.geometry.affine(sides[0], "LPS"), volume.geometry.affine(sides[1], "LPS")
    to_volume = np.linalg.solve(here, there)
    turn = io_orientation(to_volume)
    aside = np.abs(to_volume @ inv_ornt_aff(turn, labels.shape) - np.eye(4))[:3]
    if (aside @ [*volume.shape, 1.0 if measured else 0.0]).max() > _ASIDE:
        raise ValueError(
            f"{labels.source} lies elsewhere in space than {volume.source}: choose the labels of this very volume, or "
            "save them without a place, as .npy or .tif."
        )
    return np.ascontiguousarray(apply_orientation(labels.values, turn))
