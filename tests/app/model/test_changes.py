"""A change of a document says what has become what, and where."""

from __future__ import annotations

from dataclasses import replace

import pytest

from app.model.document import edits
from app.model.document.document import Document
from app.session.undo_history import described
from app.views.theme.icons import icon
from cpm_core.parameters import PRESETS
from cpm_core.shapes import Barrier, Circle

CIRCLE = Circle((100.2, 73.4), 12.0)
DRAWN = edits.add_shape(Document(), CIRCLE)


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("beta", 1.6, "Damping 0.80 → 1.60"),
        ("smoothing", "auto", "Smoothing 1.00 → auto"),
        ("ratio", 0.5, "Repulsion to attraction 0.91 → 0.50"),
        ("w2", 2.0, "Attraction 1.75 → 2.00"),
        ("scales", 2, "Scales 3 → 2"),
        ("polarity", -1.0, "Dark or light auto → dark"),
        ("edges", "vessels", "Edges from gray levels → vessels"),
    ],
)
def test_a_parameter_says_from_what_to_what(qapp, name, value, text) -> None:
    words = described("any", Document(), edits.set_parameter(Document(), name, value))
    assert words.text == text
    assert words.icon == "slider"


def test_several_parameters_at_once_keep_the_name_of_the_change() -> None:
    after = replace(Document(), parameters=PRESETS["automatic"])
    assert described("use preset Automatic", Document(), after).text == "Use preset Automatic"


@pytest.mark.parametrize(
    ("before", "after", "icon_name"),
    [
        (Document(), DRAWN, "circle"),
        (DRAWN, Document(), "bin"),
        (DRAWN, edits.add_shape(DRAWN, Barrier(((5.0, 6.0), (9.0, 9.0)))), "barrier"),
    ],
)
def test_a_change_of_a_shape_has_its_icon(qapp, before, after, icon_name) -> None:
    words = described("draw it", before, after)
    assert (words.text, words.icon) == ("Draw it", icon_name)
    assert not icon(words.icon, "#000000").isNull()


def test_the_history_shows_the_whole_drag_of_a_slider_with_its_icon(window, hand) -> None:
    window.docks.reveal("history")
    row, panel = window.panels["parameters"].rows["beta"], window.panels["history"]
    for value in (1.0, 1.3, 1.6):
        row.slider.setValue(row.slider.value() + round((value - row.number.value()) / row.control.step))
    assert panel.lines == ["Beginning", "Damping 0.80 → 1.60"]
    assert not panel._list.item(1).icon().isNull()
