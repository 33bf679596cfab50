"""The program's own files, such as samples and icons, in a checkout or in an installed package."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

_PACKAGE_FOLDER = Path(__file__).resolve().parents[2]
_ASSET_FOLDERS = (_PACKAGE_FOLDER / "assets", _PACKAGE_FOLDER.parents[1] / "assets")


def find_asset(name: str) -> Path:
    """Return the path of one of the program's own files, such as ``"icons/run.svg"``.

    ValueError when it is missing, because the installation is incomplete.
    """
    for place in _ASSET_FOLDERS:
        path = place / name
        if path.exists():
            return path
    raise ValueError(
        f"The file {name} is missing from this installation of CPM; installing it again should bring it back."
    )


def find_asset_folder(name: str) -> Path | None:
    """Return the path of an optional folder in the assets; None when it does not exist."""
    return next((place / name for place in _ASSET_FOLDERS if (place / name).is_dir()), None)


class GuideBlock(NamedTuple):
    """A heading (``# ``), a step (``1. ``) or a paragraph of the guide, with the file of its picture if it has one."""

    mark: str
    text: str
    picture: str


_BLOCK_PATTERN = re.compile(r"(# |1\. |)(.*?)(?:\n *!\[\]\((.+)\))?", re.DOTALL)


def read_guide_page(name: str) -> list[GuideBlock]:
    """Read a page of the guide: Markdown, one line a block, in which braces name actions."""
    text = find_asset(f"guide/{name}.md").read_text(encoding="utf-8")
    found = (_BLOCK_PATTERN.fullmatch(block) for block in text.strip().split("\n\n"))
    return [GuideBlock(block[1], block[2], block[3] or "") for block in found if block]
