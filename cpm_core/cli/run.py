"""``cpm run``: finds the contours of an image, those on the pages of a stack, or a surface in a volume."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.cli.arguments import (
    EXPORTED,
    add_export,
    add_image,
    add_max_steps,
    add_parameters,
    add_part,
    add_preset,
    add_session,
    add_space,
    check_exports,
    numbers_of,
    parameters_of,
    part_of,
    places_in,
    whole_number,
)
from cpm_core.cli.inputs import fitted, image_of, in_volume, reviewed, session_of, starts_from_file, truth_for
from cpm_core.cli.output import (
    Files,
    StatusLine,
    announce_compilation,
    facts_of_run,
    facts_on_place,
    lines_on_place,
    longest,
    report,
    say,
)
from cpm_core.cli.pages import StackRun, add_pages, check_pages, run_pages
from cpm_core.contours.agreement import compare
from cpm_core.contours.ground_truth import Truth, VolumeTruth
from cpm_core.contours.result import Result
from cpm_core.contours.surface_agreement import compare_surface
from cpm_core.field.edge_map import edge_map
from cpm_core.formats import (
    CONTOURS_READABLE,
    FOR_CENTERLINES,
    FOR_VOLUMES,
    SURFACES_READABLE,
    left_out,
    load_image,
    load_points,
    load_volume,
    suffix_of,
)
from cpm_core.formats.common.atomic import check_place
from cpm_core.formats.common.provenance import ENTRY, facts_of, plain_shapes, with_shapes
from cpm_core.formats.images.reading import Reading
from cpm_core.formats.sessions.recorded_run import Recorder, with_run
from cpm_core.formats.sessions.session_file import SUFFIX, ImageFile, SessionFile, save_session
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions, VolumeRegions
from cpm_core.model.state import State
from cpm_core.numerics.types import Array
from cpm_core.objects import Selection, objects_result, partition
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.parameters.quotation import counted, sized
from cpm_core.reconstruction.curve.closing import close_contours
from cpm_core.segmentation.evolve import segment
from cpm_core.shapes import KINDS, Barrier, Circle, Everywhere, Points, Region, Shape, Sphere, Stroke
from cpm_core.shapes.document_shapes import charges_of, regions_of, seeds_on, starts_of

_CLOSE = "Add --close to close those whose ends are near each other."

_FORMS = {
    2: {
        "circle": "ROW,COL,RADIUS",
        "stroke": "ROW,COL,...",
        "region": "ROW,COL,...",
        "barrier": "ROW,COL,...",
        "object": "ROW,COL",
        "not": "ROW,COL",
    },
    3: {
        "sphere": "PLANE,ROW,COL,RADIUS",
        "stroke": "PLANE,ROW,COL,...",
        "region": "PLANE,ROW,COL,PLANE,ROW,COL",
        "barrier": "PLANE,ROW,COL,PLANE,ROW,COL",
        "object": "PLANE,ROW,COL",
        "not": "PLANE,ROW,COL",
    },
}
"""Forms of what is drawn on the command line, by the number of axes and the option."""

Drawn = Mapping[str, Sequence[tuple[float, ...]]]
"""Numbers of what is drawn on the command line, by option."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_image(parser, optional=True)
    add_session(parser)
    part = parser.add_argument_group("part of a file")
    add_part(part)
    add_pages(part)
    start = parser.add_argument_group("start (one at least, of a session or here; several add up)")
    place = parser.add_argument_group("place (each may be repeated)")
    named = parser.add_argument_group("object (each may be repeated)")
    line = "ROW,COL,ROW,COL,..."
    for group, flag, form, meaning in (
        (start, "--circle", "ROW,COL,RADIUS", "a circle, in px"),
        (start, "--sphere", "PLANE,ROW,COL,RADIUS", "a sphere in a volume, in voxels; IMAGE is then a volume"),
        (start, "--stroke", line, "a stroke from point to point"),
        (start, "--points", "FILE.csv", "points: row,col on each line"),
        (start, "--start", "FILE", f"the contours of a file ({', '.join(CONTOURS_READABLE)}, or a label mask); in a "
         f"volume a surface, labels or center lines ({', '.join((*SURFACES_READABLE, *FOR_CENTERLINES))})"),
        (place, "--region", line, "corners of a polygon that particles stay in, in px; in a volume of a box"),
        (place, "--barrier", line, "vertices of a line that no particle crosses, in px; in a volume a point of a plane "
         "and the direction across it"),
        (named, "--object", "ROW,COL", "a place inside an object, in px; its boundary is closed, and written instead "
         "of the contours (all places lie in one object; without a start, particles start everywhere)"),
        (named, "--not", "ROW,COL", "a place outside the object, in px"),
    ):  # fmt: skip
        group.add_argument(flag, metavar=form, action="append", default=[], help=meaning)
    start.add_argument("--volume", action="store_true", help="IMAGE is a volume; places are then PLANE,ROW,COL")
    start.add_argument("--auto", choices=KINDS, help="everywhere, on the strongest edges, or midway between edges")
    parameters = parser.add_argument_group("parameters")
    add_preset(parameters, "the publication's values, or the session's")
    add_parameters(parameters)
    outcome = parser.add_argument_group("outcome")
    add_max_steps(outcome)
    outcome.add_argument(
        "--faces", metavar="N", type=whole_number(4), help="triangles that are left of the surface in a volume"
    )
    add_space(outcome)
    add_export(outcome, f"the contours {EXPORTED}")
    outcome.add_argument(
        "--close",
        nargs="?",
        choices=("edges", "straight"),
        const="edges",
        help="close open contours whose ends are near each other, along the edges of the image or straight",
    )
    outcome.add_argument(
        "--truth", metavar="FILE", help="compare with a ground truth: a mask, contours, or a label volume"
    )
    outcome.add_argument(
        "--save-session", metavar="FILE", help=f"write a session ({SUFFIX}) that the window opens with these contours"
    )


def run(arguments: argparse.Namespace) -> int:
    """Find contours or a surface; every check that needs no image comes first."""
    session = session_of(arguments)
    of_volumes = {*SURFACES_READABLE, *FOR_CENTERLINES}
    volume = bool(
        arguments.sphere
        or arguments.volume
        or in_volume(session)
        or any(Path(path).suffix.lower() in of_volumes for path in arguments.start)
    )
    _check_options(arguments, session, volume)
    drawn: Drawn = {
        name: [numbers_of(f"--{name}", text, form) for text in getattr(arguments, name)]
        for name, form in _FORMS[3 if volume else 2].items()
    }
    if drawn["not"] and not drawn["object"]:
        raise ValueError("--not is given without --object: name a place inside the object as well.")
    preset = arguments.preset or ("volume" if volume and not arguments.session else None)
    part = part_of(arguments, volume=volume)
    parameters = parameters_of(arguments, PRESETS[preset] if preset else session.parameters)
    path, reading = image_of(arguments.image, session, arguments.session)
    if arguments.pages is None:
        check_exports(arguments.export, arguments, path)
    else:
        check_pages(arguments, path)
        reading.pop("page", None)
    if arguments.pages is not None:
        shapes = _flat_shapes(drawn, arguments)
        order = StackRun(
            path,
            reading | part,
            parameters,
            lambda image: _seeds(arguments, session, image, parameters, shapes),
            (*plain_shapes((*session.shapes, *shapes)), *_files_drawn(arguments)),
            arguments.max_steps,
            regions_of((*session.shapes, *shapes), session.objects.barriers),
            charges_of(session.shapes),
        )
        return run_pages(arguments, order)
    return _run_image(arguments, session, path, reading | part, parameters, drawn)


def _run_image(
    arguments: argparse.Namespace,
    session: SessionFile,
    path: Path,
    part: Mapping[str, Any],
    parameters: Parameters,
    drawn: Drawn,
) -> int:
    """Find the contours of one image, or the surface in one volume."""
    volume = "sphere" in drawn
    image = (load_volume if volume else load_image)(path, **part)
    parameters = fitted(image, parameters, scales=arguments.scales is None)
    truth = truth_for(arguments, image)
    started = time.perf_counter()
    shapes = _shapes_in(image, drawn, arguments) if volume else _flat_shapes(drawn, arguments)
    limits = _planes(drawn, session) if volume else None
    seeds = _seeds(arguments, session, image, parameters, shapes)
    announce_compilation()
    recorder = Recorder()
    with StatusLine() as line:

        def follow(state: State) -> None:
            recorder(state)
            line.show_state(state)

        found = segment(
            image,
            seeds,
            parameters,
            max_steps=arguments.max_steps,
            progress=follow,
            regions=limits or regions_of((*session.shapes, *shapes), session.objects.barriers),
            charges=charges_of(session.shapes),
        )
    made = with_shapes(found, (*session.shapes, *shapes), _files_drawn(arguments))
    chosen: Selection | None = None
    if volume:
        result = shown = _surface(made, drawn, arguments.faces)
    else:
        result = shown = _contours(made, image, parameters, session, arguments)
        if drawn["object"]:
            chosen = _chosen(result, image, drawn)
            shown = _as_result(chosen, result, image)
    seconds = time.perf_counter() - started
    files = Files()
    files.export(shown, arguments.export, image=path, space=arguments.space or "LPS", warn=_say_omission)
    if arguments.save_session is not None:
        whole = _saved(arguments, session, image, path, part, parameters, shapes)
        with files.writing(arguments.save_session):
            save_session(with_run(whole, recorder), Path(arguments.save_session))
    status = files.status(_CLOSE if any(left_out(shown, suffix_of(path)) for path in files.refused) else "")
    facts, lines = _on_surface(result, seconds) if volume else _on_contours(result, chosen, seconds)
    if not volume:
        written = [path for path in files.written if path in arguments.export]
        facts["left_out"] = {path: left_out(shown, suffix_of(path)) for path in written}
    if truth is not None:
        facts["truth"] = _agreement(shown, truth)
        lines.append(_sentence_on(facts["truth"]))
    report("run", facts, lines, files, as_json=arguments.json)
    return status


def _check_options(arguments: argparse.Namespace, session: SessionFile, volume: bool) -> None:
    """Raise ValueError for options that have no meaning for this run."""
    others = ("circle", "close", "pages", "save_session") if volume else ("space", "faces")
    for name in others:
        if getattr(arguments, name):
            kind, here = ("images", "a volume is run") if volume else ("volumes", "an image is run")
            raise ValueError(f"--{name.replace('_', '-')} is for {kind}, but {here}: leave it out.")
    given = [*arguments.circle, *arguments.sphere, *arguments.stroke, *arguments.points, *arguments.start]
    if not (given or arguments.auto or starts_of(session.shapes) or (arguments.object and not volume)):
        if session.mode == "skeleton":
            raise ValueError("The session is about a skeleton and has no start: use cpm skeleton IMAGE --export PATH.")
        raise ValueError(
            "No start is given: add --circle ROW,COL,RADIUS (in a volume --sphere PLANE,ROW,COL,RADIUS), "
            "--stroke ROW,COL,ROW,COL,..., --points FILE.csv, --start FILE or --auto grid, or name a place inside an "
            "object, --object ROW,COL."
        )
    for path in arguments.export if volume else ():
        if suffix_of(path) not in FOR_VOLUMES:
            raise ValueError(f"{path} is for contours, but a volume has a surface: end its name in .ply or .stl.")
    if arguments.save_session is not None:
        if Path(arguments.save_session).suffix.lower() != SUFFIX:
            raise ValueError(f"--save-session is {arguments.save_session} but must end in {SUFFIX}.")
        check_place(Path(arguments.save_session))


def _flat_shapes(drawn: Drawn, arguments: argparse.Namespace) -> tuple[Shape, ...]:
    """The shapes that are drawn on the command line, in an image."""
    return (
        *(Circle((row, col), radius) for row, col, radius in drawn["circle"]),
        *(Stroke(places_in(numbers, 2)) for numbers in drawn["stroke"]),
        *(Points(tuple(map(tuple, load_points(path).tolist()))) for path in arguments.points),
        *(Region(places_in(numbers, 2)) for numbers in drawn["region"]),
        *(Barrier(places_in(numbers, 2)) for numbers in drawn["barrier"]),
        *([Everywhere(arguments.auto)] if arguments.auto else []),
    )


def _shapes_in(volume: Image, drawn: Drawn, arguments: argparse.Namespace) -> tuple[Shape, ...]:
    """The starts that are drawn on the command line, in a volume."""
    return (
        *(Sphere.round(tuple(center), radius, volume.spacing) for *center, radius in drawn["sphere"]),
        *(Stroke(places_in(numbers, 3)) for numbers in drawn["stroke"]),
        *(Points(tuple(map(tuple, load_points(path, 3).tolist()))) for path in arguments.points),
        *([Everywhere(arguments.auto)] if arguments.auto else []),
    )


def _planes(drawn: Drawn, session: SessionFile) -> AnyRegions | None:
    """Boxes of interest and planes that are barriers, with the limits of a session; None where none is drawn."""
    if not (drawn["region"] or drawn["barrier"]):
        return None
    saved = regions_of(session.shapes, session.objects.barriers)
    before = saved if isinstance(saved, VolumeRegions) else VolumeRegions()
    boxes, planes = (
        tuple(((a, b, c), (d, e, f)) for a, b, c, d, e, f in drawn[name]) for name in ("region", "barrier")
    )
    return VolumeRegions((*before.interest, *boxes), (*before.barriers, *planes))


def _files_drawn(arguments: argparse.Namespace) -> list[dict[str, Any]]:
    """The files whose contours a run starts from, as session files hold shapes."""
    return [{"shape": "points", "file": Path(path).name} for path in arguments.start]


def _seeds(
    arguments: argparse.Namespace,
    session: SessionFile,
    image: Image,
    parameters: Parameters,
    drawn: Sequence[Shape],
) -> Array:
    """All seeds on an image: those of the session, those drawn, and those of files."""
    shapes = (*session.shapes, *drawn, *(start for path in arguments.start for start in starts_from_file(path, image)))
    if not starts_of(shapes):  # an object alone is named
        shapes = (*shapes, Everywhere("grid"))
    return seeds_on(image, shapes, parameters.smoothing, parameters.channel)


def _contours(
    found: Result, image: Image, parameters: Parameters, session: SessionFile, arguments: argparse.Namespace
) -> Result:
    """The result of a run after all that a session says of its contours, with open ones closed as asked."""
    result = reviewed(found, image, parameters, session, kept=arguments.image is None)
    if arguments.close is None:
        return result
    edges = edge_map(image.gray(parameters.channel), parameters.smoothing) if arguments.close == "edges" else None
    return close_contours(result, edges)


def _surface(found: Result, drawn: Drawn, faces: int | None) -> Result:
    """The result with the surface of the bodies alone that places lie in, and with fewer triangles as asked."""
    if drawn["object"]:
        chosen = partition(found).select(drawn["object"], drawn["not"])
        if not len(chosen.surface.faces):
            raise ValueError("There is no object at this place: name one that the surface encloses.")
        found = replace(found, surface=chosen.surface)
    if faces is None or found.surface is None:
        return found
    surface = found.surface.decimated(faces)
    if len(surface.faces) > faces:
        say(f"{len(surface.faces)} triangles are left, not {faces}: with fewer the surface would lose its shape.")
    return replace(found, surface=surface)


def _chosen(result: Result, image: Image, drawn: Drawn) -> Selection:
    """The object that places lie in; ValueError when there is none."""
    for place in drawn["object"]:
        if not all(-0.5 <= at <= side - 0.5 for at, side in zip(place, image.shape, strict=True)):
            at = ",".join(f"{number:g}" for number in place)
            raise ValueError(f"--object is {at} but lies outside the image, which has {sized(image.shape)}.")
    chosen: Selection = partition(result).select(np.array(drawn["object"]), np.array(drawn["not"]))
    if not chosen.mask.any():
        raise ValueError("There is no object at this place: name another one inside it.")
    return chosen


def _as_result(chosen: Selection, result: Result, image: Image) -> Result:
    """A result with the boundary of an object."""
    found = objects_result([chosen], image, channel=result.channel)
    shapes = (*result.provenance.shapes, *found.provenance.shapes)
    return replace(found, provenance=replace(result.provenance, method="objects", shapes=shapes))


def _saved(
    arguments: argparse.Namespace,
    session: SessionFile,
    image: Image,
    path: Path,
    part: Mapping[str, Any],
    parameters: Parameters,
    drawn: Sequence[Shape],
) -> SessionFile:
    """The session of a run, without the run itself."""
    files = (start for given in arguments.start for start in starts_from_file(given, image))
    shapes = (*session.shapes, *drawn, *files)
    if not starts_of(shapes):
        shapes = (*shapes, Everywhere("grid"))
    spacing = part.get("spacing")
    if spacing is not None:
        part = {**part, "spacing": tuple(np.atleast_1d(spacing).tolist())}
    own = arguments.image is None
    return replace(
        session,
        image=ImageFile(str(path.absolute()), image.sha256, image.shape, reading=Reading(**part)),
        shapes=shapes,
        parameters=parameters,
        marks=session.marks if own else (),
        hand_edits=session.hand_edits if own else (),
        view=session.view if own else {},
        pages={},
        notes=(),
    )


def _say_omission(sentence: str) -> None:
    say(f"{sentence} {_CLOSE[:-1]}, or write SVG, GeoJSON or CSV.")


def _on_contours(result: Result, chosen: Selection | None, seconds: float) -> tuple[dict[str, Any], list[str]]:
    """What is said of contours, as values by name and as sentences."""
    facts: dict[str, Any] = {**facts_of_run(result, seconds), "bridges": len(result.bridges), ENTRY: facts_of(result)}
    lines = [f"{result.source}: {counted(len(result.contours), 'contour')} ({facts['closed']} closed)"]
    lines += longest(
        result.contours,
        lambda contour: (
            f"length {contour.length:.1f} px, "
            + (f"closed, area {contour.area:.1f} px²" if contour.closed else "open")
            + f", strength {contour.strength:.3g}"
        ),
    )
    if chosen is not None:
        on_object = {
            "area": sum(-contour.area if contour.hole else contour.area for contour in chosen.contours),
            "perimeter": sum(contour.length for contour in chosen.contours),
            "bridged": sum(contour.bridged for contour in chosen.contours),
            "confidence": chosen.confidence,
        }
        counts = {"holes": sum(contour.hole for contour in chosen.contours), "gaps": len(chosen.gaps)}
        facts["objects"] = [{name: round(value, 4) for name, value in on_object.items()} | counts]
        lines.append(
            "Object: area {area:.1f} px², perimeter {perimeter:.1f} px, {bridged:.1f} px of it across gaps, confidence "
            "{confidence:.2f}".format(**on_object)
        )
    if result.bridges:
        farthest = max(bridge.length for bridge in result.bridges)
        lines.append(f"Bridged {counted(len(result.bridges), 'gap')}, longest {farthest:.1f} px")
    return facts, [*lines, *_on_run(result, seconds)]


def _on_surface(result: Result, seconds: float) -> tuple[dict[str, Any], list[str]]:
    """What is said of a surface, as values by name and as sentences."""
    surface = result.surface
    vertices, faces = (0, 0) if surface is None else (len(surface.vertices), len(surface.faces))
    facts: dict[str, Any] = {
        **facts_of_run(result, seconds),
        "vertices": vertices,
        "faces": faces,
        "volume": round(surface.volume, 3) if surface is not None and surface.closed else None,
        "area": round(surface.area, 3) if surface is not None else None,
    }
    lines = [f"{result.source}: a surface of {counted(faces, 'triangle')}, with {vertices} corners"]
    lines += _on_run(result, seconds)
    if result.image is not None:
        facts |= facts_on_place(result.image)
        lines += lines_on_place(result.image)
    return facts, lines


def _on_run(result: Result, seconds: float) -> Iterator[str]:
    yield f"{counted(len(result.particles), 'particle')}, {counted(result.steps, 'step')} in {seconds:.2f} s"
    yield f"Stopped: {result.stop_reason}"


def _agreement(result: Result, truth: Truth | VolumeTruth) -> dict[str, Any]:
    """How well contours, or a surface, agree with a ground truth, as values by name."""
    on_volume = isinstance(truth, VolumeTruth)
    found: Any = (
        compare_surface(result.surface, truth) if isinstance(truth, VolumeTruth) else compare(result.contours, truth)
    )
    measures = ["dice", "jaccard", "precision", "recall", "f", "hausdorff"] + (["hausdorff95"] if on_volume else [])
    values = {name: getattr(found, name) for name in measures} | {"mean_distance": found.mean_boundary_distance}
    finite = {name: round(value, 6) if math.isfinite(value) else None for name, value in values.items()}
    return {"source": truth.source, **finite} | ({"unit": truth.unit} if isinstance(truth, VolumeTruth) else {})


def _sentence_on(agreed: Mapping[str, Any]) -> str:
    """The agreement as a sentence."""
    unit = agreed.get("unit", "px") or "voxels"
    dice = "not known" if agreed["dice"] is None else f"{agreed['dice']:.3f}"
    away = ""
    if agreed["hausdorff"] is not None:
        away = f", {agreed['mean_distance']:.2g} {unit} apart on average, {agreed['hausdorff']:.1f} {unit} at most"
    return f"Beside {agreed['source']}: Dice {dice}, F {agreed['f']:.3f}{away}"
