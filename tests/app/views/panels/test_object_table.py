"""The table of objects and proposals: what it shows, and what is done in it by mouse and keys."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from cpm_app.model.document.edits import set_pixel_size
from cpm_app.model.document.objects import rename_objects
from cpm_app.session.scene import Proposal
from cpm_app.views.features.objects import ObjectsFeature
from PySide6.QtCore import QCoreApplication, QPoint, QPointF, QRect, Qt
from PySide6.QtWidgets import QLineEdit, QMenu, QStyle

from cpm_core.contours.contour import Contour
from cpm_core.image.region import Region
from cpm_core.objects.segmented.segmented_object import Click, SegmentedObject, SegmentedObjects
from cpm_core.objects.selection import Selection
from tests.app.conftest import show_contours
from tests.app.reading import accepted_items, column_texts

pytestmark = pytest.mark.shared_window

KEY, CONTROL, SHIFT = Qt.Key, Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
LEFT, SIDE = Qt.MouseButton.LeftButton, 40.0


def square(row: float, col: float, side: float) -> tuple[tuple[float, float], ...]:
    """Corners of a square."""
    return ((row, col), (row, col + side), (row + side, col + side), (row + side, col))


OUTER, HOLE = square(9.5, 9.5, SIDE), square(19.5, 19.5, 10.0)
GAP = ((9.5, 9.5), (9.5, 21.5))
FRAME = SegmentedObject(1, (Click(((12.0, 12.0),)),), Region((OUTER, HOLE)), (GAP,), 0.75, name="frame")
DOT = SegmentedObject(2, (Click(((24.0, 24.0),)),), Region((square(21.5, 21.5, 4.0),)), category=2)


@pytest.fixture
def offer(window, monkeypatch) -> Callable[..., None]:
    """Proposes squares, and nothing else."""
    monkeypatch.setattr(window.workspace.object_selection, "_request_answer", lambda: None)
    return lambda *corners: _offer(window, *corners)


def _offer(window, *corners: tuple[float, float, float]) -> None:
    shape = window.session.image.shape
    row, col = np.indices(shape)
    found = []
    for key, (top, left, side) in enumerate(corners, start=1):
        mask = (row > top) & (row < top + side) & (col > left) & (col < left + side)
        line = Contour(np.array(square(top, left, side)), True, 5.0)
        place = np.array([[top + side / 2, left + side / 2]])
        region = Region.from_mask(mask)
        one = Selection(region, shape, place, np.empty((0, 2)), (line,), confidence=0.9)
        found.append(Proposal(one, (), key=-key))
    scene = window.session.scene
    window.session.store.set_scene(replace(scene, objects=replace(scene.objects, proposals=tuple(found))))


@pytest.fixture
def panel(window, hand):
    """The panel, at the front."""
    window.resize(1600, 900)
    window.docks.reveal_panel("objects")
    hand.wait(window.panels["objects"].isVisible)
    return window.panels["objects"]


@pytest.fixture
def table(window, hand, panel):
    """The table of a window with a square frame and a dot in its hole."""
    items = SegmentedObjects((FRAME, DOT))
    window.session.edit("draw", lambda document: replace(document, objects=items))
    hand.wait(lambda: "–" not in column(panel.table, "gray"))
    return panel.table


RINGS = (5.5, 5.5, 30.0), (12.5, 12.5, 12.0), (45.5, 5.5, 8.0), (45.5, 30.5, 6.0)
"""Squares of which the second lies in the first."""


@pytest.fixture
def drawn(window, panel, offer):
    """The table of a window with four proposals, four closed contours, one in another, and an open one."""
    line = Contour(np.array([[40.0, 5.0], [40.0, 50.0], [42.0, 58.0]]), False, 4.0)
    show_contours(window, *(Contour(np.array(square(*ring)), True, 10.0) for ring in RINGS), line)
    offer(*RINGS)
    return panel.table


def column(table, name: str) -> list[str]:
    """The texts of a column, once the table shows what there is."""
    QCoreApplication.processEvents()
    return column_texts(table, name)


def cell(table, row: int, column: str = "name") -> QRect:
    QCoreApplication.processEvents()
    index = table.model().index(row, table.column_index(column))
    table.scrollTo(index)
    return table.visualRect(index)


def choose(hand, table, row: int, modifier: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier) -> QPoint:
    """Click a row."""
    at = cell(table, row).center()
    hand.qtbot.mouseClick(table.viewport(), LEFT, modifier, at)
    return at


def undo_name(window) -> str:
    return window.session.history.undo_name


def test_it_measures_what_the_boundaries_enclose_without_holes(window, table) -> None:
    values = window.session.image.values
    inside = np.zeros(values.shape, bool)
    inside[10:50, 10:50] = True
    inside[20:30, 20:30] = False
    assert column(table, "area") == ["1,500", "16"]
    assert column(table, "length") == ["200", "16"]
    assert column(table, "gray") == [f"{values[inside].mean():.0f}", f"{values[22:26, 22:26].mean():.0f}"]
    assert column(table, "gaps") == ["12", "–"]
    assert column(table, "confidence") == ["75 %", "–"]
    assert column(table, "class") == ["object", "class 2"]


def test_lengths_and_areas_are_in_the_unit_of_the_image(window, hand, table) -> None:
    session = window.session
    session.edit("size of a pixel", lambda d: set_pixel_size(d, (0.5, 0.25), "µm"))
    assert column(table, "area") == [f"{1500 * 0.125:.0f}", "2"]
    assert column(table, "length") == [f"{math.fsum((160 * 0.375, 40 * 0.375)):.3g}", "6"]
    tip = table.model().headerData(table.column_index("area"), Qt.Orientation.Horizontal, Qt.ItemDataRole.ToolTipRole)
    assert tip.endswith("µm²")


def test_the_columns_that_are_shown_fit_with_their_whole_titles_and_the_first_ones_fit_the_panel(drawn) -> None:
    header = drawn.horizontalHeader()
    assert all(
        not drawn.isColumnHidden(drawn.column_index(name)) for name in ("number", "name", "class", "area", "confidence")
    )
    arrow = drawn.style().pixelMetric(QStyle.PixelMetric.PM_HeaderMarkSize, None, header)
    for width in (320, 700, 1600):
        drawn.resize(width, 200)
        assert drawn.horizontalScrollBar().maximum() == 0
        shown = [index for index in range(len(drawn.rows.columns)) if not drawn.isColumnHidden(index)]
        assert shown == list(range(len(shown)))
        room = {index: arrow * (index != header.sortIndicatorSection()) for index in shown}
        assert all(header.sectionSize(index) + room[index] >= header.sectionSizeHint(index) for index in shown)


def test_a_number_of_many_digits_is_shown_whole_beside_the_confidence(window, hand, table) -> None:
    window.session.edit("size of a pixel", lambda d: set_pixel_size(d, (100.0, 10.0), None))
    table.resize(324, 200)
    hand.wait(lambda: column(table, "area")[0] == "1,500,000")
    area = table.column_index("area")
    assert not table.isColumnHidden(table.column_index("confidence"))
    assert table.columnWidth(area) >= table.sizeHintForColumn(area)


NARROW_TABLE = """
import os, sys
from shiboken6 import delete
for name in sys.argv[1:]:
    for module in [each for each in sys.modules if each.startswith("cpm_app")]:
        del sys.modules[module]  # some sentences are translated as modules are loaded
    from cpm_app.model.text.language import use_language
    use_language(name)
    from cpm_app.views.application import make_application
    application = make_application()
    from cpm_app.session.features.workspace import Workspace
    from cpm_app.views.main_window import make_window
    window = make_window(Workspace())
    window.show()
    window.docks.reveal_panel("objects")
    application.processEvents()
    table = window.panels["objects"].table
    table.setFixedWidth(285)
    counts = []
    for column in range(5):
        table.sortByColumn(column, table.rows._sort_order)
        application.processEvents()
        counts.append([table.isColumnHidden(index) for index in range(5)].count(False))
    print(name, *counts, flush=True)
    window.close()
    delete(window)  # every widget that exists slows down the next window
os._exit(0)
"""


def test_the_first_columns_fit_the_narrowest_panel_in_each_language_whichever_is_sorted_by() -> None:
    command = [sys.executable, "-c", NARROW_TABLE, *(names := ["de", "en", "es", "fr", "ja", "zh"])]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert said.splitlines() == [f"{name} 5 5 5 5 5" for name in names]


def test_a_click_on_a_row_chooses_its_object_and_a_heading_sorts(window, hand, table) -> None:
    choose(hand, table, 1)
    assert window.workspace.object_list.selected_numbers == {2}
    header, area = table.horizontalHeader(), table.column_index("area")
    at = QPoint(header.sectionViewportPosition(area) + 8, header.height() // 2)
    hand.qtbot.mouseClick(header.viewport(), LEFT, pos=at)
    assert column(table, "number") == ["2", "1"]
    assert window.workspace.object_list.selected_numbers == {2}
    choose(hand, table, 1, CONTROL)
    assert window.workspace.object_list.selected_numbers == {1, 2}
    table.sortByColumn(0, Qt.SortOrder.AscendingOrder)


def test_contours_are_no_rows_and_the_filter_limits_the_rows_and_keeps_the_selection(
    window, hand, panel, drawn
) -> None:
    window.session.edit("draw", lambda document: replace(document, objects=SegmentedObjects((DOT,))))
    hand.wait(lambda: panel.summary.text() == "1 object, 4 proposals")
    choose(hand, drawn, 2)
    counts = []
    for choice in range(panel.shown.count()):
        panel.shown.setFocus()
        while panel.shown.currentIndex() != choice:
            hand.qtbot.keyClick(panel.shown, KEY.Key_Down if choice > panel.shown.currentIndex() else KEY.Key_Up)
        counts.append(len(column(drawn, "number")))
    assert counts == [5, 1, 4]
    assert [row.key for row in window.workspace.object_list.selected_rows] == [("proposal", -2)]
    assert len(drawn.selectionModel().selectedRows()) == 1


def test_accepted_closed_contours_are_objects_with_those_directly_in_them_as_holes(window, hand, drawn) -> None:
    window.workspace.object_list.select_items([("contour", 0), ("contour", 1)])
    window.actions_by_name["accept"].trigger()
    (one,) = accepted_items(window)
    assert one.region.size == pytest.approx(900.0 - 144.0)
    assert undo_name(window) == "accept contour"
    hand.canvas.setFocus()
    hand.key(KEY.Key_Z, CONTROL)
    assert accepted_items(window) == ()


def test_an_open_contour_is_accepted_as_an_open_object_with_a_length_and_no_area(window, hand, drawn) -> None:
    window.workspace.object_list.select_items([("contour", 4)])
    window.actions_by_name["accept"].trigger()
    (one,) = accepted_items(window)
    assert (one.region.size, one.region.paste(window.session.image.shape).any()) == (0.0, False)
    assert column(drawn, "area")[0] == "–"
    assert column(drawn, "length")[0] == f"{45.0 + math.hypot(2.0, 8.0):.3g}"
    assert window.workspace.object_list.selected_numbers == {1}


def test_the_table_does_not_move_under_the_pointer_when_a_row_is_selected(window, hand, panel, table) -> None:
    hand.wait(lambda: not panel.figures.text())
    place = table.mapTo(panel, QPoint(0, 0)), table.height()
    for row in (0, 1):
        choose(hand, table, row)
        hand.wait(lambda: panel.figures.text() != "")
        assert (table.mapTo(panel, QPoint(0, 0)), table.height()) == place
    at = cell(table, 1).center()
    hand.qtbot.mouseDClick(table.viewport(), LEFT, pos=at)
    editor = table.viewport().findChild(QLineEdit)
    assert editor.geometry().contains(at), "the row under the pointer is named"
    hand.qtbot.keyClick(editor, KEY.Key_Escape)


def test_all_proposals_are_accepted_but_doubtful_ones_only_when_they_are_selected(window, drawn, offer) -> None:
    offer((10.5, 10.5, 8.0), (30.5, 30.5, 8.0))
    scene, rows = window.session.scene, window.workspace.object_list
    sure, other = (replace(each, key=-at) for at, each in enumerate(scene.objects.proposals, start=1))
    doubtful = replace(other, selection=replace(other.selection, confidence=0.2))
    window.session.store.set_scene(replace(scene, objects=replace(scene.objects, proposals=(sure, doubtful))))
    window.workspace.object_commands.accept_pending()
    assert [item.confidence for item in accepted_items(window)] == [0.9]
    rows.select_items([("proposal", -2)])
    window.workspace.object_commands.accept_pending()
    assert [item.confidence for item in accepted_items(window)] == [0.9, 0.2]


def test_all_rows_are_accepted_in_one_step_and_contours_are_not_among_them(window, hand, drawn) -> None:
    hand.canvas.setFocus()
    hand.key(KEY.Key_A, CONTROL)
    assert window.session.scene.selected_contours == frozenset()
    hand.canvas.setFocus()
    window.actions_by_name["accept"].trigger()
    assert [len(item.region.boundary) for item in accepted_items(window)] == [1, 1, 1, 1]
    assert undo_name(window) == "accept 4 objects"
    window.session.undo()
    assert accepted_items(window) == ()


def test_the_number_of_a_proposal_is_never_that_of_an_object(window, drawn) -> None:
    window.session.edit("draw", lambda document: replace(document, objects=SegmentedObjects((FRAME, DOT))))
    assert column(drawn, "number") == ["1", "2", "(1)", "(2)", "(3)", "(4)"]


def test_a_rejected_object_goes_until_that_is_undone(window, hand, table) -> None:
    choose(hand, table, 1)
    hand.key(KEY.Key_X)
    assert accepted_items(window) == (FRAME,)
    assert column(table, "class") == ["object"]
    assert window.session.document.objects.rejected == (DOT,)
    hand.canvas.setFocus()
    hand.key(KEY.Key_Z, CONTROL)
    assert accepted_items(window) == (FRAME, DOT)


def test_deleted_rows_are_dismissed_and_undone_together_and_contours_stay(window, hand, drawn) -> None:
    contours = window.session.scene.contours
    choose(hand, drawn, 0)
    choose(hand, drawn, 2, SHIFT)
    hand.qtbot.keyClick(drawn, KEY.Key_Delete)
    assert len(window.session.document.objects.rejected) == 3
    assert window.session.scene.contours is contours
    assert undo_name(window) == "reject 3 objects"
    hand.key(KEY.Key_Z, CONTROL)
    assert window.session.document.objects.rejected == ()


def test_a_digit_accepts_and_classes_and_the_second_class_leaves_the_keyboard_where_it_is(window, hand, drawn) -> None:
    choose(hand, drawn, 2)
    hand.qtbot.keyClick(drawn, KEY.Key_1)
    assert [item.category for item in accepted_items(window)] == [1]
    choose(hand, drawn, column(drawn, "class").index("proposal"))
    hand.qtbot.keyClick(drawn, KEY.Key_2)
    assert [item.category for item in accepted_items(window)] == [1, 2]
    assert window.canvas_area.messages.text == "Class 2 is new; the tab Objects has a field for its name."
    assert drawn.hasFocus()
    field = window.get_feature(ObjectsFeature).panel.classes[2].name
    hand.qtbot.mouseClick(field, LEFT)
    hand.qtbot.keyClicks(field, "vessel")
    hand.qtbot.keyClick(field, KEY.Key_Return)
    assert hand.canvas.hasFocus()
    assert "2 vessel" in column(drawn, "class")
    assert "2" not in undo_name(window)


def test_classes_are_listed_once_they_are_used_and_have_names_and_colors_in_the_panel(
    window, hand, panel, table
) -> None:
    assert list(panel.classes) == [1, 2, 3]
    field = panel.classes[1].name
    hand.qtbot.mouseClick(field, LEFT)
    hand.qtbot.keyClicks(field, "bone")
    hand.qtbot.keyClick(field, KEY.Key_Return)
    panel.classes[1].color.menu().actions()[0].trigger()
    assert (window.session.document.objects.classes[0].name, accepted_items(window)[0].name) == ("bone", "frame")
    assert window.session.document.objects.classes[0].color == "#e69f00"
    choose(hand, table, 1)
    hand.qtbot.mouseClick(panel.classes[3].digit, LEFT)
    assert [item.category for item in accepted_items(window)] == [1, 3]
    assert column(table, "class") == ["1 bone", "class 3"]


def test_keys_classify_and_remove_the_chosen_objects(window, hand, table) -> None:
    choose(hand, table, 0)
    hand.qtbot.keyClick(table, KEY.Key_4)
    assert [item.category for item in accepted_items(window)] == [4, 2]
    hand.qtbot.keyClick(table, KEY.Key_Delete)
    assert accepted_items(window) == (DOT,)


def test_the_panel_measures_and_names_what_is_chosen(window, hand, panel, table) -> None:
    assert panel.figures.text() == ""
    choose(hand, table, 0)
    figures = ("object", "Area\u00a01,500\u00a0px²", "Length\u00a0200\u00a0px", "Confidence:\u00a075\u00a0%")
    hand.wait(lambda: panel.figures.text() == " · ".join(figures))  # no line ends between a number and its unit
    hand.canvas.setFocus()
    hand.key(KEY.Key_F2)
    hand.wait(lambda: table.findChild(QLineEdit) is not None)
    editor = table.findChild(QLineEdit)
    hand.qtbot.keyClicks(editor, "femur")
    hand.qtbot.keyClick(editor, KEY.Key_Return)
    hand.wait(lambda: accepted_items(window)[0].name == "femur")
    assert undo_name(window) == "name frame"
    choose(hand, table, 1, CONTROL)
    hand.wait(lambda: not panel.figures.text())
    hand.qtbot.mouseClick(panel.buttons["merge_objects"], LEFT)
    (whole,) = accepted_items(window)
    assert (whole.number, whole.region.size) == (1, pytest.approx(1516.0, rel=0.005))


def test_objects_are_hidden_and_frozen(window, hand, table) -> None:
    layer = window.canvas_area.canvas.layers["objects"]
    choose(hand, table, 1)
    window.actions_by_name["hide_object"].trigger()
    assert layer.fills.count == 1
    assert (window.actions_by_name["hide_object"].text(), accepted_items(window)[1].hidden) == ("Show", True)
    window.actions_by_name["hide_object"].trigger()
    window.actions_by_name["freeze_object"].trigger()
    assert accepted_items(window)[1].frozen


def test_a_click_on_the_eye_or_the_lock_changes_that_row_and_all_selected_ones_with_it(window, hand, table) -> None:
    def click(row: int, name: str) -> list[tuple[bool, bool]]:
        hand.qtbot.mouseClick(table.viewport(), LEFT, pos=cell(table, row, name).center())
        return [(item.hidden, item.frozen) for item in accepted_items(window)]

    assert click(0, "eye") == [(True, False), (False, False)]
    assert not window.workspace.object_list.selected_keys
    assert click(1, "lock") == [(True, False), (False, True)]
    choose(hand, table, 0)
    choose(hand, table, 1, CONTROL)
    assert click(0, "eye") == [(True, False), (True, True)]
    assert click(1, "eye") == [(False, False), (False, True)]
    assert len(window.workspace.object_list.selected_keys) == 2
    assert undo_name(window) == "show 2 objects"


def test_the_slider_fades_the_selected_objects_in_one_undo_step(window, hand, panel, table) -> None:
    layer = window.canvas_area.canvas.layers["objects"]
    assert not panel.opacity.isEnabled()
    choose(hand, table, 1)
    hand.wait(panel.opacity.isEnabled)
    panel.opacity.setFocus()
    for _ in range(2):
        hand.qtbot.keyClick(panel.opacity, Qt.Key.Key_Left)
    assert [item.opacity for item in accepted_items(window)] == [1.0, 0.9]
    assert layer.fills._areas[1][2] == pytest.approx(0.9 * layer.get_amount("fill"))
    window.session.undo()
    assert [item.opacity for item in accepted_items(window)] == [1.0, 1.0]


def test_a_name_stands_above_its_object(window, hand, table) -> None:
    canvas = window.canvas_area.canvas
    row, col = DOT.center
    center = canvas.mapFromScene(canvas.view.mapViewToScene(QPointF(col, row)))
    before = canvas.grab().toImage().pixelColor(center)
    window.session.edit("name", lambda document: rename_objects(document, [2], "a long name of a dot"))
    hand.wait(lambda: canvas.layers["objects"]._names.count == 2)
    assert canvas.grab().toImage().pixelColor(center) == before


def test_a_double_click_names_a_proposal_which_accepts_it(window, hand, drawn) -> None:
    at = choose(hand, drawn, 2)
    hand.qtbot.mouseDClick(drawn.viewport(), LEFT, pos=at)
    editor = drawn.viewport().findChild(QLineEdit) or drawn.findChild(QLineEdit)
    hand.qtbot.keyClicks(editor, "xenon")  # the first letter is a key of the window as well
    hand.qtbot.keyClick(editor, KEY.Key_Return)
    hand.wait(lambda: [item.name for item in accepted_items(window)] == ["xenon"])
    assert column(drawn, "name")[0] == "xenon"


def test_a_color_is_that_of_the_selected_objects(window, hand, drawn) -> None:
    window.session.edit("draw", lambda document: replace(document, objects=SegmentedObjects((DOT,))))
    choose(hand, drawn, 0)
    choose(hand, drawn, 1, SHIFT)
    window.actions_by_name["object_color"].trigger()
    popup = window.findChildren(QMenu)[-1]
    next(action for action in popup.actions() if action.text() == "Orange").trigger()
    popup.close()
    assert [item.color for item in accepted_items(window)] == ["#e69f00"]


def test_new_contours_preserve_the_selection_and_a_name_being_edited(window, hand, drawn) -> None:
    choose(hand, drawn, 2)
    hand.qtbot.keyClick(drawn, KEY.Key_F2)
    editor = drawn.findChild(QLineEdit)
    hand.qtbot.keyClicks(editor, "half a na")
    show_contours(window, Contour(np.array(square(*RINGS[0])), True, 10.0))
    assert len(column(drawn, "number")) == 4
    assert editor.text() == "half a na" and editor.isVisible()
    assert len(window.workspace.object_list.selected_keys) == 1
    hand.qtbot.keyClick(editor, KEY.Key_Escape)


def test_the_panel_opens_with_the_present_rows_and_its_key_gives_it_the_keyboard_and_takes_it_back(
    window, hand, panel, drawn
) -> None:
    window.docks.bring_to_front("run")
    window.workspace.object_list.select_items([("proposal", -1)])
    window.workspace.object_commands.accept_pending()
    hand.canvas.setFocus()
    hand.key(KEY.Key_O, CONTROL | SHIFT)
    hand.wait(panel.isVisible)
    assert column(drawn, "class").count("object") == 1
    assert len(drawn.selectionModel().selectedRows()) == 1
    assert drawn.hasFocus()
    hand.key(KEY.Key_O, CONTROL | SHIFT)
    assert hand.canvas.hasFocus()


def test_the_layer_draws_objects_in_the_color_of_their_class_and_gaps_dashed(window, hand, table) -> None:
    canvas = window.canvas_area.canvas
    window.workspace.object_commands.name_class(1, "bone", "#ff0000")
    canvas.layers["objects"].set_option("fill", 1.0)
    canvas.layers["objects"].set_option("names", False)
    hand.qtbot.wait(50)
    picture = canvas.grab().toImage()
    ratio = picture.devicePixelRatio()
    at = hand.at(40, 30)
    assert picture.pixelColor(int(at.x() * ratio), int(at.y() * ratio)).name() == "#ff0000"
    hole = hand.at(20.5, 28)
    assert picture.pixelColor(int(hole.x() * ratio), int(hole.y() * ratio)).name() != "#ff0000"
    canvas.layers["objects"].set_shown(False)
    assert canvas.grab().toImage().pixelColor(int(at.x() * ratio), int(at.y() * ratio)).name() != "#ff0000"


def test_the_radius_of_the_brush_is_in_the_panel_while_the_tool_that_mends_is_used(window, hand, panel) -> None:
    assert not panel.brush.isVisible()
    hand.canvas.setFocus()
    hand.key(KEY.Key_J)
    hand.wait(panel.brush.isVisible)
    before = panel.brush.value()
    hand.key(KEY.Key_BracketRight)
    assert panel.brush.value() > before
    panel.brush.selectAll()
    hand.qtbot.keyClicks(panel.brush, "7")
    hand.qtbot.keyClick(panel.brush, KEY.Key_Return)
    assert window.workspace.object_brush.radius == 7.0
    hand.key(KEY.Key_S)
    assert not panel.brush.isVisible()
