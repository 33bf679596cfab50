"""``cpm export``: writes what a session shows, or contours of a file, in other formats."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from cpm_core.cli.arguments import add_json, check_exports, notes_on, with_room
from cpm_core.cli.outcome import tell
from cpm_core.cli.terminal import announce_compilation, counted, progress_line, say, written
from cpm_core.contours.kept import with_kept
from cpm_core.contours.result import Result
from cpm_core.contours.review import apply
from cpm_core.formats import CONTOURS_READABLE, WRITABLE, export, left_out, load_image, suffix_of
from cpm_core.formats.contours.reading.contour_file import plane_of, read_contours
from cpm_core.formats.images.resolution import known_unit
from cpm_core.formats.provenance import ENTRY, facts_of, with_shapes
from cpm_core.formats.sessions.chosen_part import part_for
from cpm_core.formats.sessions.recorded_run import shown_state
from cpm_core.formats.sessions.session_file import SUFFIX, SessionFile, find_image, load_session
from cpm_core.image.image import Image
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.segment import segment, with_hand_edits
from cpm_core.shapes.document_shapes import charges_of, regions_of, seeds_on, starts_of

_FROM_FILE = "read from a file"


def add_to(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command to those of the command line."""
    parser = commands.add_parser("export", help="write a session or contours in other formats", allow_abbrev=False)
    parser.set_defaults(command=_export)
    parser.description = (
        "Write the contours that a session shows, or those of a file, in other formats. A session without a recorded "
        "run is run first."
    )
    parser.add_argument(
        "source", metavar="FILE", help=f"session ({SUFFIX}), contours ({', '.join(CONTOURS_READABLE)}) or label mask"
    )
    parser.add_argument("--image", metavar="IMAGE", help="the image that the contours belong to")
    parser.add_argument("--page", metavar="N", type=int, help="page of contours in a stack, from 1")
    parser.add_argument(
        "--to",
        metavar="PATH",
        nargs="+",
        action="extend",
        required=True,
        help=f"files to write ({', '.join(WRITABLE)})",
    )
    parser.add_argument("--outlines", action="store_true", help="lines in label masks, open ones too, instead of areas")
    add_json(parser)


def _export(arguments: argparse.Namespace) -> int:
    """Write the files, after all checks that need none of them."""
    source = Path(arguments.source)
    check_exports(arguments.to, str(source))
    if arguments.image is not None:
        check_exports(arguments.to, arguments.image)
    if source.suffix.lower() == SUFFIX:
        result, image = _of_session(source, arguments.image)
    else:
        result, image = _of_file(source, arguments), arguments.image
    refused: dict[Path, str] = {}
    export(result, *arguments.to, image=image, outlines=arguments.outlines, refused=refused.__setitem__, tell=_tell)
    files = [path for path in arguments.to if Path(path) not in refused]
    missing = {path: left_out(result, suffix_of(path), outlines=arguments.outlines) for path in files}
    closed = sum(contour.closed for contour in result.contours)
    facts = {"source": str(source), "contours": len(result.contours), "closed": closed, "left_out": missing}
    with written("the files were written before"):
        line = f"{source.name}: {counted(len(result.contours), 'contour')} ({closed} closed)"
        tell("export", {**facts, ENTRY: facts_of(result)}, [line], files, as_json=arguments.json)
    if refused:
        raise ValueError(" ".join(refused.values()))
    return 0


def _tell(sentence: str) -> None:
    say(f"cpm: {sentence}")


def _of_file(source: Path, arguments: argparse.Namespace) -> Result:
    """The contours of a file as a result on the image that is named, or one of the size that the file tells."""
    image = None if arguments.image is None else load_image(arguments.image)
    found = read_contours(source, plane_of(image), page=arguments.page)
    for note in found.notes:
        _tell(f"{source.name}: {note}")
    if not found.contours:
        raise ValueError(f"{source.name} holds single points only, and no contours: choose another file.")
    shape = found.shape if image is None else image.shape
    if shape is None:
        corners = np.concatenate([contour.points for contour in found.contours])
        rows, cols = (np.ceil(corners.max(axis=0)) + 1).astype(int).tolist()
        shape = (max(rows, 1), max(cols, 1))
        _tell(f"{source.name} does not tell the size of its image: {rows} x {cols} px is taken; name it with --image.")
    spacing = (1.0, 1.0) if image is None else image.spacing
    name = source.name if image is None else image.source
    unit = None if image is None or image.unit is None else known_unit(image.unit)
    nothing = np.empty((0, 2))
    return Result(nothing, found.contours, None, 0, True, _FROM_FILE, shape, spacing, unit, name, image=image)


def _of_session(source: Path, named: str | None) -> tuple[Result, str]:
    """What the window shows of a session: the state that it keeps, or else the end of its run."""
    session = load_session(source)
    if named is None and session.image is None:
        raise ValueError(f"{source.name} names no image: add --image IMAGE.")
    path, notes = Path(named or ""), session.notes
    part = {}
    if session.image is not None and named is not None:
        part = part_for(path, session.image.reading)
    elif session.image is not None:
        path, found = find_image(session.image, source.absolute().parent)
        notes, part = (*notes, *found), session.image.reading.arguments
    for told in notes:
        _tell(told)
    image = load_image(path, **part)
    parameters, small = with_room(session.parameters, image)
    for note in (*notes_on(image, parameters), *small):
        _tell(f"{image.source}: {note}")
    result = _found(replace(session, parameters=parameters), image, source)
    edited = with_hand_edits(with_shapes(result, session.shapes), image, parameters, session.hand_edits)
    whole = with_kept(edited, session.marks)
    return apply(whole, session.marks, learning=session.learning, found=edited.contours), str(path)


def _found(session: SessionFile, image: Image, source: Path) -> Result:
    announce_compilation()
    shown = shown_state(session, image.shape)
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
