"""Every option of a layer can be changed in the panel, is stored, and is restored."""

from __future__ import annotations

import pytest
from cpm_app.session.features.workspace import Workspace
from cpm_app.views.layers.layer import Option
from cpm_app.views.main_window import make_window
from PySide6.QtCore import Qt


def another(option: Option, value: object) -> object:
    """Some other value of an option."""
    if option.choices:
        return next(way for way in reversed(option.choices) if way not in (value, "hand"))
    if isinstance(option.default, bool):
        return not value
    low, high, _ = option.bounds
    return low if value != low else high


def test_every_option_of_every_layer_is_restored_from_its_view_state(window):
    for layer in window.canvas_area.canvas.layers:
        before, shown = layer.view_state(), layer.shown
        layer.set_shown(not shown)
        layer.set_opacity(0.4)
        for option in layer.options:
            layer.set_option(option.name, another(option, layer.option_values[option.name]))
        after = layer.view_state()
        assert {"shown", "opacity", *(option.name for option in layer.options)} <= after.keys()
        for key in ("shown", "opacity", *(option.name for option in layer.options)):
            assert after[key] != before[key], (layer.name, key)
        layer.use_view_state(before)
        assert layer.view_state() == before and layer.shown is shown, layer.name
        layer.use_view_state(after)
        assert layer.view_state() == after and layer.shown is not shown, layer.name
        layer.use_view_state(before)


def test_an_invalid_setting_changes_nothing(window, cases):
    for nonsense in cases([None, 7.5, "no such way", True, -3, float("nan"), [1], {}]):
        for layer in window.canvas_area.canvas.layers:
            before = layer.view_state()
            wrong = {option.name: nonsense for option in layer.options if option.validate_value(nonsense) is None}
            layer.use_view_state({**wrong, "low": nonsense, "opacity": "much"})
            assert layer.view_state() == before


def test_the_panel_shows_and_changes_opacity_and_settings(window, hand):
    window.docks.reveal_panel("layers")
    for name, row in window.panels["layers"].rows.items():
        layer = hand.canvas.layers[name]
        row.fold.setFocus()
        hand.qtbot.keyClick(row.fold, Qt.Key.Key_Return)
        slider = row.opacity
        slider.setFocus()
        hand.qtbot.keyClick(slider, Qt.Key.Key_Home)
        assert layer.opacity == pytest.approx(0.05), name
        hand.qtbot.mouseDClick(slider, Qt.MouseButton.LeftButton)
        assert layer.opacity == 1.0, name
        box = row.box
        box.setFocus()
        shown = layer.shown
        hand.qtbot.keyClick(box, Qt.Key.Key_Return)
        assert layer.shown is not shown, name
        hand.qtbot.keyClick(box, Qt.Key.Key_Return)
        assert layer.shown is shown
        assert set(row.settings.fields) == {option.name for option in layer.options}
        row.fold.setFocus()
        hand.qtbot.keyClick(row.fold, Qt.Key.Key_Return)
        assert not row.settings.isVisible()


def test_settings_are_kept_for_the_next_start_but_not_what_is_shown(window):
    layer = window.canvas_area.canvas.layers["particles"]
    layer.set_option("colour", "force")
    layer.set_shown(False)
    window.canvas_area.canvas.layers["image"].set_option("range", "1")
    window.close()
    other = make_window(Workspace())
    again = other.canvas_area.canvas.layers["particles"]
    assert again.get_choice("colour") == "force"
    assert again.shown
    assert other.canvas_area.canvas.layers["image"].get_choice("range") == "1"
    other.close()
    other.deleteLater()
