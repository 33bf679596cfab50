"""``cpm run VOLUME --sphere``: finds the surface of objects in a volume."""

from __future__ import annotations

import argparse
import json
import sys
import time
from dataclasses import replace

import numpy as np

from cpm_core.cli.arguments import as_number, as_steps, check_exports, parameters_of, part_of
from cpm_core.cli.place import facts_on, lines_on
from cpm_core.cli.terminal import Progress, counted, say, written
from cpm_core.contours.result import Result
from cpm_core.formats import FOR_VOLUMES, export, load_volume, suffix_of
from cpm_core.formats.printable import printable
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array
from cpm_core.parameters import PRESETS
from cpm_core.particles.volume_starts import sphere
from cpm_core.segmentation.segment import segment

_OF_IMAGES = ("circle", "stroke", "points", "region", "barrier", "auto", "object", "session", "close")
"""Options that have a meaning for images only; ``--not`` follows ``--object``."""

_FEWEST_FACES = 4
"""Least number of triangles of a closed surface."""


def run_volume(arguments: argparse.Namespace) -> None:
    """Find a surface; every check that needs no volume comes first."""
    if not arguments.sphere:
        raise ValueError("--faces is for the surface in a volume: add --sphere PLANE,ROW,COL,RADIUS, or leave it out.")
    for name in _OF_IMAGES:
        if getattr(arguments, name, None):
            raise ValueError(f"--{name} is for images, but --sphere starts in a volume: leave one of them out.")
    if arguments.image is None:
        raise ValueError("No VOLUME is given: name one.")
    spheres = [_numbers(text) for text in arguments.sphere]
    part = part_of(arguments)
    if "page" in part:
        raise ValueError(f"--page is {part['page']}, but a volume takes all pages of {arguments.image}: leave it out.")
    if arguments.channel is not None:  # colors of a volume are turned into gray levels as it is read
        part["color"], arguments.channel = arguments.channel, None
    parameters = parameters_of(arguments, PRESETS[arguments.preset or "volume"])
    max_steps, faces = as_steps(arguments.max_steps), _as_faces(arguments.faces)
    check_exports(arguments.export, arguments.image, None)
    for path in arguments.export:
        if suffix_of(path) not in FOR_VOLUMES:
            raise ValueError(f"{path} is for contours, but a volume has a surface: end its name in .ply or .stl.")
    volume = load_volume(arguments.image, **part)
    for note in volume.notes:
        say(f"cpm: {volume.source}: {note}")
    started = time.perf_counter()
    progress = Progress() if sys.stderr.isatty() else None
    try:
        found = segment(volume, _seeds(volume, spheres), parameters, max_steps=max_steps, progress=progress)
    finally:
        if progress is not None:
            progress.clear()
    result = found if faces is None else _decimated(found, faces)
    seconds = time.perf_counter() - started
    export(result, *arguments.export, image=arguments.image)
    with written("the files were written before" if arguments.export else ""):
        _report(result, seconds, arguments)


def _as_faces(given: int | float | str | None) -> int | None:
    """The given number of triangles; ValueError unless it is a whole number that makes a closed surface."""
    if given is None or (isinstance(given, int) and given >= _FEWEST_FACES):
        return given
    raise ValueError(f"--faces is {given} but must be a whole number of at least {_FEWEST_FACES}.")


def _decimated(found: Result, faces: int) -> Result:
    """The same result with fewer triangles; a note tells when there are more than wanted."""
    if found.surface is None:
        return found
    surface = found.surface.decimated(faces)
    if len(surface.faces) > faces:
        print(
            f"cpm: {len(surface.faces)} triangles are left, not {faces}: with fewer the surface would lose its shape.",
            file=sys.stderr,
        )
    return replace(found, surface=surface)


def _numbers(text: str) -> list[float]:
    """Plane, row, column and radius of a sphere."""
    parts = [as_number(part.strip()) for part in text.split(",")]
    numbers = [float(part) for part in parts if not isinstance(part, str)]
    if len(numbers) != 4 or len(parts) != 4:
        raise ValueError(f'--sphere is "{text}" but must be four numbers, PLANE,ROW,COL,RADIUS in voxels.')
    return numbers


def _seeds(volume: Image, spheres: list[list[float]]) -> Array:
    """Particles on all spheres, whose radius is in sides of the smallest voxel."""
    plane, row, col = (side / min(volume.spacing) for side in volume.spacing)
    return np.concatenate([sphere((p, r, c), radius, spacing=(plane, row, col)) for p, r, c, radius in spheres])


def _report(result: Result, seconds: float, arguments: argparse.Namespace) -> None:
    surface = result.surface
    vertices, faces = (0, 0) if surface is None else (len(surface.vertices), len(surface.faces))
    if arguments.json:
        facts = {
            "particles": len(result.particles),
            "contours": 0,
            "closed": 0,
            "vertices": vertices,
            "faces": faces,
            "steps": result.steps,
            "converged": result.converged,
            "stop_reason": result.stop_reason,
            "seconds": round(seconds, 3),
            **({} if result.image is None else facts_on(result.image)),
        }
        print(json.dumps(facts))
        return
    print(f"{result.source}: a surface of {counted(faces, 'triangle')}, with {vertices} corners")
    print(f"{counted(len(result.particles), 'particle')}, {counted(result.steps, 'step')} in {seconds:.2f} s")
    print(f"Stopped: {result.stop_reason}")
    for line in [] if result.image is None else lines_on(result.image):
        print(line)
    for path in arguments.export:
        print(printable(f"Wrote {path}"))
