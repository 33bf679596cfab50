"""``cpm info``: shows the properties of an image or volume."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from cpm_core.cli.arguments import add_json
from cpm_core.cli.inputs import add_part, color_read, part_of
from cpm_core.cli.outcome import IN_PART, print_json
from cpm_core.cli.place import facts_on, lines_on
from cpm_core.cli.terminal import say
from cpm_core.formats import READABLE, holds_volume, load_image, load_volume
from cpm_core.image.image import Image


def add_to(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command to those of the command line."""
    parser = commands.add_parser("info", help="show the properties of an image or volume", allow_abbrev=False)
    parser.set_defaults(command=_info)
    parser.description = (
        "Show the size, gray levels, pixel size and place in space of an image or volume, and what reading it changed."
    )
    parser.add_argument(
        "images", metavar="IMAGE", nargs="+", help=f"image, folder or pattern such as *.tif ({', '.join(READABLE)})"
    )
    add_part(parser, channel=True)
    parser.add_argument("--volume", action="store_true", help="take all planes of a file that holds several")
    add_json(parser)


def _info(arguments: argparse.Namespace) -> int:
    """Show the properties of images or volumes; of several, each that cannot be read is told, and the others follow."""
    part = part_of(arguments)
    part |= color_read(part, arguments)
    single = len(arguments.images) == 1
    facts: list[dict[str, Any]] = []
    for path in arguments.images:
        try:
            image = _loaded(path, part, arguments.volume)
        except ValueError as error:
            if single:
                raise
            say(f"cpm: {error}")
            facts.append({"source": Path(path).name, "path": path, "trouble": str(error)})
            continue
        facts.append({"source": image.source, "path": path, **_facts(image)})
        if not arguments.json:
            for line in _lines(image):
                print(line)
    if arguments.json:
        print_json("info", {**(facts[0] if single else {}), "images": facts})
    return IN_PART if any("trouble" in one for one in facts) else 0


def _loaded(path: str, part: Mapping[str, Any], as_volume: bool) -> Image:
    volume = as_volume or ("page" not in part and holds_volume(path, part.get("series")))
    return (load_volume if volume else load_image)(path, **part)


def _facts(image: Image) -> dict[str, Any]:
    low, high = float(image.values.min()), float(image.values.max())
    place = facts_on(image)
    return {"shape": list(image.shape), "minimum": low, "maximum": high, **place, "notes": list(image.notes)}


def _lines(image: Image) -> Iterator[str]:
    axes = ("planes", "rows", "columns")[-image.ndim :]
    size = " x ".join(f"{count} {axis}" for count, axis in zip(image.shape, axes, strict=True))
    low, high = float(image.values.min()), float(image.values.max())
    yield f"{image.source}: {size}, gray levels {low:g} to {high:g}"
    yield from lines_on(image)
    for note in image.notes:
        yield f"Note: {note}"
