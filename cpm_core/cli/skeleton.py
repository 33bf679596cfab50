"""``cpm skeleton``: finds the skeletons of the objects in an image, and center lines in a volume."""

from __future__ import annotations

import argparse
import time

from cpm_core.cli.arguments import (
    EXPORT_HELP,
    PART_OPTIONS,
    add_options,
    add_parameter_options,
    check_exports,
    parse_parameters,
    parse_part,
)
from cpm_core.cli.inputs import fit_parameters
from cpm_core.cli.output import OutputFiles, describe_contour_count, ensure_compiled, list_longest, print_report
from cpm_core.formats import CENTERLINES_WRITABLE, CONTOURS_WRITABLE, find_format_suffix, load_image, load_volume
from cpm_core.formats.common.provenance import PROVENANCE_KEY, describe_image_provenance, describe_provenance
from cpm_core.medial_axis.centerlines import Centerlines
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.medial_axis.skeleton_method import skeleton
from cpm_core.numerics.types import JsonDict
from cpm_core.parameters import PRESETS

_PARAMETER_OPTIONS = (
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
"""Parameters that can be set."""

_POLARITIES = ("auto", "dark", "light")
"""Values of ``--of``, the default first."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_options(parser, "image")
    parser.add_argument("--volume", action="store_true", help="IMAGE is a volume, as with --export LINES.swc.")
    parser.add_argument(
        "--of",
        choices=_POLARITIES,
        default=_POLARITIES[0],
        help="Find skeletons of what is darker or lighter than its surroundings (default: of what stands out).",
    )
    parser.add_argument(
        "--within", metavar="MASK", help="Find the skeletons of the objects of this mask, an image of the same size."
    )
    parser.add_argument("--outside", action="store_true", help="Find the skeleton of the background, too.")
    add_options(parser.add_argument_group("part of a file"), *PART_OPTIONS)
    add_parameter_options(
        parser.add_argument_group("parameters"), _PARAMETER_OPTIONS, (PRESETS["noisy"], PRESETS["volume"])
    )
    outcome = parser.add_argument_group("outcome")
    suffixes = ", ".join((*CONTOURS_WRITABLE, *CENTERLINES_WRITABLE))
    add_options(outcome, "--export", help=EXPORT_HELP.format(what="the lines", suffixes=suffixes))
    add_options(outcome, "--space")


def run_skeleton(arguments: argparse.Namespace) -> int:
    """Find skeletons or center lines, after all checks that need no image."""
    volume = arguments.volume or any(find_format_suffix(path) in CENTERLINES_WRITABLE for path in arguments.export)
    if arguments.space and not volume:
        raise ValueError("--space is for center lines in a volume: add --volume, or leave it out.")
    part = parse_part(arguments, volume=volume)
    parameters = parse_parameters(arguments, PRESETS["volume" if volume else "noisy"])
    check_exports(arguments.export, arguments)
    for path in arguments.export if volume else ():
        if find_format_suffix(path) not in CENTERLINES_WRITABLE:
            raise ValueError(
                f"{path} cannot contain center lines in a volume, which --volume and a .swc file ask for: leave it out."
            )
    load = load_volume if volume else load_image
    image = load(arguments.image, **part)
    fit_parameters(image, parameters, scales=False)
    mask = None if arguments.within is None else load(arguments.within).values > 0.0
    ensure_compiled()
    started = time.perf_counter()
    found = skeleton(image, parameters, of=arguments.of, within=mask, outside=arguments.outside)
    seconds = time.perf_counter() - started
    files = OutputFiles()
    files.export_result(found, arguments.export, **({"space": arguments.space or "LPS"} if volume else {}))
    return print_report(arguments.name, arguments.json, *_describe_skeleton(found, seconds), files)


def _describe_skeleton(found: Skeleton | Centerlines, seconds: float) -> tuple[JsonDict, list[str]]:
    """Describe a skeleton, or center lines in a volume, as values by name and as sentences."""
    if isinstance(found, Centerlines):
        lengths, unit = found.lengths.tolist(), found.unit or "voxels"
        facts: JsonDict = {
            "unit": found.unit,
            PROVENANCE_KEY: describe_image_provenance(found.source, found.provenance),
        }
        first = describe_contour_count(found, "center line")
    else:
        lengths, unit = [contour.length for contour in found.contours], "px"
        of = {-1: "dark", 0: "all", 1: "light"}[found.polarity]
        facts = {"thickness": round(found.thickness, 3), "of": of, "max_width": round(found.width, 3)}
        facts[PROVENANCE_KEY] = describe_provenance(found)
        wide = f" and up to {found.width:.0f} px wide" if found.width else ""
        what = "" if of == "all" else f" of what is {of}{wide}"
        thick = f"thickness up to {found.thickness:.1f} px,"
        first = f"skeleton{what}: {describe_contour_count(found, 'line')}, {thick}"
    facts |= {
        "contours": len(found.contours),
        "closed": sum(contour.closed for contour in found.contours),
        "length": round(float(sum(lengths)), 3),
        "largest_radius": round(max((float(radii.max()) for radii in found.radii), default=0.0), 3),
        "seconds": round(seconds, 3),
    }
    lines = [
        f"length {length:.1f} {unit}, radius {radii.min():.1f} to {radii.max():.1f} {unit}"
        for length, radii in zip(lengths, found.radii, strict=True)
    ]
    return facts, [f"{found.source}: {first} in {seconds:.2f} s", *list_longest(lines)]
