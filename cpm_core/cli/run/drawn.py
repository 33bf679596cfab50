"""What is drawn on the command line of ``cpm run``: starts, limits, and contours of files that a run starts from."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.cli.inputs import numbers_in, starts_from_files
from cpm_core.formats import (
    load_points,
)
from cpm_core.formats.sessions.plain_values import shape_from_plain
from cpm_core.formats.sessions.session_file import SessionFile
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.starts import circle, stroke
from cpm_core.parameters.quotation import shown
from cpm_core.shapes import Barrier, Points, Region, Shape
from cpm_core.shapes.document_shapes import regions_of, starts_of


def shapes_drawn(arguments: argparse.Namespace, image: Image) -> tuple[Shape, ...]:
    """All that is drawn on the command line, as shapes of a session."""
    plain = [shape for shape in plain_drawn(arguments) if "file" not in shape]
    points = [load_points(path).tolist() for path in arguments.points]
    return (
        *(shape_from_plain(shape, f"shape {number}") for number, shape in enumerate(plain, start=1)),
        *(Points(tuple((row, col) for row, col in places)) for places in points),
        *starts_from_files(arguments, image),
    )


def seeds_drawn(arguments: argparse.Namespace, session: SessionFile) -> list[NDArray[np.float64]]:
    """Seeds of the circles, strokes and points on the command line."""
    given = arguments.circle or arguments.stroke or arguments.points or arguments.auto or arguments.object
    given = given or arguments.start
    if not (given or starts_of(session.shapes)) and session.mode == "skeleton":
        raise ValueError("The session is about a skeleton and has no start: use cpm skeleton IMAGE --export PATH.")
    if not (given or starts_of(session.shapes)):
        raise ValueError(
            "No start is given: add --circle ROW,COL,RADIUS, --stroke ROW,COL,ROW,COL,..., "
            "--points FILE.csv, --start FILE or --auto grid, or name a place inside an object, --object ROW,COL."
        )
    return [
        *(_circle(text) for text in arguments.circle),
        *(_stroke(text) for text in arguments.stroke),
        *(load_points(path) for path in arguments.points),
    ]


def plain_drawn(arguments: argparse.Namespace) -> list[dict[str, Any]]:
    """What is drawn on the command line, as session files hold shapes; of a file its name."""
    circles = [numbers_in(text) for text in arguments.circle]
    lines = (("stroke", arguments.stroke), ("region", arguments.region), ("barrier", arguments.barrier))
    plain: list[dict[str, Any]] = [{"shape": "circle", "center": [*at], "radius": radius} for *at, radius in circles]
    plain += [{"shape": shape, "points": _line(f"--{shape}", text, 1)} for shape, texts in lines for text in texts]
    plain += [{"shape": "points", "file": Path(path).name} for path in (*arguments.points, *arguments.start)]
    if arguments.auto:
        plain.append({"shape": "everywhere", "kind": arguments.auto})
    return plain


def _circle(text: str) -> NDArray[np.float64]:
    numbers = numbers_in(text)
    if len(numbers) != 3:
        raise ValueError(f"--circle is {shown(text)} but must be three numbers, ROW,COL,RADIUS in px.")
    return circle(center=(numbers[0], numbers[1]), radius=numbers[2])


def _stroke(text: str) -> NDArray[np.float64]:
    return stroke(np.array(_line("--stroke", text, 1)))


def regions_drawn(arguments: argparse.Namespace, session: SessionFile) -> AnyRegions | None:
    """Regions of interest and barriers of the session and on the command line."""
    regions = [Region(_line("--region", text, 3)) for text in arguments.region]
    barriers = [Barrier(_line("--barrier", text, 2)) for text in arguments.barrier]
    return regions_of((*session.shapes, *regions, *barriers), session.objects.barriers)


def _line(flag: str, text: str, least: int) -> tuple[tuple[float, float], ...]:
    """Points of a line given as row and column in turn."""
    numbers = numbers_in(text)
    points = tuple(zip(numbers[::2], numbers[1::2], strict=False))
    if len(numbers) % 2 or len(set(points)) < least:
        raise ValueError(
            f"{flag} is {shown(text)} but must be rows and columns in turn, of {least} different points at least, "
            "ROW,COL,ROW,COL,... in px."
        )
    return points
