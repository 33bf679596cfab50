"""Which part of a file is read, and the size of a pixel by hand."""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping
from typing import Any

from cpm_core.cli.inputs.numbers import as_number
from cpm_core.image.colors import CONTRAST, LUMINANCE
from cpm_core.parameters.quotation import shown

CHANNEL_HELP = (
    "Or its number in a file that holds several, from 1; or contrast, for the color whose gray levels vary the most."
)

_SIZE = re.compile(r"(?P<sides>[0-9.eE+-]+(?:x[0-9.eE+-]+){0,2})(?P<unit>nm|um|µm|μm|mm|cm|m)")
"""Sizes of a pixel and their unit."""


def add_part(parser: argparse._ActionsContainer, channel: bool = False) -> None:
    """Add which part of a file is read, and the size of a pixel by hand; see `part_of`.

    With `channel` the channel as well, which commands with a parameter of that name take from there.
    """
    parser.add_argument("--page", metavar="N", help="plane, page or frame of a file that holds several, from 1")
    parser.add_argument("--time", metavar="N", help="point in time of a file that holds several, from 1")
    if channel:
        parser.add_argument("--channel", metavar="N", help=CHANNEL_HELP)
    parser.add_argument(
        "--series", metavar="N|NAME", help="series of a TIFF or of a folder of DICOM files, or array of an archive"
    )
    parser.add_argument(
        "--pixel-size",
        metavar="SIZE",
        help="size of a pixel where the file does not tell, such as 0.25um, of rows and columns 0.5x0.25um, "
        "of planes, rows and columns 2x0.5x0.5mm",
    )


def part_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """What `load_image` and `load_volume` are told beside the path; ValueError when a size of a pixel is no size.

    A channel that is a number, or that with the largest contrast, is chosen in reading and no parameter of the run;
    one that is named is a parameter. Either comes before those of a session.
    """
    part: dict[str, Any] = {
        name: as_number(given) for name in ("page", "time", "series") if (given := getattr(arguments, name)) is not None
    }
    channel = None if arguments.channel is None else as_number(arguments.channel)
    if channel == CONTRAST or not isinstance(channel, str | None):
        part["color" if channel == CONTRAST else "channel"], arguments.channel = channel, LUMINANCE
    elif channel is not None:
        part["color"] = LUMINANCE
    if arguments.pixel_size is not None:
        size = _SIZE.fullmatch(arguments.pixel_size.replace(" ", ""))
        numbers = [] if size is None else [as_number(side) for side in size["sides"].split("x")]
        if size is None or any(isinstance(number, str) for number in numbers):
            raise ValueError(
                f"--pixel-size is {shown(arguments.pixel_size)} but must be one to three sizes and a unit (nm, um, mm, "
                "cm or m), such as 0.25um or 2x0.5x0.5mm."
            )
        part |= {"spacing": numbers[0] if len(numbers) == 1 else numbers, "unit": size["unit"]}
    return part


def color_read(part: Mapping[str, Any], arguments: argparse.Namespace) -> dict[str, Any]:
    """What chooses a named channel in reading, where there is no run that takes it as a parameter."""
    named, arguments.channel = arguments.channel, None
    return {"color": named} if part.get("color") == LUMINANCE else {}


def part_of_volume(arguments: argparse.Namespace) -> dict[str, Any]:
    """What `load_volume` is told beside the path; ValueError for what would leave a plane."""
    part = part_of(arguments)
    if "page" in part:
        raise ValueError(f"--page is {part['page']}, but a volume takes all pages of {arguments.image}: leave it out.")
    return part | color_read(part, arguments)
