"""All that is made for the documentation, into one folder next to its pages."""

from __future__ import annotations

import shutil
from pathlib import Path

from making import command_line, figures, formats, headers, notebooks, parameters, reference, rows

ROOT = Path(__file__).parents[2]
"""The folder of the project."""


def make(folder: Path) -> None:
    """Write pages and figures anew."""
    shutil.rmtree(folder, ignore_errors=True)
    written = {
        "parameters.md": parameters.table(),
        "presets.md": parameters.presets(),
        "command_line.md": command_line.text(),
        "readable.md": formats.readable(),
        "writable.md": formats.writable(),
        "headers.md": headers.headers(),
        "contours_readable.md": formats.contours_readable(),
        "surfaces_readable.md": formats.surfaces_readable(),
        "rows.md": rows.table(),
        **reference.pages(),
    }
    for name, text in written.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    figures.draw(folder / "figures")
    notebooks.make(ROOT / "docs" / "notebooks", folder / "notebooks", ROOT)
