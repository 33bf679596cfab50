"""Sentences that reach the window finished, errors above all, are found again and said in its language."""

from __future__ import annotations

import ast
import errno
import gettext
import importlib
import os
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cpm_core as cpm
from app.model.text import language
from app.model.text.reasons import reason
from app.model.text.templates import Templates
from app.session.exchange.messages import sentence
from cpm_core.contours.surface import Surface
from cpm_core.formats import load_contours, load_image
from cpm_core.formats.sessions.session_file import load_session
from cpm_core.shapes import Circle, Polygon

ROOT = Path(__file__).parents[4]
READ = [
    path
    for package in ("cpm_core", "app")
    for path in sorted((ROOT / package).rglob("*.py"))
    if "cli" not in path.parts
]
"""Sources of what is read in the window; the command line speaks English."""


@pytest.fixture(scope="module")
def known():
    """All sentences that can be translated; those that reach the window finished by their templates."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "assets" / "languages"))
        return importlib.import_module("make_template").sentences()


@pytest.fixture(scope="module")
def extract():
    """Finds the templates in a source."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "assets" / "languages"))
        return importlib.import_module("core_templates").templates


@pytest.fixture
def in_brackets(monkeypatch, known):
    """A language made up of brackets."""

    class Brackets(gettext.NullTranslations):
        def gettext(self, message):
            return f"⟦{message}⟧" if message in known else message

    finished = [said.removeprefix("core\x04") for said in known if said.startswith("core\x04")]
    monkeypatch.setattr(language, "_catalog", Brackets())
    monkeypatch.setattr(language, "_core", Templates({said: f"⟦{said}⟧" for said in finished}))


TEMPLATES = Templates(
    {
        "{name} has {count} pages": "{count} Seiten hat {name}",
        "{name} has {count} pages: choose {one}": "{count} Seiten hat {name}: {one} wählen",
        "page {number} of {name}": "Seite {number} von {name}",
        "The file is damaged.": "Die Datei ist beschädigt.",
        "It was turned.": "Es wurde gedreht.",
        "region of interest": "Bereich",
    }
)


@pytest.mark.parametrize(
    ("said", "translated"),
    [
        ("The file is damaged.", "Die Datei ist beschädigt."),
        ("a.tif has 3 pages", "3 Seiten hat a.tif"),
        ("a.tif has 3 pages: choose 1 or 2", "3 Seiten hat a.tif: 1 or 2 wählen"),
        ("page 2 of a.tif has 3 pages", "3 Seiten hat Seite 2 von a.tif"),
        ("a.tif: The file is damaged.", "a.tif: Die Datei ist beschädigt."),
        ("It was turned. The file is damaged.", "Es wurde gedreht. Die Datei ist beschädigt."),
        ("It was turned. Nobody knows this.", "Es wurde gedreht. Nobody knows this."),
        ("region of interest 3 has 0 pages", "0 Seiten hat Bereich 3"),
        ("Nobody knows this.", "Nobody knows this."),
        ("{name} has {count} pages", "{count} Seiten hat {name}"),
        ("", ""),
    ],
)
def test_a_finished_sentence_is_found_among_the_templates(said, translated) -> None:
    assert TEMPLATES.translated(said) == translated


@given(st.text(max_size=40), st.integers(-(10**9), 10**9))
def test_any_value_is_carried_over(name, count) -> None:
    template = Templates({"⟪{name}⟫ has {count} pages!": "{count} Seiten: ⟪{name}⟫"})
    assert template.translated(f"⟪{name}⟫ has {count} pages!") == f"{count} Seiten: ⟪{name}⟫"


@given(st.text())
def test_any_text_comes_back_where_nothing_is_known(said) -> None:
    assert Templates({}).translated(said) == said
    assert isinstance(TEMPLATES.translated(said), str)


def test_a_long_text_costs_no_more_than_its_length() -> None:
    """Values may be found in many ways; only one of them is looked for."""
    pages = Templates({" ".join(["{a}", "a", "{b}", "b", "{c}", "c"] * 4): "x", "{a}, {b}, {c}, {d}; {e}!": "y"})
    assert pages.translated("a , b " * 20000).startswith("a , b")


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ('raise ValueError(f"{path.name} has {len(pages)} pages")', ["{name} has {count} pages"]),
        ('raise ValueError("too " f"few {x!r}: " + y)', ["too few {x}: {y}"]),
        ('raise ReadError(f"{n} page{\'s\' if n > 1 else \'\'} {\'are\' if n > 1 else \'is\'} gone")',
         ["{n} pages are gone", "{n} page is gone"]),
        ('raise ValueError(f"{len(a)} of {len(b)} {x.name} {y.name}")', ["{count} of {count2} {name} {name2}"]),
        ('raise ValueError(f"there are {count or \'no\'} pages")', ["there are {count} pages", "no"]),
        ('raise ValueError(tr("This file is damaged."))', []),
        ('def f():\n    """Two words."""\n    log.warning("two words")\n    return {"a b": 1}', []),
        ('notes = ("It was turned.", "id")', ["It was turned."]),
        ('FORMATS = {".svg": "a vector drawing"}', []),
    ],
)  # fmt: skip
def test_templates_are_found_in_a_source(extract, source, found) -> None:
    assert [said for said, _ in extract(source) if said != "a b"] == found


PASSED_ON = {
    "KeyError(number)": "a mapping asks for it, and nobody reads it",
    "ValueError(self.nothing_to_start_from)": "the text comes from tr",
    "ValueError(found.sentence)": "the text comes from `sentence`",
    "ValueError(NOTHING_TO_START_FROM)": "the text comes from tr",
}
"""Errors whose texts are no literals, and why they are translated all the same."""


def test_what_errors_say_can_be_translated(known, extract) -> None:
    """The text of an error is a literal that the templates hold, or passes through `tr`."""
    for path in READ:
        source = path.read_text(encoding="utf-8")
        said = {text for text, _ in extract(source, errors_only=True)}
        assert {text for text in said if text not in known and f"core\x04{text}" not in known} == set(), path
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.Call) and node.args and re.fullmatch(r"\w+Error", ast.unparse(node.func)):
                text = ast.unparse(node.args[0])
                literal = isinstance(node.args[0], ast.Constant | ast.JoinedStr | ast.BinOp)
                translated = text.startswith(("tr(", "message.format(", "text.format(", "str(error)"))
                assert literal or translated or ast.unparse(node) in PASSED_ON, f"{path}:{node.lineno}"


SAYING = {"sentence", "_sentence", "_kept_apart", "reason", "cause", "trouble_of", "failure_report"}
"""Functions that take an error and say it in the language of the window."""

LOOKING = {"isinstance", "append", "warning", "error", "info", "debug"}
"""Functions that look at an error, keep it for the others, or write it into the log."""

NO_WINDOW = (
    *((ROOT / "app" / name) for name in ("__main__.py", "napari")),
    ROOT / "app" / "views" / "window" / "display.py",
)
"""Sources that write to the terminal or speak to napari, in English."""


def test_the_text_of_an_error_is_shown_by_one_way() -> None:
    """Nothing but `reason` and what uses it turns an error into a text, so that each is translated."""
    for path in READ:
        if any(map(path.is_relative_to, (ROOT / "cpm_core", *NO_WINDOW))):
            continue
        for handler in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(handler, ast.ExceptHandler) and handler.name:
                assert uses(handler) == [], path


def uses(handler: ast.ExceptHandler) -> list[str]:
    """Expressions that use the error of a handler in another way than is known."""
    found = []
    for parent in ast.walk(handler):
        for child in ast.iter_child_nodes(parent):
            if isinstance(child, ast.Name) and child.id == handler.name:
                called = ast.unparse(parent.func).rpartition(".")[2] if isinstance(parent, ast.Call) else ""
                if called not in SAYING | LOOKING and not isinstance(parent, ast.Raise | ast.Attribute):
                    found.append(ast.unparse(parent))
    return found


def unreadable(tmp_path, name, content):
    file = tmp_path / name
    file.write_bytes(content)
    return file


SEEDS = [Circle((10.0, 10.0), 4.0)]

ERRORS = [
    lambda folder: load_image(folder / "missing.png"),
    load_image,
    lambda folder: load_image(unreadable(folder, "empty.png", b"")),
    lambda folder: load_image(unreadable(folder, "broken.png", b"\x89PNG\r\n\x1a\nxxxx")),
    lambda folder: load_image(unreadable(folder, "a.czi", b"ZISRAWFILE" + bytes(64))),
    lambda folder: load_session(folder / "missing.cpm"),
    lambda folder: load_session(unreadable(folder, "a.cpm", b"{}")),
    lambda folder: load_session(unreadable(folder, "b.cpm", b"\xff\xfe")),
    lambda folder: load_contours(unreadable(folder, "a.json", b"{}")),
    lambda folder: load_contours(unreadable(folder, "a.csv", b"x,y\n1,2\n")),
    lambda _: cpm.segment(np.zeros((4, 4)), SEEDS),
    lambda _: cpm.segment(np.zeros((64, 64)), SEEDS),
    lambda _: cpm.segment(np.full((64, 64), np.nan), SEEDS),
    lambda _: cpm.segment(np.zeros((64, 64, 64, 64)), SEEDS),
    lambda _: cpm.segment(np.eye(64), SEEDS, max_steps=0),
    lambda _: cpm.segment(np.eye(64), [Circle((10.0, 10.0), -1.0)]),
    lambda _: cpm.Parameters(smoothing=-1.0),
    lambda _: cpm.Parameters(w1=0.9, w2=0.5),
    lambda _: Polygon(((0.0, 0.0), (1.0, 1.0))),
    lambda _: Surface(np.array([[np.nan] * 3]), np.zeros((0, 3), int)),
]
"""Mistakes that a person can make, each with an error of the core."""

ALLOWED = re.compile(
    r"\b(cpm|NaN|PNG|TIFF|JPEG|CSV|GeoJSON|JSON|CPM|NumPy|QuPath|labelme|px|row|col|uint8|float64|int64)\b"
)
NAMES = re.compile(r"\b[\w-]+\.(png|czi|cpm|json|csv)\b|\b\w+_\w+\b|test_\S+|/\S*|'[^']*'|\"[^\"]*\"")


def outside_brackets(said: str) -> str:
    depth, kept = 0, ""
    for letter in said:
        depth += (letter == "⟦") - (letter == "⟧")
        kept += letter if depth == 0 else ""
    return kept


@pytest.mark.parametrize("mistake", ERRORS)
def test_an_error_of_the_core_is_said_in_the_language_of_the_window(in_brackets, tmp_path, mistake) -> None:
    with pytest.raises(ValueError) as caught:
        mistake(tmp_path)
    assert "⟦" not in str(caught.value)
    said = sentence(caught.value, "trying")
    assert said.startswith(("⟦", "empty", "missing", "broken")), said
    left = NAMES.sub(" ", outside_brackets(said))
    assert not re.search(r"[A-Za-z]{3,}", left), said


def test_what_the_system_says_of_a_file_is_translated(in_brackets) -> None:
    error = PermissionError(errno.EACCES, os.strerror(errno.EACCES), "folder/a.png")
    assert reason(error) == "a.png: ⟦Permission denied⟧"


def test_a_long_message_without_a_translation_stays_as_it_is() -> None:
    error = ValueError("x is 3 but must be below 2.")
    assert sentence(error, "trying") == "X is 3 but must be below 2."
