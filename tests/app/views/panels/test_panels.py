"""The panels show the present state and change only what the user changes."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.model.display.plots import PLOTS, RunMetrics
from cpm_app.model.parameters.controls import build_controls, control_value
from cpm_app.views.layers.fields import ARROW_SPACING, build_arrow_lines, find_arrow_ends
from cpm_app.views.panels.run import Chart
from PySide6.QtCore import QPoint, QRectF, Qt
from PySide6.QtWidgets import QCheckBox, QLabel, QToolButton

from cpm_core.parameters.choices import CHOICE_PARAMETERS

pytestmark = pytest.mark.shared_window


def test_every_tooltip_has_symbol_effect_default_and_the_range_of_its_slider(window) -> None:
    rows = window.panels["run"].parameters.rows
    assert list(rows) == [control.name for control in build_controls()]
    for name, row in rows.items():
        control, ends = row.control, []
        row.slider.moved_to.connect(ends.append)
        row.slider.setValue(row.slider.minimum())
        row.slider.setValue(row.slider.maximum())
        row.slider.setValue(row.slider.minimum())
        assert (min(ends), max(ends)) == pytest.approx((control.slider_low, control.slider_high)), name
        span = f"{control.slider_low:g} to {control.slider_high:.3g}"
        for part in (control.symbol, control.meaning, control.effect_of_larger, span, "default"):
            assert part in row.toolTip(), name


def test_a_double_click_on_a_slider_and_the_button_restore_the_default(window, hand, cases) -> None:
    panel = window.panels["run"].parameters
    panel.more.fold.click()
    begun = window.session.document.parameters
    for name in cases(["reach", "beta", "ratio", "annealing", "w2", "time_step", "d_min", "edge_floor"]):
        row = panel.rows[name]
        button = row.findChild(QToolButton, "restore")
        hand.wait(lambda button=button: button.height() > 8)
        for click, target in ((hand.qtbot.mouseDClick, row.slider), (hand.qtbot.mouseClick, button)):
            row.slider.setValue(row.slider.maximum())
            assert window.session.document.parameters != begun
            click(target, Qt.MouseButton.LeftButton)
            assert control_value(window.session.document.parameters, name) == pytest.approx(control_value(begun, name))


def test_automatic_smoothing_can_be_turned_on_and_off(window, hand) -> None:
    row = window.panels["run"].parameters.rows["smoothing"]
    row.findChild(QCheckBox).click()
    assert window.session.document.parameters.smoothing == "auto"
    assert not row.slider.isEnabled()
    row.findChild(QCheckBox).click()
    assert window.session.document.parameters.smoothing == 1.0
    assert row.slider.isEnabled()


def test_a_choice_is_taken_with_the_keys_undone_and_explained(window, hand) -> None:
    row = window.panels["run"].parameters.choices["edges"]
    window.panels["run"].parameters.more.fold.click()
    assert row.box.currentText() == "gray levels"
    row.box.setFocus()
    hand.qtbot.keyClick(row.box, Qt.Key.Key_Down)
    assert window.session.document.parameters.edges == "vessels"
    window.actions_by_name["undo"].trigger()
    assert window.session.document.parameters.edges == "gradient"
    assert row.box.currentText() == "gray levels"
    assert all(effect in row.toolTip() for effect in CHOICE_PARAMETERS["edges"].choices.values())


def test_layers_are_switched_from_panel_menu_and_key_alike(window, hand) -> None:
    box, action = window.panels["layers"].boxes["particles"], window.actions_by_name["layer_particles"]
    box.click()
    assert not action.isChecked()
    hand.key(Qt.Key.Key_1, Qt.KeyboardModifier.AltModifier)
    assert box.isChecked()
    assert action.isChecked()


def test_no_label_is_cut_off(window, hand) -> None:
    size = (1280, 720)
    window.resize(*size)
    window.panels["run"].parameters.more.fold.click()
    hand.wait(lambda: (window.width(), window.height()) == size)
    hand.qtbot.wait(1)  # the tool bar lays out its words
    icon_only = Qt.ToolButtonStyle.ToolButtonIconOnly
    labels = [one for one in window.findChildren(QLabel) if one.isVisible() and one.text() and not one.wordWrap()]
    buttons = [one for one in window.findChildren(QToolButton) if one.isVisible() and one.text()]
    buttons = [one for one in buttons if one.toolButtonStyle() != icon_only]
    assert labels
    assert buttons
    assert [one.text() for one in (*labels, *buttons) if one.width() < one.sizeHint().width()] == []
    column = window.panels["run"]
    hand.wait(lambda: any(not one.visibleRegion().isEmpty() for one in column.findChildren(QLabel)))  # it is painted
    shown = [one for one in column.findChildren(QLabel) if one.isVisible() and not one.visibleRegion().isEmpty()]
    assert shown
    assert [one.text() for one in shown if one.mapTo(column, QPoint(one.width(), 0)).x() > column.width()] == []


def test_the_plot_draws_all_values_that_a_run_can_have(qtbot) -> None:
    plot = Chart(PLOTS, "")
    qtbot.addWidget(plot)
    plot.resize(300, 150)
    empty = plot.grab().toImage()
    for epsilon in ([np.nan], [np.nan, np.nan, 0.0], [0.1, np.nan, 1e-12, 1e9], np.geomspace(1, 1e-7, 5000)):
        values = np.asarray(epsilon, dtype=float)
        steps = np.arange(1.0, len(values) + 1)
        plot.show_metrics(RunMetrics(steps, values, steps, steps, values, values, steps // 7, steps))
        drawn = plot.grab().toImage()
    assert drawn != empty


def test_arrows_neither_crowd_nor_leave_the_visible_part() -> None:
    field = np.stack([np.zeros((200, 300)), np.ones((200, 300))])
    seen = QRectF(50.0, 20.0, 100.0, 80.0)
    for pixel in (0.02, 0.5, 3.0):
        starts, ends = find_arrow_ends(field, seen, pixel)
        stride = max(1.0, ARROW_SPACING * pixel)
        middle = 0.5 * (starts + ends)
        assert ((middle[:, 1] >= 50) & (middle[:, 1] <= 150) & (middle[:, 0] >= 20) & (middle[:, 0] <= 100)).all()
        assert len(starts) <= (100 / stride + 2) * (80 / stride + 2)
        assert (ends[:, 0] == starts[:, 0]).all()
        assert (ends[:, 1] > starts[:, 1]).all()
        assert build_arrow_lines(starts, ends).shape == (6 * len(starts), 2)


def test_a_change_of_a_parameter_is_shown_once(window, monkeypatch) -> None:
    panel = window.panels["run"].parameters
    shown = []
    show = panel.rows["beta"].show_value
    monkeypatch.setattr(panel.rows["beta"], "show_value", lambda *values: (shown.append(values), show(*values)))
    panel.rows["beta"].slider.setValue(panel.rows["beta"].slider.maximum())
    assert [value for (value,) in shown] == [window.session.document.parameters.beta]
