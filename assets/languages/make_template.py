"""Writes ``cpm.pot``: every sentence of the window, for translating it; see `app.model.text.language`.

Run ``python assets/languages/make_template.py`` to write it beside this file, or name another file.
"""

from __future__ import annotations

import ast
import json
import sys
from collections.abc import Iterator
from pathlib import Path

from cpm_core.formats import WRITABLE
from cpm_core.parameters import PARAMETERS
from cpm_core.parameters.choices import CHOICES
from cpm_core.shapes import SHAPES

HERE = Path(__file__).parent
ROOT = HERE.parent.parent

_HEAD = 'msgid ""\nmsgstr ""\n"Content-Type: text/plain; charset=UTF-8\\n"\n"Content-Transfer-Encoding: 8bit\\n"\n'


_NAME = "English"
"""Is translated by the name of the language, such as "Deutsch"."""


def in_source() -> Iterator[tuple[str, str]]:
    """Sentences that the window's source gives to ``tr``, each with where it stands."""
    for path in sorted((ROOT / "app").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "tr" and node.args:
                said = node.args[0]
                if isinstance(said, ast.Constant) and isinstance(said.value, str):
                    yield said.value, f"{path.relative_to(ROOT)}:{node.lineno}"


def in_core() -> Iterator[tuple[str, str]]:
    """Sentences of the core and of the samples that the window shows."""
    for name, info in PARAMETERS.items():
        for said in (info.title, info.meaning, info.more, info.equation, info.unit):
            yield said, f"parameter {name}"
    for name, choice in CHOICES.items():
        for said in (choice.title, choice.meaning, *choice.choices.values()):
            yield said, f"parameter {name}"
    for name, kind in SHAPES.items():
        if isinstance(kind.title, str):
            yield kind.title, f"shape {name}"
    for suffix, said in WRITABLE.items():
        yield said, f"format {suffix}"
    listed = json.loads((ROOT / "assets" / "samples" / "samples.json").read_text(encoding="utf-8"))
    for entry in listed:
        yield entry["title"], f"sample {entry['file']}"
        yield entry["about"], f"sample {entry['file']}"


def sentences() -> dict[str, list[str]]:
    """All sentences, each with the places where it stands."""
    places: dict[str, list[str]] = {_NAME: ["name of the language in itself"]}
    for said, place in (*in_source(), *in_core()):
        if said:
            places.setdefault(said, []).append(place)
    return places


def template() -> str:
    """The whole file."""
    entries = (
        "".join(f"#: {place}\n" for place in where)
        + ("#, python-brace-format\n" if "{" in said else "")
        + f'msgid {json.dumps(said, ensure_ascii=False)}\nmsgstr ""\n'
        for said, where in sentences().items()
    )
    return "\n".join((_HEAD, *entries))


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "cpm.pot"
    target.write_text(template(), encoding="utf-8")
