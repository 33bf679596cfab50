"""What is made from the program: tables in the pages, and a folder of parts that only the built documentation has."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

from docs.making import command_line, figures, formats, headers, notebooks, parameters, reference

ROOT = Path(__file__).parents[2]
"""The folder of the project."""

TABLES: Mapping[str, Callable[[], str]] = {
    "parameters": parameters.table,
    "presets": parameters.presets,
    "writable": formats.writable,
}
"""The tables that pages contain, so that they can be read without building the documentation."""

_TABLE = re.compile(r"(<!-- made: (\w+) -->\n).*?(<!-- end -->)", flags=re.DOTALL)


def with_current_tables(page: str) -> str:
    """Return the text of a page with its tables made from the program as it is."""
    return _TABLE.sub(lambda match: f"{match[1]}\n{TABLES[match[2]]()}\n{match[3]}", page)


def update_pages() -> None:
    """Write the tables and the figures of the pages anew."""
    for path in (ROOT / "docs").glob("*.md"):
        text = path.read_text(encoding="utf-8")
        current = with_current_tables(text)
        if current != text:
            path.write_text(current, encoding="utf-8")
    figures.draw(ROOT / "docs" / "figures")


def make(folder: Path) -> None:
    """Write the help of the commands, tables of headers, the reference and the notebooks anew, into a folder."""
    shutil.rmtree(folder, ignore_errors=True)
    parts = {"command_line.md": command_line.text(), "headers.md": headers.headers()}
    for name, text in {**parts, **reference.pages()}.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    notebooks.make(ROOT / "docs" / "notebooks", folder / "notebooks", ROOT)
