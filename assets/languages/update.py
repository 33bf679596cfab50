"""Brings the translations up to date with the sentences of the window, and lists what they lack.

Run ``python assets/languages/update.py``; it needs ``msgmerge`` and ``msgfmt`` of gettext. Names of languages, such as
``fr ja``, begin those that are not there yet. ``--check`` only lists, from the catalogs as they are, and needs nothing.

A catalog is made once a translation has given the name of its language, for "English". Until then the language cannot
be chosen, and `update.py` only reports how much of it there is.
"""

from __future__ import annotations

import gettext
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from make_template import NAME, sentences, template

HERE = Path(__file__).parent

_PLACEHOLDER = re.compile(r"\{[^{}]*\}")


class _Lacking(gettext.NullTranslations):
    """Answers for a catalog where it has no translation."""

    def gettext(self, message: str) -> str:
        return ""


def translation(catalog: Path) -> gettext.GNUTranslations:
    """Read a catalog that gives an empty text for what it lacks."""
    with catalog.open("rb") as stream:
        made = gettext.GNUTranslations(stream)
    made.add_fallback(_Lacking())
    return made


def lacking(catalog: Path) -> list[str]:
    """Sentences that a catalog does not translate."""
    known = translation(catalog)
    return [said for said in sentences() if not known.gettext(said)]


def wrong(catalog: Path) -> Iterator[str]:
    """Find what is wrong in a catalog: other placeholders or keys of menus than in the sentence."""
    known = translation(catalog)
    for said in sentences():
        other = known.gettext(said)
        if other and sorted(_PLACEHOLDER.findall(said)) != sorted(_PLACEHOLDER.findall(other)):
            yield f"{said!r}: {other!r} has other placeholders"
        if other and (said.count("\n"), said.endswith("…")) != (other.count("\n"), other.endswith("…")):
            yield f"{said!r}: {other!r} has other lines or dots at its end"


def catalogs() -> list[Path]:
    """All catalogs."""
    return sorted(HERE.glob("*/LC_MESSAGES/cpm.mo"))


_HEAD = """msgid ""
msgstr ""
"Project-Id-Version: CPM\\n"
"Language: {name}\\n"
"MIME-Version: 1.0\\n"
"Content-Type: text/plain; charset=UTF-8\\n"
"Content-Transfer-Encoding: 8bit\\n"
"""


def begin(name: str) -> None:
    """Begin the translation into a language, unless it is there."""
    po = HERE / name / "LC_MESSAGES" / "cpm.po"
    if not po.exists():
        po.parent.mkdir(parents=True, exist_ok=True)
        po.write_text(_HEAD.format(name=name), encoding="utf-8")


def update() -> None:
    """Merge the sentences of the window into each translation, and make its catalog again if it has a name."""
    with tempfile.TemporaryDirectory() as folder:
        pot = Path(folder) / "cpm.pot"
        pot.write_text(template(), encoding="utf-8")
        for po in sorted(HERE.glob("*/LC_MESSAGES/cpm.po")):
            merge = ["msgmerge", "--quiet", "--update", "--backup=none", "--no-location", "--no-fuzzy-matching"]
            subprocess.run([*merge, str(po), str(pot)], check=True)
            subprocess.run(["msgattrib", "--no-obsolete", "-o", str(po), str(po)], check=True)
            made = Path(folder) / "cpm.mo"
            subprocess.run(["msgfmt", "--check-format", "-o", str(made), str(po)], check=True)
            known = translation(made)
            if known.gettext(NAME):
                shutil.copyfile(made, po.with_suffix(".mo"))
            else:
                there = sum(bool(known.gettext(said)) for said in sentences())
                print(f"{po.parents[1].name}: has no name yet; {there} of {len(sentences())} sentences are translated")


def main() -> int:
    """Update, or only check; the exit status is 1 if something is missing."""
    if "--check" not in sys.argv[1:]:
        if shutil.which("msgmerge") is None:
            sys.exit("msgmerge was not found: install gettext, or only check with --check.")
        for name in sys.argv[1:]:
            begin(name)
        update()
    count = 0
    for catalog in catalogs():
        name = catalog.parents[1].name
        for said in lacking(catalog):
            count += 1
            print(f"{name}: not translated: {said}")
        for problem in wrong(catalog):
            count += 1
            print(f"{name}: {problem}")
    return min(count, 1)


if __name__ == "__main__":
    sys.exit(main())
