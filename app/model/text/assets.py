"""The program's own files, such as samples and icons, in a checkout or in an installed package."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[2]
_PLACES = (_PACKAGE / "assets", _PACKAGE.parent / "assets")


def asset(name: str) -> Path:
    """Path of one of the program's own files, such as ``"icons/run.svg"``.

    ValueError when it is missing, because the installation is incomplete.
    """
    for place in _PLACES:
        path = place / name
        if path.exists():
            return path
    raise ValueError(
        f"The file {name} is missing from this installation of CPM; installing it again should bring it back."
    )


def folder(name: str) -> Path | None:
    """Path of an optional folder in the assets; None when it does not exist."""
    return next((place / name for place in _PLACES if (place / name).is_dir()), None)
