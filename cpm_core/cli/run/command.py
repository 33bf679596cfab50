"""``cpm run``: finds the contours of an image."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.cli.arguments import (
    add_close,
    add_export,
    add_image,
    add_json,
    add_parameters,
    add_session,
    add_space,
    as_steps,
    check_exports,
    notes_on,
    parameters_of,
    with_room,
)
from cpm_core.cli.inputs import (
    add_part,
    as_number,
    image_of,
    in_space,
    in_volume,
    part_of,
    reading_of,
    session_of,
    starts_from_files,
    truth_for,
)
from cpm_core.cli.outcome import Files, outcome_of, tell
from cpm_core.cli.run.agreement import agreement, sentence_on
from cpm_core.cli.run.drawn import plain_drawn, regions_drawn, seeds_drawn
from cpm_core.cli.run.objects import add_objects, check_objects, choose, facts_of_object, sentence
from cpm_core.cli.run.pages import StackRun, add_pages, check_pages, run_pages
from cpm_core.cli.run.saved_session import check_save, save
from cpm_core.cli.run.volume import run_volume
from cpm_core.cli.terminal import announce_compilation, progress_line
from cpm_core.contours.kept import with_kept
from cpm_core.contours.result import Result
from cpm_core.contours.review import apply
from cpm_core.field.edge_map import edge_map
from cpm_core.formats import (
    CONTOURS_READABLE,
    FOR_CENTERLINES,
    SURFACES_READABLE,
    left_out,
    load_image,
    suffix_of,
)
from cpm_core.formats.common.printable import printable
from cpm_core.formats.common.provenance import ENTRY, facts_of, plain_shapes, with_shapes
from cpm_core.formats.sessions.recorded_run import Recorder
from cpm_core.formats.sessions.session_file import SUFFIX, SessionFile
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.objects import Selection
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.parameters.quotation import counted
from cpm_core.reconstruction.curve.closing import close_contours
from cpm_core.segmentation.evolve import segment, with_hand_edits
from cpm_core.shapes import KINDS, Everywhere
from cpm_core.shapes.document_shapes import charges_of, seeds_on

_CLOSE = "Add --close to close those whose ends are near each other."
_CURE = f"{_CLOSE[:-1]}, or write SVG, GeoJSON or CSV."


def add_to(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command to those of the command line."""
    parser = commands.add_parser("run", help="find the contours of an image", allow_abbrev=False)
    parser.set_defaults(command=_run)
    parser.description = "Let particles flow from a start to the contours of an image."
    add_image(parser, optional=True)
    add_session(parser)
    part = parser.add_argument_group("part of a file")
    add_part(part)
    add_pages(part)
    _add_places(parser)
    add_objects(parser.add_argument_group("object"))
    parameters = parser.add_argument_group("parameters")
    parameters.add_argument(
        "--preset",
        choices=tuple(PRESETS),
        help="named settings (default: the publication's values, or the session's)",
    )
    add_parameters(parameters)
    outcome = parser.add_argument_group("outcome")
    outcome.add_argument("--max-steps", metavar="N", type=as_number, help="stop after so many steps at most")
    outcome.add_argument(
        "--faces", metavar="N", type=as_number, help="triangles that are left of the surface in a volume"
    )
    add_space(outcome)
    add_export(outcome, "contours")
    add_close(outcome)
    outcome.add_argument(
        "--truth", metavar="FILE", help="compare with a ground truth: a mask, contours, or a label volume"
    )
    outcome.add_argument(
        "--save-session", metavar="FILE", help=f"write a session ({SUFFIX}) that the window opens with these contours"
    )
    add_json(outcome)


def _add_places(parser: argparse.ArgumentParser) -> None:
    """Add where a run starts, and what limits it."""
    start = parser.add_argument_group("start (one at least, of a session or here; several add up)")
    place = parser.add_argument_group("place (each may be repeated)")
    line = "ROW,COL,ROW,COL,..."
    for group, flag, form, meaning in (
        (start, "--circle", "ROW,COL,RADIUS", "a circle, in px"),
        (start, "--sphere", "PLANE,ROW,COL,RADIUS", "a sphere in a volume, in voxels; IMAGE is then a volume"),
        (start, "--stroke", line, "a stroke from point to point"),
        (start, "--points", "FILE.csv", "points: row,col on each line"),
        (
            start,
            "--start",
            "FILE",
            f"the contours of a file ({', '.join(CONTOURS_READABLE)}, or a label mask); in a "
            f"volume a surface, labels or center lines ({', '.join((*SURFACES_READABLE, *FOR_CENTERLINES))})",
        ),
        (place, "--region", line, "corners of a polygon that particles stay in, in px; in a volume of a box"),
        (place, "--barrier", line, "vertices of a line that no particle crosses, in px; in a volume a plane"),
    ):
        group.add_argument(flag, metavar=form, action="append", default=[], help=meaning)
    start.add_argument("--volume", action="store_true", help="IMAGE is a volume; places are then PLANE,ROW,COL")
    start.add_argument("--auto", choices=KINDS, help="everywhere, on the strongest edges, or midway between edges")


def _run(arguments: argparse.Namespace) -> int:
    """Find the contours of an image, or of the pages of a stack; every check that needs no image comes first."""
    surface = arguments.sphere or arguments.volume or arguments.space or arguments.faces is not None
    session = session_of(arguments)
    if surface or in_space(arguments) or in_volume(session):
        return run_volume(arguments, session)
    part = part_of(arguments)
    parameters = parameters_of(arguments, PRESETS[arguments.preset] if arguments.preset else session.parameters)
    max_steps = as_steps(arguments.max_steps)
    check_objects(arguments)
    drawn = seeds_drawn(arguments, session)
    regions = regions_drawn(arguments, session)
    path, notes = image_of(arguments.image, session, arguments.session)
    own = reading_of(arguments.image, session, path)
    part = {name: value for name, value in own.items() if name != "page" or arguments.pages is None} | part
    check_pages(arguments, str(path))
    check_save(arguments, str(path))
    if arguments.pages is None:
        check_exports(arguments.export, arguments, path)
        _tell_notes((*session.notes, *notes))
        return _run_image(arguments, session, path, part, parameters, max_steps, drawn, regions)
    if session.marks or session.hand_edits:
        notes = (*notes, "The review and the edits of the session belong to one page and are not used for others.")
    _tell_notes((*session.notes, *notes))
    order = StackRun(
        path,
        part,
        parameters,
        lambda image: _seeds(arguments, session, image, parameters, drawn),
        (*plain_shapes(session.shapes), *plain_drawn(arguments)),
        max_steps,
        regions,
        charges_of(session.shapes),
    )
    return run_pages(arguments, order)


def _run_image(
    arguments: argparse.Namespace,
    session: SessionFile,
    path: Path,
    part: Mapping[str, Any],
    parameters: Parameters,
    max_steps: int | None,
    drawn: list[NDArray[np.float64]],
    regions: AnyRegions | None,
) -> int:
    """Find the contours of one image."""
    image = load_image(path, **part)
    small: tuple[str, ...] = ()
    if arguments.scales is None:
        parameters, small = with_room(parameters, image)
    _tell_notes(f"{image.source}: {note}" for note in (*notes_on(image, parameters), *small))
    truth = truth_for(arguments, image)
    started = time.perf_counter()
    seeds, charges = _seeds(arguments, session, image, parameters, drawn), charges_of(session.shapes)
    announce_compilation()
    recorder = Recorder()
    with progress_line(recorder) as progress:
        found = segment(
            image, seeds, parameters, max_steps=max_steps, progress=progress, regions=regions, charges=charges
        )
    found = with_shapes(found, session.shapes, plain_drawn(arguments))
    result = _edited(found, image, parameters, session, arguments)
    chosen, shown = None, result
    if arguments.object:
        chosen, shown = choose(result, image, arguments)
    seconds = time.perf_counter() - started
    files = Files()
    files.export(shown, arguments.export, image=path, tell=_tell_omission)
    if arguments.save_session is not None:
        with files.writing(arguments.save_session):
            save(arguments, session, image, path, part, parameters, recorder)
    if any(left_out(shown, suffix_of(path)) for path in files.refused):
        files.advice = _CLOSE
    files.check()
    _report(result, chosen, seconds, shown, files, agreement(shown, truth), arguments)
    return files.status()


def _edited(
    found: Result, image: Image, parameters: Parameters, session: SessionFile, arguments: argparse.Namespace
) -> Result:
    """The result of a run after all that a session says of its contours, with open ones closed as asked."""
    own = arguments.image is None  # kept contours belong to the image of the session
    edited = with_hand_edits(found, image, parameters, session.hand_edits)
    whole = with_kept(edited, session.marks) if own else edited
    result = apply(whole, session.marks)
    if arguments.close is None:
        return result
    edges = edge_map(image.gray(parameters.channel), parameters.smoothing) if arguments.close == "edges" else None
    return close_contours(result, edges)


def _tell_notes(notes: Iterable[str]) -> None:
    for note in notes:
        print(f"cpm: {note}", file=sys.stderr)


def _tell_omission(sentence: str) -> None:
    print(printable(f"cpm: {sentence} {_CURE}"), file=sys.stderr, flush=True)


def _seeds(
    arguments: argparse.Namespace,
    session: SessionFile,
    image: Image,
    parameters: Parameters,
    drawn: list[NDArray[np.float64]],
) -> NDArray[np.float64]:
    """All seeds on an image: those drawn, those of the session, and those that are placed by themselves."""
    seen = parameters.smoothing, parameters.channel
    seeds = [seeds_on(image, session.shapes, *seen), *drawn, *(s.seeds() for s in starts_from_files(arguments, image))]
    if arguments.auto:
        seeds.append(seeds_on(image, (Everywhere(arguments.auto),), *seen))
    elif arguments.object and not any(map(len, seeds)):
        seeds.append(seeds_on(image, (Everywhere("grid"),), *seen))
    return np.concatenate(seeds)


def _report(
    result: Result,
    chosen: Selection | None,
    seconds: float,
    shown: Result,
    files: Files,
    agreed: Mapping[str, Any],
    arguments: argparse.Namespace,
) -> None:
    objects = {} if chosen is None else {"objects": [facts_of_object(chosen)]}
    missing = {path: left_out(shown, suffix_of(path)) for path in files.written if path in arguments.export}
    more = {"bridges": len(result.bridges), "left_out": missing, "not_written": files.refused}
    facts = {**outcome_of(result, seconds), **more, **objects, **agreed, ENTRY: facts_of(result)}
    tell("run", facts, _lines(result, chosen, facts), files.written, as_json=arguments.json)


def _lines(result: Result, chosen: Selection | None, facts: Mapping[str, Any]) -> Iterator[str]:
    """What a person is told."""
    yield f"{result.source}: {counted(len(result.contours), 'contour')} ({facts['closed']} closed)"
    for number, contour in enumerate(result.contours[:10], start=1):
        kind = f"closed, area {contour.area:.1f} px²" if contour.closed else "open"
        yield f"  {number}. length {contour.length:.1f} px, {kind}, strength {contour.strength:.3g}"
    if len(result.contours) > 10:
        yield f"  ... and {len(result.contours) - 10} shorter ones"
    if chosen is not None:
        yield sentence(chosen)
    if result.bridges:
        longest = max(bridge.length for bridge in result.bridges)
        yield f"Bridged {counted(len(result.bridges), 'gap')}, longest {longest:.1f} px"
    if "truth" in facts:
        yield sentence_on(facts["truth"])
    yield f"{counted(len(result.particles), 'particle')}, {counted(result.steps, 'step')} in {facts['seconds']:.2f} s"
    yield f"Stopped: {result.stop_reason}"
