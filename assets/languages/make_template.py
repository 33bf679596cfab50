"""Writes ``cpm.pot``: every sentence that a person reads in the window; see `app.model.text.language`.

Run ``python assets/languages/make_template.py`` to write it beside this file, or name another file.
"""

from __future__ import annotations

import ast
import json
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from core_templates import OF_THE_SYSTEM, WORDS, parts, templates

from cpm_core.formats import WRITABLE
from cpm_core.formats.writers import FOR_VOLUMES
from cpm_core.objects.methods.registry import CONTOUR_METHODS
from cpm_core.objects.methods.settings import Settings
from cpm_core.parameters import PARAMETERS
from cpm_core.parameters.choices import CHOICES
from cpm_core.shapes import SHAPES

HERE = Path(__file__).parent
ROOT = HERE.parent.parent

_HEAD = 'msgid ""\nmsgstr ""\n"Content-Type: text/plain; charset=UTF-8\\n"\n"Content-Transfer-Encoding: 8bit\\n"\n'


NAME = "English"
"""Is translated by the name of the language, such as "Deutsch"."""


def in_source() -> Iterator[tuple[str, str]]:
    """Sentences that the window's source gives to ``tr``, each with where it stands."""
    for path in sorted((ROOT / "app").rglob("*.py")):
        source = path.read_text(encoding="utf-8")
        for node in parts(ast.parse(source)) if "tr(" in source else ():
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "tr" and node.args:
                said = node.args[0]
                if isinstance(said, ast.Constant) and isinstance(said.value, str):
                    yield said.value, f"{path.relative_to(ROOT)}:{node.lineno}"


CORE = "core\x04"
"""Before a sentence that the core has finished: the context of gettext, as catalogs keep it."""

_COMMAND_LINE = ROOT / "cpm_core" / "cli"
"""Speaks English, as what it prints is read by programs too."""

_BATCH = (_COMMAND_LINE / "batch.py", _COMMAND_LINE / "workers.py")
"""What the window shares with it."""

_NOT_READ = (
    "cpm_core/cli/batch.py",  # its help
    "cpm_core/contours/features.py",  # names of numbers
    "cpm_core/formats/sessions/particle_state.py",  # names of fields of files
    "cpm_core/formats/sessions/space_state.py",
    "cpm_core/objects/candidates",  # names of numbers
    "cpm_core/objects/warm_up.py",  # a command
)
"""Where strings are names rather than sentences; errors are read there as well."""


def in_tables() -> Iterator[tuple[str, str]]:
    """Sentences of the tables of the core, and of the samples, that the window shows."""
    for name, info in PARAMETERS.items():
        for said in (info.title, info.meaning, info.more, info.equation, info.unit):
            yield said, f"parameter {name}"
    for name, method in CONTOUR_METHODS.items():
        yield method.title, f"method {name}"
        yield method.about, f"method {name}"
        own = method.settings.table() if issubclass(method.settings, Settings) else {}
        for field, info in own.items():
            for said in (info.title, info.meaning, info.more, info.equation, info.unit):
                yield said, f"method {name}, {field}"
    for name, choice in CHOICES.items():
        for said in (choice.title, choice.meaning, *choice.choices.values()):
            yield said, f"parameter {name}"
    for name, kind in SHAPES.items():
        if isinstance(kind.title, str):
            yield kind.title, f"shape {name}"
    for suffix, said in (*WRITABLE.items(), *FOR_VOLUMES.items()):
        yield said, f"format {suffix}"
    listed = json.loads((ROOT / "assets" / "samples" / "samples.json").read_text(encoding="utf-8"))
    for entry in listed:
        yield entry["title"], f"sample {entry['file']}"
        yield entry["about"], f"sample {entry['file']}"


def finished() -> Iterator[tuple[str, str]]:
    """What finished sentences are made of: errors, notes and reasons of the core, and errors within the window."""
    for package in ("cpm_core", "app"):
        for path in sorted((ROOT / package).rglob("*.py")):
            place = path.relative_to(ROOT).as_posix()
            if not path.is_relative_to(_COMMAND_LINE) or path in _BATCH:
                errors_only = package == "app" or place.startswith(_NOT_READ)
                for said, line in templates(path.read_text(encoding="utf-8"), errors_only):
                    yield said, f"{place}:{line}"
    for said in OF_THE_SYSTEM:
        yield said, "what the system says of files"
    for said in ("The image is small: scales is set to {most}.", "The image is gray: it has no channel {wanted}."):
        yield said, "cpm_core/cli/inputs.py"
    for said in WORDS:
        yield said, "a word within sentences"


@cache
def sentences() -> dict[str, list[str]]:
    """All sentences, each with the places where it stands; those that reach the window finished begin with `CORE`."""
    places: dict[str, list[str]] = {NAME: ["name of the language in itself"]}
    for said, place in (*in_source(), *in_tables()):
        if said:
            places.setdefault(said, []).append(place)
    for said, place in finished():
        if said not in places:
            places.setdefault(f"{CORE}{said}", []).append(place)
    return places


def template() -> str:
    """The whole file."""
    return "\n".join((_HEAD, *(_entry(said, where) for said, where in sentences().items())))


def _entry(said: str, places: list[str]) -> str:
    context, _, text = said.rpartition("\x04")
    return (
        "".join(f"#: {place}\n" for place in places)
        + ("#, python-brace-format\n" if "{" in text else "")
        + (f'msgctxt "{context}"\n' if context else "")
        + f'msgid {json.dumps(text, ensure_ascii=False)}\nmsgstr ""\n'
    )


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "cpm.pot"
    target.write_text(template(), encoding="utf-8")
