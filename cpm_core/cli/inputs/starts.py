"""Starts along what files hold: contours of an image, surfaces and center lines of a volume."""

from __future__ import annotations

import argparse
from pathlib import Path

from cpm_core.cli.terminal import say
from cpm_core.formats import (
    CONTOURS_READABLE,
    FOR_CENTERLINES,
    SURFACES_READABLE,
    load_centerlines,
    load_surface,
)
from cpm_core.formats.contours.reading.contour_file import plane_of, read_contours
from cpm_core.image.image import Image
from cpm_core.shapes import Points, Polygon, Stroke
from cpm_core.shapes.outlines import start_on_surface, starts_along, starts_in


def starts_from_files(arguments: argparse.Namespace, image: Image) -> tuple[Polygon | Stroke | Points, ...]:
    """Starts along the contours of the files of ``--start``."""
    return tuple(start for path in arguments.start for start in starts_from_file(path, image))


def starts_from_file(path: str, image: Image) -> tuple[Polygon | Stroke | Points, ...]:
    """Starts along the contours of one file; what was left out of it is said."""
    found = read_contours(path, plane_of(image))
    for note in found.notes:
        say(f"cpm: {Path(path).name}: {note}")
    return starts_along(found.contours, found.places)


def in_space(arguments: argparse.Namespace) -> bool:
    """Whether a file of a start holds what only volumes have, a surface or center lines."""
    return any(Path(path).suffix.lower() in {*SURFACES_READABLE, *FOR_CENTERLINES} for path in arguments.start)


def starts_in_volume(arguments: argparse.Namespace, volume: Image) -> tuple[Points | Stroke, ...]:
    """Starts on the surfaces and along the center lines of the files of ``--start``, in a volume."""
    starts: list[Points | Stroke] = []
    for path in arguments.start:
        if Path(path).suffix.lower() in CONTOURS_READABLE:
            raise ValueError(f"--start {path} has contours, which lie in a plane: name a surface or center lines.")
        if Path(path).suffix.lower() in FOR_CENTERLINES:
            starts += starts_in(load_centerlines(path, volume, tell=_tell))
        else:
            starts.append(start_on_surface(load_surface(path, volume, tell=_tell)))
    return tuple(starts)


def _tell(note: str) -> None:
    say(f"cpm: {note}")
