"""The files that a command line names: none without a name, and none that is read is replaced."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from pathlib import Path

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
