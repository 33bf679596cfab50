"""What files hold, as results: contours of an image, surfaces and center lines of a volume."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from cpm_core.cli.terminal import say
from cpm_core.contours.result import Result
from cpm_core.formats import (
    FOR_CENTERLINES,
    FOR_VOLUMES,
    SURFACES_READABLE,
    WRITABLE,
    load_centerlines,
    load_image,
    load_surface,
    load_volume,
    suffix_of,
)
from cpm_core.formats.contours.reading.contour_file import plane_of, read_contours
from cpm_core.formats.images.resolution import known_unit
from cpm_core.image.image import Image
from cpm_core.medial_axis.space.centerlines import Centerlines

_FROM_FILE = "read from a file"


def of_file(source: Path, arguments: argparse.Namespace) -> Result | Centerlines:
    """What a file holds: what its suffix says, or of labels the surface where a file of a surface is to be written."""
    suffix, wanted = source.suffix.lower(), {suffix_of(path) for path in arguments.to}
    if suffix in FOR_CENTERLINES or suffix in SURFACES_READABLE or wanted & (FOR_VOLUMES.keys() - WRITABLE.keys()):
        return _in_volume(source, arguments)
    return _in_plane(source, arguments)


def _in_plane(source: Path, arguments: argparse.Namespace) -> Result:
    """The contours of a file as a result on the image that is named, or one of the size that the file tells."""
    image = None if arguments.image is None else load_image(arguments.image)
    found = read_contours(source, plane_of(image), page=arguments.page)
    for note in found.notes:
        say(f"cpm: {source.name}: {note}")
    if not found.contours:
        raise ValueError(f"{source.name} holds single points only, and no contours: choose another file.")
    shape = found.shape if image is None else image.shape
    if shape is None:
        corners = np.concatenate([contour.points for contour in found.contours])
        rows, cols = (np.ceil(corners.max(axis=0)) + 1).astype(int).tolist()
        shape = (max(rows, 1), max(cols, 1))
        say(
            f"cpm: {source.name} does not tell the size of its image: {rows} x {cols} px is taken; name it with "
            "--image."
        )
    spacing = (1.0, 1.0) if image is None else image.spacing
    return replace(_read(source, image, shape, spacing), contours=found.contours)


def _in_volume(source: Path, arguments: argparse.Namespace) -> Result | Centerlines:
    """A surface or center lines as a result in the volume that is named."""
    if arguments.page is not None:
        raise ValueError(
            "--page is for contours in a stack, but surfaces and center lines lie in volumes: leave it out."
        )
    image = None if arguments.image is None else load_volume(arguments.image)

    def tell(note: str) -> None:
        say(f"cpm: {note}")

    if source.suffix.lower() in FOR_CENTERLINES:
        return load_centerlines(source, image, tell=tell)
    in_voxels = {path for path in arguments.to if suffix_of(path) in WRITABLE}
    if image is None and source.suffix.lower() not in SURFACES_READABLE:
        image = load_volume(source)
    if image is None and in_voxels:
        raise ValueError(f"{min(in_voxels)} has the voxels of a volume: name the volume with --image.")
    surface = load_surface(source, image, tell=tell)
    shape = (1, 1, 1) if image is None else image.shape
    return replace(_read(source, image, shape, surface.spacing), surface=surface, unit=surface.unit)


def _read(source: Path, image: Image | None, shape: tuple[int, ...], spacing: tuple[float, ...]) -> Result:
    """A result without contours, of what has been read from a file."""
    name = source.name if image is None else image.source
    unit = None if image is None or image.unit is None else known_unit(image.unit)
    nothing = np.empty((0, len(shape)))
    return Result(nothing, (), None, 0, True, _FROM_FILE, shape, spacing, unit, name, image=image)
