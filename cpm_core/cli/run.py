"""``cpm run``: finds the contours of an image, those on the pages of a stack, or a surface in a volume."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from cpm_core.cli.arguments import (
    EXPORT_HELP,
    PART_OPTIONS,
    SURFACE_OPTIONS,
    add_options,
    add_parameter_options,
    parse_number_ranges,
)
from cpm_core.cli.inputs import (
    fit_parameters,
    load_named_truth,
)
from cpm_core.cli.large import run_large
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
from cpm_core.cli.run_request import RunRequest, parse_run_request
from cpm_core.contours.agreement import compare
from cpm_core.contours.ground_truth import Truth, VolumeTruth
from cpm_core.contours.surface_agreement import compare_surface
from cpm_core.formats import (
    CENTERLINES_WRITABLE,
    CONTOURS_READABLE,
    CONTOURS_WRITABLE,
    SURFACES_READABLE,
    VOLUMES_WRITABLE,
    count_left_out,
    find_format_suffix,
    load_image,
    load_volume,
    open_stack,
)
from cpm_core.formats.common.provenance import PROVENANCE_KEY, describe_provenance, record_drawn_shapes
from cpm_core.formats.images.reading import Reading
from cpm_core.formats.sessions.recorded_run import RunRecorder, add_recorded_run
from cpm_core.formats.sessions.session_file import SESSION_SUFFIX, ImageFile, save_session
from cpm_core.formats.sessions.session_run import segment_shapes
from cpm_core.model.state import State
from cpm_core.numerics.types import JsonDict
from cpm_core.objects import Selection
from cpm_core.objects.confidence import whole_percent
from cpm_core.objects.segmented import select_by_clicks
from cpm_core.parameters import PRESETS, Parameters, Provenance
from cpm_core.parameters.formatting import format_count, format_size
from cpm_core.results import FoundObjects, boundaries_in_image, replace_by_objects
from cpm_core.results.result import Result
from cpm_core.segmentation.evolve import find_seeded_methods
from cpm_core.segmentation.select import partition
from cpm_core.shapes import SEEDING_KINDS
from cpm_core.shapes.document_shapes import collect_regions, select_starts

_CLOSE_ADVICE = "Name an object by --object ROW,COL, whose boundary is closed."
"""Advice where a format that cannot hold open contours is not written."""

_OPEN_CONTOURS_ADVICE = "Name an object by --object ROW,COL, whose boundary is closed, or write SVG, GeoJSON or CSV."
"""Advice where a format is written without the open contours, which it cannot hold."""

_WRITABLE = tuple(dict.fromkeys((*CONTOURS_WRITABLE, *VOLUMES_WRITABLE)))
"""Suffixes of the files that a run can write."""

_MAX_PRINTED_OBJECTS = 10
"""Largest number of objects that are printed one by one."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_options(parser, "image", nargs="?")
    add_options(parser, "--session")
    part = parser.add_argument_group("part of a file")
    add_options(part, *PART_OPTIONS)
    part.add_argument(
        "--pages",
        metavar="all|N-M,...",
        help="Run each of these pages of a stack as an image of its own, in this order.",
    )
    part.add_argument(
        "--follow", action="store_true", help="Start each page from the contours of the one before, not from the start."
    )
    start = parser.add_argument_group("start", "One at least, here or of a session; several add up.")
    for flag, form, meaning in (
        ("--circle", "ROW,COL,RADIUS", "Start on a circle, in px."),
        ("--polygon", "ROW,COL,...", "Start on a closed line through these corners."),
        ("--stroke", "ROW,COL,...", "Start on a line from point to point."),
        ("--points", "FILE.csv", "Start at points: row,col on each line."),
        ("--sphere", "PLANE,ROW,COL,RADIUS", "Start on a sphere, in voxels. IMAGE is then a volume."),
        ("--start", "FILE", f"Start at the contours of a file ({', '.join(CONTOURS_READABLE)}, or a label mask). In a "
         f"volume at a surface, labels or center lines ({', '.join((*SURFACES_READABLE, *CENTERLINES_WRITABLE))})."),
    ):  # fmt: skip
        start.add_argument(flag, metavar=form, action="append", default=[], help=meaning)
    start.add_argument(
        "--auto",
        choices=SEEDING_KINDS,
        help="Start everywhere (grid), on the strongest edges (gradient), or midway between edges (centers).",
    )
    start.add_argument("--volume", action="store_true", help="IMAGE is a volume; places are then PLANE,ROW,COL.")
    add_options(start, "--xy")
    place = parser.add_argument_group("limits and charges", "Each may be repeated.")
    for flag, form, meaning in (
        ("--region", "ROW,COL,...", "Keep particles inside a polygon, in px. In a volume give two corners of a box."),
        ("--barrier", "ROW,COL,...", "Let no particle cross a line, in px. In a volume give a point of a plane and the "
         "direction across it."),
        ("--charge", "ROW,COL,STRENGTH", "Place a charge, which attracts particles above 0 and repels them below."),
    ):  # fmt: skip
        place.add_argument(flag, metavar=form, action="append", default=[], help=meaning)
    named = parser.add_argument_group(
        "objects",
        "Written instead of contours. Particles start everywhere by default; places in a volume need no particles.",
    )
    for flag, meaning in (
        ("--object", "Select the object at a place, in px; its boundary is closed. Repeated, it adds to the object, as "
         "clicks do in the window. With --pages it is on the first of them, and --follow finds it on the others."),
        ("--not", "Leave this place out of the object."),
    ):  # fmt: skip
        named.add_argument(flag, metavar="ROW,COL", action=_ClickAction, default=[], help=meaning)
    named.add_argument(
        "--larger",
        metavar="N",
        action=_ClickAction,
        default=[],
        help="After a place take the candidate N sizes larger, or with -N smaller, as ] and [ do in the window.",
    )
    named.add_argument("--and", nargs=0, action=_ClickAction, default=[], help="Select another object from here on.")
    named.add_argument(
        "--model",
        metavar="NAME|FOLDER|ADDRESS",
        default="",
        help="Let a larger model answer --object in place of the network: see cpm model. Or a folder with two files, "
        "*encoder*.onnx and *decoder*.onnx. In a volume the address of a server of nnInteractive.",
    )
    named.add_argument(
        "--objects",
        action="store_true",
        help="Find the objects that the run proposes, as the window does. From everywhere these are all of the image, "
        "else the one of each start. --object adds others.",
    )
    named.add_argument(
        "--pick", metavar="N-M,...", help="Take these of the objects that the run proposes, the best of which is 1."
    )
    parameters = parser.add_argument_group(
        "parameters", "Defaults are those of the publication; a preset, a session and a volume have their own."
    )
    add_options(parameters, "--preset", help=f"Take named settings: {', '.join(PRESETS)}.")
    parameters.add_argument(
        "--method",
        choices=tuple(find_seeded_methods()),
        help="The program's own method, or the model as published (default: that of the session, else cpm).",
    )
    add_parameter_options(parameters, defaults=(Parameters(),))
    where = parser.add_argument_group("workers", "For an image of OME-Zarr, which --auto runs chunk by chunk.")
    add_options(where.add_mutually_exclusive_group(), "--workers", "--scheduler")
    outcome = parser.add_argument_group("outcome")
    add_options(outcome, *SURFACE_OPTIONS)
    add_options(outcome, "--export", help=EXPORT_HELP.format(what="what is found", suffixes=", ".join(_WRITABLE)))
    outcome.add_argument(
        "--truth", metavar="FILE", help="Compare with a ground truth: a mask, contours, or a label volume."
    )
    outcome.add_argument(
        "--save-session",
        metavar="FILE",
        help=f"Write a session ({SESSION_SUFFIX}) that the window opens with these contours.",
    )
    add_options(outcome, "--max-steps")


class _ClickAction(argparse.Action):
    """Collect in their order: places inside and outside an object, sizes of its candidates, where another begins."""

    def __call__(self, _: object, namespace: argparse.Namespace, values: Any, __: str | None = None) -> None:
        setattr(namespace, self.dest, [*getattr(namespace, self.dest), values])
        namespace.clicks = [*getattr(namespace, "clicks", ()), (self.dest, values)]


def run_segmentation(arguments: argparse.Namespace) -> int:
    """Find contours or a surface; every check that needs no image comes first."""
    request = parse_run_request(arguments)
    if request.is_chunked:
        return run_large(request)
    return _run_image(request) if request.pages is None else run_pages(request)


def _run_image(request: RunRequest) -> int:
    """Find the contours of one image, or the surface in one volume."""
    session = request.session
    image = (load_volume if request.is_volume else load_image)(request.path, **request.part)
    parameters = fit_parameters(image, request.parameters, scales=request.fits_scales)
    if (
        not request.is_volume
        and request.part.get("page") is None
        and (open_stack(request.path, request.part.get("series")).default_plane > 0)
    ):
        print_message(f"{image.source}: --volume runs all of its planes.")
    truth = load_named_truth(request.truth_file, image)
    for place in (place for clicks in request.clicked for click in clicks if click.inside for place in click.places):
        if not all(-0.5 <= at <= side - 0.5 for at, side in zip(place, image.shape, strict=True)):
            at = ",".join(f"{number:g}" for number in place)
            raise ValueError(f"--object is {at} but lies outside the image, which has {format_size(image.shape)}.")
    started = time.perf_counter()
    shapes = request.collect_shapes(image)
    recorder = RunRecorder()
    if select_starts(shapes):
        ensure_compiled(volume=request.is_volume)
        with StatusLine() as line:

            def record_state(state: State) -> None:
                recorder(state)
                line.show_state(state)

            found = segment_shapes(
                image,
                shapes,
                parameters,
                session,
                max_steps=request.max_steps,
                progress=record_state,
                regions=request.volume_regions,
            )
    else:  # places in a volume
        limits = request.volume_regions or collect_regions(shapes, session.objects.barriers)
        found = boundaries_in_image(image, Provenance("objects"), regions=limits)
    result = record_drawn_shapes(found, request.collect_drawn_shapes(image), request.describe_start_files())
    chosen = _select_objects(result, request)
    shown = result if chosen is None else replace_by_objects(result, chosen, session.objects)
    seconds = time.perf_counter() - started
    files = OutputFiles()
    files.export_result(
        shown,
        request.exports,
        image=request.path,
        **request.surface_options,
        warn=lambda sentence: print_message(sentence if image.ndim == 3 else f"{sentence} {_OPEN_CONTOURS_ADVICE}"),
    )
    if request.session_file is not None:
        own = request.has_session_image
        whole = replace(
            session,
            image=ImageFile(str(request.path.absolute()), image.sha256, image.shape, reading=Reading(**request.part)),
            shapes=shapes,
            parameters=parameters,
            view=session.view if own else {},
            pages={},
            notes=(),
        )
        with files.record_writing(request.session_file):
            save_session(add_recorded_run(whole, recorder), Path(request.session_file))
    if request.is_volume:
        facts, lines = _describe_surface(result, shown, seconds)
    else:
        facts, lines = _describe_contours(result, chosen or (), seconds)
        written = [path for path in files.written if path in request.exports]
        facts["left_out"] = {path: count_left_out(shown, find_format_suffix(path)) for path in written}
    if truth is not None:
        facts["truth"], sentence = _measure_truth_agreement(shown, truth)
        lines.append(sentence)
    advice = _CLOSE_ADVICE if any(count_left_out(shown, find_format_suffix(path)) for path in files.refused) else ""
    return print_report("run", request.as_json, facts, lines, files, advice)


def _select_objects(result: Result, request: RunRequest) -> FoundObjects | None:
    """Select the objects of a run, and those of clicks; None where contours or a surface are wanted."""
    if not (request.all_objects or request.clicked):
        return None
    proposed = result.objects if request.all_objects else ()
    if request.picked is not None:
        numbers = parse_number_ranges("--pick", request.picked, len(proposed), "object", "the run")
        proposed = tuple(proposed[number - 1] for number in numbers)
    if not request.clicked:
        return proposed
    chosen = select_by_clicks(partition(result, model=request.model), request.clicked, proposed)
    for one in chosen:
        if result.surface is not None and ((one.prediction is not None and not one.model) or not one.has_boundary):
            raise ValueError("There is no object at this position: name one that the surface encloses.")
        if not one.has_boundary:
            raise ValueError("There is no object at this position: name another one inside it.")
    return (*proposed, *chosen)


def _describe_contours(result: Result, chosen: Sequence[Selection], seconds: float) -> tuple[JsonDict, list[str]]:
    """Describe contours, as values by name and as sentences."""
    facts: JsonDict = {
        **collect_run_facts(result),
        "seconds": round(seconds, 3),
        "faces": len(result.faces),
        "bridges": len(result.bridges),
        PROVENANCE_KEY: describe_provenance(result),
    }
    lines = [f"{result.source}: {describe_contour_count(result)}, {format_count(len(result.faces), 'face')}"]
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
            title = f"Object {number}" if len(chosen) > 1 else "Object"
            lines.append(
                f"{title}: "
                "area {area:.1f} px², perimeter {perimeter:.1f} px, {bridged:.1f} px of it across gaps, "
                "confidence {share:.0f} %".format(share=whole_percent(one.confidence), **on_object)
            )
    if len(chosen) > _MAX_PRINTED_OBJECTS:
        lines.append(f"... and {len(chosen) - _MAX_PRINTED_OBJECTS} more objects")
    if result.bridges:
        farthest = max(bridge.length for bridge in result.bridges)
        lines.append(f"Bridged {format_count(len(result.bridges), 'gap')}, longest {farthest:.1f} px")
    return facts, [*lines, *_describe_run(result, seconds)]


def _describe_surface(result: Result, shown: Result, seconds: float) -> tuple[JsonDict, list[str]]:
    """Describe the surface that is shown of a result, as values by name and as sentences."""
    surface = shown.surface
    vertices, faces = (0, 0) if surface is None else (len(surface.vertices), len(surface.faces))
    facts: JsonDict = {
        **collect_run_facts(result),
        "seconds": round(seconds, 3),
        "vertices": vertices,
        "faces": faces,
        "volume": round(surface.volume, 3) if surface is not None and surface.closed else None,
        "area": round(surface.area, 3) if surface is not None else None,
    }
    lines = [f"{result.source}: a surface of {format_count(faces, 'triangle')}, with {vertices:,} corners"]
    if shown is not result and surface is not None:
        lines[0] += f" around {format_count(surface.components, 'part')}"
    lines += _describe_run(result, seconds)
    if result.image is not None:
        facts |= collect_geometry_facts(result.image)
        lines += describe_geometry(result.image)
    return facts, lines


def _describe_run(result: Result, seconds: float) -> Iterator[str]:
    if not result.steps:  # places in a volume
        return
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
    sentence = f"Compared with {truth.source}: Dice "
    sentence += "not known" if agreed["dice"] is None else f"{agreed['dice']:.3f}"
    sentence += f", F {agreed['f']:.3f}"
    if agreed["hausdorff"] is not None:
        sentence += f", {agreed['mean_distance']:.2g} {unit} apart on average, {agreed['hausdorff']:.1f} {unit} at most"
    count = int(truth.objects.max(initial=0))
    if count > 1:
        sentence += f", with all of its {count} objects together"
    return {"source": truth.source, **agreed, **of}, sentence
