"""The object of ``cpm run --object``: chosen by places, written and told."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cpm_core.cli.inputs import numbers_in
from cpm_core.contours.result import Result
from cpm_core.image.image import Image
from cpm_core.objects import Selection, objects_result, partition
from cpm_core.parameters.quotation import shown, sized


def add_objects(parser: argparse._ActionsContainer) -> None:
    """Add the places inside and outside an object, as `object` and `outside`."""
    parser.add_argument(
        "--object",
        metavar="ROW,COL",
        action="append",
        default=[],
        help="a place inside an object, in px; its boundary is closed, and written instead of the contours (may be "
        "repeated: all places lie in one object; without a start, particles start everywhere)",
    )
    parser.add_argument(
        "--not",
        metavar="ROW,COL",
        action="append",
        default=[],
        dest="outside",
        help="a place outside the object, in px (may be repeated)",
    )


def check_objects(arguments: argparse.Namespace) -> None:
    """Raise ValueError unless the places are rows and columns, some of them inside."""
    _places("--object", arguments.object)
    if _places("--not", arguments.outside) and not arguments.object:
        raise ValueError("--not is given without --object: name a place inside the object as well, --object ROW,COL.")


def choose(result: Result, image: Image, arguments: argparse.Namespace) -> tuple[Selection, Result]:
    """The object that the places of the command line lie in, and a result with its boundary.

    ValueError when no object is found there.
    """
    inside, outside = _places("--object", arguments.object), _places("--not", arguments.outside)
    for place in inside:
        if not all(-0.5 <= at <= side - 0.5 for at, side in zip(place, image.shape, strict=True)):
            at = ",".join(f"{number:g}" for number in place)
            raise ValueError(f"--object is {at} but lies outside the image, which has {sized(image.shape)}.")
    chosen = partition(result).select(np.array(inside), np.array(outside))
    if not chosen.mask.any():
        raise ValueError(f"There is no object at {', '.join(arguments.object)}: name another place inside one.")
    found = objects_result([chosen], image, channel=result.channel)
    shapes = (*result.provenance.shapes, *found.provenance.shapes)
    return chosen, replace(found, provenance=replace(result.provenance, method="objects", shapes=shapes))


def facts_of_object(chosen: Selection) -> dict[str, object]:
    """Values of an object by name, as they are printed as JSON."""
    return {
        "area": round(_net_area(chosen), 3),
        "perimeter": round(sum(contour.length for contour in chosen.contours), 3),
        "holes": sum(contour.hole for contour in chosen.contours),
        "gaps": len(chosen.gaps),
        "bridged": round(sum(contour.bridged for contour in chosen.contours), 3),
        "confidence": round(chosen.confidence, 4),
    }


def sentence(chosen: Selection) -> str:
    """What a person is told of an object."""
    perimeter = sum(contour.length for contour in chosen.contours)
    bridged = sum(contour.bridged for contour in chosen.contours)
    return (
        f"Object: area {_net_area(chosen):.1f} px², perimeter {perimeter:.1f} px, {bridged:.1f} px of it across gaps, "
        f"confidence {chosen.confidence:.2f}"
    )


def _net_area(chosen: Selection) -> float:
    return sum(-contour.area if contour.hole else contour.area for contour in chosen.contours)


def _places(flag: str, texts: Sequence[str]) -> list[tuple[float, float]]:
    places = []
    for text in texts:
        numbers = numbers_in(text)
        if len(numbers) != 2 or not np.isfinite(numbers).all():
            raise ValueError(f"{flag} is {shown(text)} but must be two numbers, ROW,COL in px.")
        places.append((numbers[0], numbers[1]))
    return places
