"""Images on the command line: files, folders, and patterns that the shell has not replaced by files."""

from __future__ import annotations

import argparse
import glob
import os
import re
from collections.abc import Sequence
from pathlib import Path

from cpm_core.cli.inputs.named_files import check_names
from cpm_core.formats import READABLE
from cpm_core.formats.images.medical.dicom.reader import is_series
from cpm_core.parameters.quotation import shown


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
