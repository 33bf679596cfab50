"""Notebooks: scripts with cells, run when the documentation is built, as pages and as files for Jupyter.

A script is Python with ``# %%`` before each cell and ``# %% [markdown]`` before text, which editors show as cells too.
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

_MARK = "# %%"


@dataclass(frozen=True)
class Cell:
    """A cell: its text, and whether that is code."""

    text: str
    code: bool


def cells(script: str) -> list[Cell]:
    """Split a script into its cells."""
    found = []
    for part in script.split(f"{_MARK}")[1:]:
        head, _, body = part.partition("\n")
        text = body.strip("\n")
        if "[markdown]" in head:
            text = "\n".join(line[2:] if line.startswith("# ") else line[1:] for line in text.splitlines())
        found.append(Cell(text, "[markdown]" not in head))
    return found


def run(cell: Cell, names: dict[str, Any]) -> tuple[str, Any]:
    """Run a cell of code; gives what it printed, and the value of its last line if that is an expression."""
    tree = ast.parse(cell.text)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    stream, value = io.StringIO(), None
    with contextlib.redirect_stdout(stream):
        exec(compile(tree, "<cell>", "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), "<cell>", "eval"), names)
    return stream.getvalue(), value


def make(scripts: Path, folder: Path, root: Path) -> None:
    """Run all notebooks in the project's folder; write a page and a file for Jupyter of each."""
    folder.mkdir(parents=True, exist_ok=True)
    for script in sorted(scripts.glob("*.py")):
        parts = cells(script.read_text(encoding="utf-8"))
        (folder / f"{script.stem}.ipynb").write_text(jupyter(parts), encoding="utf-8")
        (folder / f"{script.stem}.md").write_text(_page(parts, script.stem, folder, root), encoding="utf-8")


def _page(parts: list[Cell], name: str, folder: Path, root: Path) -> str:
    """Make a page of the cells and their outputs."""
    import matplotlib as mpl
    from matplotlib import pyplot

    mpl.use("agg")
    names: dict[str, Any] = {}
    text: list[str] = []
    before = Path.cwd()
    os.chdir(root)
    try:
        for number, cell in enumerate(parts):
            if not cell.code:
                text.append(cell.text)
                continue
            text.append(f"```python\n{cell.text}\n```")
            printed, value = run(cell, names)
            shown = printed if value is None or pyplot.get_fignums() else f"{printed}{value!r}\n"
            if shown:
                text.append(f"```text\n{shown}```")
            for figure in pyplot.get_fignums():
                file = f"{name}_{number}_{figure}.png"
                pyplot.figure(figure).savefig(folder / file, dpi=110, bbox_inches="tight")
                pyplot.close(figure)
                text.append(f"![What the cell draws]({file})")
            if value is not None and hasattr(value, "_repr_png_"):
                file = f"{name}_{number}.png"
                (folder / file).write_bytes(value._repr_png_())
                text.append(f"![What the cell gives]({file})")
    finally:
        os.chdir(before)
    note = "it reads the samples in the folder of the project."
    text.insert(1, f"{{download}}`As a notebook for Jupyter <{name}.ipynb>`; {note}")
    return "\n\n".join(text) + "\n"


def jupyter(parts: list[Cell]) -> str:
    """Encode a notebook without outputs, format 4.5."""
    made = []
    for number, cell in enumerate(parts):
        entry: dict[str, Any] = {"id": f"cell-{number}", "metadata": {}, "source": cell.text.splitlines(keepends=True)}
        kind = {"cell_type": "code", "execution_count": None, "outputs": []} if cell.code else {"cell_type": "markdown"}
        made.append({**kind, **entry})
    kernel = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    return json.dumps({"cells": made, "metadata": kernel, "nbformat": 4, "nbformat_minor": 5}, indent=1) + "\n"
