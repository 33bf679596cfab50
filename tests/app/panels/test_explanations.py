"""Every parameter is named, explained and illustrated; the illustration follows its value and stops when hidden."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QCheckBox, QLabel

from app.model.parameters.controls import controls
from app.model.preferences.table import MOTION, WORDING
from app.model.text.wording import FORMULAS, rich
from app.views.features.file.preferences import PreferencesFeature
from app.views.panels.parameters.illustration import Illustration
from app.views.panels.parameters.illustrations import ILLUSTRATIONS
from cpm_core.parameters import PARAMETERS

pytestmark = pytest.mark.shared_window

CONTROLS = {control.name: control for control in controls()}


def test_every_control_has_words_and_an_illustration_and_nothing_else_has() -> None:
    assert set(FORMULAS) == set(ILLUSTRATIONS) == set(CONTROLS) == {*PARAMETERS, "ratio"} - {"w1"}


def test_no_two_controls_have_the_same_name() -> None:
    names = [control.title for control in CONTROLS.values()]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("name", CONTROLS)
def test_an_illustration_changes_with_the_value_and_with_time(qtbot, name) -> None:
    illustration, control = Illustration(), CONTROLS[name]
    qtbot.addWidget(illustration)
    span = control.slider_high - control.slider_low
    pictures = []
    for share in (0.02, 0.35, 0.98):
        value = control.slider_low + share * span
        illustration.show_control(name, round(value) if control.whole else value)
        pictures.append(illustration.picture(0.8))
    assert all(one != other for index, one in enumerate(pictures) for other in pictures[:index]), name
    assert illustration.picture(0.1) != illustration.picture(0.8)


@pytest.mark.parametrize("name", CONTROLS)
def test_an_illustration_accepts_every_value_that_may_be_typed(qtbot, name) -> None:
    illustration, control = Illustration(), CONTROLS[name]
    qtbot.addWidget(illustration)
    for value in (control.low, control.high, "auto"):
        illustration.show_control(name, value)
        for moment in (0.0, 0.5, 1.0):
            assert not illustration.picture(moment).isNull()


def test_an_illustration_is_animated_only_while_it_is_visible_and_animation_is_on(window, hand) -> None:
    illustration = window.panels["parameters"].explanation.illustration
    hand.wait(lambda: illustration.moving)
    window.actions_by_name["motion"].trigger()
    assert not illustration.moving
    assert window.preferences.value(MOTION) is False
    window.actions_by_name["motion"].trigger()
    assert illustration.moving
    window.docks["layers"].raise_()
    hand.wait(lambda: not illustration.moving)


@pytest.mark.parametrize("size", [(1000, 700), (1500, 1000)])
def test_the_explanation_follows_the_focus_and_fits_its_panel(window, hand, size) -> None:
    window.resize(*size)
    panel = window.panels["parameters"]
    panel.advanced.fold.click()
    hand.wait(lambda: (window.width(), window.height()) == size)
    for wording in ("symbol", "name"):
        window.actions_by_name[f"wording_{wording}"].trigger()
        for name, row in panel.rows.items():
            field = row.slider if row.slider.isEnabled() else row.findChild(QCheckBox)
            field.setFocus(Qt.FocusReason.TabFocusReason)
            hand.wait(lambda row=row: panel.explanation.control is row.control)
            shown = panel.explanation.head.text() + panel.explanation.body.text()
            assert row.control.more in shown
            assert row.control.rich_symbol in shown
            for label in (panel.explanation.head, panel.explanation.body):
                assert label.isHidden() or label.heightForWidth(label.width()) <= label.height(), name


def test_the_explanation_is_complete_where_there_is_room(window, hand) -> None:
    window.resize(1500, 1100)
    explanation = window.panels["parameters"].explanation
    hand.wait(explanation.body.isVisible)
    control = explanation.control
    shown = explanation.head.text() + explanation.body.text()
    for part in (control.title, control.span, control.meaning, control.formula, control.acts):
        assert part in shown


def test_the_illustration_follows_the_slider(window, hand) -> None:
    panel = window.panels["parameters"]
    row = panel.rows["annealing"]
    row.explained.emit(row.control)
    before = panel.explanation.illustration.picture(0.8)
    row.slider.setFocus()
    hand.qtbot.keyClick(row.slider, Qt.Key.Key_Home)
    assert window.session.document.parameters.annealing == pytest.approx(0.9)
    assert panel.explanation.illustration.picture(0.8) != before


def test_labels_begin_with_name_or_symbol_by_choice_which_is_remembered(window, hand) -> None:
    row = window.panels["parameters"].rows["beta"]
    assert row.findChild(QLabel).text().startswith("Damping")
    window.actions_by_name["wording_symbol"].trigger()
    assert row.findChild(QLabel).text().startswith("<i>β</i>")
    assert row.slider.accessibleName() == "Damping"
    assert window.preferences.value(WORDING) == "symbol"
    window.actions_by_name["wording_name"].trigger()
    assert row.findChild(QLabel).text().startswith("Damping")


def test_symbols_are_set_with_subscripts() -> None:
    assert rich("d_max,0") == "<i>d</i><sub>max,0</sub>"
    assert rich("β") == "<i>β</i>"


def test_the_preferences_offer_wording_animation_and_colors(window, hand) -> None:
    dialog = window.feature(PreferencesFeature).show()
    wording, motion, colors = (dialog.rows[label] for label in ("Labels", "Illustrations", "Colors of the window"))
    hand.qtbot.keyClick(wording, Qt.Key.Key_Down)
    wording.activated.emit(1)
    assert window.actions_by_name["wording_symbol"].isChecked()
    assert not window.actions_by_name["wording_name"].isChecked()
    hand.qtbot.mouseClick(motion, Qt.MouseButton.LeftButton)
    assert not window.actions_by_name["motion"].isChecked()
    colors.activated.emit(2)
    assert window.actions_by_name["theme_dark"].isChecked()
    assert window.palette().window().color().lightness() < 60
    dialog.reject()
