"""``cpm info``: shows the properties of an image or volume."""

from __future__ import annotations

import argparse
import json

from cpm_core.cli.arguments import add_image, add_json, add_part, part_of
from cpm_core.formats import holds_volume, load_image, load_volume
from cpm_core.image.geometry import Geometry
from cpm_core.image.image import Image

_ENDS = {"L": "left", "R": "right", "P": "back", "A": "front", "S": "head", "I": "feet"}


def add_to(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command to those of the command line."""
    parser = commands.add_parser("info", help="show the properties of an image or volume", allow_abbrev=False)
    parser.set_defaults(command=_info)
    parser.description = (
        "Show the size, gray levels, pixel size and place in space of an image or volume, and what reading it changed."
    )
    add_image(parser)
    add_part(parser, channel=True)
    parser.add_argument("--volume", action="store_true", help="take all planes of a file that holds several")
    add_json(parser)


def _info(arguments: argparse.Namespace) -> None:
    """Show the properties of an image or volume."""
    part = part_of(arguments)
    volume = arguments.volume or ("page" not in part and holds_volume(arguments.image, part.get("series")))
    image = (load_volume if volume else load_image)(arguments.image, **part)
    low, high = float(image.values.min()), float(image.values.max())
    if arguments.json:
        facts = {
            "source": image.source,
            "shape": list(image.shape),
            "minimum": low,
            "maximum": high,
            "spacing": list(image.spacing) if image.unit else None,
            "unit": image.unit,
            "geometry": None if image.geometry is None else _facts_of(image.geometry, image),
            "notes": list(image.notes),
        }
        print(json.dumps(facts))
        return
    axes = ("planes", "rows", "columns")[-image.ndim :]
    size = " x ".join(f"{count} {axis}" for count, axis in zip(image.shape, axes, strict=True))
    print(f"{image.source}: {size}, gray levels {low:g} to {high:g}")
    what = "pixel" if image.ndim == 2 else "voxel"
    if image.unit:
        sides = " x ".join(f"{side:g}" for side in image.spacing)
        order = " x ".join(("plane", "row", "column")[-image.ndim :])
        print(f"Size of a {what}: {sides} {image.unit} ({order})")
    else:
        print(f"Size of a {what}: not given in the file")
    if image.geometry is not None:
        print(_place(image.geometry, image))
    for note in image.notes:
        print(f"Note: {note}")


def _place(geometry: Geometry, image: Image) -> str:
    """Where an image lies, as lines for a person."""
    x, y, z = geometry.origin
    ways = [f"{axis} to the {_ENDS[letter]}" for axis, letter in zip(_AXES, geometry.letters, strict=True)]
    turned = f", up to {geometry.oblique:.1f}° oblique" if geometry.oblique >= _OBLIQUE else ""
    return (
        f"Orientation: {', '.join(ways[-image.ndim :])}{turned}\n"
        f"First {'pixel' if image.ndim == 2 else 'voxel'}: at ({x:g}, {y:g}, {z:g}) {image.unit}, {geometry.convention}"
    )


_AXES = ("planes", "rows", "columns")
_OBLIQUE = 0.05
"""Angle from which axes are called oblique [degrees]."""


def _facts_of(geometry: Geometry, image: Image) -> dict[str, object]:
    """Where an image lies, as plain JSON."""
    return {
        "origin": list(geometry.origin),
        "directions": [list(direction) for direction in geometry.directions],
        "convention": geometry.convention,
        "letters": "".join(geometry.letters),
        "affine": geometry.affine(image.spacing).tolist(),
    }
