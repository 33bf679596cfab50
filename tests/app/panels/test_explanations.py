"""Every parameter is named and explained."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel

from app.model.parameters.controls import controls
from app.model.preferences.table import WORDING
from app.model.text.wording import FORMULAS, rich
from app.views.features.help import PreferencesFeature
from cpm_core.parameters import PARAMETERS

pytestmark = pytest.mark.shared_window

CONTROLS = {control.name: control for control in controls()}


def test_every_control_has_words_and_nothing_else_has() -> None:
    assert set(FORMULAS) == set(CONTROLS) == {*PARAMETERS, "ratio"} - {"w1"}


def test_no_two_controls_have_the_same_name() -> None:
    names = [control.title for control in CONTROLS.values()]
    assert len(set(names)) == len(names)


def test_labels_begin_with_name_or_symbol_by_choice_which_is_remembered(window, hand) -> None:
    row = window.panels["run"].parameters.rows["beta"]
    assert row.findChild(QLabel).text().startswith("Damping")
    window.preferences.choose(WORDING, "symbol")
    assert row.findChild(QLabel).text().startswith("<i>β</i>")
    assert row.slider.accessibleName() == "Damping"
    assert window.preferences.value(WORDING) == "symbol"
    window.preferences.choose(WORDING, "name")
    assert row.findChild(QLabel).text().startswith("Damping")


def test_symbols_are_set_with_subscripts() -> None:
    assert rich("d_max,0") == "<i>d</i><sub>max,0</sub>"
    assert rich("β") == "<i>β</i>"


def test_the_preferences_offer_wording_and_colors(window, hand) -> None:
    dialog = window.feature(PreferencesFeature).show()
    wording, colors = (dialog.rows[label] for label in ("Labels", "Theme"))
    hand.qtbot.keyClick(wording, Qt.Key.Key_Down)
    wording.activated.emit(1)
    assert window.preferences.value(WORDING) == "symbol"
    colors.activated.emit(2)
    assert window.palette().window().color().lightness() < 60
    dialog.reject()
