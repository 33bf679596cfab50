"""``cpm export``: writes the result of a session, or contours and surfaces of a file, in other formats."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from cpm_core.cli.arguments import (
    EXPORT_HELP,
    SURFACE_OPTIONS,
    add_options,
    check_exports,
    check_targets,
    collect_surface_options,
    parse_whole_number,
)
from cpm_core.cli.inputs import (
    fit_parameters,
    locate_image,
)
from cpm_core.cli.output import (
    OutputFiles,
    StatusLine,
    describe_contour_count,
    ensure_compiled,
    print_message,
    print_notes,
    print_report,
)
from cpm_core.formats import (
    CENTERLINES_WRITABLE,
    CONTOURS_READABLE,
    CONTOURS_WRITABLE,
    SURFACES_READABLE,
    VOLUMES_WRITABLE,
    count_left_out,
    find_format_suffix,
    holds_volume,
    load_centerlines,
    load_image,
    load_surface,
    load_volume,
)
from cpm_core.formats.common.provenance import (
    PROVENANCE_KEY,
    describe_image_provenance,
    describe_provenance,
    record_drawn_shapes,
)
from cpm_core.formats.contour_file import describe_plane, read_contours
from cpm_core.formats.images.resolution import find_unit
from cpm_core.formats.sessions.recorded_run import restore_shown_state
from cpm_core.formats.sessions.session_file import SESSION_SUFFIX, SessionFile, load_session
from cpm_core.formats.sessions.session_run import is_volume_session, segment_shapes
from cpm_core.image.image import Image
from cpm_core.medial_axis.centerlines import Centerlines
from cpm_core.numerics.types import Extent, JsonDict
from cpm_core.parameters import Parameters, Provenance
from cpm_core.parameters.formatting import format_count
from cpm_core.results import add_segmented_objects, boundaries_in_image, boundaries_result
from cpm_core.results.result import Result
from cpm_core.segmentation.evolve import find_seeded_methods
from cpm_core.shapes.document_shapes import select_starts


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    known = ", ".join((*CONTOURS_READABLE, *SURFACES_READABLE, *CENTERLINES_WRITABLE))
    writable = (*CONTOURS_WRITABLE, *VOLUMES_WRITABLE, *CENTERLINES_WRITABLE)
    parser.add_argument(
        "source",
        metavar="FILE",
        help=f"Session ({SESSION_SUFFIX}), contours, surface, center lines or labels. Formats are {known}.",
    )
    parser.add_argument("--image", metavar="IMAGE", help="The image or volume that it belongs to.")
    parser.add_argument("--page", metavar="N", type=parse_whole_number, help="Page of contours in a stack, from 1.")
    parser.add_argument(
        "--to",
        metavar="PATH",
        nargs="+",
        action="extend",
        required=True,
        help=EXPORT_HELP.format(what="it", suffixes=", ".join(dict.fromkeys(writable))),
    )
    parser.add_argument("--objects", action="store_true", help="Write the objects of a session, not its contours.")
    parser.add_argument("--outlines", action="store_true", help="Draw lines in label masks, not areas.")
    add_options(parser, *SURFACE_OPTIONS)


def run_export(arguments: argparse.Namespace) -> int:
    """Write the files, after all checks that need none of them."""
    source = Path(arguments.source)
    check_exports(arguments.to, arguments)
    if arguments.objects and source.suffix.lower() != SESSION_SUFFIX:
        raise ValueError(f"--objects is for sessions, but {source.name} is none: leave it out.")
    suffix, wanted = source.suffix.lower(), {find_format_suffix(path) for path in arguments.to}
    of_volumes = suffix in {*CENTERLINES_WRITABLE, *SURFACES_READABLE}
    if (
        arguments.page is None
        and suffix not in {SESSION_SUFFIX, *CONTOURS_READABLE}
        and wanted <= VOLUMES_WRITABLE.keys()
    ):
        of_volumes = of_volumes or holds_volume(source)  # labels, for labels or surfaces
    if arguments.page is not None and (suffix == SESSION_SUFFIX or of_volumes):
        raise ValueError(f"--page is for contours in a stack, but {source.name} holds none: leave it out.")
    result: Result | Centerlines
    image = arguments.image
    if suffix == SESSION_SUFFIX:
        result, image = _load_session_result(source, arguments)
    else:
        result = _read_volume_result(source, arguments) if of_volumes else _read_plane_result(source, arguments)
    files = OutputFiles()
    options = {"outlines": arguments.outlines, **collect_surface_options(arguments)}
    files.export_result(result, arguments.to, image=image, warn=print_message, **options)
    missing = {
        path: count_left_out(result, find_format_suffix(path), outlines=arguments.outlines) for path in files.written
    }
    said, line = _describe_result(result, source)
    return print_report(
        arguments.name, arguments.json, {"source": str(source), "left_out": missing, **said}, [line], files
    )


def _describe_result(result: Result | Centerlines, source: Path) -> tuple[JsonDict, str]:
    """Describe a result, as plain JSON and as a line."""
    facts: JsonDict = {"contours": len(result.contours), "closed": sum(one.closed for one in result.contours)}
    if isinstance(result, Centerlines):
        facts[PROVENANCE_KEY] = describe_image_provenance(result.source, result.provenance)
        return facts, f"{source.name}: {describe_contour_count(result, 'center line')}"
    facts[PROVENANCE_KEY] = describe_provenance(result)
    if result.surface is None:
        return facts, f"{source.name}: {describe_contour_count(result)}"
    vertices, faces = len(result.surface.vertices), len(result.surface.faces)
    facts |= {"vertices": vertices, "faces": faces}
    return facts, f"{source.name}: a surface of {format_count(faces, 'triangle')}, with {vertices:,} corners"


def _load_session_result(source: Path, arguments: argparse.Namespace) -> tuple[Result, str]:
    """Return the result that the window shows of a session, and the path of its image."""
    session = load_session(source)
    if arguments.image is None and session.image is None:
        raise ValueError(f"{source.name} does not name an image: add --image IMAGE.")
    path, reading = locate_image(arguments.image, session, source)
    check_targets(arguments.to, arguments, path)
    image = (load_volume if is_volume_session(session) else load_image)(path, **reading)
    if arguments.objects:
        objects = add_segmented_objects(boundaries_in_image(image, Provenance("objects")), session.objects)
        if objects is None:
            raise ValueError(f"{source.name} has no objects: accept some in the window, or leave out --objects.")
        return objects, str(path)
    parameters = fit_parameters(image, session.parameters)
    result = record_drawn_shapes(_restore_or_run(session, parameters, image, source), session.shapes)
    return result, str(path)


def _restore_or_run(session: SessionFile, parameters: Parameters, image: Image, source: Path) -> Result:
    """Restore the result of the state that a session shows, or else run it to its end."""
    ensure_compiled(volume=image.ndim == 3)
    kept = restore_shown_state(replace(session, parameters=parameters), image)
    if kept is not None:
        state, method_name, at_step, shown = kept
        method = find_seeded_methods()[method_name](image, at_step, state.regions)
        return replace(cast("Result", method.result(state, shown)), source=image.source)
    if not select_starts(session.shapes):
        raise ValueError(f"{source.name} has no start and no contours: draw a start in the window, and save it again.")
    with StatusLine() as line:
        return segment_shapes(image, session.shapes, parameters, session, progress=line.show_state)


def _read_plane_result(source: Path, arguments: argparse.Namespace) -> Result:
    """Read the contours of a file as a result on the given image, or on one of the size that the file states."""
    image = None if arguments.image is None else load_image(arguments.image)
    found = read_contours(source, describe_plane(image), page=arguments.page)
    print_notes(source.name, found.notes)
    if not found.contours:
        raise ValueError(f"{source.name} contains only single points, no contours: choose another file.")
    shape = found.shape if image is None else image.shape
    if shape is None:
        corners = np.concatenate([contour.points for contour in found.contours])
        rows, cols = (np.ceil(corners.max(axis=0)) + 1).astype(int).tolist()
        shape = (max(rows, 1), max(cols, 1))
        print_message(
            f"{source.name} does not state the size of its image: {rows} x {cols} px is taken; name it with --image."
        )
    return _build_read_result(source, image, shape, contours=found.contours)


def _read_volume_result(source: Path, arguments: argparse.Namespace) -> Result | Centerlines:
    """Read a surface or center lines as a result in the given volume."""
    suffix = source.suffix.lower()
    image = None if arguments.image is None else load_volume(arguments.image)
    if suffix in CENTERLINES_WRITABLE:
        return load_centerlines(source, image, warn=print_message)
    if image is None and suffix not in SURFACES_READABLE:
        image = load_volume(source)
    in_voxels = {path for path in arguments.to if find_format_suffix(path) in CONTOURS_WRITABLE}
    if image is None and in_voxels:
        raise ValueError(f"{min(in_voxels)} has the voxels of a volume: name the volume with --image.")
    surface = load_surface(source, image, warn=print_message)
    found = _build_read_result(source, image, (1, 1, 1) if image is None else image.shape, surface=surface)
    return replace(found, spacing=surface.spacing, unit=surface.unit)


def _build_read_result(source: Path, image: Image | None, shape: Extent, **found: Any) -> Result:
    """Build a result of what has been read from a file."""
    found["stop_reason"] = "read from a file"
    if image is None:
        return boundaries_result(shape, source.name, **found)
    unit = image.unit and find_unit(image.unit)
    return boundaries_result(shape, image.source, image.spacing, unit, image=image, **found)
