"""``cpm skeleton``: finds the skeletons of the objects in an image."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence

from cpm_core.cli.arguments import (
    add_export,
    add_image,
    add_json,
    add_parameters,
    as_number,
    check_exports,
    parameters_of,
)
from cpm_core.cli.terminal import counted
from cpm_core.formats import export, load_image
from cpm_core.medial_axis.skeleton import PRUNING, Skeleton, skeleton
from cpm_core.parameters import PRESETS

_PRESET = "noisy"
_PARAMETERS = ("smoothing", "gamma", "edge_floor", "min_strength", "min_length", "edges")


def add_to(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command to those of the command line."""
    parser = commands.add_parser("skeleton", help="find the skeletons of the objects in an image", allow_abbrev=False)
    parser.set_defaults(command=_skeleton)
    parser.description = (
        "Find the middle lines of the objects in an image, with the distance to the boundary at every point. "
        "The smoothing is chosen from the image's noise unless it is given."
    )
    add_image(parser)
    parser.add_argument(
        "--pruning",
        metavar="PX",
        type=as_number,
        default=PRUNING,
        help="how far a part of the shape may stick out of the rest for its branch to be left out; "
        f"more of it leaves fewer branches (default: {PRUNING:g})",
    )
    parser.add_argument("--outside", action="store_true", help="the skeleton of the background, too")
    add_parameters(parser.add_argument_group("parameters"), _PARAMETERS)
    outcome = parser.add_argument_group("outcome")
    add_export(outcome, "skeleton")
    add_json(outcome)


def _skeleton(arguments: argparse.Namespace) -> None:
    """Find the skeletons of an image, after all checks that need no image."""
    parameters = parameters_of(arguments, PRESETS[_PRESET])
    if isinstance(arguments.pruning, str):
        raise ValueError(f'--pruning is "{arguments.pruning}" but must be a number of pixels, 0 or more.')
    check_exports(arguments.export, arguments.image)
    image = load_image(arguments.image)
    started = time.perf_counter()
    found = skeleton(image, parameters, pruning=arguments.pruning, outside=arguments.outside)
    seconds = time.perf_counter() - started
    export(found, *arguments.export)
    _report(found, seconds, arguments.export, as_json=arguments.json)


def _report(found: Skeleton, seconds: float, written: Sequence[str], *, as_json: bool) -> None:
    closed = sum(contour.closed for contour in found.contours)
    largest = max((float(radii.max()) for radii in found.radii), default=0.0)
    if as_json:
        facts = {
            "contours": len(found.contours),
            "closed": closed,
            "length": round(found.length, 3),
            "largest_radius": round(largest, 3),
            "seconds": round(seconds, 3),
        }
        print(json.dumps(facts))
        return
    print(f"{found.source}: skeleton of {counted(len(found.contours), 'line')} ({closed} closed) in {seconds:.2f} s")
    for number, (contour, radii) in enumerate(zip(found.contours[:10], found.radii, strict=False), start=1):
        print(f"  {number}. length {contour.length:.1f} px, radius {radii.min():.1f} to {radii.max():.1f} px")
    if len(found.contours) > 10:
        print(f"  ... and {len(found.contours) - 10} shorter ones")
    for path in written:
        print(f"Wrote {path}")
