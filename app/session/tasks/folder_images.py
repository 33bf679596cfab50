"""The images of a folder in the order in which people count, and the sessions beside them."""

from __future__ import annotations

import os
import re
from pathlib import Path

from cpm_core.formats import READABLE
from cpm_core.formats.sessions.session_file import SUFFIX, find_image, load_session

_NUMBER = re.compile(r"(\d+)")


def images_beside(image: Path) -> tuple[Path, ...]:
    """The images in the folder of an image, this one among them: 2 comes before 10."""
    others = {path.name for path in images_in(image.parent)}
    return tuple(image.parent / name for name in sorted(others | {image.name}, key=_counted))


def images_in(folder: Path) -> tuple[Path, ...]:
    """The images in a folder; none in one that cannot be read."""
    try:
        with os.scandir(folder) as entries:
            names = [entry.name for entry in entries if _is_image(entry)]
    except OSError:
        return ()
    return tuple(folder / name for name in sorted(names, key=_counted))


def session_beside(image: Path) -> Path | None:
    """The session of an image in its folder, of the same name, or None when there is none that can be used."""
    path = image.with_suffix(SUFFIX)
    if path == image or not path.is_file():
        return None
    try:
        file = load_session(path).image
        found, _ = find_image(file, path.absolute().parent) if file is not None else (None, ())
    except ValueError:
        return None
    return path if found is not None and found == image.resolve() else None


def _is_image(entry: os.DirEntry[str]) -> bool:
    return Path(entry.name).suffix.lower() in READABLE and not entry.name.startswith(".") and entry.is_file()


def _counted(name: str) -> tuple[list[str | int], str]:
    """Key of the natural order: numbers count by value, letters regardless of case."""
    parts = _NUMBER.split(name.casefold())
    return [int(part) if index % 2 else part for index, part in enumerate(parts)], name
