"""Every parameter is named and explained."""

from __future__ import annotations

import pytest
from cpm_app.model.parameters.controls import build_controls
from cpm_app.model.text.wording import PARAMETER_FORMULAS, format_symbol
from cpm_app.views.features.help import PreferencesFeature

from cpm_core.parameters import PARAMETERS

pytestmark = pytest.mark.shared_window

CONTROLS = {control.name: control for control in build_controls()}


def test_every_control_has_words_and_nothing_else_has() -> None:
    assert set(PARAMETER_FORMULAS) == set(CONTROLS) == {*PARAMETERS, "ratio"} - {"w1"}


def test_no_two_controls_have_the_same_name() -> None:
    names = [control.title for control in CONTROLS.values()]
    assert len(set(names)) == len(names)


def test_symbols_are_set_with_subscripts() -> None:
    assert format_symbol("d_max,0") == "<i>d</i><sub>max,0</sub>"
    assert format_symbol("β") == "<i>β</i>"


def test_the_preferences_offer_colors(window, hand) -> None:
    dialog = window.get_feature(PreferencesFeature).open_preferences()
    dialog.rows["Theme"].activated.emit(2)
    assert window.palette().window().color().lightness() < 60
    dialog.reject()
