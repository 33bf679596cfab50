"""``cpm info``: shows the properties of an image file."""

from __future__ import annotations

import argparse
import json

from cpm_core.cli.arguments import add_image, add_json
from cpm_core.formats import load_image


def add_to(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command to those of the command line."""
    parser = commands.add_parser("info", help="show the properties of an image file", allow_abbrev=False)
    parser.set_defaults(command=_info)
    parser.description = "Show the size, gray levels and pixel size of an image, and what reading it changed."
    add_image(parser)
    add_json(parser)


def _info(arguments: argparse.Namespace) -> None:
    """Show the properties of an image file."""
    image = load_image(arguments.image)
    low, high = float(image.values.min()), float(image.values.max())
    if arguments.json:
        facts = {
            "source": image.source,
            "shape": list(image.shape),
            "minimum": low,
            "maximum": high,
            "spacing": list(image.spacing) if image.unit else None,
            "unit": image.unit,
            "notes": list(image.notes),
        }
        print(json.dumps(facts))
        return
    print(f"{image.source}: {image.shape[0]} rows x {image.shape[1]} columns, gray levels {low:g} to {high:g}")
    if image.unit:
        print(f"Size of a pixel: {image.spacing[0]:g} x {image.spacing[1]:g} {image.unit} (row x column)")
    else:
        print("Size of a pixel: not given in the file")
    for note in image.notes:
        print(f"Note: {note}")
