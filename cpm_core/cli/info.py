"""``cpm info``: shows the properties of an image or volume."""

from __future__ import annotations

import argparse
from pathlib import Path

from cpm_core.cli.arguments import PART_OPTIONS, add_options, parse_part
from cpm_core.cli.output import EXIT_IN_PART, collect_geometry_facts, describe_geometry, print_json, print_message
from cpm_core.formats import holds_volume, load_image, load_volume
from cpm_core.formats.common.content import find_local_file
from cpm_core.numerics.types import JsonDict


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_options(parser, "images", *PART_OPTIONS, "--channel")
    parser.add_argument("--volume", action="store_true", help="Take all planes of a file that holds several.")


def show_info(arguments: argparse.Namespace) -> int:
    """Show the properties of images or volumes; of several, each that cannot be read is reported."""
    part = parse_part(arguments, runs=False)
    single = len(arguments.images) == 1
    facts: list[JsonDict] = []
    for path in arguments.images:
        try:
            local = find_local_file(path)
            volume = arguments.volume or ("page" not in part and holds_volume(local, part.get("series")))
            image = (load_volume if volume else load_image)(local, **part)
        except ValueError as error:
            if single:
                raise
            print_message(str(error))
            facts.append({"source": Path(path).name, "path": path, "trouble": str(error)})
            continue
        low, high = map(float, image.gray_range)
        values = {"shape": list(image.shape), "minimum": low, "maximum": high, **collect_geometry_facts(image)}
        facts.append({"source": image.source, "path": path, **values, "notes": list(image.notes)})
        if not arguments.json:
            axes = ("planes", "rows", "columns")[-image.ndim :]
            size = " x ".join(f"{count} {axis}" for count, axis in zip(image.shape, axes, strict=True))
            print(f"{image.source}: {size}, gray levels {low:g} to {high:g}")
            print(*describe_geometry(image), *(f"Note: {note}" for note in image.notes), sep="\n")
    if arguments.json:
        print_json(arguments.name, {**(facts[0] if single else {}), "images": facts})
    return EXIT_IN_PART if any("trouble" in one for one in facts) else 0
