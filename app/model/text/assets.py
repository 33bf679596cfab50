"""Where the program's own files are: samples and icons, in a checkout as in an installed package."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[2]
_PLACES = (_PACKAGE / "assets", _PACKAGE.parent / "assets")


def asset(name: str) -> Path:
    """Path of one of the program's own files.

    Parameters
    ----------
    name : str
        Path inside the assets, such as ``"icons/run.svg"``.

    Raises
    ------
    ValueError
        When there is no such file; the message says that the installation is incomplete.
    """
    for place in _PLACES:
        path = place / name
        if path.exists():
            return path
    raise ValueError(
        f"The file {name} is missing from this installation of CPM; installing it again should bring it back."
    )


def folder(name: str) -> Path | None:
    """Path of a folder in the assets that need not be there; None when it is not."""
    return next((place / name for place in _PLACES if (place / name).is_dir()), None)
