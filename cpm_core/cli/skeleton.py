"""``cpm skeleton``: finds the skeletons of the objects in an image, and the center lines of what lies in a volume."""

from __future__ import annotations

import argparse
import sys
import time

from cpm_core.cli.arguments import (
    add_export,
    add_image,
    add_json,
    add_parameters,
    add_space,
    check_exports,
    notes_on,
    parameters_of,
)
from cpm_core.cli.inputs import add_part, part_of, part_of_volume
from cpm_core.cli.outcome import Files, tell
from cpm_core.cli.terminal import announce_compilation, say
from cpm_core.formats import FOR_CENTERLINES, load_image, load_volume, suffix_of
from cpm_core.formats.common.provenance import ENTRY, facts_of, facts_on
from cpm_core.medial_axis.centerlines import Centerlines
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.medial_axis.skeleton_method import skeleton
from cpm_core.parameters import PRESETS
from cpm_core.parameters.quotation import counted

_PRESET = "noisy"
_PARAMETERS = (
    "pruning",
    "max_width",
    "smoothing",
    "gamma",
    "edge_floor",
    "sure_edge",
    "min_strength",
    "min_length",
    "edges",
    "channel",
)
_OF = ("auto", "dark", "light")


def add_to(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command to those of the command line."""
    parser = commands.add_parser("skeleton", help="find the skeletons of the objects in an image", allow_abbrev=False)
    parser.set_defaults(command=_skeleton)
    parser.description = (
        "Find the middle lines of the objects in an image, with the distance to the boundary at every point. "
        "The smoothing is chosen from the image's noise unless it is given. In a volume the lines are written as SWC."
    )
    add_image(parser)
    parser.add_argument("--volume", action="store_true", help="IMAGE is a volume, as with --export LINES.swc")
    parser.add_argument(
        "--of",
        choices=_OF,
        default=_OF[0],
        help="of what is darker, or lighter, than its surroundings (default: of what stands out in the image)",
    )
    parser.add_argument(
        "--within", metavar="MASK", help="the skeleton of the objects of this mask, an image of the same size"
    )
    add_part(parser.add_argument_group("part of a file"))
    parser.add_argument("--outside", action="store_true", help="the skeleton of the background, too")
    add_parameters(parser.add_argument_group("parameters"), _PARAMETERS)
    outcome = parser.add_argument_group("outcome")
    add_space(outcome)
    add_export(outcome, "skeleton")
    add_json(outcome)


def _skeleton(arguments: argparse.Namespace) -> int:
    """Find the skeletons of an image, after all checks that need no image, or the center lines in a volume."""
    if arguments.volume or any(suffix_of(path) in FOR_CENTERLINES for path in arguments.export):
        return find_centerlines(arguments)
    if arguments.space:
        raise ValueError("--space is for center lines in a volume: add --volume, or leave it out.")
    part = part_of(arguments)
    parameters = parameters_of(arguments, PRESETS[_PRESET])
    check_exports(arguments.export, arguments)
    image = load_image(arguments.image, **part)
    for note in notes_on(image, parameters):
        print(f"cpm: {image.source}: {note}", file=sys.stderr)
    mask = None if arguments.within is None else load_image(arguments.within).values > 0.0
    announce_compilation()
    started = time.perf_counter()
    found = skeleton(image, parameters, of=arguments.of, within=mask, outside=arguments.outside)
    seconds = time.perf_counter() - started
    assert isinstance(found, Skeleton)
    files = Files()
    files.export(found, arguments.export)
    files.check()
    _report(found, seconds, files, as_json=arguments.json)
    return files.status()


def _report(found: Skeleton, seconds: float, files: Files, *, as_json: bool) -> None:
    closed = sum(contour.closed for contour in found.contours)
    largest = max((float(radii.max()) for radii in found.radii), default=0.0)
    of = {-1: "dark", 0: "all", 1: "light"}[found.polarity]
    facts = {
        "contours": len(found.contours),
        "closed": closed,
        "length": round(found.length, 3),
        "thickness": round(found.thickness, 3),
        "largest_radius": round(largest, 3),
        "of": of,
        "max_width": round(found.width, 3),
        "seconds": round(seconds, 3),
        "not_written": files.refused,
        ENTRY: facts_of(found),
    }
    what = "" if of == "all" else f" of what is {of}" + (f" and up to {found.width:.0f} px wide" if found.width else "")
    count = counted(len(found.contours), "line")
    lines = [
        f"{found.source}: skeleton{what} of {count} ({closed} closed), thickness up to {found.thickness:.1f} px, "
        f"in {seconds:.2f} s"
    ]
    for number, (contour, radii) in enumerate(zip(found.contours[:10], found.radii, strict=False), start=1):
        lines.append(f"  {number}. length {contour.length:.1f} px, radius {radii.min():.1f} to {radii.max():.1f} px")
    if len(found.contours) > 10:
        lines.append(f"  ... and {len(found.contours) - 10} shorter ones")
    tell("skeleton", facts, lines, files.written, as_json=as_json)


def find_centerlines(arguments: argparse.Namespace) -> int:
    """Find the center lines in a volume; every check that needs no volume comes first."""
    part = part_of_volume(arguments)
    parameters = parameters_of(arguments, PRESETS["volume"])
    check_exports(arguments.export, arguments)
    for path in arguments.export:
        if suffix_of(path) not in FOR_CENTERLINES:
            raise ValueError(f"{path} holds no center lines in a volume: end its name in {', '.join(FOR_CENTERLINES)}.")
    volume = load_volume(arguments.image, **part)
    for note in volume.notes:
        say(f"cpm: {volume.source}: {note}")
    mask = None if arguments.within is None else load_volume(arguments.within).values > 0.0
    announce_compilation()
    started = time.perf_counter()
    found = skeleton(volume, parameters, of=arguments.of, within=mask, outside=arguments.outside)
    seconds = time.perf_counter() - started
    assert isinstance(found, Centerlines)
    files = Files()
    files.export(found, arguments.export, space=arguments.space or "LPS")
    files.check()
    _report_lines(found, seconds, files, as_json=arguments.json)
    return files.status()


def _report_lines(found: Centerlines, seconds: float, files: Files, *, as_json: bool) -> None:
    closed = sum(branch.closed for branch in found.branches)
    facts = {
        "contours": len(found.branches),
        "closed": closed,
        "length": round(float(found.lengths.sum()), 3),
        "largest_radius": round(max((float(radii.max()) for radii in found.radii), default=0.0), 3),
        "unit": found.unit,
        "seconds": round(seconds, 3),
        "not_written": files.refused,
        ENTRY: facts_on(found.source, found.provenance),
    }
    unit = found.unit or "voxels"
    count = counted(len(found.branches), "center line")
    lines = [f"{found.source}: {count} ({closed} closed) in {seconds:.2f} s"]
    for number, (length, radii) in enumerate(zip(found.lengths[:10], found.radii, strict=False), start=1):
        lines.append(f"  {number}. length {length:.1f} {unit}, radius {radii.min():.1f} to {radii.max():.1f} {unit}")
    if len(found.branches) > 10:
        lines.append(f"  ... and {len(found.branches) - 10} shorter ones")
    tell("skeleton", facts, lines, files.written, as_json=as_json)
