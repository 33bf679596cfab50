"""Every sentence that the user reads can be translated: none in the source bypasses `tr`, none in the window appears as
it was written when `tr` puts brackets around it."""

from __future__ import annotations

import ast
import errno
import gettext
import importlib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from cpm_app import __main__ as start
from cpm_app.__main__ import EXIT_CANNOT_OPEN, main
from cpm_app.model.text import language
from cpm_app.session.storage.preferences import Preferences

ROOT = Path(__file__).parents[3]
SOURCES = sorted((ROOT / "app").rglob("*.py"))

SHOWING = {
    "setText", "setToolTip", "setWindowTitle", "setStatusTip", "setAccessibleName", "setAccessibleDescription",
    "setPlaceholderText", "setHtml", "setSuffix", "setPrefix", "setSpecialValueText", "show", "set_busy", "addAction",
    "addMenu", "addItem", "addTab", "QLabel", "QPushButton", "QCheckBox", "QAction", "QGroupBox", "QRadioButton",
    "QToolBar", "QDockWidget", "getOpenFileName", "getSaveFileName", "getText", "getItem", "Section",
}  # fmt: skip
"""Calls whose texts the user reads."""

NAMING = {"edit"}
"""Calls whose first text is the name of a change, which follows "Undo"."""

WORDS = {"text", "tip", "title", "short", "about", "hint", "label", "note"}
"""Arguments of any call that the user reads."""

NOT_READ = {"all", "edges", "opening", "preparing", "reconstructing", "restoring", "seeding", "straight"}
"""Literals that are names in code."""


def readable(node: ast.expr) -> bool:
    """Whether an expression is a literal with words in it, tags aside."""
    parts = [node] if isinstance(node, ast.Constant) else node.values if isinstance(node, ast.JoinedStr) else []
    said = "".join(str(part.value) for part in parts if isinstance(part, ast.Constant) and isinstance(part.value, str))
    return re.search(r"[A-Za-z]{3,}", without_tags(said).replace("CPM", "")) is not None


def without_tags(said: str) -> str:
    return re.sub(r"<[^>]*>?|&\w+;", " ", said)


def bypassing(source: str) -> list[tuple[int, str]]:
    """Lines and literals that the user would read untranslated."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.Call):
            continue
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        said = list(node.args) if name in SHOWING else node.args[:1] if name in NAMING else []
        said += [keyword.value for keyword in node.keywords if keyword.arg in WORDS]
        found += [(part.lineno, ast.unparse(part)) for part in said
                  if readable(part) and getattr(part, "value", "") not in NOT_READ]  # fmt: skip
    return found


def test_no_sentence_bypasses_translation() -> None:
    window = [path for path in SOURCES if path.parent.name != "napari"]  # the plugin has the language of napari
    found = {str(path.relative_to(ROOT)): bypassing(path.read_text(encoding="utf-8")) for path in window}
    assert {path: said for path, said in found.items() if said} == {}


def test_what_is_translated_is_a_literal_that_can_be_found_in_the_source() -> None:
    texts = [
        (f"{path}:{node.lineno}", node.args[0])
        for path in SOURCES
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "tr"
    ]
    assert len(texts) > 500
    assert [place for place, text in texts if not isinstance(text, ast.Constant)] == []


@pytest.fixture(scope="module")
def template(tmp_path_factory) -> Path:
    """The template for translations, written again."""
    target = tmp_path_factory.mktemp("languages") / "cpm.pot"
    script = ROOT / "assets" / "languages" / "make_template.py"
    subprocess.run([sys.executable, str(script), str(target)], check=True, env=os.environ | {"PYTHONPATH": str(ROOT)})
    return target


def test_the_template_holds_the_sentences_of_window_core_and_samples(template) -> None:
    text = template.read_text(encoding="utf-8")
    for said in ("Drag on the image to draw a circle in or around an object.", "Repulsion to attraction", "Damping",
                 "Friction that slows the particles down.", "Uses the red channel.",
                 "region of interest", "An artery"):  # fmt: skip
        assert f'msgid "{said}"' in text


@pytest.mark.skipif(shutil.which("msgfmt") is None, reason="gettext is not there")
def test_the_tools_of_gettext_read_the_template(template, tmp_path) -> None:
    done = subprocess.run(
        ["msgfmt", "-c", "-o", str(tmp_path / "cpm.mo"), str(template)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    with (tmp_path / "cpm.mo").open("rb") as stream:
        assert gettext.GNUTranslations(stream).gettext("Damping") == "Damping"


LANGUAGES = ROOT / "assets" / "languages"
CATALOGS = sorted(LANGUAGES.glob("*/LC_MESSAGES/cpm.mo"))


@pytest.fixture
def update(monkeypatch):
    """The command that brings translations up to date."""
    monkeypatch.syspath_prepend(str(LANGUAGES))
    return importlib.import_module("update")


@pytest.mark.parametrize("catalog", CATALOGS, ids=lambda catalog: catalog.parents[1].name)
def test_a_translation_is_complete_and_keeps_all_placeholders(update, catalog) -> None:
    assert list(update.wrong(catalog)) == []
    assert update.lacking(catalog) == []


def test_what_lacks_a_translation_stays_english_and_is_listed(update, monkeypatch, capsys) -> None:
    monkeypatch.setattr(update, "sentences", lambda: {"Force": [], "No such sentence {count}": []})
    monkeypatch.setattr("sys.argv", ["update.py", "--check"])
    assert update.main() == 1
    assert "de: not translated: No such sentence {count}" in capsys.readouterr().out
    language.use_language("de")
    assert language.current_language() == "de"
    assert language.tr("Force") == "Kraft"
    assert language.tr("No such sentence {count}") == "No such sentence {count}"
    language.use_language("en")
    assert language.tr("Force") == "Force"


def test_the_preferred_language_is_in_use_before_the_window_is_loaded(qapp, monkeypatch) -> None:
    Preferences().store_key(language.LANGUAGE_KEY, "de")
    seen = []
    monkeypatch.setattr(start, "explain_no_window", lambda: seen.append(language.current_language()) or "no window")
    assert main([]) == EXIT_CANNOT_OPEN
    assert seen == ["de"]
    language.use_language("en")


WHAT_THE_START_LOADS = """
import sys
from cpm_app import __main__ as start
from cpm_app.model.text import language

translated = []
language.tr = lambda message, **_: translated.append(message) or message
language.use_language = lambda *_: print(translated)
start.explain_no_window = lambda: "no window"
sys.exit(start.main([]))
"""


def test_no_sentence_is_translated_before_the_language_is_known(tmp_path) -> None:
    environment = os.environ | {"XDG_CONFIG_HOME": str(tmp_path)}
    command = [sys.executable, "-c", WHAT_THE_START_LOADS]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, env=environment)
    assert (done.returncode, done.stdout.strip()) == (EXIT_CANNOT_OPEN, "[]"), done.stderr


@pytest.mark.parametrize(
    ("environment", "of_the_system", "used"),
    [
        ({}, ["de-AT", "de"], "de"),
        ({}, ["pt-BR", "de-DE"], "de"),
        ({}, ["en-GB", "de-DE"], "en"),
        ({}, ["tlh"], "en"),
        ({}, [], "en"),
        ({"LANGUAGE": "de"}, ["en-US"], "de"),
        ({"LANG": "C.UTF-8"}, ["de-DE"], "en"),
    ],
)
def test_the_system_names_the_language_where_the_environment_does_not(
    monkeypatch, environment, of_the_system, used
) -> None:
    for name in ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    try:
        language.use_language(language.SYSTEM_LANGUAGE, of_the_system)
        assert language.current_language() == used
    finally:
        language.use_language("en")


@pytest.mark.parametrize("name", ["de", "fr", "es", "ja", "zh"])
def test_a_language_can_be_chosen_exactly_when_its_translation_has_its_name(name) -> None:
    entry = r'^msgid "English"\nmsgstr "(.*)"$'
    named = re.search(entry, (LANGUAGES / name / "LC_MESSAGES" / "cpm.po").read_text(encoding="utf-8"), re.MULTILINE)
    assert language.list_languages().get(name, "") == named.group(1)


def test_a_whole_sentence_of_the_core_is_translated_and_others_stay_english() -> None:
    try:
        language.use_language("de")
        error = PermissionError(errno.EACCES, os.strerror(errno.EACCES), "folder/a.png")
        assert language.explain_error(error) == "a.png: Keine Berechtigung"
        assert language.explain_error(ValueError("x is 3 but must be below 2.")) == "x is 3 but must be below 2."
    finally:
        language.use_language("en")


def test_the_sentences_of_the_core_in_the_catalogs_are_those_of_its_source() -> None:
    source = "".join(path.read_text(encoding="utf-8") for path in sorted((ROOT / "cpm_core").rglob("*.py")))
    said = (LANGUAGES / "core_sentences.txt").read_text(encoding="utf-8").splitlines()
    of_the_core = [each for each in said if each[0].islower() or each.endswith(".")]
    assert [each for each in of_the_core if each.partition(" for ")[0] not in source] == []


IN_BRACKETS = """
import gettext, re, sys
sys.path.insert(0, sys.argv[1])
import cpm_app.model.text.language as language
from make_template import sentences
known = set(sentences())

class Brackets(gettext.NullTranslations):
    def gettext(self, said):
        return f"⟦{said}⟧" if said in known else said

language._catalog = Brackets()
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QAbstractSpinBox, QComboBox, QMenu, QTabBar, QWidget
from cpm_app.session.features.workspace import Workspace
from cpm_app.views.application import make_application
from cpm_app.views.main_window import make_window

application = make_application()
window = make_window(Workspace())
window.show()
application.processEvents()

QTS_OWN = ("qt_dockwidget", "ScrollLeftButton", "ScrollRightButton", "qt_toolbar_ext_button")
seen = 0

def outside(said):
    said = re.sub(r"\\n[^\\n]*\\(\\d{4}\\)$", " ", said)  # authors and year of a publication
    said = re.sub(r"<sub>.*?</sub>|<[^>]*>|&\\w+;|\\b\\w_\\w+(,0)?", " ", said)
    said = re.sub(r"\\((\\w|\\+|,|\\.|\\[|\\]|Shift|Escape|Space|Delete|F\\d+|Ctrl|Alt|Home|End)+\\)", " ", said)
    depth, kept = 0, ""
    for letter in said:
        depth += (letter == "⟦") - (letter == "⟧")
        kept += letter if depth == 0 else ""
    return kept

def look(said, where):
    global seen
    seen += "⟦" in said
    if re.search(r"[A-Za-z]{3,}", outside(said).replace("CPM", "")):
        print(where, repr(said))

for widget in (window, *window.findChildren(QWidget)):
    name = widget.objectName()
    if name.startswith(QTS_OWN):
        continue
    for attribute in ("text", "toolTip", "statusTip", "windowTitle", "accessibleName", "placeholderText"):
        read = getattr(widget, attribute, None)
        if callable(read) and not isinstance(widget, QAbstractSpinBox):
            look(str(read()), f"{type(widget).__name__} {name} {attribute}")
    if isinstance(widget, (QComboBox, QTabBar)):
        read = widget.itemText if isinstance(widget, QComboBox) else widget.tabText
        for index in range(widget.count()):
            look(read(index), f"{type(widget).__name__} {name}")
for action in window.actions() + [action for menu in window.findChildren(QMenu) for action in menu.actions()]:
    for said in (action.text().partition("\t")[0], action.toolTip(), action.statusTip()):
        look(said, "action")
window.close()
print("seen", seen)
"""


def test_a_window_in_a_made_up_language_shows_nothing_that_is_not_translated(tmp_path) -> None:
    environment = os.environ | {"QT_QPA_PLATFORM": "offscreen", "XDG_CONFIG_HOME": str(tmp_path), "PYTHONUTF8": "1"}
    done = subprocess.run(
        [sys.executable, "-c", IN_BRACKETS, str(LANGUAGES)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        env=environment,
    )
    assert done.returncode == 0, done.stderr
    *bare, last = done.stdout.strip().splitlines()
    assert bare == []
    assert int(last.removeprefix("seen ")) > 300
