"""``cpm compare``: runs several methods on an image and tells what each has found, and in what time."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from cpm_core.cli.arguments import add_image, add_json, add_part, add_session, as_number, as_steps, part_of
from cpm_core.cli.compare.settings import add_settings, chosen_settings
from cpm_core.cli.compare.start import add_start, outlines_drawn, start_on
from cpm_core.cli.outcome import print_json
from cpm_core.cli.terminal import announce_compilation, say
from cpm_core.contours.ground_truth import Truth
from cpm_core.formats import load_image
from cpm_core.formats.animations.comparison import Tile, check_comparison, write_comparison
from cpm_core.formats.ground_truth_file import load_truth
from cpm_core.formats.printable import printable
from cpm_core.formats.sessions.session_file import SessionFile, find_image, load_session
from cpm_core.image.image import Image
from cpm_core.parameters import Parameters
from cpm_core.segmentation.methods import (
    CONTOUR_METHODS,
    Compared,
    Facts,
    Start,
    facts_of,
    method_named,
    run_method,
    runnable,
)
from cpm_core.shapes.document_shapes import check_axes

_WIDTH = 24
"""Width of the column of the methods [characters]."""


def add_to(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command to those of the command line."""
    parser = commands.add_parser("compare", help="compare methods on the same image and start", allow_abbrev=False)
    parser.set_defaults(command=_compare)
    parser.description = (
        "Run the charged particles and classical methods from the same start, one after the other. "
        + " ".join(f"{method.name}: {method.about}" for method in CONTOUR_METHODS.values())
    )
    add_image(parser, optional=True)
    add_session(parser)
    add_part(parser.add_argument_group("part of a file"), channel=True)
    add_start(parser)
    methods = parser.add_argument_group("methods")
    methods.add_argument(
        "--methods",
        metavar="NAME",
        nargs="+",
        action="extend",
        default=[],
        help=f"which methods ({', '.join(CONTOUR_METHODS)}; default: those of the session, or all)",
    )
    add_settings(methods)
    methods.add_argument("--max-steps", metavar="N", type=as_number, help="stop each after so many steps at most")
    outcome = parser.add_argument_group("outcome")
    outcome.add_argument("--truth", metavar="MASK", help="ground truth: a mask, or a file of contours")
    outcome.add_argument(
        "--export",
        metavar="PATH",
        nargs="+",
        action="extend",
        default=[],
        help="write the table (.csv), a picture of the methods side by side (.png), or the contours of each method in "
        "a format of cpm run (such as .svg, .json, .tif): with several methods a file for each, such as a.gac.svg",
    )
    add_json(outcome)


def _compare(arguments: argparse.Namespace) -> None:
    """Run the methods; every check that needs no image comes first."""
    session = load_session(Path(arguments.session)) if arguments.session else SessionFile()
    if arguments.image is None and session.image is None:
        raise ValueError("No IMAGE is given: name one, or with --session FILE a session that has one.")
    compared = Compared(()) if session.comparison == Compared() else session.comparison
    named = arguments.methods or [name for name in compared.methods if name]
    names = _methods(named)
    settings = chosen_settings(arguments, names, session.parameters if arguments.session else Parameters(), compared)
    max_steps = as_steps(arguments.max_steps)
    outlines = outlines_drawn(arguments, session)
    for path in arguments.export:
        check_comparison(path, names)
    image = _image(arguments, session)
    check_axes(session.shapes, image.shape, image.source)
    start = start_on(image, outlines, arguments, session)
    truth = None if arguments.truth is None else load_truth(arguments.truth, image.shape)
    for missing in [] if named else [method.missing for method in CONTOUR_METHODS.values() if method.missing]:
        say(f"cpm: {missing}")
    announce_compilation()
    tiles = []
    for name in names:
        moment = run_method(CONTOUR_METHODS[name], image, start, settings[name], max_steps)
        tiles.append(Tile(moment.state.contours, facts_of(moment, truth), settings[name]))
        if not arguments.json:
            _tell(tiles[-1].facts, truth, first=len(tiles) == 1)
    written = write_comparison(image, start, tiles, arguments.export, lambda said: say(f"cpm: {said}"), truth)
    if arguments.json:
        _print_json(image, start, [tile.facts for tile in tiles], truth)
        return
    for path in written:
        print(printable(f"Wrote {path}"))


def _methods(named: Sequence[str]) -> list[str]:
    """The methods that are named, or all that can run."""
    for name in named:
        method_named(name).check()
    return list(dict.fromkeys(named or runnable()))


def _print_json(image: Image, start: Start, rows: Sequence[Facts], truth: Truth | None) -> None:
    given = {"image": image.source, "around": start.around, "truth": None if truth is None else truth.source}
    plain = [{name: _finite(value) for name, value in asdict(row).items()} for row in rows]
    print_json("compare", {**given, "methods": plain})


def _finite(value: object) -> object:
    """A value as JSON can hold it: an infinite distance is null."""
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _tell(row: Facts, truth: Truth | None, *, first: bool) -> None:
    """Print a line of the table, before the first its head."""
    if first:
        scores = f"{'Dice':>7}{'F':>7}{'Hausdorff':>12}{'mean dist.':>12}" if truth else ""
        print(f"{'':{_WIDTH}}{'steps':>7}{'time':>10}{scores}{'contours':>10}{'closed':>8}  end")
    agree = ""
    if row.dice is not None and row.f is not None:
        agree = f"{row.dice:7.3f}{row.f:7.3f}{_px(row.hausdorff, 1):>12}{_px(row.mean_distance, 2):>12}"
    counts = f"{row.contours:10}{row.closed:8}"
    title, time = CONTOUR_METHODS[row.method].title, f"{row.seconds:.2f} s"
    print(f"{title:{_WIDTH}}{row.steps:7}{time:>10}{agree}{counts}  {row.stop_reason}", flush=True)


def _px(distance: float | None, digits: int) -> str:
    return "" if distance is None else f"{distance:.{digits}f} px" if np.isfinite(distance) else "-"


def _image(arguments: argparse.Namespace, session: SessionFile) -> Image:
    part = part_of(arguments)
    path, notes = Path(arguments.image or ""), session.notes
    if arguments.image is None and session.image is not None:
        path, found = find_image(session.image, Path(arguments.session).absolute().parent)
        notes += found
    loaded = load_image(path, **part)
    image = loaded if arguments.channel is None else Image(loaded.gray(arguments.channel), source=loaded.source)
    for note in (*notes, *loaded.notes):
        say(f"cpm: {image.source}: {note}")
    if image.ndim != 2:
        raise ValueError(f"{image.source} is a volume, but methods are compared on images: take a plane, --page N.")
    return image
