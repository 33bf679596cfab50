"""The table of contours and the canvas: one shared selection, and reviews that appear in both and in files."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtWidgets import QLineEdit, QMenu

from app.model.document import edits
from app.session.exchange.contour_tracking import ContourTracker
from app.session.scene import ReviewedContours
from app.views.features.contours import ContoursFeature
from app.views.panels.contours import COLUMNS, ContourTable
from app.views.window.window import MainWindow
from cpm_core.parameters import Parameters
from cpm_core.shapes import Circle
from tests.app.conftest import Hand

pytestmark = pytest.mark.shared_window

KEY = Qt.Key
SHIFT = Qt.KeyboardModifier.ShiftModifier
LEFT = Qt.MouseButton.LeftButton

OUTER, INNER, SINGLE, WEAK = (48.0, 68.0), (48.0, 52.0), (28.0, 114.0), (76.0, 110.0)
"""Points on the four contours: a disc in a disc, and two others, the last of which is weak."""

DISCS = ((48, 40, 28, 90.0), (48, 40, 12, 90.0), (28, 100, 14, 180.0), (76, 100, 10, 60.0))


@pytest.fixture
def found(window: MainWindow, hand: Hand, tmp_path: Path) -> MainWindow:
    """A window in which four contours have been found and their table is open."""
    row, col = np.indices((96, 128))
    values = np.full(row.shape, 20.0)
    for at_row, at_col, radius, rise in DISCS:
        values += np.where(np.hypot(row - at_row, col - at_col) < radius, rise, 0.0)
    path = tmp_path / "discs.npy"
    np.save(path, values)
    session = window.session
    window.resize(1600, 900)  # the table has room for most columns
    session.open(path)
    hand.wait(lambda: session.document.image is not None and session.document.image.name == "discs.npy")
    session.edit("reach", lambda document: replace(document, parameters=Parameters()))
    for at_row, at_col, radius, _ in DISCS:
        circle = Circle((float(at_row), float(at_col)), 0.75 * radius)
        session.edit("draw", lambda document, circle=circle: edits.add_shape(document, circle))
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle)
    window.docks.reveal("contours")
    assert len(window.workspace.review.items) == 4
    return window


@pytest.fixture
def table(found: MainWindow) -> ContourTable:
    return found.panels["contours"].table


def cell(table: ContourTable, row: int, column: str) -> QRect:
    number = next(index for index, one in enumerate(COLUMNS) if one.name == column)
    table.scrollTo(table.model().index(row, number))
    return table.visualRect(table.model().index(row, number))


def click_row(hand: Hand, table: ContourTable, row: int, modifier=Qt.KeyboardModifier.NoModifier) -> None:
    hand.qtbot.mouseClick(table.viewport(), LEFT, modifier, cell(table, row, "name").center())


def click_heading(hand: Hand, table: ContourTable, column: str) -> None:
    number = next(index for index, one in enumerate(COLUMNS) if one.name == column)
    header = table.horizontalHeader()
    table.scrollTo(table.model().index(0, number))
    at = QPoint(header.sectionViewportPosition(number) + header.sectionSize(number) // 2, header.height() // 2)
    hand.qtbot.mouseClick(header.viewport(), LEFT, pos=at)


def pick(hand: Hand, place: tuple[float, float], modifier=Qt.KeyboardModifier.NoModifier) -> None:
    """Click on a contour with the contour tool."""
    hand.qtbot.mousePress(hand.canvas.viewport(), LEFT, modifier, hand.at(*place))
    hand.qtbot.mouseRelease(hand.canvas.viewport(), LEFT, modifier, hand.at(*place))


def exported(hand: Hand, window: MainWindow, tmp_path: Path) -> list[dict]:
    """The contours of a file that is exported now."""
    path = tmp_path / "out.json"
    path.unlink(missing_ok=True)
    window.session.export(path)
    hand.wait(path.exists)
    hand.wait(lambda: window.session.idle)
    return json.loads(path.read_text(encoding="utf-8"))["contours"]


def test_the_columns_that_a_table_shows_fit_into_it_with_their_whole_titles(table) -> None:
    for width in (420, 700, 1000, 1600):
        table.resize(width, 200)
        header = table.horizontalHeader()
        assert table.horizontalScrollBar().maximum() == 0
        shown = [index for index in range(len(COLUMNS)) if not table.isColumnHidden(index)]
        assert shown == list(range(len(shown)))
        for index in shown:
            assert header.sectionSize(index) >= header.sectionSizeHint(index)


def test_the_table_shows_the_measures_of_each_contour_drawn(found, table) -> None:
    assert table.column("kind") == ["closed"] * 4
    radii = [28.0, 14.0, 12.0, 10.0]
    for length, radius in zip(table.column("length"), radii, strict=True):
        assert float(length) == pytest.approx(2 * np.pi * radius, rel=0.05)
    for area, radius in zip(table.column("area"), radii, strict=True):
        assert float(area.replace(",", "")) == pytest.approx(np.pi * radius**2, rel=0.07)
    assert table.column("inside") == ["–", "–", "1", "–"]
    assert "4 closed, 0 open" in found.panels["contours"].summary.text()


def test_a_click_on_a_heading_sorts_by_it_and_a_second_reverses_the_order(found, table, hand) -> None:
    click_heading(hand, table, "strength")
    strengths = list(map(float, table.column("strength")))
    assert strengths == sorted(strengths)
    assert table.column("number")[0] == "4"
    click_heading(hand, table, "strength")
    assert list(map(float, table.column("strength"))) == sorted(strengths, reverse=True)


def test_table_and_canvas_share_one_selection(found, table, hand) -> None:
    review, layer = found.workspace.review, hand.canvas.layers.contours
    click_row(hand, table, 0)
    assert [item.measures.number for item in review.chosen] == [1]
    assert layer._chosen.count == 1
    hand.canvas.setFocus()
    hand.key(KEY.Key_V)
    pick(hand, SINGLE)
    assert [index.row() for index in table.selectionModel().selectedRows()] == [1]
    pick(hand, INNER, SHIFT)
    assert sorted(index.row() for index in table.selectionModel().selectedRows()) == [1, 2]
    assert layer._chosen.count == 2
    pick(hand, SINGLE, SHIFT)
    assert [index.row() for index in table.selectionModel().selectedRows()] == [2]
    pick(hand, (5.0, 5.0))
    assert not review.selected
    assert not table.selectionModel().hasSelection()


def test_a_contour_rejected_on_the_canvas_is_marked_in_its_row_and_missing_in_the_file(
    found, table, hand, tmp_path
) -> None:
    hand.key(KEY.Key_V)
    pick(hand, SINGLE)
    hand.key(KEY.Key_Delete)
    assert table.column("verdict") == ["–", "✗ rejected", "–", "–"]
    assert hand.canvas.layers.contours.counts == (3, 0)
    assert hand.canvas.layers.contours.rejected.count == 1
    assert len(exported(hand, found, tmp_path)) == 3
    assert found.actions_by_name["undo"].text().startswith("Undo reject")
    hand.key(KEY.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert table.column("verdict") == ["–"] * 4
    assert len(exported(hand, found, tmp_path)) == 4


def test_the_table_can_be_limited_to_a_verdict_and_keeps_the_selection(found, table, hand) -> None:
    shown = found.panels["contours"].shown
    click_row(hand, table, 1)
    hand.key(KEY.Key_K, SHIFT)
    click_row(hand, table, 2)
    hand.key(KEY.Key_X)
    for choice, numbers in ((1, ["2"]), (2, ["3"]), (3, ["1", "4"]), (0, ["1", "2", "3", "4"])):
        shown.setFocus()
        while shown.currentIndex() != choice:
            hand.qtbot.keyClick(shown, KEY.Key_Down if choice > shown.currentIndex() else KEY.Key_Up)
        assert table.column("number") == numbers
        assert [item.measures.number for item in found.workspace.review.chosen] == [3]
    assert [index.row() for index in table.selectionModel().selectedRows()] == [2]


def test_a_kept_contour_stays_with_its_number_when_a_slider_or_a_later_run_drops_it(
    found, table, hand, tmp_path
) -> None:
    review, session = found.workspace.review, found.session
    weak = min(review.items, key=lambda item: item.measures.strength)
    review.select([weak.key])
    hand.key(KEY.Key_K, SHIFT)
    limit = weak.measures.strength + 1.0
    session.edit("raise", lambda document: edits.set_parameter(document, "min_strength", limit))
    hand.wait(lambda: session.idle)
    numbers = {item.measures.number for item in review.items}
    assert weak.measures.number in numbers
    assert [one["number"] for one in exported(hand, found, tmp_path)].count(weak.measures.number) == 1
    session.reset()
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle)
    (kept,) = [item for item in review.items if item.reviewed.verdict == "kept"]
    assert kept.measures.number == weak.measures.number
    np.testing.assert_allclose(kept.contour.points, weak.contour.points, atol=1e-3)
    session.edit("lower", lambda document: edits.set_parameter(document, "min_strength", 0.0))
    hand.wait(lambda: session.idle and len(review.items) == 4)
    assert sorted(item.measures.number for item in review.items) == [1, 2, 3, 4]


def test_several_rows_are_reviewed_and_undone_together(found, table, hand) -> None:
    click_row(hand, table, 0)
    click_row(hand, table, 2, SHIFT)
    hand.qtbot.mouseClick(found.panels["contours"].buttons["reject"], LEFT)
    assert table.column("verdict") == ["✗ rejected"] * 3 + ["–"]
    assert "3 rejected" in found.panels["contours"].summary.text()
    hand.key(KEY.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert table.column("verdict") == ["–"] * 4


def test_a_double_click_names_a_contour_and_the_name_is_exported(found, table, hand, tmp_path) -> None:
    at = cell(table, 1, "name").center()
    hand.qtbot.mouseClick(table.viewport(), LEFT, pos=at)
    hand.qtbot.mouseDClick(table.viewport(), LEFT, pos=at)
    editor = table.viewport().findChild(QLineEdit) or table.findChild(QLineEdit)
    assert editor is not None
    hand.qtbot.keyClicks(editor, "xenon")  # the first letter is a key of the window as well
    hand.qtbot.keyClick(editor, KEY.Key_Return)
    hand.wait(lambda: table.column("name")[1] == "xenon")
    assert table.column("verdict")[1] == "–"
    assert [text for _, text, _ in hand.canvas.layers.contours._names.texts] == ["xenon"]
    assert "xenon" in [contour["name"] for contour in exported(hand, found, tmp_path)]
    hand.canvas.setFocus()
    hand.key(KEY.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert table.column("name")[1] == ""


def test_enter_names_a_contour_on_the_canvas_and_escape_does_not(found, table, hand) -> None:
    field = found.feature(ContoursFeature).name_field
    hand.key(KEY.Key_V)
    pick(hand, SINGLE)
    hand.key(KEY.Key_Return)
    hand.wait(field.isVisible)
    hand.qtbot.keyClicks(field, "not this")
    hand.qtbot.keyClick(field, KEY.Key_Escape)
    assert not field.isVisible()
    assert found.session.document.marks == ()
    hand.key(KEY.Key_Return)
    hand.qtbot.keyClicks(field, "aorta")
    hand.qtbot.keyClick(field, KEY.Key_Return)
    assert not field.isVisible()
    assert table.column("name")[1] == "aorta"


def test_a_color_is_chosen_from_the_menu_drawn_and_exported(found, table, hand, tmp_path) -> None:
    click_row(hand, table, 0)
    menu = QMenu()
    found.feature(ContoursFeature)._fill_colors(menu)
    assert menu.actions()[0].text() == "Orange"
    menu.actions()[0].trigger()
    layer = hand.canvas.layers.contours
    assert list(layer._other.colors) == ["#e69f00"]
    assert layer._curves.count == 3
    assert "#e69f00" in [contour["color"] for contour in exported(hand, found, tmp_path)]
    hand.key(KEY.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert layer._curves.count == 4


def test_a_reconstruction_preserves_selection_order_and_a_name_being_edited(found, table, hand) -> None:
    click_heading(hand, table, "strength")
    click_row(hand, table, 2)
    chosen = table.column("number")[2]
    hand.qtbot.keyClick(table, KEY.Key_F2)
    editor = table.findChild(QLineEdit)
    assert editor is not None
    hand.qtbot.keyClicks(editor, "half a na")
    counted = []
    found.workspace.review.changed.connect(lambda: counted.append(1))
    found.session.edit("x", lambda document: edits.set_parameter(document, "min_length", 65.0))
    hand.wait(lambda: bool(counted) and found.session.idle)
    assert len(table.column("number")) == 3, "the smallest is gone"
    assert editor.text() == "half a na"
    assert editor.isVisible()
    strengths = list(map(float, table.column("strength")))
    assert strengths == sorted(strengths)
    assert [item.measures.number for item in found.workspace.review.chosen] == [int(chosen)]
    hand.qtbot.keyClick(editor, KEY.Key_Return)
    hand.wait(lambda: found.workspace.review.chosen[0].contour.name == "half a na")


def test_a_table_that_is_opened_later_shows_the_present_selection_and_review(found, table, hand) -> None:
    found.docks.bring("run")
    hand.canvas.setFocus()
    hand.key(KEY.Key_V)
    pick(hand, SINGLE)
    hand.key(KEY.Key_X)
    assert table.column("verdict") == ["–"] * 4, "a hidden table is not updated"
    hand.key(KEY.Key_T, Qt.KeyboardModifier.ControlModifier)
    assert table.isVisible()
    assert table.column("verdict") == ["–", "✗ rejected", "–", "–"]
    assert [index.row() for index in table.selectionModel().selectedRows()] == [1]


def test_lengths_are_given_in_the_unit_of_the_image(found, table) -> None:
    result = replace(found.workspace.review.result, spacing=(0.5, 0.5), unit="mm")
    tracked = ContourTracker().track(result, thorough=False)
    found.session.show(replace(found.session.scene, contours=ReviewedContours.of(tracked, ())))
    header: Callable[[int], str] = lambda index: table.model().headerData(index, Qt.Orientation.Horizontal)  # noqa: E731
    assert [header(index) for index in range(4, 6)] == ["Length [mm]", "Area [mm²]"]
    assert float(table.column("length")[0]) == pytest.approx(np.pi * 28.0, rel=0.05)
