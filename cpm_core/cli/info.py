"""``cpm info``: shows the properties of an image or volume."""

from __future__ import annotations

import argparse
import json

from cpm_core.cli.arguments import add_image, add_json, add_part, part_of
from cpm_core.cli.place import facts_on, lines_on
from cpm_core.formats import holds_volume, load_image, load_volume


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
    if arguments.channel is not None:  # a color, which only runs take as a parameter
        part["color"] = arguments.channel
    volume = arguments.volume or ("page" not in part and holds_volume(arguments.image, part.get("series")))
    image = (load_volume if volume else load_image)(arguments.image, **part)
    low, high = float(image.values.min()), float(image.values.max())
    if arguments.json:
        facts = {
            "source": image.source,
            "shape": list(image.shape),
            "minimum": low,
            "maximum": high,
            **facts_on(image),
            "notes": list(image.notes),
        }
        print(json.dumps(facts))
        return
    axes = ("planes", "rows", "columns")[-image.ndim :]
    size = " x ".join(f"{count} {axis}" for count, axis in zip(image.shape, axes, strict=True))
    print(f"{image.source}: {size}, gray levels {low:g} to {high:g}")
    for line in lines_on(image):
        print(line)
    for note in image.notes:
        print(f"Note: {note}")
