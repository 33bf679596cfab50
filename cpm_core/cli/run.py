"""``cpm run``: finds the contours of an image, those on the pages of a stack, or a surface in a volume."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from cpm_core.cli.arguments import (
    EXPORT_FORMATS_HELP,
    PART_OPTIONS,
    add_options,
    add_parameter_options,
    check_exports,
    check_targets,
    group_coordinates,
    parse_number_list,
    parse_parameters,
    parse_part,
    refuse_options,
)
from cpm_core.cli.inputs import (
    apply_session_review,
    fit_parameters,
    is_volume_session,
    load_named_session,
    load_named_truth,
    locate_image,
    read_starts,
    segment_shapes,
)
from cpm_core.cli.large import is_large, is_large_volume, run_large
from cpm_core.cli.output import (
    OutputFiles,
    StatusLine,
    collect_geometry_facts,
    collect_run_facts,
    describe_contour_count,
    describe_geometry,
    ensure_compiled,
    list_longest,
    print_message,
    print_report,
)
from cpm_core.cli.pages import run_pages
from cpm_core.contours.agreement import compare
from cpm_core.contours.ground_truth import Truth, VolumeTruth
from cpm_core.contours.result import Result
from cpm_core.contours.surface_agreement import compare_surface
from cpm_core.formats import (
    CENTERLINES_WRITABLE,
    CONTOURS_READABLE,
    SURFACES_READABLE,
    VOLUMES_WRITABLE,
    count_left_out,
    find_format_suffix,
    load_image,
    load_points,
    load_volume,
)
from cpm_core.formats.common.atomic import check_target, check_writable
from cpm_core.formats.common.provenance import PROVENANCE_KEY, describe_provenance, describe_shapes, record_drawn_shapes
from cpm_core.formats.images.reading import Reading
from cpm_core.formats.sessions.recorded_run import RunRecorder, add_recorded_run
from cpm_core.formats.sessions.session_file import SESSION_SUFFIX, ImageFile, SessionFile, save_session
from cpm_core.formats.stack_files import STACKS_WRITABLE
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions, VolumeRegions
from cpm_core.model.state import State
from cpm_core.numerics.polyline import as_line
from cpm_core.numerics.types import JsonDict, JsonObject
from cpm_core.objects import Partition, Selection, VolumePartition, objects_result, select_all
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.parameters.formatting import format_count, format_size
from cpm_core.shapes import SEEDING_KINDS, Barrier, Circle, Everywhere, Points, Region, Shape, Sphere, Stroke
from cpm_core.shapes.document_shapes import collect_charges, collect_regions, compute_seeds, select_starts

_CLOSE_ADVICE = "Name an object by --object ROW,COL, whose boundary is closed."
"""Advice where a format cannot hold open contours."""

_MAX_PRINTED_OBJECTS = 10
"""Largest number of objects that are printed one by one."""

DrawnNumbers = Mapping[str, Sequence[tuple[float, ...]]]
"""Numbers that the drawing options were given, by option."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_options(parser, "image", nargs="?")
    add_options(parser, "--session")
    part = parser.add_argument_group("part of a file")
    add_options(part, *PART_OPTIONS)
    part.add_argument(
        "--pages",
        metavar="all|N-M,...",
        help="run each of these pages of a stack as an image of its own, in this order",
    )
    part.add_argument(
        "--follow", action="store_true", help="start each page from the contours of the one before, not from the start"
    )
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
         f"volume a surface, labels or center lines ({', '.join((*SURFACES_READABLE, *CENTERLINES_WRITABLE))})"),
        (place, "--region", line, "corners of a polygon that particles stay in, in px; in a volume of a box"),
        (place, "--barrier", line, "vertices of a line that no particle crosses, in px; in a volume a point of a plane "
         "and the direction across it"),
        (named, "--object", "ROW,COL", "a place inside an object, in px; its boundary is closed, and written instead "
         "of the contours (all places lie in one object; without a start, particles start everywhere); with --pages on "
         "the first of them, and --follow finds it on the others"),
        (named, "--not", "ROW,COL", "a place outside the object, in px"),
    ):  # fmt: skip
        group.add_argument(flag, metavar=form, action="append", default=[], help=meaning)
    named.add_argument(
        "--objects",
        action="store_true",
        help="all objects: those that closed contours enclose, and what lies between contours and is likely one; they "
        "are written instead of the contours (without a start, particles start everywhere)",
    )
    start.add_argument("--volume", action="store_true", help="IMAGE is a volume; places are then PLANE,ROW,COL")
    start.add_argument(
        "--auto", choices=SEEDING_KINDS, help="everywhere, on the strongest edges, or midway between edges"
    )
    parameters = parser.add_argument_group("parameters")
    add_options(parameters, "--preset", help="named settings (default: the publication's values, or the session's)")
    add_parameter_options(parameters)
    where = parser.add_argument_group("where an image of OME-Zarr is run, which --auto does chunk by chunk")
    add_options(where.add_mutually_exclusive_group(), "--workers", "--scheduler")
    outcome = parser.add_argument_group("outcome")
    add_options(outcome, "--max-steps")
    add_options(outcome, "--space")
    add_options(outcome, "--export", help=f"write the contours {EXPORT_FORMATS_HELP}")
    outcome.add_argument(
        "--truth", metavar="FILE", help="compare with a ground truth: a mask, contours, or a label volume"
    )
    outcome.add_argument(
        "--save-session",
        metavar="FILE",
        help=f"write a session ({SESSION_SUFFIX}) that the window opens with these contours",
    )


def run_segmentation(arguments: argparse.Namespace) -> int:
    """Find contours or a surface; every check that needs no image comes first."""
    session = load_named_session(arguments)
    of_volumes = {*SURFACES_READABLE, *CENTERLINES_WRITABLE}
    volume = bool(
        arguments.sphere
        or arguments.volume
        or is_volume_session(session)
        or is_large_volume(arguments)
        or any(Path(path).suffix.lower() in of_volumes for path in arguments.start)
    )
    _check_options(arguments, session, volume)
    place = "PLANE,ROW,COL" if volume else "ROW,COL"
    forms = {
        "sphere" if volume else "circle": f"{place},RADIUS",
        "stroke": f"{place},...",
        **dict.fromkeys(("region", "barrier"), f"{place},{place if volume else '...'}"),
        **dict.fromkeys(("object", "not"), place),
    }
    drawn: DrawnNumbers = {
        name: [parse_number_list(f"--{name}", text, form) for text in getattr(arguments, name)]
        for name, form in forms.items()
    }
    if drawn["not"] and not drawn["object"]:
        raise ValueError("--not is given without --object: name a position inside the object as well.")
    if arguments.objects:
        refuse_options(arguments, ("object", "pages"), "one object, or a stack, but --objects finds all of an image")
    preset = arguments.preset or ("volume" if volume and not arguments.session else None)
    part = parse_part(arguments, volume=volume)
    parameters = parse_parameters(arguments, PRESETS[preset] if preset else session.parameters)
    path, reading = locate_image(arguments.image, session, arguments.session)
    if is_large(arguments, path):
        return run_large(arguments, path, reading | part, parameters, volume=volume)
    refuse_options(arguments, ("scheduler", "workers"), "images in folders of Zarr that are run everywhere, by --auto")
    if arguments.pages is None:
        check_exports(arguments.export, arguments, path)
        return _run_image(arguments, session, path, reading | part, parameters, drawn)
    if drawn["object"] and not arguments.follow:
        raise ValueError("--object is on the first of the pages: add --follow, which finds the object on the others.")
    refuse_options(arguments, ("page", "truth", "save_session"), "one image, but --pages runs several")
    for target in arguments.export:
        check_target(target, STACKS_WRITABLE, "for all pages of a stack")
    check_targets(arguments.export, arguments, path)
    reading.pop("page", None)
    shapes = _build_drawn_shapes(drawn, arguments)
    return run_pages(
        arguments,
        path,
        reading | part,
        parameters,
        lambda image: compute_seeds(
            image, _collect_run_shapes(arguments, session, image, shapes), parameters.smoothing, parameters.channel
        ),
        prompt_points=(drawn["object"], drawn["not"]),
        drawn=(*describe_shapes((*session.shapes, *shapes)), *_list_start_files(arguments)),
        regions=collect_regions((*session.shapes, *shapes), session.objects.barriers),
        charges=collect_charges(session.shapes),
    )


def _run_image(
    arguments: argparse.Namespace,
    session: SessionFile,
    path: Path,
    part: JsonObject,
    parameters: Parameters,
    drawn: DrawnNumbers,
) -> int:
    """Find the contours of one image, or the surface in one volume."""
    volume = "sphere" in drawn
    image = (load_volume if volume else load_image)(path, **part)
    parameters = fit_parameters(image, parameters, scales=arguments.scales is None)
    truth = load_named_truth(arguments, image)
    for place in drawn["object"]:
        if not all(-0.5 <= at <= side - 0.5 for at, side in zip(place, image.shape, strict=True)):
            at = ",".join(f"{number:g}" for number in place)
            raise ValueError(f"--object is {at} but lies outside the image, which has {format_size(image.shape)}.")
    started = time.perf_counter()
    shapes = _build_drawn_shapes(drawn, arguments, image if volume else None)
    starting = _collect_run_shapes(arguments, session, image, shapes)
    ensure_compiled()
    recorder = RunRecorder()
    with StatusLine() as line:

        def record_state(state: State) -> None:
            recorder(state)
            line.show_state(state)

        regions = _build_volume_regions(drawn, session) if volume else None
        found = segment_shapes(
            image, starting, parameters, session, max_steps=arguments.max_steps, progress=record_state, regions=regions
        )
    made = record_drawn_shapes(found, (*session.shapes, *shapes), _list_start_files(arguments))
    chosen: Sequence[Selection] = ()
    if volume:
        result = shown = _select_bodies(made, drawn)
    else:
        result = shown = apply_session_review(made, image, parameters, session, kept=arguments.image is None)
        if drawn["object"] or arguments.objects:
            parted = Partition.from_result(result)
            chosen = select_all(parted) if arguments.objects else [parted.select(drawn["object"], drawn["not"])]
            if drawn["object"] and not chosen[0].mask.any():
                raise ValueError("There is no object at this position: name another one inside it.")
            boundary = objects_result(chosen, image, channel=result.channel)
            drew = (*result.provenance.shapes, *boundary.provenance.shapes)
            shown = replace(boundary, provenance=replace(result.provenance, method="objects", shapes=drew))
    seconds = time.perf_counter() - started
    files = OutputFiles()
    files.export_result(
        shown,
        arguments.export,
        image=path,
        space=arguments.space or "LPS",
        warn=lambda sentence: print_message(f"{sentence} {_CLOSE_ADVICE[:-1]}, or write SVG, GeoJSON or CSV."),
    )
    if arguments.save_session is not None:
        own = arguments.image is None
        whole = replace(
            session,
            image=ImageFile(str(path.absolute()), image.sha256, image.shape, reading=Reading(**part)),
            shapes=starting,
            parameters=parameters,
            marks=session.marks if own else (),
            hand_edits=session.hand_edits if own else (),
            view=session.view if own else {},
            pages={},
            notes=(),
        )
        with files.record_writing(arguments.save_session):
            save_session(add_recorded_run(whole, recorder), Path(arguments.save_session))
    facts, lines = _describe_surface(result, seconds) if volume else _describe_contours(result, chosen, seconds)
    if not volume:
        written = [path for path in files.written if path in arguments.export]
        facts["left_out"] = {path: count_left_out(shown, find_format_suffix(path)) for path in written}
    if truth is not None:
        facts["truth"], sentence = _measure_truth_agreement(shown, truth)
        lines.append(sentence)
    advice = _CLOSE_ADVICE if any(count_left_out(shown, find_format_suffix(path)) for path in files.refused) else ""
    return print_report(arguments, facts, lines, files, advice)


def _check_options(arguments: argparse.Namespace, session: SessionFile, volume: bool) -> None:
    """Raise ValueError for options that have no meaning for this run."""
    if volume:
        refuse_options(arguments, ("circle", "objects", "pages", "save_session"), "images, but a volume is run")
    else:
        refuse_options(arguments, ("space",), "volumes, but an image is run")
    given = [*arguments.circle, *arguments.sphere, *arguments.stroke, *arguments.points, *arguments.start]
    named = arguments.objects or (arguments.object and not volume)
    if not (given or arguments.auto or select_starts(session.shapes) or named):
        if session.mode == "skeleton":
            raise ValueError("The session is for a skeleton and has no start: use cpm skeleton IMAGE --export PATH.")
        raise ValueError(
            "No start is given: add --circle ROW,COL,RADIUS (in a volume --sphere PLANE,ROW,COL,RADIUS), "
            "--stroke ROW,COL,ROW,COL,..., --points FILE.csv, --start FILE or --auto grid, or name a position inside "
            "an object, --object ROW,COL."
        )
    for path in arguments.export if volume and not is_large(arguments, Path(arguments.image or "")) else ():
        if find_format_suffix(path) not in VOLUMES_WRITABLE:
            raise ValueError(f"{path} is for contours, but a volume has a surface: end its name in .ply or .stl.")
    if arguments.save_session is not None:
        if Path(arguments.save_session).suffix.lower() != SESSION_SUFFIX:
            raise ValueError(f"--save-session is {arguments.save_session} but must end in {SESSION_SUFFIX}.")
        check_writable(Path(arguments.save_session))


def _build_drawn_shapes(
    drawn: DrawnNumbers, arguments: argparse.Namespace, volume: Image | None = None
) -> tuple[Shape, ...]:
    """Return the shapes of the command line, in an image or in a volume, where limits are no shapes."""
    axes = 2 if volume is None else 3
    shapes: list[Shape] = [Stroke(group_coordinates(numbers, axes)) for numbers in drawn["stroke"]]
    shapes += [Points(as_line(load_points(path, axes))) for path in arguments.points]
    everywhere = [Everywhere(arguments.auto)] if arguments.auto else []
    if volume is not None:
        spheres = (Sphere.from_voxel_size(tuple(center), radius, volume.spacing) for *center, radius in drawn["sphere"])
        return (*spheres, *shapes, *everywhere)
    circles = (Circle((row, col), radius) for row, col, radius in drawn["circle"])
    regions = (Region(group_coordinates(numbers, 2)) for numbers in drawn["region"])
    barriers = (Barrier(group_coordinates(numbers, 2)) for numbers in drawn["barrier"])
    return (*circles, *shapes, *regions, *barriers, *everywhere)


def _collect_run_shapes(
    arguments: argparse.Namespace, session: SessionFile, image: Image, drawn: Sequence[Shape]
) -> tuple[Shape, ...]:
    """Return all shapes of a run: those of the session, those drawn, and those of files."""
    files = (start for path in arguments.start for start in read_starts(path, image))
    shapes = (*session.shapes, *drawn, *files)
    return shapes if select_starts(shapes) else (*shapes, Everywhere("grid"))  # only an object was named


def _build_volume_regions(drawn: DrawnNumbers, session: SessionFile) -> AnyRegions | None:
    """Return boxes of interest and planes as barriers, with the limits of a session; None where none is drawn."""
    if not (drawn["region"] or drawn["barrier"]):
        return None
    saved = collect_regions(session.shapes, session.objects.barriers)
    before = saved if isinstance(saved, VolumeRegions) else VolumeRegions()
    boxes, planes = (
        tuple(((a, b, c), (d, e, f)) for a, b, c, d, e, f in drawn[name]) for name in ("region", "barrier")
    )
    return VolumeRegions((*before.interest, *boxes), (*before.barriers, *planes))


def _list_start_files(arguments: argparse.Namespace) -> list[JsonDict]:
    """Return the files whose contours a run starts from, as session files hold shapes."""
    return [{"shape": "points", "file": Path(path).name} for path in arguments.start]


def _select_bodies(found: Result, drawn: DrawnNumbers) -> Result:
    """Restrict the surface of a result to the bodies that contain the positive points, if any."""
    if not drawn["object"]:
        return found
    chosen = VolumePartition.from_result(found).select(drawn["object"], drawn["not"])
    if chosen.body is not None or not chosen.has_boundary:
        raise ValueError("There is no object at this position: name one that the surface encloses.")
    return replace(found, surface=chosen.surface)


def _describe_contours(result: Result, chosen: Sequence[Selection], seconds: float) -> tuple[JsonDict, list[str]]:
    """Describe contours, as values by name and as sentences."""
    facts: JsonDict = {
        **collect_run_facts(result, seconds),
        "bridges": len(result.bridges),
        PROVENANCE_KEY: describe_provenance(result),
    }
    lines = [f"{result.source}: {describe_contour_count(result)}"]
    lines += list_longest(
        [
            f"length {contour.length:.1f} px, "
            + (f"closed, area {contour.area:.1f} px²" if contour.closed else "open")
            + f", strength {contour.strength:.3g}"
            for contour in result.contours
        ]
    )
    for number, one in enumerate(chosen, start=1):
        on_object = {
            "area": sum(-contour.area if contour.hole else contour.area for contour in one.contours),
            "perimeter": sum(contour.length for contour in one.contours),
            "bridged": sum(contour.bridged for contour in one.contours),
            "confidence": one.confidence,
        }
        counts = {"holes": sum(contour.hole for contour in one.contours), "gaps": len(one.gaps)}
        facts.setdefault("objects", []).append({name: round(value, 4) for name, value in on_object.items()} | counts)
        if number <= _MAX_PRINTED_OBJECTS:
            lines.append(
                "Object: area {area:.1f} px², perimeter {perimeter:.1f} px, {bridged:.1f} px of it across gaps, "
                "confidence {share:.0f} %".format(share=100.0 * one.confidence, **on_object)
            )
    if len(chosen) > _MAX_PRINTED_OBJECTS:
        lines.append(f"... and {len(chosen) - _MAX_PRINTED_OBJECTS} more objects")
    if result.bridges:
        farthest = max(bridge.length for bridge in result.bridges)
        lines.append(f"Bridged {format_count(len(result.bridges), 'gap')}, longest {farthest:.1f} px")
    return facts, [*lines, *_describe_run(result, seconds)]


def _describe_surface(result: Result, seconds: float) -> tuple[JsonDict, list[str]]:
    """Describe a surface, as values by name and as sentences."""
    surface = result.surface
    vertices, faces = (0, 0) if surface is None else (len(surface.vertices), len(surface.faces))
    facts: JsonDict = {
        **collect_run_facts(result, seconds),
        "vertices": vertices,
        "faces": faces,
        "volume": round(surface.volume, 3) if surface is not None and surface.closed else None,
        "area": round(surface.area, 3) if surface is not None else None,
    }
    lines = [f"{result.source}: a surface of {format_count(faces, 'triangle')}, with {vertices} corners"]
    lines += _describe_run(result, seconds)
    if result.image is not None:
        facts |= collect_geometry_facts(result.image)
        lines += describe_geometry(result.image)
    return facts, lines


def _describe_run(result: Result, seconds: float) -> Iterator[str]:
    yield f"{format_count(len(result.particles), 'particle')}, {format_count(result.steps, 'step')} in {seconds:.2f} s"
    yield f"Stopped: {result.stop_reason}"


def _measure_truth_agreement(result: Result, truth: Truth | VolumeTruth) -> tuple[JsonDict, str]:
    """Measure how well contours, or a surface, agree with a ground truth: values by name, and a sentence."""
    found: Any
    measures, of, unit = ["dice", "jaccard", "precision", "recall", "f", "hausdorff"], {}, "px"
    if isinstance(truth, VolumeTruth):
        found, of, unit = compare_surface(result.surface, truth), {"unit": truth.unit}, truth.unit or "voxels"
        measures.append("hausdorff95")
    else:
        found = compare(result.contours, truth)
    values = {name: getattr(found, name) for name in measures} | {"mean_distance": found.mean_boundary_distance}
    agreed = {name: round(value, 6) if math.isfinite(value) else None for name, value in values.items()}
    sentence = f"Beside {truth.source}: Dice "
    sentence += "not known" if agreed["dice"] is None else f"{agreed['dice']:.3f}"
    sentence += f", F {agreed['f']:.3f}"
    if agreed["hausdorff"] is not None:
        sentence += f", {agreed['mean_distance']:.2g} {unit} apart on average, {agreed['hausdorff']:.1f} {unit} at most"
    return {"source": truth.source, **agreed, **of}, sentence
