"""Options that several commands share, and the parsing of their values."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.formats import IMAGES_READABLE, check_export
from cpm_core.formats.meshes.simplification import Simplification
from cpm_core.formats.sessions.session_file import SESSION_SUFFIX
from cpm_core.image.colors import CONTRAST_CHOICE, LUMINANCE_CHOICE
from cpm_core.image.geometry import CONVENTIONS
from cpm_core.numerics.types import JsonDict
from cpm_core.parameters import AUTOMATIC_PARAMETERS, PARAMETERS, PRESETS, ParameterInfo, Parameters
from cpm_core.parameters.choices import CHOICE_PARAMETERS
from cpm_core.parameters.formatting import format_count, quote_value

_PARAMETER_NAMES = (*PARAMETERS, *CHOICE_PARAMETERS)
"""Names of all parameters."""

CHANNEL_HELP = (
    "A number selects a channel of a file that holds several, from 1; contrast the color whose gray levels vary most."
)
"""Help on channels that are not named."""


def parse_number_or_text(text: str) -> int | float | str:
    """Convert text to a number if it is one; otherwise the check of the value reports the error."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def parse_whole_number(text: str) -> int:
    """Parse a whole number of at least 1, as the type of an option."""
    if not re.fullmatch(r"\d{1,15}", text, re.ASCII) or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{quote_value(text)} must be a whole number of at least 1")
    return int(text)


def parse_number_list(flag: str, text: str, form: str, *, is_xy: bool = False) -> tuple[float, ...]:
    """Parse numbers between commas, in a form such as ROW,COL,RADIUS, or ROW,COL,... for any number of points.

    With `is_xy` places are given as X,Y, or X,Y,Z in a volume.
    """
    axes = 3 if "PLANE" in form else 2
    count = form.replace(",...", "").count(",") + 1
    if is_xy:
        form = form.replace("PLANE,ROW,COL", "X,Y,Z").replace("ROW,COL", "X,Y")
    try:
        numbers = tuple(map(float, text.split(",")))
    except ValueError:
        numbers = ()
    fits = len(numbers) % count == 0 if form.endswith("...") else len(numbers) == count
    if not numbers or not fits or not np.isfinite(numbers).all():
        raise ValueError(f"{flag} is {quote_value(text)} but must be numbers between commas, {form}.")
    return _reverse_places(numbers, axes) if is_xy else numbers


def parse_number_ranges(flag: str, text: str, count: int, what: str, owner: str) -> list[int]:
    """Parse numbers of what an owner has, from 1 to a count: all, or numbers and ranges between commas."""
    if text == "all":
        return list(range(1, count + 1))
    numbers: list[int] = []
    for part in text.replace(" ", "").split(","):
        ends = re.fullmatch(r"([0-9]{1,9})(?:-([0-9]{1,9}))?", part)
        if ends is None:
            raise ValueError(f"{flag} is {quote_value(text)} but must be all, or numbers and ranges such as 1,3,5-9.")
        first, last = int(ends[1]), int(ends[2] or ends[1])
        outside = next((number for number in (first, last) if not 1 <= number <= count), None)
        if outside is not None:
            raise ValueError(f"{flag} names {what} {outside}, but {owner} has {format_count(count, what)}.")
        numbers += range(first, last + 1) if first <= last else range(first, last - 1, -1)
    if len(set(numbers)) < len(numbers):
        raise ValueError(f"{flag} is {quote_value(text)} but lists a {what} twice: list each once.")
    return numbers


def _reverse_places(numbers: tuple[float, ...], axes: int) -> tuple[float, ...]:
    """Reverse the axes of each place; a radius after the places stays."""
    last = len(numbers) // axes * axes
    return (*(number for at in range(0, last, axes) for number in numbers[at : at + axes][::-1]), *numbers[last:])


def group_coordinates(numbers: Sequence[float], axes: int) -> tuple[tuple[float, ...], ...]:
    """Group numbers into points of `axes` numbers each."""
    return tuple(zip(*(numbers[axis::axes] for axis in range(axes)), strict=True))


_SHARED_OPTIONS: dict[str, JsonDict] = {
    "image": {
        "metavar": "IMAGE",
        "help": "The image, or - for one on standard input. Its format is one of "
        f"{', '.join(IMAGES_READABLE)}; an address of fsspec does as well.",
    },
    "images": {
        "metavar": "IMAGE",
        "nargs": "+",
        "help": "Images, folders of images, or patterns such as *.tif. Formats are "
        f"{', '.join(IMAGES_READABLE)}; addresses of fsspec do as well.",
    },
    "--session": {
        "metavar": "FILE",
        "help": f"Session file ({SESSION_SUFFIX}) with image, start, limits and parameters.",
    },
    "--page": {"metavar": "N", "help": "Plane, page or frame of a file that holds several, from 1."},
    "--time": {"metavar": "N", "help": "Point in time of a file that holds several, from 1."},
    "--channel": {
        "metavar": "N|NAME",
        "help": f"Channel of a color image by its name, such as green. {CHANNEL_HELP}",
    },
    "--series": {
        "metavar": "N|NAME",
        "help": "Series of a TIFF or of a folder of DICOM files, or array of an archive.",
    },
    "--pixel-size": {
        "metavar": "SIZE",
        "help": "Size of a pixel where the file states none, such as 0.25um. Of rows and columns 0.5x0.25um, of "
        "planes, rows and columns 2x0.5x0.5mm.",
    },
    "--xy": {
        "action": "store_true",
        "help": "Give places as X,Y instead of ROW,COL. In a volume they are X,Y,Z instead of PLANE,ROW,COL.",
    },
    "--preset": {"metavar": "NAME", "choices": tuple(PRESETS)},
    "--max-steps": {"metavar": "N", "type": parse_whole_number, "help": "Stop each run after N steps."},
    "--space": {
        "choices": CONVENTIONS,
        "help": "Coordinates in files of a surface or of center lines. LPS (default): to the left, back and head of a "
        "patient; RAS: to the right, front and head.",
    },
    "--surface-smoothing": {
        "metavar": "ROUNDS",
        "type": parse_whole_number,
        "help": "Smooth a surface before it is written, and say how far this moves it (default: 0).",
    },
    "--surface-triangles": {
        "metavar": "SHARE",
        "type": float,
        "help": "Write this share of the triangles of a surface, such as 0.25 (default: 1).",
    },
    "--export": {"metavar": "PATH", "nargs": "+", "action": "extend", "default": []},
    "--workers": {
        "metavar": "N",
        "type": parse_whole_number,
        "help": "Number of processes to work in, each on one core (default: all cores).",
    },
    "--scheduler": {
        "metavar": "ADDRESS",
        "help": "Work on a dask cluster that sees the same files. dask trusts its network: anyone who reaches the "
        "scheduler can run programs on its workers.",
    },
}
"""Options that several commands share; see `parse_part` for those that select a part of a file."""

SURFACE_OPTIONS = ("--space", "--surface-smoothing", "--surface-triangles")
"""Options of files of surfaces."""

SURFACE_FIELDS = tuple(name.removeprefix("--").replace("-", "_") for name in SURFACE_OPTIONS)
"""Their names among the arguments."""

PART_OPTIONS = ("--page", "--time", "--series", "--pixel-size")
"""Options for the part of a file, and for setting the size of a pixel."""

EXPORT_HELP = (
    "Write {what}, each file in the format of its suffix. A name such as -.csv is standard output. "
    "Suffixes: {suffixes}."
)
"""Help on files to write."""


def add_options(parser: argparse._ActionsContainer, *names: str, **changes: Any) -> None:
    """Add shared options, with changes of their settings."""
    for name in names:
        parser.add_argument(name, **(_SHARED_OPTIONS[name] | changes))


_NUMBER_PATTERN = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
"""A number, with or without an exponent."""

_PIXEL_SIZE_PATTERN = re.compile(rf"({_NUMBER_PATTERN}(?:x{_NUMBER_PATTERN}){{0,2}})(nm|um|µm|μm|mm|cm|m)")
"""One to three sizes of a pixel, and their unit."""


def parse_part(arguments: argparse.Namespace, *, volume: bool = False, runs: bool = True) -> JsonDict:
    """Return the keyword arguments of `load_image` or `load_volume`, and settle which channel a run takes.

    A channel given by its number, or as the one of the largest contrast, is selected on reading. A named one is a
    parameter of a run on an image; for a volume, or where the command `runs` nothing, it is selected on reading too.
    """
    given = {name: getattr(arguments, name) for name in ("page", "time", "series")}
    part: JsonDict = {name: parse_number_or_text(text) for name, text in given.items() if text is not None}
    if volume and "page" in part:
        raise ValueError(f"--page is {part['page']}, but a volume uses all pages of {arguments.image}: leave it out.")
    channel, in_reading = arguments.channel, volume or not runs
    if channel is not None and not isinstance(parse_number_or_text(channel), str):
        part["channel"], arguments.channel = parse_number_or_text(channel), LUMINANCE_CHOICE
    elif channel == CONTRAST_CHOICE:
        part["color"], arguments.channel = channel, LUMINANCE_CHOICE
    elif channel is not None:
        part["color"] = channel if in_reading else LUMINANCE_CHOICE
    if in_reading:
        arguments.channel = None
    if arguments.pixel_size is not None:
        size = _PIXEL_SIZE_PATTERN.fullmatch(arguments.pixel_size.replace(" ", ""))
        if size is None:
            raise ValueError(
                f"--pixel-size is {quote_value(arguments.pixel_size)} but must be one to three sizes and a unit (nm, "
                "um, mm, cm or m), such as 0.25um or 2x0.5x0.5mm."
            )
        part |= {"spacing": tuple(map(float, size[1].split("x"))), "unit": size[2]}
    return part


def add_parameter_options(
    parser: argparse._ActionsContainer, names: Sequence[str] = _PARAMETER_NAMES, defaults: Sequence[Parameters] = ()
) -> None:
    """Add parameters, each as a flag of its name; see `parse_parameters`. `defaults` are of images, and of volumes."""
    for name in names:
        own = dict.fromkeys(str(getattr(one, name)) for one in defaults)
        limits = [] if name in CHOICE_PARAMETERS else [_describe_range(PARAMETERS[name])]
        limits += [f"default: {', in a volume '.join(own)}"] if own else []
        addition = f" ({'; '.join(limits)})" if limits else ""
        parser.add_argument(
            "--" + name.replace("_", "-"),
            metavar="NAME" if name in CHOICE_PARAMETERS else "X",
            type=str if name in CHOICE_PARAMETERS else parse_number_or_text,
            help=f"{_describe_parameter(name)}{addition}".replace("%", "%%"),
        )


def _describe_parameter(name: str) -> str:
    """Describe a parameter in sentences."""
    if name not in CHOICE_PARAMETERS:
        return f"{PARAMETERS[name].meaning} {PARAMETERS[name].effect_of_larger}"
    choice = CHOICE_PARAMETERS[name]
    effects = " ".join(f"{value}: {effect}" for value, effect in choice.choices.items())
    return f"{choice.meaning} {effects} {CHANNEL_HELP if name == 'channel' else ''}".rstrip()


def _describe_range(info: ParameterInfo) -> str:
    """Describe the values that a parameter can have."""
    values = f"{info.low:g} to {info.high:g}"
    return f"{values}, or auto: derived from the image" if info.name in AUTOMATIC_PARAMETERS else values


def parse_parameters(arguments: argparse.Namespace, base: Parameters) -> Parameters:
    """Return the parameters `base` with those given as flags replaced; ValueError on a bad value."""
    given = {field.name: getattr(arguments, field.name, None) for field in fields(Parameters)}
    return replace(base, **{name: value for name, value in given.items() if value is not None})


def collect_surface_options(arguments: argparse.Namespace) -> JsonDict:
    """Return the options of `export` for files of surfaces; ValueError when one is out of range."""
    given = {name: getattr(arguments, name) for name in SURFACE_FIELDS if getattr(arguments, name) is not None}
    Simplification(given.get("surface_smoothing", 0), given.get("surface_triangles", 1.0))
    return given


def refuse_options(arguments: argparse.Namespace, names: Iterable[str], purpose: str) -> None:
    """Raise ValueError when an option is given that has no meaning here."""
    for name in names:
        if getattr(arguments, name):
            raise ValueError(f"--{name.replace('_', '-')} is for {purpose}: leave it out.")


_READ_ARGUMENTS = ("image", "session", "source", "start", "points", "truth", "within")
"""Arguments that name files to read."""


def check_targets(paths: Iterable[str | Path], arguments: argparse.Namespace, image: str | Path | None = None) -> None:
    """Raise ValueError when a file to be written is one that the command reads; `image` is the one of a session."""
    read: list[str | Path] = [] if image is None else [image]
    for name in _READ_ARGUMENTS:
        given = getattr(arguments, name, None)
        read += [given] if isinstance(given, str) else given or []
    kept = {Path(path).resolve() for path in read}
    for path in paths:
        if Path(path).resolve() in kept:
            raise ValueError(f"{path} would overwrite a file that is read: choose another name.")


def check_exports(paths: Sequence[str], arguments: argparse.Namespace, image: str | Path | None = None) -> None:
    """Raise ValueError unless each path can be written and none is a file that is read."""
    for path in paths:
        check_export(path)
    check_targets(paths, arguments, image)
