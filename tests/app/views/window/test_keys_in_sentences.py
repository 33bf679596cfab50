"""Keys in sentences are those that the actions have now; none that can be changed stands there as fixed text."""

from __future__ import annotations

import gettext
import importlib
import re
from functools import cache
from pathlib import Path

import pytest
from cpm_app.model.text.keys import ActionName, insert_keys, use_action_names
from cpm_app.views.features.help import HelpFeature
from cpm_app.views.widgets.actions import native_key_text
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QAbstractButton, QLabel, QTableView, QWidget

pytestmark = pytest.mark.shared_window

LANGUAGES = Path(__file__).parents[4] / "assets" / "languages"

NAMED = re.compile(r"\{key:(\w+)\}")

FIXED = (
    # In fields, dialogs and on the divider, these keys are not those of an action.
    r"Enter or Esc (in a field )?(gives it back|returns it)", r"Esc ends the comparison",
    r"press Space to enlarge", r"Enlarge \(Space\)",
    # While corners, marks or objects are there, the canvas itself takes these.
    r"Backspace (removes|takes back|takes the last)", r"Delete(:| removes the stretch)",
    # Words, names and measures.
    r"^&?(Delete|Space|Menu)\b", r"A\. C\.", r"\bF \{f\}", r"^F$", r"^U shape$", r"whole U\b", r"in space",
)  # fmt: skip
"""What sentences say of keys that no action has, or with words that are no keys."""

WORDS = {
    "Escape": r"\bEsc(ape)?\b", "PgUp": r"\b(PgUp|Page Up)\b", "PgDown": r"\b(PgDown|Page Down)\b",
}  # fmt: skip
"""How people write keys that are named otherwise in code."""

IN_GERMAN = r"|(Strg|Umschalt|Alt)\+\w|Leertaste|\bEntf\b|\bEsc\b|\bBild (auf|ab)\b|\b(Pos1|Ende)\)|\([B-HJ-Z,.]\)"
"""How people write keys in German."""
ALIKE = r"Ctrl\+\w|\(F\d+\)"
"""How they write them in all languages."""
ALIKE_FIXED = (
    r"Enter oder Esc gibt", r"Enter oder Esc in einem Feld", r"oder Esc schließt diese", r"Esc beendet den Vergleich",
    r"Leertaste vergrößert", r"Vergrößern \(Leertaste\)", r"Entf löscht den Abschnitt", r"Umschalt\+Enter",
    r"Strg\+Enter", r"die Entf-Taste", r"vom Bild ab", r"Welche Seite an jedem Rand.*",
)  # fmt: skip


@cache
def sentences() -> list[str]:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(LANGUAGES))
        return list(importlib.import_module("make_template").sentences())


def pattern_of(key: str) -> str:
    """How a sentence says a key: a letter or sign by itself only in parentheses or before a verb."""
    if len(key) == 1:
        return rf"\({re.escape(key)}\)" + (rf"|(?<![\w.“]){key} [a-z]+s\b" if key.isalpha() and key not in "AI" else "")
    return WORDS.get(key, rf"(?<![\w+]){re.escape(key)}(?![\w+])")


def without(said: str, fixed: tuple[str, ...]) -> str:
    return re.sub("|".join(fixed), "", said)


@pytest.fixture
def renamed(window) -> dict[str, str]:
    """The keys that all actions named in sentences have been given, by the names of the actions."""
    actions = sorted({name for said in sentences() for name in NAMED.findall(said)})
    keys = {name: f"Ctrl+Alt+Shift+F{number}" for number, name in enumerate(actions, start=1)}
    for name, key in keys.items():
        window.shortcuts.assign_key(name, key)
    yield {name: native_key_text(key) for name, key in keys.items()}
    window.shortcuts.reset()


def texts_of(window) -> list[str]:
    """All that the widgets of a window say, and what they would say under the pointer."""
    found = [action.toolTip() for action in window.actions()] + [action.statusTip() for action in window.actions()]
    for widget in window.findChildren(QWidget):
        found += [widget.toolTip(), widget.accessibleName()]
        if isinstance(widget, QLabel | QAbstractButton):
            found.append(widget.text())
        if isinstance(widget, QTableView) and widget.model() is not None:
            model = widget.model()
            found += [
                str(model.headerData(column, Qt.Orientation.Horizontal, Qt.ItemDataRole.ToolTipRole))
                for column in range(model.columnCount())
            ]
    return found


def test_no_sentence_says_a_key_that_can_be_changed_as_fixed_text(window) -> None:
    keys = {key for action in window.shortcuts.actions for key in action.default}
    patterns = re.compile("|".join(sorted(map(pattern_of, keys), key=len, reverse=True)))
    assert [said for said in sentences() if patterns.search(without(said, FIXED))] == []


@pytest.mark.parametrize("catalog", sorted(LANGUAGES.glob("*/LC_MESSAGES/cpm.mo")), ids=lambda path: path.parts[-3])
def test_no_translation_says_a_key_that_is_not_in_its_sentence(catalog) -> None:
    with catalog.open("rb") as stream:
        known = gettext.GNUTranslations(stream)
    keys = re.compile(ALIKE + (IN_GERMAN if catalog.parts[-3] == "de" else ""))
    told = {said: known.gettext(said) for said in sentences() if not re.search(f"{ALIKE}|{'|'.join(FIXED)}", said)}
    assert [other for said, other in told.items() if other != said and keys.search(without(other, ALIKE_FIXED))] == []


def test_changed_keys_are_in_every_sentence_of_the_window(window, renamed) -> None:
    said = texts_of(window)
    assert not [text for text in said if "{key:" in text]
    for name in ("objects", "escape", "previous_slice", "next_slice", "name_object", "reject"):
        assert any(renamed[name] in text for text in said), name
    assert renamed["reject"] in window.actions_by_name["select"].toolTip()
    assert renamed["reject"] in window.actions_by_name["select"].statusTip()


def test_the_guide_follows_changed_keys_while_it_is_open(window, hand) -> None:
    feature = window.get_feature(HelpFeature)
    feature.show_guide("canvas")
    window.shortcuts.assign_key("run", "Ctrl+F7")
    assert native_key_text("Ctrl+F7") in feature.guide.text.toPlainText()
    feature.guide.close()
    hand.wait(lambda: feature.guide is None)
    window.shortcuts.assign_key("keys", "Ctrl+F8")
    window.actions_by_name["keys"].trigger()
    keys = feature.guide
    assert native_key_text("Ctrl+F7") in keys.text.toPlainText()
    assert native_key_text("Ctrl+F8") in keys.text.toPlainText()
    hand.wait(keys.isActiveWindow)
    hand.qtbot.keyClick(keys, Qt.Key.Key_F8, Qt.KeyboardModifier.ControlModifier)
    hand.wait(lambda: feature.guide is None)


def test_an_action_without_a_key_is_called_by_its_title() -> None:
    use_action_names({"run": ActionName("", "Run"), "open": ActionName("", "Open"), "reset": ActionName("{", "Reset")})
    assert insert_keys("Press {key:run} to run.") == "Press “Run” to run."
    assert insert_keys("Open an image ({key:open}) or drop one here.") == "Open an image or drop one here."
    assert insert_keys("Reset ({key:reset}) removes the {shape}.", shape="circle") == "Reset ({) removes the circle."
