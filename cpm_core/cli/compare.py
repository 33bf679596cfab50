"""``cpm compare``: runs several methods on an image and reports what each has found, and in what time."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import cast

import numpy as np

from cpm_core.cli.arguments import (
    PART_OPTIONS,
    add_options,
    check_targets,
    group_coordinates,
    parse_number_list,
    parse_number_or_text,
    parse_part,
)
from cpm_core.cli.inputs import fit_parameters, load_named_session, load_named_truth, locate_image, read_starts
from cpm_core.cli.output import OutputFiles, ensure_compiled, print_message, print_report
from cpm_core.contours.ground_truth import Truth
from cpm_core.formats import load_image
from cpm_core.formats.comparison import check_comparison, list_comparison_files, write_comparison
from cpm_core.formats.contour_file import CONTOURS_READABLE
from cpm_core.formats.sessions.session_file import SessionFile
from cpm_core.image.colors import LUMINANCE_CHOICE
from cpm_core.image.image import Image
from cpm_core.methods import (
    CONTOUR_METHODS,
    RunReport,
    Start,
    build_method_result,
    report_run,
    run_method,
)
from cpm_core.numerics.types import JsonDict, Texts
from cpm_core.parameters import PRESETS
from cpm_core.parameters.formatting import format_choice, format_count, quote_value
from cpm_core.results.result import Result
from cpm_core.shapes import Barrier, Charge, Circle, Polygon, PolygonRegion, Shape
from cpm_core.shapes.document_shapes import check_axes, select_starts
from cpm_core.shapes.outlines import drawn_outlines

_METHODS_HELP = " ".join(f"{method.name}: {method.about}" for method in CONTOUR_METHODS.values())
"""Descriptions of the methods, for the help."""

_PARTICLE_METHODS = tuple(name for name, method in CONTOUR_METHODS.items() if method.of_particles)
"""Methods whose settings are the parameters of a run."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_options(parser, "image", nargs="?")
    add_options(parser, "--session")
    add_options(parser.add_argument_group("part of a file"), *PART_OPTIONS, "--channel")
    start = parser.add_argument_group("start", "One at least, here or of a session; several add up.")
    for flag, form, words in (
        ("--circle", "ROW,COL,RADIUS", "Start on a circle, in px."),
        ("--polygon", "ROW,COL,...", "Start on a closed line through these corners."),
        ("--start", "FILE", f"Start at closed contours of a file ({', '.join(CONTOURS_READABLE)}, or a label mask)."),
    ):
        start.add_argument(flag, metavar=form, action="append", default=[], help=words)
    start.add_argument(
        "--around",
        action="store_true",
        help="The start lies around the object, so that balloons and pressures drive contours inwards.",
    )
    add_options(start, "--xy")
    methods = parser.add_argument_group("methods")
    methods.add_argument(
        "--methods",
        metavar="NAME",
        nargs="+",
        action="extend",
        default=[],
        help=f"Compare these of the methods {', '.join(CONTOUR_METHODS)} (default: all). {_METHODS_HELP}",
    )
    others = (
        f"{name}: {', '.join(_list_setting_names(name))}" for name in CONTOUR_METHODS if name not in _PARTICLE_METHODS
    )
    methods.add_argument(
        "--set",
        metavar="METHOD.NAME=VALUE",
        nargs="+",
        action="extend",
        default=[],
        help="Change settings of methods, such as geodesic.balloon=0.5 cpm.smoothing=2. Settings are of "
        f"{'; of '.join(others)}; of {' and '.join(_PARTICLE_METHODS)}: the parameters of cpm run.",
    )
    add_options(
        methods, "--preset", help=f"Settings of {' and '.join(_PARTICLE_METHODS)} (default: those of the session)."
    )
    add_options(methods, "--max-steps")
    outcome = parser.add_argument_group("outcome")
    outcome.add_argument("--truth", metavar="MASK", help="Measure the agreement with a mask, or contours.")
    add_options(
        outcome,
        "--export",
        help="Write the table (.csv), or the contours of each method in a format of cpm run. Of several methods "
        "each has a file, such as a.geodesic.svg.",
    )


def run_comparison(arguments: argparse.Namespace) -> int:
    """Run the methods; every check that needs no image comes first."""
    session = load_named_session(arguments)
    for name in arguments.methods:
        if name not in CONTOUR_METHODS:
            raise ValueError(f"--methods is {quote_value(name)} but must be {format_choice(name, CONTOUR_METHODS)}")
    names = list(dict.fromkeys(arguments.methods or CONTOUR_METHODS))
    settings = _parse_settings(arguments, names, session)
    drawn = _collect_start_shapes(arguments, session)
    for path in arguments.export:
        check_comparison(path, names)
    targets = [file for path in arguments.export for file in list_comparison_files(Path(path), names)]
    check_targets(targets, arguments)
    image = _load_gray_image(arguments, session, targets)
    start = _build_start(image, drawn, arguments)
    truth = cast("Truth | None", load_named_truth(arguments.truth, image))
    ensure_compiled()
    scores = ("Dice", "F", "Hausd. [px]", "mean [px]") if truth else ()
    if not arguments.json:
        print(_format_cells("", "steps", "time", *scores, "contours", "closed"), " end")
    found: list[RunReport] = []
    results: list[Result] = []
    for name in names:
        moment = run_method(CONTOUR_METHODS[name], image, start, settings[name], arguments.max_steps)
        facts = report_run(moment, truth)
        if not facts.stop_reason:
            facts = replace(facts, stop_reason=f"stopped after {format_count(facts.steps, 'step')}, as requested")
        if not arguments.json:
            agreed = (facts.dice, facts.f, facts.hausdorff, facts.mean_distance) if truth else ()
            measures = (f"{value:.3f}" if value is not None and np.isfinite(value) else "-" for value in agreed)
            title, seconds = CONTOUR_METHODS[name].title, f"{facts.seconds:.2f} s"
            line = _format_cells(title, facts.steps, seconds, *measures, facts.contours, facts.closed)
            print(line, "", facts.stop_reason, flush=True)
        found.append(facts)
        results.append(build_method_result(facts, moment.state.contours, image, start, settings[name]))
    files = OutputFiles()
    files.written += map(str, write_comparison(found, results, arguments.export, print_message, files.refuse_file))
    given = {"image": image.source, "around": start.around, "truth": truth and truth.source, "unit": "px"}
    # JSON has no infinite distances
    rows = [
        {
            name: None if isinstance(value, float) and not np.isfinite(value) else value
            for name, value in asdict(one).items()
        }
        for one in found
    ]
    return print_report(arguments.name, arguments.json, {**given, "methods": rows}, (), files)


def _format_cells(title: str, *cells: object) -> str:
    """Format the first cells of a line of the table."""
    return f"{title:24}" + "".join(f"{cell!s:>12}" for cell in cells)


def _load_gray_image(arguments: argparse.Namespace, session: SessionFile, targets: Sequence[Path]) -> Image:
    """Load the image, in the gray levels that all methods take."""
    part = parse_part(arguments)
    path, reading = locate_image(arguments.image, session, arguments.session)
    check_targets(targets, arguments, path)
    image = load_image(path, **(reading | part))
    channel = arguments.channel or session.parameters.channel
    fit_parameters(image, replace(session.parameters, channel=channel), scales=False)
    if image.colors is not None and channel != LUMINANCE_CHOICE:
        image = replace(image, stored=image.gray_levels(channel), colors=None)
    check_axes(session.shapes, image.shape, image.source)
    return image


def _parse_settings(arguments: argparse.Namespace, methods: Sequence[str], session: SessionFile) -> JsonDict:
    """Return the settings of each method, changed as the arguments ask; particles have those of the session.

    Raises
    ------
    ValueError
        When a setting is of another form, of a method that is not compared, unknown, or out of its range.
    """
    ours = PRESETS[arguments.preset] if arguments.preset else session.parameters if arguments.session else None
    found: JsonDict = {
        name: ours if ours is not None and name in _PARTICLE_METHODS else CONTOUR_METHODS[name].defaults
        for name in methods
    }
    changes: dict[str, JsonDict] = {}
    for text in arguments.set:
        place, equals, value = text.partition("=")
        method, dot, name = place.partition(".")
        if not (equals and dot and name and value):
            raise ValueError(
                f"--set is {quote_value(text)} but must be METHOD.NAME=VALUE, such as geodesic.balloon=0.5."
            )
        if method not in found:
            raise ValueError(
                f"--set {quote_value(text)} is for {quote_value(method)}, which is not one of the compared methods."
            )
        if name not in _list_setting_names(method):
            raise ValueError(
                f"--set is {quote_value(text)}, but a setting of {method} must be "
                f"{format_choice(name, _list_setting_names(method))}"
            )
        changes.setdefault(method, {})[name] = parse_number_or_text(value)
    return {name: replace(settings, **changes.get(name, {})) for name, settings in found.items()}


def _list_setting_names(method: str) -> Texts:
    """Return the names of the settings of a method."""
    return tuple(setting.name for setting in fields(CONTOUR_METHODS[method].settings))


def _collect_start_shapes(arguments: argparse.Namespace, session: SessionFile) -> list[Shape]:
    """Return the shapes of the command line and of the session; ValueError when there is no start at all."""
    circles = (parse_number_list("--circle", text, "ROW,COL,RADIUS", is_xy=arguments.xy) for text in arguments.circle)
    polygons = (parse_number_list("--polygon", text, "ROW,COL,...", is_xy=arguments.xy) for text in arguments.polygon)
    drawn: list[Shape] = [Circle((row, col), radius) for row, col, radius in circles]
    drawn += [Polygon(group_coordinates(numbers, 2)) for numbers in polygons]
    drawn += session.shapes
    if not (drawn_outlines(drawn) or arguments.start):
        raise ValueError(
            "No start is given: add --circle ROW,COL,RADIUS, --polygon ROW,COL,ROW,COL,... or --start FILE, or a "
            "session with a circle, an ellipse or a polygon."
        )
    if any(isinstance(shape, PolygonRegion | Barrier | Charge) for shape in session.shapes):
        print_message("regions, barriers and charges of the session are left out: the other methods have none.")
    _report_open_starts("the session", select_starts(session.shapes))
    return drawn


def _build_start(image: Image, drawn: Sequence[Shape], arguments: argparse.Namespace) -> Start:
    """Return the start: lines that are drawn, and those of the files of ``--start``."""
    found = list(drawn_outlines(drawn))
    for path in arguments.start:
        shapes, name = read_starts(path, image), Path(path).name
        closed = drawn_outlines(shapes)
        if not closed:
            raise ValueError(
                f"{name} has no closed contour, but methods are compared from closed lines: close its contours, or add "
                "--circle ROW,COL,RADIUS."
            )
        _report_open_starts(name, shapes)
        found += closed
    return Start(tuple(found), around=arguments.around)


def _report_open_starts(where: str, shapes: Sequence[Shape]) -> None:
    """Report how many starts are left out since they enclose nothing."""
    if loose := len(shapes) - len(drawn_outlines(shapes)):
        what = format_count(loose, "start without an inside", "starts without an inside")
        print_message(f"{where}: {what} left out, as most of the methods need one.")
