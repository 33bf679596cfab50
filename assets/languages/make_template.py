"""Writes ``cpm.pot``: every sentence of the window; see `cpm_app.model.text.language`.

Run ``python assets/languages/make_template.py`` to write it next to this file, or name another file.
"""

from __future__ import annotations

import ast
import json
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from cpm_app.model.text.assets import read_guide_page

from cpm_core.formats import CONTOURS_WRITABLE
from cpm_core.formats.writers import VOLUMES_WRITABLE
from cpm_core.parameters import PARAMETERS
from cpm_core.parameters.choices import CHOICE_PARAMETERS
from cpm_core.shapes import SHAPES_BY_NAME

HERE = Path(__file__).parent
ROOT = HERE.parent.parent

_HEAD = 'msgid ""\nmsgstr ""\n"Content-Type: text/plain; charset=UTF-8\\n"\n"Content-Transfer-Encoding: 8bit\\n"\n'


NAME = "English"
"""Is translated by the name of the language, such as "Deutsch"."""


GIVEN = {"tr": slice(0, 1), "ActionSpec": slice(2, 4), "Submenu": slice(2, 3), "Panel": slice(1, 2)}
"""Which arguments of what the window calls are sentences that are translated."""


def in_source() -> Iterator[tuple[str, str]]:
    """Sentences of the window's source, each with its file and line."""
    for path in sorted((ROOT / "app").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in GIVEN:
                for said in node.args[GIVEN[node.func.id]]:
                    if isinstance(said, ast.Constant) and isinstance(said.value, str):
                        yield said.value, f"{path.relative_to(ROOT)}:{node.lineno}"


def in_guide() -> Iterator[tuple[str, str]]:
    """Headings and paragraphs of the guide."""
    for path in sorted((ROOT / "assets" / "guide").glob("*.md")):
        for block in read_guide_page(path.stem):
            yield block.text, f"guide {path.name}"


def in_tables() -> Iterator[tuple[str, str]]:
    """Sentences of the tables of the core, and of the samples, that the window shows."""
    for name, info in PARAMETERS.items():
        for said in (info.title, info.meaning, info.effect_of_larger, info.equation, info.unit):
            yield said, f"parameter {name}"
    for name, choice in CHOICE_PARAMETERS.items():
        for said in (choice.title, choice.meaning, *choice.choices.values()):
            yield said, f"parameter {name}"
    for name, kind in SHAPES_BY_NAME.items():
        if isinstance(kind.title, str):
            yield kind.title, f"shape {name}"
    for suffix, said in (*CONTOURS_WRITABLE.items(), *VOLUMES_WRITABLE.items()):
        yield said, f"format {suffix}"
    listed = json.loads((ROOT / "assets" / "samples" / "samples.json").read_text(encoding="utf-8"))
    for entry in listed:
        yield entry["title"], f"sample {entry['file']}"
        yield entry["about"], f"sample {entry['file']}"


def of_the_core() -> Iterator[tuple[str, str]]:
    """Whole sentences of the core, and of the system, that are met often; others are shown in English."""
    for said in (HERE / "core_sentences.txt").read_text(encoding="utf-8").splitlines():
        yield said, "core_sentences.txt"


@cache
def sentences() -> dict[str, list[str]]:
    """All sentences, each with the places where it occurs."""
    places: dict[str, list[str]] = {NAME: ["name of the language in itself"]}
    for said, place in (*in_source(), *in_guide(), *in_tables(), *of_the_core()):
        if said:
            places.setdefault(said, []).append(place)
    return places


def template() -> str:
    """Return the whole file."""
    return "\n".join((_HEAD, *(_entry(said, where) for said, where in sentences().items())))


def _entry(said: str, places: list[str]) -> str:
    return (
        "".join(f"#: {place}\n" for place in places)
        + ("#, python-brace-format\n" if "{" in said else "")
        + f'msgid {json.dumps(said, ensure_ascii=False)}\nmsgstr ""\n'
    )


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "cpm.pot"
    target.write_text(template(), encoding="utf-8")
