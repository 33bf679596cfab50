"""What commands take: images and the parts of them that are read, sessions, starts, and ground truths."""

from __future__ import annotations

import argparse
import glob
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from cpm_core.cli.terminal import say
from cpm_core.contours.ground_truth import Truth
from cpm_core.contours.surface.ground_truth import VolumeTruth
from cpm_core.formats import (
    CONTOURS_READABLE,
    FOR_CENTERLINES,
    READABLE,
    SURFACES_READABLE,
    load_centerlines,
    load_surface,
)
from cpm_core.formats.contours.reading.contour_file import plane_of, read_contours
from cpm_core.formats.ground_truth_file import load_truth, load_volume_truth
from cpm_core.formats.images.dicom import is_series
from cpm_core.formats.sessions.chosen_part import part_for
from cpm_core.formats.sessions.session_file import SessionFile, find_image, load_session
from cpm_core.image.colors import CONTRAST, LUMINANCE
from cpm_core.image.image import Image
from cpm_core.parameters.quotation import shown
from cpm_core.shapes import Points, Polygon, Stroke
from cpm_core.shapes.outlines import start_on_surface, starts_along, starts_in


def as_number(text: str) -> int | float | str:
    """Convert text to a number if it is one; else the check of the value reports the error."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def numbers_in(text: str) -> list[float]:
    """Numbers between commas; an empty list when a part is not a number."""
    parts = [as_number(part.strip()) for part in text.split(",")]
    numbers = [float(part) for part in parts if not isinstance(part, str)]
    return numbers if len(numbers) == len(parts) else []


_READ = {
    "image": "the image itself",
    "session": "the session file itself",
    "source": "the file that it is made from",
    "start": "the start",
    "points": "the points of the start",
    "truth": "the ground truth",
    "within": "the mask",
}
"""Arguments that name files to read -> what these are called."""

_POSITIONAL = {"image": "IMAGE", "images": "IMAGE", "source": "FILE"}
_NAMING = (*_READ, "images", "export", "to", "output", "save_session")
"""Arguments that name files or folders."""


def check_names(arguments: argparse.Namespace) -> None:
    """Raise ValueError when a file or a folder is named by nothing, as by a variable of the shell that is not set."""
    for name in _NAMING:
        if "" in _given(arguments, name):
            called = f"--{name.replace('_', '-')}"
            if name in _POSITIONAL and not (name == "image" and hasattr(arguments, "source")):
                called = _POSITIONAL[name]
            raise ValueError(f"{called} is empty: give the name of a file, or leave it out.")


def check_kept(
    paths: Iterable[str | Path], arguments: argparse.Namespace, image: str | Path | None = None, flag: str = "--export"
) -> None:
    """Raise ValueError when a file to be written is one that the command reads, also by another name or through a link.

    `image` is the one that a session names.
    """
    kept = {Path(path).resolve(): what for name, what in _READ.items() for path in _given(arguments, name)}
    if image is not None:
        kept[Path(image).resolve()] = "the stack itself" if getattr(arguments, "pages", None) else _READ["image"]
    for path in paths:
        what = kept.get(Path(path).resolve())
        if what is not None:
            raise ValueError(f"{flag} {path} would overwrite {what}: choose another name.")


def _given(arguments: argparse.Namespace, name: str) -> Iterator[str]:
    """What an argument names, which the command may not have, and may have several times."""
    given = getattr(arguments, name, None)
    yield from (given,) if isinstance(given, str) else given or ()


def expanded(given: Sequence[str]) -> list[str]:
    """The images that files, folders and patterns name.

    A folder stands for the images in it, in the order of the numbers in their names; one with the slices of a DICOM
    series for itself. ValueError for a folder or a pattern without images; a file need not be there.
    """
    found: list[str] = []
    for text in given:
        if os.path.lexists(text):
            found += _in_folder(Path(text)) if Path(text).is_dir() else [text]
        elif glob.has_magic(text):
            names = sorted(filter(os.path.isfile, glob.glob(text, recursive=True)), key=_natural)  # noqa: PTH207 - names as given
            if not names:
                raise ValueError(f"No file is named like {shown(text)}: check the pattern and the folder.")
            found += names
        else:
            found.append(text)
    return found


def only_image(given: str) -> str:
    """The image that a file, a folder or a pattern names; ValueError when it names several."""
    found = expanded([given])
    if len(found) > 1:
        what = "is a folder with" if Path(given).is_dir() else "names"
        raise ValueError(
            f"{shown(given)} {what} {len(found)} images, but one is taken here: name it, or use cpm batch."
        )
    return found[0]


def use_files(arguments: argparse.Namespace) -> None:
    """Replace folders and patterns among the arguments of a command by images."""
    check_names(arguments)
    image, images = getattr(arguments, "image", None), getattr(arguments, "images", None)
    if image is not None:
        arguments.image = only_image(image)
    if images is not None:
        arguments.images = expanded(images)


def _in_folder(folder: Path) -> list[str]:
    if is_series(folder):
        return [str(folder)]
    try:
        inside = [entry for entry in folder.iterdir() if entry.suffix.lower() in READABLE and entry.is_file()]
    except OSError as error:
        raise ValueError(f"{folder} cannot be read: {error.strerror or error}.") from error
    if not inside:
        raise ValueError(f"{folder} is a folder without images: choose another one, or name a file.")
    return sorted(map(str, inside), key=_natural)


def _natural(name: str) -> list[tuple[int, str]]:
    """Key by which a2 comes before a10."""
    return [(int(part), "") if part.isdecimal() else (-1, part.lower()) for part in re.split(r"(\d+)", name)]


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


def session_of(arguments: argparse.Namespace) -> SessionFile:
    """The session that is named, else an empty one; ValueError when there is no image."""
    session = load_session(Path(arguments.session)) if arguments.session else SessionFile()
    if arguments.image is None and session.image is None:
        raise ValueError("No IMAGE is given: name one, or with --session FILE a session that has one.")
    return session


def in_volume(session: SessionFile) -> bool:
    """Whether a session is about a volume."""
    return session.image is not None and len(session.image.shape) == 3


def image_of(named: str | None, session: SessionFile, source: str | Path | None) -> tuple[Path, tuple[str, ...]]:
    """Path of the image that is named, or else of that of the session of a file, and notes on it."""
    if named is not None or session.image is None or source is None:
        return Path(named or ""), ()
    return find_image(session.image, Path(source).absolute().parent)


def reading_of(named: str | None, session: SessionFile, path: Path) -> dict[str, Any]:
    """How a session says that the image at a path is read: its own, or the one that is named."""
    if session.image is None:
        return {}
    reading = session.image.reading
    return reading.arguments if named is None else part_for(path, reading)


def starts_from_files(arguments: argparse.Namespace, image: Image) -> tuple[Polygon | Stroke | Points, ...]:
    """Starts along the contours of the files of ``--start``."""
    return tuple(start for path in arguments.start for start in starts_from_file(path, image))


def starts_from_file(path: str, image: Image) -> tuple[Polygon | Stroke | Points, ...]:
    """Starts along the contours of one file; what was left out of it is said."""
    found = read_contours(path, plane_of(image))
    for note in found.notes:
        say(f"cpm: {Path(path).name}: {note}")
    return starts_along(found.contours, found.places)


def in_space(arguments: argparse.Namespace) -> bool:
    """Whether a file of a start holds what only volumes have, a surface or center lines."""
    return any(Path(path).suffix.lower() in {*SURFACES_READABLE, *FOR_CENTERLINES} for path in arguments.start)


def starts_in_volume(arguments: argparse.Namespace, volume: Image) -> tuple[Points | Stroke, ...]:
    """Starts on the surfaces and along the center lines of the files of ``--start``, in a volume."""
    starts: list[Points | Stroke] = []
    for path in arguments.start:
        if Path(path).suffix.lower() in CONTOURS_READABLE:
            raise ValueError(f"--start {path} has contours, which lie in a plane: name a surface or center lines.")
        if Path(path).suffix.lower() in FOR_CENTERLINES:
            starts += starts_in(load_centerlines(path, volume, tell=_tell))
        else:
            starts.append(start_on_surface(load_surface(path, volume, tell=_tell)))
    return tuple(starts)


def _tell(note: str) -> None:
    say(f"cpm: {note}")


def truth_for(arguments: argparse.Namespace, image: Image) -> Truth | None:
    """The ground truth that is named, of this image."""
    if arguments.truth is None:
        return None
    return load_truth(arguments.truth, image.shape, spacing=image.spacing, unit=image.unit)


def volume_truth_for(arguments: argparse.Namespace, volume: Image) -> VolumeTruth | None:
    """The ground truth that is named, of this volume."""
    return None if arguments.truth is None else load_volume_truth(arguments.truth, volume)
