"""The table of objects: what it shows, and what is done in it by mouse and keys."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt

from app.model.document.edits import set_pixel_size
from app.views.features.objects import ObjectsFeature
from cpm_core.objects.segmented.segmented_object import Click, SegmentedObject, SegmentedObjects

pytestmark = pytest.mark.shared_window

KEY, CONTROL = Qt.Key, Qt.KeyboardModifier.ControlModifier
SIDE = 40.0


def square(row: float, col: float, side: float) -> tuple[tuple[float, float], ...]:
    """Corners of a square."""
    return ((row, col), (row, col + side), (row + side, col + side), (row + side, col))


OUTER, HOLE = square(9.5, 9.5, SIDE), square(19.5, 19.5, 10.0)
GAP = ((9.5, 9.5), (9.5, 21.5))
FRAME = SegmentedObject(1, (Click(((12.0, 12.0),)),), (OUTER, HOLE), (GAP,), 0.75, name="frame")
DOT = SegmentedObject(2, (Click(((24.0, 24.0),)),), (square(21.5, 21.5, 4.0),), category=2)


@pytest.fixture
def table(window, hand):
    """The table of a window with a square frame and a dot in its hole."""
    items = SegmentedObjects((FRAME, DOT))
    window.session.edit("draw", lambda document: replace(document, objects=items))
    window.actions_by_name["object_table"].trigger()
    found = window.panels["objects"].table
    hand.wait(lambda: "–" not in found.column("gray"))
    return found


def choose(hand, table, row: int, modifier: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier) -> QPoint:
    """Click a row."""
    at = table.visualRect(table.model().index(row, 1)).center()
    hand.qtbot.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, modifier, at)
    return at


def items(window) -> tuple[SegmentedObject, ...]:
    return window.session.document.objects.items


def test_it_measures_what_the_boundaries_enclose_without_holes(window, table) -> None:
    values = window.session.image.values
    inside = np.zeros(values.shape, bool)
    inside[10:50, 10:50] = True
    inside[20:30, 20:30] = False
    assert table.column("area") == ["1,500", "16"]
    assert table.column("perimeter") == ["200", "16"]
    assert table.column("gray") == [f"{values[inside].mean():.0f}", f"{values[22:26, 22:26].mean():.0f}"]
    assert table.column("gaps") == ["12", "–"]
    assert table.column("confidence") == ["0.75", "0.00"]
    assert table.column("class") == ["1  object", "2  class 2"]


def test_lengths_and_areas_are_in_the_unit_of_the_image(window, hand, table) -> None:
    session = window.session
    session.edit("size of a pixel", lambda d: set_pixel_size(d, (0.5, 0.25), "µm"))
    assert table.column("area") == [f"{1500 * 0.125:.0f}", "2"]
    assert table.column("perimeter") == [f"{math.fsum((160 * 0.375, 40 * 0.375)):.3g}", "6"]
    assert table.model().headerData(3, Qt.Orientation.Horizontal) == "Net area [µm²]"


def test_a_click_on_a_row_chooses_its_object_and_a_heading_sorts(window, hand, table) -> None:
    choose(hand, table, 1)
    assert window.workspace.object_list.chosen == {2}
    table.sortByColumn(3, Qt.SortOrder.AscendingOrder)
    assert table.column("number") == ["2", "1"]
    assert window.workspace.object_list.chosen == {2}
    choose(hand, table, 1, CONTROL)
    assert window.workspace.object_list.chosen == {1, 2}


def test_keys_classify_and_remove_the_chosen_objects(window, hand, table) -> None:
    choose(hand, table, 0)
    hand.qtbot.keyClick(table, KEY.Key_4)
    assert [item.category for item in items(window)] == [4, 2]
    hand.qtbot.keyClick(table, KEY.Key_Delete)
    assert items(window) == (DOT,)


def test_buttons_hide_freeze_and_merge(window, hand, table) -> None:
    buttons, layer = window.panels["objects"].buttons, window.canvas_area.canvas.layers["objects"]
    choose(hand, table, 1)
    assert not buttons["merge"].isEnabled()
    hand.qtbot.mouseClick(buttons["hide"], Qt.MouseButton.LeftButton)
    assert layer.fills.count == 1
    assert (buttons["hide"].text(), table.column("state")[1]) == ("Show", "hidden")
    hand.qtbot.mouseClick(buttons["hide"], Qt.MouseButton.LeftButton)
    hand.qtbot.mouseClick(buttons["freeze"], Qt.MouseButton.LeftButton)
    assert items(window)[1].frozen
    choose(hand, table, 0, CONTROL)
    hand.qtbot.mouseClick(buttons["merge"], Qt.MouseButton.LeftButton)
    (whole,) = items(window)
    assert whole.number == 1
    assert whole.area == pytest.approx(1516.0, rel=0.005)


def test_the_layer_draws_objects_in_the_color_of_their_class_and_gaps_dashed(window, hand, table) -> None:
    canvas = window.canvas_area.canvas
    window.workspace.object_list.name_class(1, "bone", "#ff0000")
    canvas.layers["objects"].choose("fill", 1.0)
    canvas.layers["objects"].choose("names", False)
    hand.qtbot.wait(50)
    picture = canvas.grab().toImage()
    ratio = picture.devicePixelRatio()
    at = hand.at(40, 30)
    assert picture.pixelColor(int(at.x() * ratio), int(at.y() * ratio)).name() == "#ff0000"
    hole = hand.at(20.5, 28)
    assert picture.pixelColor(int(hole.x() * ratio), int(hole.y() * ratio)).name() != "#ff0000"
    canvas.layers["objects"].set_shown(False)
    assert canvas.grab().toImage().pixelColor(int(at.x() * ratio), int(at.y() * ratio)).name() != "#ff0000"


def test_a_name_that_is_typed_goes_to_no_object_of_another_image(window, hand, table, image_file) -> None:
    field = window.feature(ObjectsFeature).name_field
    choose(hand, table, 0)
    hand.canvas.setFocus()
    window.actions_by_name["name_object"].trigger()
    hand.wait(field.isVisible)
    before = window.session.image_generation
    window.session.open(image_file)
    hand.wait(lambda: window.session.image_generation != before)
    assert not field.isVisible()
