"""The start of ``cpm compare``: closed lines of the command line, of files and of a session, for all methods alike."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from cpm_core.cli.inputs.numbers import numbers_in
from cpm_core.cli.inputs.starts import starts_from_file
from cpm_core.cli.terminal import say
from cpm_core.formats.contours.reading.contour_file import CONTOURS_READABLE
from cpm_core.formats.sessions.session_file import SessionFile
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array
from cpm_core.objects.methods import Start
from cpm_core.parameters.quotation import counted, shown
from cpm_core.shapes import Barrier, Charge, Circle, Region, Shape
from cpm_core.shapes.document_shapes import starts_of
from cpm_core.shapes.outlines import outlines_of

Sphere = tuple[float, float, float, float]
"""Center (plane, row, col) and radius [voxels]."""


def add_start(parser: argparse.ArgumentParser) -> None:
    """Add the flags of the start; see `outlines_drawn` and `start_on`."""
    start = parser.add_argument_group("start (one at least, of a session or here; several add up)")
    flags = (
        ("--circle", "ROW,COL,RADIUS", "a circle, in px"),
        ("--polygon", "ROW,COL,ROW,COL,...", "corners of a closed line, in px"),
        ("--sphere", "PLANE,ROW,COL,RADIUS", "a sphere in a volume, in voxels; IMAGE is then a volume"),
        ("--start", "FILE", f"the closed contours of a file ({', '.join(CONTOURS_READABLE)}, or a label mask)"),
    )
    for flag, form, words in flags:
        start.add_argument(flag, metavar=form, action="append", default=[], help=words)
    start.add_argument(
        "--around",
        action="store_true",
        help="the start lies around the object, so that balloons and pressures drive contours inwards",
    )


def outlines_drawn(arguments: argparse.Namespace, session: SessionFile) -> tuple[Array, ...]:
    """The closed lines on the command line and those of the session; ValueError when there is no start at all."""
    outlines = [_circle(text) for text in arguments.circle] + [_polygon(text) for text in arguments.polygon]
    drawn = outlines_of(session.shapes)
    if not (outlines or drawn or arguments.start):
        raise ValueError(
            "No start is given: add --circle ROW,COL,RADIUS, --polygon ROW,COL,ROW,COL,... or --start FILE, or a "
            "session with a circle, an ellipse or a polygon."
        )
    if any(isinstance(shape, Region | Barrier | Charge) for shape in session.shapes):
        say("cpm: regions, barriers and charges of the session are left out: the other methods have none.")
    _tell_open("the session", starts_of(session.shapes))
    return (*outlines, *drawn)


def start_in_volume(volume: Image, spheres: Sequence[Sphere], arguments: argparse.Namespace) -> Start:
    """The start in a volume: spheres, whose radius is in sides of the smallest voxel."""
    plane, row, col = (side / min(volume.spacing) for side in volume.spacing)
    return Start((), arguments.around, tuple(spheres), (plane, row, col))


def spheres_drawn(arguments: argparse.Namespace) -> tuple[Sphere, ...]:
    """The spheres on the command line; ValueError beside what is for images only."""
    for name in ("circle", "polygon", "start", "session") if arguments.sphere else ():
        if getattr(arguments, name):
            raise ValueError(f"--{name} is for images, but --sphere is for volumes: leave one out.")
    return tuple(_sphere(text) for text in arguments.sphere)


def start_on(image: Image, outlines: Sequence[Array], arguments: argparse.Namespace, session: SessionFile) -> Start:
    """The start on an image: lines that are drawn, and those of the files of ``--start``."""
    found = list(outlines)
    for path in arguments.start:
        shapes = starts_from_file(path, image)
        closed, name = outlines_of(shapes), Path(path).name
        if not closed:
            raise ValueError(
                f"{name} has no closed contour, but methods are compared from closed lines: close its contours, or add "
                "--circle ROW,COL,RADIUS."
            )
        _tell_open(name, shapes)
        found += closed
    return Start(tuple(found), around=arguments.around or session.comparison.around)


def _tell_open(where: str, shapes: Sequence[Shape]) -> None:
    """Say how many starts are left out since they enclose nothing."""
    if loose := len(shapes) - len(outlines_of(shapes)):
        what = counted(loose, "start without an inside", "starts without an inside")
        say(f"cpm: {where}: {what} left out, as most of the methods need one.")


def _sphere(text: str) -> Sphere:
    numbers = _numbers(text)
    if len(numbers) != 4:
        raise ValueError(f"--sphere is {shown(text)} but must be four numbers, PLANE,ROW,COL,RADIUS in voxels.")
    plane, row, col, radius = numbers
    return plane, row, col, radius


def _circle(text: str) -> Array:
    numbers = _numbers(text)
    if len(numbers) != 3:
        raise ValueError(f"--circle is {shown(text)} but must be three numbers, ROW,COL,RADIUS in px.")
    return Circle((numbers[0], numbers[1]), numbers[2]).outline[:-1]


def _polygon(text: str) -> Array:
    numbers = _numbers(text)
    corners = np.array(numbers[: len(numbers) // 2 * 2]).reshape(-1, 2)
    if len(numbers) % 2 or len(np.unique(corners, axis=0)) < 3:
        raise ValueError(
            f"--polygon is {shown(text)} but must be rows and columns in turn, of three different corners at least, "
            "ROW,COL,ROW,COL,... in px."
        )
    return corners


def _numbers(text: str) -> list[float]:
    """Numbers between commas; an empty list when a part is not a finite number."""
    numbers = numbers_in(text)
    return numbers if np.isfinite(numbers).all() else []
