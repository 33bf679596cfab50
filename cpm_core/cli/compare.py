"""``cpm compare``: runs several methods on an image and reports what each has found, and in what time."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.cli.arguments import add_image, add_json, add_session, as_steps, notes_on
from cpm_core.cli.inputs import (
    add_part,
    as_number,
    check_kept,
    image_of,
    numbers_in,
    part_of,
    part_of_volume,
    reading_of,
    session_of,
    starts_from_file,
    truth_for,
    volume_truth_for,
)
from cpm_core.cli.outcome import Files, tell
from cpm_core.cli.terminal import announce_compilation, say
from cpm_core.contours.ground_truth import Truth
from cpm_core.contours.surface.ground_truth import VolumeTruth
from cpm_core.formats import load_image, load_volume
from cpm_core.formats.animations.comparison import Tile, check_comparison, files_of, write_comparison
from cpm_core.formats.contours.contour_file import CONTOURS_READABLE
from cpm_core.formats.sessions.session_file import SessionFile
from cpm_core.image.colors import LUMINANCE
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array
from cpm_core.objects.methods import (
    CONTOUR_METHODS,
    Compared,
    Facts,
    Settings,
    Start,
    facts_of,
    method_named,
    run_method,
    runnable,
)
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.parameters.quotation import counted, shown
from cpm_core.shapes import Barrier, Charge, Circle, Region, Shape
from cpm_core.shapes.document_shapes import check_axes, starts_of
from cpm_core.shapes.outlines import outlines_of

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


def _compare(arguments: argparse.Namespace) -> int:
    """Run the methods; every check that needs no image comes first."""
    session = session_of(arguments)
    compared = Compared(()) if session.comparison == Compared() else session.comparison
    spheres = spheres_drawn(arguments)
    ndim = 3 if spheres else 2
    named = arguments.methods or [name for name in compared.methods if name]
    names = _methods(named, ndim)
    settings = chosen_settings(arguments, names, _ours(arguments, session, ndim), compared)
    max_steps = as_steps(arguments.max_steps)
    outlines = () if spheres else outlines_drawn(arguments, session)
    for path in arguments.export:
        check_comparison(path, names, ndim)
    files = [file for path in arguments.export for file in files_of(Path(path), names)]
    check_kept(files, arguments)
    truth: Truth | VolumeTruth | None
    if spheres:
        image = _volume(arguments)
        start, truth = start_in_volume(image, spheres, arguments), volume_truth_for(arguments, image)
    else:
        image = _image(arguments, session, files)
        check_axes(session.shapes, image.shape, image.source)
        start, truth = start_on(image, outlines, arguments, session), truth_for(arguments, image)
    for method in () if named else CONTOUR_METHODS.values():
        if method.missing and (ndim == 2 or method.in_volumes):
            say(f"cpm: {method.missing}")
    announce_compilation()
    tiles = []
    for name in names:
        moment = run_method(CONTOUR_METHODS[name], image, start, settings[name], max_steps)
        facts = facts_of(moment, truth)
        if not facts.stop_reason:
            facts = replace(facts, stop_reason=f"stopped after {counted(facts.steps, 'step')}, as asked")
        tiles.append(Tile(moment.state.contours, facts, settings[name], moment.state.surface))
        if not arguments.json:
            _tell(facts, truth, first=len(tiles) == 1)
    shown_truth = truth if isinstance(truth, Truth) else None
    written = Files()
    found = write_comparison(
        image, start, tiles, arguments.export, lambda said: say(f"cpm: {said}"), shown_truth, written.refuse
    )
    written.written += map(str, found)
    written.check()
    _report(image, start, [tile.facts for tile in tiles], truth, written, as_json=arguments.json)
    return written.status()


def _methods(named: Sequence[str], ndim: int) -> list[str]:
    """The methods that are named, or all that can run."""
    for name in named:
        method = method_named(name)
        method.check()
        if ndim == 3 and not method.in_volumes:
            raise ValueError(f"{method.title} is for images: in a volume choose among {', '.join(runnable(ndim))}.")
    return list(dict.fromkeys(named or runnable(ndim)))


def _ours(arguments: argparse.Namespace, session: SessionFile, ndim: int) -> Parameters | None:
    """The parameters of the particles, unless some are set; None for their defaults."""
    if arguments.session:
        return session.parameters
    return PRESETS["volume"] if ndim == 3 else None


def _report(
    image: Image,
    start: Start,
    rows: Sequence[Facts],
    truth: Truth | VolumeTruth | None,
    files: Files,
    *,
    as_json: bool,
) -> None:
    source = None if truth is None else truth.source
    given = {"image": image.source, "around": start.around, "truth": source, "unit": _unit(truth)}
    plain = [{name: _finite(value) for name, value in asdict(row).items()} for row in rows]
    tell("compare", {**given, "methods": plain, "not_written": files.refused}, (), files.written, as_json=as_json)


def _finite(value: object) -> object:
    """A value as JSON can hold it: an infinite distance is null."""
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _tell(row: Facts, truth: Truth | VolumeTruth | None, *, first: bool) -> None:
    """Print a line of the table, before the first its head."""
    if first:
        scores = f"{'Dice':>7}{'F':>7}{'Hausdorff':>12}{'mean dist.':>12}" if truth else ""
        print(f"{'':{_WIDTH}}{'steps':>7}{'time':>10}{scores}{'contours':>10}{'closed':>8}  end")
    agree = ""
    if row.dice is not None and row.f is not None:
        agree = (
            f"{row.dice:7.3f}{row.f:7.3f}{_away(row.hausdorff, 1, truth):>12}{_away(row.mean_distance, 2, truth):>12}"
        )
    counts = f"{row.contours:10}{row.closed:8}"
    title, time = CONTOUR_METHODS[row.method].title, f"{row.seconds:.2f} s"
    print(f"{title:{_WIDTH}}{row.steps:7}{time:>10}{agree}{counts}  {row.stop_reason}", flush=True)


def _away(distance: float | None, digits: int, truth: Truth | VolumeTruth | None) -> str:
    return "" if distance is None else f"{distance:.{digits}f} {_unit(truth)}" if np.isfinite(distance) else "-"


def _unit(truth: Truth | VolumeTruth | None) -> str:
    """Unit of distances: pixels of an image, or that of the sides of a voxel."""
    return (truth.unit or "vx") if isinstance(truth, VolumeTruth) else "px"


def _volume(arguments: argparse.Namespace) -> Image:
    volume = load_volume(arguments.image, **part_of_volume(arguments))
    for note in volume.notes:
        say(f"cpm: {volume.source}: {note}")
    if not np.allclose(volume.spacing, volume.spacing[0], rtol=1e-3):
        say(f"cpm: {volume.source}: its voxels are no cubes, but methods other than the particles take them for cubes.")
    return volume


def _image(arguments: argparse.Namespace, session: SessionFile, files: Sequence[Path]) -> Image:
    part = part_of(arguments)
    path, notes = image_of(arguments.image, session, arguments.session)
    check_kept(files, arguments, path)
    image = load_image(path, **(reading_of(arguments.image, session, path) | part))
    channel = arguments.channel or session.parameters.channel
    for note in (*session.notes, *notes, *notes_on(image, replace(session.parameters, channel=channel))):
        say(f"cpm: {image.source}: {note}")
    if image.colors is not None and channel != LUMINANCE:
        image = replace(image, values=image.gray(channel), colors=None)
    if image.ndim != 2:
        raise ValueError(
            f"{image.source} is a volume, but this start is for images: take a plane, --page N, or add --sphere "
            "PLANE,ROW,COL,RADIUS."
        )
    return image


_OURS = tuple(name for name, method in CONTOUR_METHODS.items() if method.of_particles)
"""The methods whose settings are the parameters of a run."""


def add_settings(parser: argparse._ActionsContainer) -> None:
    """Add settings, as `set`, and the preset of the particles, as `preset`; see `chosen_settings`."""
    parser.add_argument(
        "--set",
        metavar="METHOD.NAME=VALUE",
        nargs="+",
        action="extend",
        default=[],
        help="settings of methods, such as gac.balloon=0.5 cpm.smoothing=2; of "
        + "; of ".join(
            f"{name}: {', '.join(_names(name))}" for name, method in CONTOUR_METHODS.items() if not method.of_particles
        )
        + f"; of {' and '.join(_OURS)}: the parameters of cpm run",
    )
    parser.add_argument("--preset", choices=tuple(PRESETS), help=f"named settings of {' and '.join(_OURS)}")


def chosen_settings(
    arguments: argparse.Namespace, methods: Sequence[str], ours: Parameters | None, compared: Compared
) -> dict[str, Any]:
    """The settings of each of some methods: those of a comparison, `ours` of the particles if given, and what was set.

    Raises
    ------
    ValueError
        When a setting is of another form, of a method that is not compared, unknown, or out of its range.
    """
    base = PRESETS[arguments.preset] if arguments.preset else ours
    found: dict[str, Any] = {
        name: base if base is not None and CONTOUR_METHODS[name].of_particles else compared.settings_of(name)
        for name in methods
    }
    changes: dict[str, dict[str, Any]] = {}
    for text in arguments.set:
        place, equals, value = text.partition("=")
        method, dot, name = place.partition(".")
        if not (equals and dot and name and value):
            raise ValueError(f"--set is {shown(text)} but must be METHOD.NAME=VALUE, such as gac.balloon=0.5.")
        if method not in found:
            raise ValueError(f"--set {shown(text)} is for {shown(method)}, which is none of the methods compared.")
        if name not in _names(method):
            raise ValueError(f"{shown(name)} is no setting of {method}: choose among {', '.join(_names(method))}.")
        changes.setdefault(method, {})[name] = as_number(value)
    return {name: replace(settings, **changes.get(name, {})) for name, settings in found.items()}


def _names(method: str) -> tuple[str, ...]:
    """Names of the settings of a method."""
    kind = CONTOUR_METHODS[method].settings
    return tuple(kind.table()) if issubclass(kind, Settings) else tuple(Parameters.__dataclass_fields__)


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
