"""``cpm export``: writes what a session shows, or contours and surfaces of a file, in other formats."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.cli.arguments import add_json, add_space, check_exports, notes_on, with_room
from cpm_core.cli.inputs import as_number, check_kept, image_of, in_volume, reading_of
from cpm_core.cli.outcome import Files, tell
from cpm_core.cli.terminal import announce_compilation, progress_line, say
from cpm_core.contours.kept import with_kept
from cpm_core.contours.result import Result
from cpm_core.contours.review import apply
from cpm_core.formats import (
    CONTOURS_READABLE,
    FOR_CENTERLINES,
    FOR_VOLUMES,
    SURFACES_READABLE,
    WRITABLE,
    left_out,
    load_centerlines,
    load_image,
    load_surface,
    load_volume,
    suffix_of,
)
from cpm_core.formats.common.provenance import ENTRY, facts_of, facts_on, with_shapes
from cpm_core.formats.contours.contour_file import plane_of, read_contours
from cpm_core.formats.images.resolution import known_unit
from cpm_core.formats.sessions.recorded_run import shown_state
from cpm_core.formats.sessions.session_file import SUFFIX, SessionFile, load_session
from cpm_core.image.image import Image
from cpm_core.medial_axis.space.centerlines import Centerlines
from cpm_core.parameters.quotation import counted, shown
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.segment import segment, with_hand_edits
from cpm_core.shapes.document_shapes import charges_of, regions_of, seeds_on, starts_of


def add_to(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command to those of the command line."""
    parser = commands.add_parser("export", help="write a session or contours in other formats", allow_abbrev=False)
    parser.set_defaults(command=_export)
    parser.description = (
        "Write the contours or the surface that a session shows, or those of a file, in other formats. A session "
        "without a recorded run is run first."
    )
    known = ", ".join((*CONTOURS_READABLE, *SURFACES_READABLE, *FOR_CENTERLINES))
    parser.add_argument(
        "source", metavar="FILE", help=f"session ({SUFFIX}), contours, a surface or center lines ({known}), or labels"
    )
    parser.add_argument("--image", metavar="IMAGE", help="the image or volume that it belongs to")
    parser.add_argument("--page", metavar="N", type=as_number, help="page of contours in a stack, from 1")
    parser.add_argument(
        "--to",
        metavar="PATH",
        nargs="+",
        action="extend",
        required=True,
        help=f"files to write ({', '.join(dict.fromkeys((*WRITABLE, *FOR_VOLUMES, *FOR_CENTERLINES)))})",
    )
    parser.add_argument("--outlines", action="store_true", help="lines in label masks, open ones too, instead of areas")
    add_space(parser)
    add_json(parser)


def _export(arguments: argparse.Namespace) -> int:
    """Write the files, after all checks that need none of them."""
    source = Path(arguments.source)
    check_exports(arguments.to, arguments, flag="--to")
    _check_page(arguments.page, source)
    result: Result | Centerlines
    if source.suffix.lower() == SUFFIX:
        result, image = of_session(source, arguments)
    else:
        result, image = of_file(source, arguments), arguments.image
    files = Files()
    files.export(
        result,
        arguments.to,
        image=image,
        outlines=arguments.outlines,
        space=arguments.space or "LPS",
        tell=lambda sentence: say(f"cpm: {sentence}"),
    )
    files.check()
    missing = {path: left_out(result, suffix_of(path), outlines=arguments.outlines) for path in files.written}
    told, line = _told(result, source)
    facts = {"source": str(source), "left_out": missing, "not_written": files.refused, **told}
    tell("export", facts, [line], files.written, as_json=arguments.json)
    return files.status()


def _check_page(page: int | float | str | None, source: Path) -> None:
    """Raise ValueError unless a page is a number, of a file that may have several."""
    if page is None:
        return
    if source.suffix.lower() == SUFFIX:
        raise ValueError(f"--page is for contours in a stack, but {source.name} is a session: leave it out.")
    if not isinstance(page, int) or page < 1:
        raise ValueError(f"--page is {shown(page)} but must be a whole number from 1 up.")


def _told(result: Result | Centerlines, source: Path) -> tuple[dict[str, Any], str]:
    """What is told of a result, as plain JSON and as a line."""
    closed = sum(contour.closed for contour in result.contours)
    facts: dict[str, Any] = {"contours": len(result.contours), "closed": closed}
    if isinstance(result, Centerlines):
        facts[ENTRY] = facts_on(result.source, result.provenance)
        return facts, f"{source.name}: {counted(len(result.contours), 'center line')} ({closed} closed)"
    facts[ENTRY] = facts_of(result)
    if result.surface is None:
        return facts, f"{source.name}: {counted(len(result.contours), 'contour')} ({closed} closed)"
    vertices, faces = len(result.surface.vertices), len(result.surface.faces)
    facts |= {"vertices": vertices, "faces": faces}
    return facts, f"{source.name}: a surface of {counted(faces, 'triangle')}, with {vertices} corners"


def of_session(source: Path, arguments: argparse.Namespace) -> tuple[Result, str]:
    """What the window shows of a session: the state that it keeps, or else the end of its run."""
    session, named = load_session(source), arguments.image
    if named is None and session.image is None:
        raise ValueError(f"{source.name} names no image: add --image IMAGE.")
    path, notes = image_of(named, session, source)
    check_kept(arguments.to, arguments, path, flag="--to")
    for told in (*session.notes, *notes):
        say(f"cpm: {told}")
    part = reading_of(named, session, path)
    image = load_volume(path, **part) if in_volume(session) else load_image(path, **part)
    parameters, small = with_room(session.parameters, image)
    for note in (*notes_on(image, parameters), *small):
        say(f"cpm: {image.source}: {note}")
    result = _found(replace(session, parameters=parameters), image, source)
    edited = with_hand_edits(with_shapes(result, session.shapes), image, parameters, session.hand_edits)
    whole = with_kept(edited, session.marks)
    return apply(whole, session.marks), str(path)


def _found(session: SessionFile, image: Image, source: Path) -> Result:
    announce_compilation()
    shown = shown_state(session, image)
    if shown is not None:
        state, parameters = shown
        return replace(Engine(image, parameters, state.regions).result(state, parameters), source=image.source)
    if not starts_of(session.shapes):
        raise ValueError(f"{source.name} has no start and no contours: draw a start in the window, and save it again.")
    seen = session.parameters.smoothing, session.parameters.channel
    seeds = seeds_on(image, session.shapes, *seen)
    regions, charges = regions_of(session.shapes, session.objects.barriers), charges_of(session.shapes)
    with progress_line() as progress:
        return segment(image, seeds, session.parameters, progress=progress, regions=regions, charges=charges)


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
