"""``cpm run VOLUME --volume`` or ``--sphere``: finds the surface of objects in a volume."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cpm_core.cli.arguments import as_steps, check_exports, parameters_of
from cpm_core.cli.inputs import (
    image_of,
    in_space,
    in_volume,
    numbers_in,
    part_of_volume,
    reading_of,
    starts_in_volume,
    volume_truth_for,
)
from cpm_core.cli.outcome import Files, tell
from cpm_core.cli.place import facts_on, lines_on
from cpm_core.cli.run.agreement import agreement, sentence_on
from cpm_core.cli.terminal import announce_compilation, progress_line, say
from cpm_core.contours.result import Result
from cpm_core.formats import FOR_VOLUMES, load_volume, suffix_of
from cpm_core.formats.common.provenance import with_shapes
from cpm_core.formats.contours.points_csv import load_points
from cpm_core.formats.sessions.session_file import SessionFile
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions, Pair, VolumeRegions
from cpm_core.model.starts import stroke
from cpm_core.model.volume.starts import at_centers, everywhere, on_strong_edges, sphere
from cpm_core.numerics.types import Array
from cpm_core.objects.partition import partition
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.parameters.quotation import counted, shown
from cpm_core.segmentation.evolve import segment
from cpm_core.shapes.document_shapes import charges_of, regions_of, seeds_on, starts_of

_OF_IMAGES = ("circle", "close", "pages", "follow", "resume", "save_session")
"""Options that have a meaning for images only."""

_AUTOMATIC: Mapping[str, Callable[[Image], Array]] = {
    "grid": everywhere,
    "gradient": on_strong_edges,
    "centers": at_centers,
}
"""What starts without anything drawn."""

_FEWEST_FACES = 4
"""Least number of triangles of a closed surface."""


def run_volume(arguments: argparse.Namespace, session: SessionFile) -> int:
    """Find a surface; every check that needs no volume comes first."""
    _check_options(arguments, session)
    drawn, regions = _drawn(arguments, session), _regions(arguments, session)
    clicks = _clicks("--object", arguments.object), _clicks("--not", arguments.outside)
    if clicks[1] and not clicks[0]:
        raise ValueError("--not is given without --object: add --object PLANE,ROW,COL, a place inside the object.")
    part = part_of_volume(arguments)
    preset = arguments.preset or (None if arguments.session else "volume")
    parameters = parameters_of(arguments, PRESETS[preset] if preset else session.parameters)
    max_steps, faces = as_steps(arguments.max_steps), _as_faces(arguments.faces)
    path, notes = image_of(arguments.image, session, arguments.session)
    check_exports(arguments.export, arguments, path)
    for file in arguments.export:
        if suffix_of(file) not in FOR_VOLUMES:
            raise ValueError(f"{file} is for contours, but a volume has a surface: end its name in .ply or .stl.")
    volume = load_volume(path, **(reading_of(arguments.image, session, path) | part))
    for note in (*session.notes, *notes, *(f"{volume.source}: {note}" for note in volume.notes)):
        say(f"cpm: {note}")
    truth = volume_truth_for(arguments, volume)
    started = time.perf_counter()
    seeds = _seeds(arguments, session, volume, parameters, drawn)
    announce_compilation()
    with progress_line() as progress:
        found = segment(
            volume, seeds, parameters, max_steps=max_steps, progress=progress, regions=regions,
            charges=charges_of(session.shapes),
        )  # fmt: skip
    found = with_shapes(found, session.shapes) if session.shapes else found
    whole = _selected(found, *clicks) if clicks[0] else found
    result = whole if faces is None else _decimated(whole, faces)
    seconds = time.perf_counter() - started
    files = Files()
    files.export(result, arguments.export, image=path, space=arguments.space or "LPS")
    files.check()
    _report(result, seconds, files, agreement(result, truth), arguments)
    return files.status()


def _check_options(arguments: argparse.Namespace, session: SessionFile) -> None:
    """ValueError for options that have no meaning for this run."""
    if not (arguments.sphere or arguments.volume or in_space(arguments) or in_volume(session)):
        given = "--space" if arguments.faces is None else "--faces"
        raise ValueError(f"{given} is for the surface in a volume: add --sphere PLANE,ROW,COL,RADIUS, or leave it out.")
    for name in _OF_IMAGES:
        if getattr(arguments, name, None):
            given = f"--{name.replace('_', '-')}"
            volumes = "the session is about a volume" if in_volume(session) else "--sphere and --volume are for volumes"
            raise ValueError(f"{given} is for images, but {volumes}: leave one out.")


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


def _numbers(flag: str, text: str, form: str, count: int = 0) -> list[float]:
    """Numbers between commas, so many, or else three or more times three."""
    numbers = numbers_in(text)
    fits = len(numbers) == count if count else len(numbers) % 3 == 0
    if not (numbers and fits):
        words = {3: "three numbers", 4: "four numbers", 6: "six numbers"}.get(count, "planes, rows and columns in turn")
        raise ValueError(f"{flag} is {shown(text)} but must be {words}, {form} in voxels.")
    return numbers


def _drawn(arguments: argparse.Namespace, session: SessionFile) -> list[Array]:
    """Spheres, as plane, row, column and radius each, then the particles of strokes and of files with points."""
    spheres = [_numbers("--sphere", text, "PLANE,ROW,COL,RADIUS", 4) for text in arguments.sphere]
    lines = [_numbers("--stroke", text, "PLANE,ROW,COL,PLANE,ROW,COL,...") for text in arguments.stroke]
    given = spheres or lines or arguments.points or arguments.start or arguments.auto or starts_of(session.shapes)
    if not given and session.mode == "skeleton":
        raise ValueError("The session is about a skeleton and has no start: use cpm skeleton VOLUME --export PATH.")
    if not given:
        raise ValueError(
            "No start is given: add --sphere PLANE,ROW,COL,RADIUS, --stroke PLANE,ROW,COL,PLANE,ROW,COL,..., "
            "--points FILE.csv, --start FILE or --auto grid."
        )
    return [
        *(np.array(numbers) for numbers in spheres),
        *(stroke(np.reshape(numbers, (-1, 3))) for numbers in lines),
        *(load_points(path, 3) for path in arguments.points),
    ]


def _clicks(flag: str, texts: Sequence[str]) -> list[list[float]]:
    """Places inside or outside an object."""
    return [_numbers(flag, text, "PLANE,ROW,COL", 3) for text in texts]


def _selected(found: Result, inside: list[list[float]], outside: list[list[float]]) -> Result:
    """The result with the surface of the bodies alone that places lie in; ValueError when there are none."""
    chosen = partition(found).select(inside, outside)
    if not len(chosen.surface.faces):
        places = ", ".join(",".join(f"{number:g}" for number in place) for place in inside)
        raise ValueError(f"There is no object at {places}: name a place that the surface encloses.")
    return replace(found, surface=chosen.surface)


def _regions(arguments: argparse.Namespace, session: SessionFile) -> AnyRegions | None:
    """Limits of the session, boxes of interest, and planes that are barriers."""
    boxes = [_numbers("--region", text, "PLANE,ROW,COL,PLANE,ROW,COL of two corners", 6) for text in arguments.region]
    form = "PLANE,ROW,COL of a point and then of the direction across it,"
    planes = [_numbers("--barrier", text, form, 6) for text in arguments.barrier]
    saved = regions_of(session.shapes, session.objects.barriers)
    if not (boxes or planes):
        return saved
    interest, barriers = (tuple(_pair(limit) for limit in limits) for limits in (boxes, planes))
    before = saved if isinstance(saved, VolumeRegions) else VolumeRegions()
    return VolumeRegions((*before.interest, *interest), (*before.barriers, *barriers))


def _pair(numbers: list[float]) -> Pair:
    one, other = (numbers[0], numbers[1], numbers[2]), (numbers[3], numbers[4], numbers[5])
    return one, other


def _seeds(
    arguments: argparse.Namespace, session: SessionFile, volume: Image, parameters: Parameters, drawn: list[Array]
) -> Array:
    """Particles of all starts; the radius of a sphere is in sides of the smallest voxel."""
    plane, row, col = (side / min(volume.spacing) for side in volume.spacing)
    sides = (plane, row, col)
    saved = seeds_on(volume, session.shapes, parameters.smoothing)
    seeds = [saved] if len(saved) else []
    seeds += [part if part.ndim == 2 else sphere((part[0], part[1], part[2]), part[3], spacing=sides) for part in drawn]
    seeds += [start.seeds() for start in starts_in_volume(arguments, volume)]
    if arguments.auto:
        seeds.append(_AUTOMATIC[arguments.auto](volume))
    return np.concatenate(seeds)


def _report(
    result: Result, seconds: float, files: Files, agreed: Mapping[str, Any], arguments: argparse.Namespace
) -> None:
    surface = result.surface
    vertices, faces = (0, 0) if surface is None else (len(surface.vertices), len(surface.faces))
    facts = {
        "particles": len(result.particles),
        "contours": 0,
        "closed": 0,
        "vertices": vertices,
        "faces": faces,
        "volume": round(surface.volume, 3) if surface is not None and surface.closed else None,
        "area": round(surface.area, 3) if surface is not None else None,
        "steps": result.steps,
        "converged": result.converged,
        "stop_reason": result.stop_reason,
        "seconds": round(seconds, 3),
        "not_written": files.refused,
        **({} if result.image is None else facts_on(result.image)),
        **agreed,
    }
    lines = [
        f"{result.source}: a surface of {counted(faces, 'triangle')}, with {vertices} corners",
        f"{counted(len(result.particles), 'particle')}, {counted(result.steps, 'step')} in {seconds:.2f} s",
        f"Stopped: {result.stop_reason}",
        *([] if result.image is None else lines_on(result.image)),
        *([sentence_on(agreed["truth"])] if agreed else []),
    ]
    tell("run", facts, lines, files.written, as_json=arguments.json)
