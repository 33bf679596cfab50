"""The tool that selects contours and objects: clicks and frames; Shift adds, Ctrl removes, Esc cancels."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.views.features.objects import ObjectsFeature
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QApplication, QLineEdit

from cpm_core.contours.contour import Contour
from cpm_core.image.region import Region
from cpm_core.objects.segmented.segmented_object import SegmentedObject, SegmentedObjects
from cpm_core.shapes import Circle
from tests.app.conftest import Hand, show_contours

pytestmark = pytest.mark.shared_window

KEY, LEFT = Qt.Key, Qt.MouseButton.LeftButton
SHIFT, CONTROL = Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.ControlModifier
NONE = Qt.KeyboardModifier.NoModifier
PLACES = [(20, 20), (20, 60), (20, 100), (60, 20), (60, 60), (60, 100)]


def ring(place: tuple[int, int]) -> np.ndarray:
    angles = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    return np.stack([place[0] + 11.0 * np.sin(angles), place[1] + 11.0 * np.cos(angles)], axis=1)


@pytest.fixture
def found(window: MainWindow, hand: Hand, tmp_path: Path) -> MainWindow:
    """A window with six closed contours, and the tool is in use."""
    path = tmp_path / "discs.npy"
    np.save(path, np.random.default_rng(0).normal(100.0, 1.0, (84, 124)))
    session = window.session
    session.open_file(path)
    hand.wait(lambda: session.document.image is not None and session.document.image.name == "discs.npy")
    show_contours(window, *(Contour(ring(place), True, 5.0) for place in PLACES))
    hand.canvas.setFocus()
    hand.key(KEY.Key_S)
    return window


def drag(hand: Hand, *places: tuple[float, float], held: Qt.KeyboardModifier = NONE, release: bool = True) -> None:
    view = hand.canvas.viewport()
    hand.qtbot.mousePress(view, LEFT, held, hand.at(*places[0]))
    for start, end in pairwise(places):
        for share in (0.5, 1.0):
            at = tuple(np.array(start) + share * (np.array(end) - start))
            move(hand, at, held)
    if release:
        hand.qtbot.mouseRelease(view, LEFT, held, hand.at(*places[-1]))


def move(hand: Hand, at: tuple[float, ...], held: Qt.KeyboardModifier) -> None:
    """A move of the pointer with modifier keys, which `qtbot.mouseMove` cannot hold."""
    view, place = hand.canvas.viewport(), hand.at(*at)
    kind, on_screen = QMouseEvent.Type.MouseMove, view.mapToGlobal(place).toPointF()
    event = QMouseEvent(kind, place.toPointF(), on_screen, Qt.MouseButton.NoButton, LEFT, held)
    QApplication.sendEvent(view, event)


def selected(window: MainWindow) -> set[tuple[int, int]]:
    centers = [np.mean(contour.points, axis=0) for contour in window.workspace.contour_selection.selected_contours]
    return {min(PLACES, key=lambda place: float(np.hypot(*(center - place)))) for center in centers}


def chosen(window: MainWindow) -> frozenset[int]:
    return window.workspace.object_list.selected_numbers


def test_a_frame_selects_what_lies_in_it_shift_adds_and_ctrl_removes(found, hand) -> None:
    drag(hand, (3.0, 3.0), (40.0, 80.0))
    assert selected(found) == {(20, 20), (20, 60)}
    drag(hand, (40.0, 80.0), (3.0, 118.0), held=SHIFT)
    assert selected(found) == {(20, 20), (20, 60), (20, 100)}
    drag(hand, (3.0, 40.0), (40.0, 80.0), held=CONTROL)
    assert selected(found) == {(20, 20), (20, 100)}
    drag(hand, (40.0, 3.0), (80.0, 40.0))
    assert selected(found) == {(60, 20)}
    assert hand.canvas.layers.contours._selected.count == 1


def test_a_click_removes_a_contour_and_one_away_from_all_of_them_clears_the_selection(found, hand) -> None:
    drag(hand, (3.0, 3.0), (80.0, 118.0))
    assert len(selected(found)) == 6
    drag(hand, (20.0, 31.0), held=CONTROL)
    assert selected(found) == {*PLACES} - {(20, 20)}
    drag(hand, (40.0, 40.0), held=SHIFT)
    assert len(selected(found)) == 5
    drag(hand, (40.0, 40.0))
    assert selected(found) == set()


def test_escape_during_a_drag_selects_what_was_selected_before(found, hand) -> None:
    drag(hand, (20.0, 31.0))
    drag(hand, (40.0, 3.0), (80.0, 80.0), release=False)
    assert len(selected(found)) == 2
    hand.key(KEY.Key_Escape)
    assert selected(found) == {(20, 20)}


def name_field(window: MainWindow, hand) -> QLineEdit:
    """The field in which the selected object is named, in the table."""
    table = window.get_feature(ObjectsFeature).panel.table
    hand.wait(lambda: table.findChild(QLineEdit) is not None and table.findChild(QLineEdit).hasFocus())
    return table.findChild(QLineEdit)


def test_a_click_on_a_contour_tells_its_length_and_enter_makes_an_object_that_f2_names(found, hand) -> None:
    drag(hand, (20.0, 71.0))
    assert selected(found) == {(20, 60)}
    assert "69.1 px long" in found.canvas_area.strip.hint.text()
    hand.key(KEY.Key_Return)
    assert found.session.history.undo_name == "accept contour"
    hand.key(KEY.Key_F2)
    field = name_field(found, hand)
    hand.qtbot.keyClicks(field, "aorta")
    hand.qtbot.keyClick(field, KEY.Key_Return)
    (item,) = found.session.document.objects.items
    hand.wait(lambda: found.session.document.objects.items[0].name == "aorta")
    drag(hand, (20.0, 71.0))
    assert (chosen(found), selected(found)) == ({item.number}, set()), "the contour around it is that of the object"


def disk_object(number: int, place: tuple[int, int]) -> SegmentedObject:
    return SegmentedObject(number, (), Region((tuple(map(tuple, ring(place).tolist())),)))


def add_objects(window: MainWindow, *items: SegmentedObject) -> None:
    window.session.edit("draw", lambda document: replace(document, objects=SegmentedObjects(items)))


def test_a_frame_takes_objects_before_contours_and_both_are_selected_together_by_clicks(found, hand) -> None:
    add_objects(found, disk_object(1, (60, 20)))
    drag(hand, (40.0, 3.0), (80.0, 80.0))
    assert (chosen(found), selected(found)) == ({1}, set())
    drag(hand, (60.0, 71.0), held=SHIFT)
    assert (chosen(found), selected(found)) == ({1}, {(60, 60)})
    hand.key(KEY.Key_Return)
    assert len(found.session.document.objects.items) == 2


def test_delete_and_the_keys_of_objects_leave_contours_as_they_are(found, hand) -> None:
    add_objects(found, disk_object(1, (60, 20)))
    before, contours = found.session.document, found.session.scene.contours
    drag(hand, (20.0, 31.0))
    for key in (KEY.Key_Delete, KEY.Key_X, KEY.Key_M, KEY.Key_F2):
        hand.key(key)
        assert found.session.document == before and found.session.scene.contours is contours
    hand.key(KEY.Key_A, CONTROL)
    assert (chosen(found), selected(found)) == ({1}, set())
    hand.key(KEY.Key_Delete)
    assert found.session.document.objects.items == () and found.session.scene.contours is contours


def test_a_frozen_object_is_neither_deleted_nor_rejected_and_a_sentence_says_why(found, hand) -> None:
    add_objects(found, replace(disk_object(1, (60, 20)), frozen=True))
    drag(hand, (60.0, 20.0))
    for key in (KEY.Key_Delete, KEY.Key_X):
        found.canvas_area.messages.clear()
        hand.key(key)
        assert len(found.session.document.objects.items) == 1
        assert found.canvas_area.messages.text == "object 1 is frozen: unfreeze it to remove it."


def test_a_double_click_names_the_object_under_the_pointer(found, hand) -> None:
    add_objects(found, disk_object(1, (20, 60)))
    hand.double_click(20.0, 60.0)
    hand.release(20.0, 60.0)  # which QTest leaves out
    hand.qtbot.keyClick(name_field(found, hand), KEY.Key_Escape)


def test_other_contours_take_the_place_of_the_selected_ones(found, hand) -> None:
    drag(hand, (3.0, 3.0), (80.0, 118.0))
    assert len(selected(found)) == 6
    show_contours(found, Contour(ring((20, 20)), True, 5.0))
    assert selected(found) == set()


def test_a_line_of_a_shape_comes_before_what_lies_under_it_and_its_inside_after(found, hand) -> None:
    circle = Circle((20.0, 60.0), 15.0)
    found.session.edit("draw", lambda document: edits.add_shape(document, circle))
    add_objects(found, disk_object(1, (20, 60)))
    drag(hand, (20.0, 60.0))
    assert (found.session.selected_shape, chosen(found)) == (None, {1})
    drag(hand, (20.0, 75.0), (30.0, 75.0))
    assert (found.session.selected_shape, chosen(found)) == (0, set())
    assert found.session.document.shapes[0].center == pytest.approx((30.0, 60.0), abs=0.5)


def test_keys_alone_select_and_reject(found, hand) -> None:
    add_objects(found, *(disk_object(number, place) for number, place in enumerate(PLACES, start=1)))
    hand.key(KEY.Key_N, SHIFT)
    hand.key(KEY.Key_N, SHIFT)
    assert chosen(found) == {2}
    hand.key(KEY.Key_I, CONTROL)
    assert chosen(found) == {1, 3, 4, 5, 6}
    hand.key(KEY.Key_X)
    assert len(found.session.document.objects.rejected) == 5
    assert found.session.history.undo_name == "reject 5 objects"
