"""The pages of a stack in the window: paging, running all, following, the table, files and sessions."""

from __future__ import annotations

import re
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tifffile
from cpm_app.model.document import edits
from cpm_app.model.document.saving import describe_changes
from cpm_app.session.features import kept_pages
from cpm_app.session.features.kept_pages import KeptPage
from cpm_app.session.tasks import opening
from cpm_app.views.features.exchange import ExportFeature
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.features.volumes import PagesFeature
from cpm_app.views.window import dialogs
from PySide6.QtCore import QCoreApplication, Qt

from cpm_core import Page, Parameters
from cpm_core.objects.segmented import SegmentedObjects
from cpm_core.pages import ObjectFollower
from cpm_core.shapes import Circle, Everywhere, Polygon, PolygonRegion
from tests.app.conftest import disc
from tests.app.exporting import asked, export
from tests.app.reading import column_texts

pytestmark = pytest.mark.shared_window

LEFT = Qt.MouseButton.LeftButton
CIRCLE = Circle((30.0, 20.0), 5.0)
REGION = PolygonRegion(((1.0, 1.0), (60.0, 1.0), (60.0, 60.0), (1.0, 60.0)))


def shifted(by: int) -> np.ndarray:
    """A small disc that has moved to the right."""
    return np.roll(disc(9.0), by - 14, axis=1).astype(np.uint8)


@pytest.fixture
def stack_file(tmp_path: Path) -> Path:
    """Five pages with a disc that moves; the fourth is constant."""
    path = tmp_path / "cells.tif"
    pages = np.array([shifted(0), shifted(5), shifted(10), np.full((64, 64), 7), shifted(15)], np.uint8)
    tifffile.imwrite(path, pages, imagej=True, metadata={"axes": "TYX"})
    return path


@pytest.fixture
def stack(window, hand, stack_file):
    """A window on the first page, with a circle in the disc."""
    window.open_image(str(stack_file))
    hand.wait(lambda: window.session.document.image.name == "cells.tif" and window.session.idle)
    # without a limit of reach, since a start that lies across an edge does not say what it is drawn around
    window.session.load_document(edits.set_parameters(window.session.document, Parameters()))
    window.session.edit("draw circle", lambda document: edits.add_shape(document, CIRCLE))
    window.canvas_area.canvas.setFocus()
    return window


def settled(window, hand) -> None:
    """Wait until nothing is being done, and the tracks are those of what has been found."""
    pages = window.workspace.pages
    hand.wait(lambda: window.session.idle and not pages.running and not pages._turning)
    hand.wait(lambda: not pages._later.isActive() and pages._linking.idle and window.session.idle)
    QCoreApplication.processEvents()  # takes what the thread has found


def go(window, hand, key=Qt.Key.Key_PageDown, page: int = 0) -> None:
    """Press a key that goes to another page, and wait for it."""
    hand.key(key)
    hand.wait(lambda: window.workspace.pages.number == page)
    settled(window, hand)


def vertices(window) -> list[tuple[int, list[object]]]:
    """Vertices of the contours of all pages that are done."""
    found = window.workspace.pages.result.pages
    return [(page.number, [one.points.tolist() for one in page.contours]) for page in found]


def run_all(window, hand) -> None:
    hand.qtbot.mouseClick(window.get_feature(PagesFeature).bar.run, LEFT)
    assert window.workspace.pages.running
    settled(window, hand)


def test_nothing_is_said_of_the_first_page_when_it_is_opened_and_on_the_way_back_to_it(stack, hand) -> None:
    messages = stack.canvas_area.messages
    assert stack.session.image.notes == ()
    assert "first of its" not in messages.text
    go(stack, hand, Qt.Key.Key_PageDown, 2)
    assert "first of its" not in messages.text
    go(stack, hand, Qt.Key.Key_PageUp, 1)
    assert "first of its" not in messages.text
    assert stack.session.document.image.reading.page is None  # as in sessions and commands


def test_all_pages_are_written_in_several_formats_at_once(stack, hand, tmp_path) -> None:
    run_all(stack, hand)
    labels, table = export(hand.qtbot, stack, tmp_path, "pages:.tif", "pages:.measures.csv")
    assert (labels.name, table.name) == ("cells_pages.tif", "cells_pages.measures.csv")
    hand.wait(lambda: stack.canvas_area.messages.text == f"2 files written: {labels}")
    assert (tifffile.imread(labels)[0] > 0).sum() == pytest.approx(np.pi * 81.0, rel=0.1)
    assert table.read_text().startswith("page,track,")


def test_all_pages_are_written_only_if_asked_and_the_message_names_all_that_was_written(stack, hand, tmp_path) -> None:
    run_all(stack, hand)
    dialog = asked(hand.qtbot, stack)
    kinds = {what for what, _ in dialog.list.rows}
    assert {file.kind for file in dialog.checked_files} == {"contours"} and "pages" in kinds
    dialog.list.rows["pages", ".tif"].setCheckState(0, Qt.CheckState.Checked)
    assert dialog.summary.text() == "2 files: 1 contour of this page, All pages."
    dialog.reject()
    pages, contours = export(hand.qtbot, stack, tmp_path, "pages:.tif", "contours:.svg")[::-1]
    hand.wait(lambda: "(1 contour)" in stack.canvas_area.messages.text)
    hand.wait(lambda: {pages.name, contours.name} <= set(re.split("[ /;]", stack.canvas_area.messages.text)))
    (tmp_path / "again").mkdir()
    export(hand.qtbot, stack, tmp_path / "again", "contours:.svg")
    hand.wait(lambda: "again" in stack.canvas_area.messages.text)
    assert pages.name not in stack.canvas_area.messages.text
    (tmp_path / "three").mkdir()
    export(hand.qtbot, stack, tmp_path / "three", "pages:.tif", "pages:.measures.csv", "contours:.svg")
    hand.wait(lambda: stack.canvas_area.messages.text.startswith("3 files written: "))
    assert len(list((tmp_path / "three").iterdir())) == 3


def test_export_all_pages_checks_files_of_all_pages_alone(stack, hand) -> None:
    run_all(stack, hand)
    hand.key(Qt.Key.Key_F11, Qt.KeyboardModifier.ShiftModifier)
    hand.qtbot.mouseClick(stack.get_feature(PagesFeature).panel.export, LEFT)
    dialog = stack.get_feature(ExportFeature).dialog
    assert dialog is not None
    assert {file.kind for file in dialog.checked_files} == {"pages"}
    dialog.reject()


def test_the_line_shows_the_pages_and_keys_go_through_them(stack, hand) -> None:
    bar = stack.get_feature(PagesFeature).bar
    assert bar.isVisible()
    assert (bar.number.value(), bar.total_label.text()) == (1, "of 5")
    go(stack, hand, page=2)
    assert bar.number.value() == bar.slider.value() == 2
    np.testing.assert_array_equal(stack.session.image.values, shifted(5))
    go(stack, hand, Qt.Key.Key_PageUp, page=1)
    np.testing.assert_array_equal(stack.session.image.values, shifted(0))
    bar.number.setValue(5)
    hand.wait(lambda: stack.workspace.pages.number == 5)


def test_each_page_keeps_its_shapes_its_undo_and_its_run(stack, hand) -> None:
    session = stack.session
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    settled(stack, hand)
    here, found, done = session.document, session.scene.result, session.status.step
    assert len(found.contours) == 1
    go(stack, hand, page=2)
    assert isinstance(session.document.starts[0], Polygon)  # from the contours of the page before
    assert not session.history.undo_name
    session.edit("draw region", lambda document: edits.add_shape(document, REGION))
    go(stack, hand, Qt.Key.Key_PageUp, page=1)
    hand.wait(lambda: session.status.step == done and bool(session.scene.contours))
    assert session.document == here
    np.testing.assert_array_equal(session.scene.contours[0].points, found.contours[0].points)
    assert session.history.undo_name == "draw circle"
    session.undo()
    assert session.document.shapes == ()
    session.redo()
    go(stack, hand, page=2)
    assert session.history.undo_name == "draw region"
    assert isinstance(session.document.shapes[-1], PolygonRegion)


def test_all_pages_are_run_and_followed_and_the_table_tells_them(stack, hand) -> None:
    run_all(stack, hand)
    feature = stack.get_feature(PagesFeature)
    hand.key(Qt.Key.Key_F11, Qt.KeyboardModifier.ShiftModifier)
    table = feature.panel.table
    assert column_texts(table, "page") == ["1", "2", "3", "4", "5"]
    assert column_texts(table, "track") == ["1", "1", "1", "–", "1"]
    assert "constant" in column_texts(table, "happens")[3]
    assert [float(area) for area in column_texts(table, "area") if area != "–"] == pytest.approx(
        [np.pi * 81] * 4, rel=0.05
    )
    columns = [float(col) for col in column_texts(table, "col") if col != "–"]
    np.testing.assert_allclose(np.diff(columns), [5, 5, 5], atol=0.3)
    assert feature.panel.summary.text() == (
        "4 of 5 pages were run. Proposals on them, each counted once: 1. On each page Enter accepts its objects; "
        "until then its contours are listed. 1 could not be used."
    )
    strengths = column_texts(table, "strength")
    assert stack.session.status.phase == "finished"  # the page that is open shows its run
    assert len(stack.session.scene.contours) == 1
    for page in (1, 2, 3, 5):
        if page == 5:
            hand.key(Qt.Key.Key_PageDown)  # past the constant page, which cannot be opened
        if page > 1:
            go(stack, hand, page=page)
        hand.wait(lambda: bool(stack.workspace.object_selection.proposals))
        hand.canvas.setFocus()
        hand.key(Qt.Key.Key_Return)
        hand.wait(lambda: bool(stack.session.document.objects.items))
    hand.wait(lambda: feature.panel.summary.text() == "4 of 5 pages finished; tracks: 1. 1 could not be used.")
    for before, after in zip(strengths, column_texts(table, "strength"), strict=True):  # of contours, and of objects
        assert before == after == "–" or float(after) == pytest.approx(float(before), rel=0.02)


def test_enter_is_said_to_accept_nothing_once_all_that_pages_propose_is_rejected(stack, hand) -> None:
    run_all(stack, hand)
    feature = stack.get_feature(PagesFeature)
    hand.key(Qt.Key.Key_F11, Qt.KeyboardModifier.ShiftModifier)
    for page in (1, 2, 3, 5):
        if page == 5:
            hand.key(Qt.Key.Key_PageDown)  # past the constant page, which cannot be opened
        if page > 1:
            go(stack, hand, page=page)
        assert "Enter accepts" in feature.panel.summary.text()
        hand.wait(lambda: bool(stack.workspace.object_selection.proposals))
        hand.canvas.setFocus()
        hand.key(Qt.Key.Key_X)
        hand.wait(lambda: bool(stack.session.document.objects.rejected))
    hand.wait(lambda: feature.panel.summary.text() == "4 of 5 pages finished; tracks: 1. 1 could not be used.")


def test_a_page_that_shows_an_earlier_step_keeps_its_place_in_the_plot(stack, hand) -> None:
    run_all(stack, hand)
    panel = stack.get_feature(PagesFeature).panel
    hand.key(Qt.Key.Key_F11, Qt.KeyboardModifier.ShiftModifier)
    areas = column_texts(panel.table, "area")
    hand.canvas.setFocus()
    hand.key(Qt.Key.Key_Home)
    hand.wait(lambda: not stack.session.scene.contours and stack.session.scene.result is not None)
    settled(stack, hand)
    go(stack, hand, page=2)
    assert column_texts(panel.table, "area") == areas


def test_objects_of_a_page_are_not_said_to_be_missing_while_they_are_being_found(stack, hand) -> None:
    run_all(stack, hand)
    stack.docks.reveal_panel("objects")
    summary, said = stack.panels["objects"].summary, []
    hand.canvas.setFocus()
    for key, page in ((Qt.Key.Key_PageDown, 2), (Qt.Key.Key_PageUp, 1)):
        hand.key(key)
        hand.wait(lambda page=page: stack.workspace.pages.number == page)
        hand.wait(lambda: said.append(summary.text()) or bool(stack.workspace.object_selection.proposals))
    assert not [text for text in said if text.startswith("Nothing yet")]


def test_a_double_click_in_the_table_goes_to_the_contour_and_selects_it(window, hand, tmp_path) -> None:
    two = np.stack([shifted(by) + np.roll(shifted(by), (-20, 20), (0, 1)) for by in range(0, 9, 3)]).astype(np.uint8)
    tifffile.imwrite(tmp_path / "two.tif", two, photometric="minisblack")
    window.open_image(str(tmp_path / "two.tif"))
    hand.wait(lambda: window.session.document.image.name == "two.tif" and window.session.idle)
    window.session.edit("start", lambda document: edits.add_shape(document, Everywhere("grid")))
    run_all(window, hand)
    hand.key(Qt.Key.Key_F11, Qt.KeyboardModifier.ShiftModifier)
    feature = window.get_feature(PagesFeature)
    table, selection = feature.panel.table, window.workspace.contour_selection
    for row in reversed(range(table.model().rowCount())):
        told = table.rows.items[row]
        table.scrollTo(table.model().index(row, 0))
        place = table.visualRect(table.model().index(row, 0)).center()
        hand.qtbot.mouseClick(table.viewport(), LEFT, pos=place)
        hand.qtbot.mouseDClick(table.viewport(), LEFT, pos=place)
        hand.wait(lambda told=told: feature.bar.number.value() == told.page and len(selection.selected_contours) == 1)
        center = selection.selected_contours[0].points.mean(axis=0)
        np.testing.assert_allclose(center, (told.row, told.col), atol=1.0)


def test_a_page_that_was_run_in_the_background_shows_its_contours_and_undo_leads_back(stack, hand) -> None:
    session = stack.session
    go(stack, hand, page=2)
    before = session.document
    session.edit(
        "draw region", lambda document: edits.add_shape(document, PolygonRegion(((1, 1), (60, 1), (60, 60), (1, 60))))
    )
    go(stack, hand, Qt.Key.Key_PageUp, page=1)
    run_all(stack, hand)
    go(stack, hand, page=2)
    hand.wait(lambda: bool(session.scene.contours))
    assert session.status.phase == "finished"
    assert isinstance(session.document.starts[0], Polygon)
    assert session.history.undo_name == "run all pages"
    session.undo()
    assert session.document.starts == before.starts
    assert session.history.undo_name == "draw region"


def test_the_first_undo_after_all_pages_were_run_takes_the_last_edit_back_and_no_number_is_given_twice(
    stack, hand
) -> None:
    session, control = stack.session, Qt.KeyboardModifier.ControlModifier
    run_all(stack, hand)
    hand.canvas.setFocus()
    taken = stack.workspace.pages.largest_number
    assert taken > 0
    assert not describe_changes(session.document, replace(session.document, objects=SegmentedObjects()))
    hand.key(Qt.Key.Key_Z, control)
    assert session.document.shapes == ()
    hand.key(Qt.Key.Key_Y, control)
    assert session.document.shapes == (CIRCLE,)
    assert session.document.objects.next_number == taken + 1


def test_enter_right_after_a_page_key_accepts_what_that_page_offers(stack, hand) -> None:
    run_all(stack, hand)
    hand.canvas.setFocus()
    hand.key(Qt.Key.Key_Return)
    for page in (2, 3):
        hand.key(Qt.Key.Key_PageDown)
        hand.key(Qt.Key.Key_Return)
        hand.wait(lambda page=page: stack.workspace.pages.number == page)
        hand.wait(lambda: not stack.workspace.object_selection.has_waiting_keys)
    assert [len(stack.workspace.pages.documents[page].objects.items) for page in (1, 2, 3)] == [1, 1, 1]


@pytest.fixture
def later_pages(monkeypatch) -> threading.Event:
    """Pages after the first are run once this is set."""
    may_run, run, begun = threading.Event(), kept_pages.run_recorded, []

    def run_late(*given):
        begun.append(given)
        assert len(begun) == 1 or may_run.wait(60)
        return run(*given)

    monkeypatch.setattr(kept_pages, "run_recorded", run_late)
    return may_run


def begin_to_run_all(window, hand) -> None:
    """Begin to run all pages, and go to the second one, which is not run yet."""
    hand.qtbot.mouseClick(window.get_feature(PagesFeature).bar.run, LEFT)
    hand.wait(lambda: 1 in window.workspace.pages._proposed)
    hand.canvas.setFocus()
    hand.key(Qt.Key.Key_PageDown)
    hand.wait(lambda: window.workspace.pages.number == 2)


def test_objects_of_a_page_stay_when_the_run_of_all_pages_comes_to_it(stack, hand, later_pages) -> None:
    begin_to_run_all(stack, hand)
    selection = stack.workspace.object_selection
    hand.key(Qt.Key.Key_W)
    hand.wait(lambda: selection.ready)
    hand.click(30.0, 25.0)
    hand.key(Qt.Key.Key_Return)
    hand.wait(lambda: bool(stack.session.document.objects.items))
    accepted = stack.session.document.objects.items
    later_pages.set()
    settled(stack, hand)
    assert stack.session.document.objects.items == accepted


def test_enter_that_waits_on_a_page_acts_after_the_run_of_all_pages_has_come_to_it(
    stack, hand, later_pages, monkeypatch
) -> None:
    session, selection, may_find = stack.session, stack.workspace.object_selection, threading.Event()
    find = ObjectFollower.find_on_page
    monkeypatch.setattr(ObjectFollower, "find_on_page", lambda *given: (may_find.wait(60), find(*given))[1])
    hand.qtbot.mouseClick(stack.get_feature(PagesFeature).bar.run, LEFT)
    hand.wait(lambda: 1 in stack.workspace.pages._proposed and selection.idle and bool(selection.proposals))
    hand.canvas.setFocus()
    hand.key(Qt.Key.Key_Return)
    hand.key(Qt.Key.Key_PageDown)
    hand.wait(lambda: stack.workspace.pages.number == 2 and selection.awaits_offer)
    hand.key(Qt.Key.Key_Return)
    assert selection.has_waiting_keys
    with hand.qtbot.waitSignal(session.image_changed):
        later_pages.set()
    may_find.set()
    settled(stack, hand)
    hand.wait(lambda: not selection.has_waiting_keys)
    assert len(session.document.objects.items) == 1


@pytest.fixture
def late_opening(monkeypatch):
    """An event until which no further image is opened, and what has been asked for."""
    may_open, prepare, asked_for = threading.Event(), opening.prepare_image, []

    def prepare_late(*given):
        asked_for.append(given)
        may_open.wait(60)
        return prepare(*given)

    monkeypatch.setattr(opening, "prepare_image", prepare_late)
    return may_open, asked_for


def test_going_back_while_a_page_is_opened_shows_the_page_that_was_gone_back_to(stack, hand, late_opening) -> None:
    pages, (may_open, asked_for) = stack.workspace.pages, late_opening
    hand.key(Qt.Key.Key_PageDown)
    hand.wait(lambda: bool(asked_for))
    hand.key(Qt.Key.Key_PageUp)
    hand.qtbot.wait(50)
    may_open.set()
    hand.wait(lambda: pages.wanted_page == pages.number == 1 and not pages.is_turning and stack.session.idle)
    settled(stack, hand)
    assert (pages.wanted_page, pages.number, pages.is_turning) == (1, 1, False)
    np.testing.assert_array_equal(stack.session.image.values, shifted(0))


@pytest.mark.parametrize("keys", [(Qt.Key.Key_PageDown, Qt.Key.Key_PageUp), (Qt.Key.Key_PageDown,)])
def test_a_page_left_while_what_its_run_has_found_is_opened_keeps_the_run(
    stack, hand, later_pages, late_opening, keys
) -> None:
    pages, (may_open, asked_for) = stack.workspace.pages, late_opening
    hand.qtbot.mouseClick(stack.get_feature(PagesFeature).bar.run, LEFT)
    hand.wait(lambda: bool(asked_for))  # the first page is opened again
    hand.canvas.setFocus()
    for key in keys:
        hand.key(key)
    hand.wait(lambda: not pages._turning)
    may_open.set()
    hand.wait(lambda: pages.number == pages.wanted_page == 3 - len(keys) and not pages.is_turning)
    if len(keys) == 1:
        hand.key(Qt.Key.Key_PageUp)
    hand.wait(lambda: pages.number == 1 and not pages.is_turning and len(stack.session.scene.contours) == 1)
    later_pages.set()
    settled(stack, hand)
    assert pages.documents[1].shapes == (CIRCLE,)
    assert pages._describe_open_page().runs


def test_a_page_that_was_left_but_is_shown_all_the_same_gives_way_to_the_wanted_one(stack, hand, monkeypatch) -> None:
    pages, replace_image, late = stack.workspace.pages, stack.session.replace_image, []
    monkeypatch.setattr(stack.session, "replace_image", late.append)
    hand.key(Qt.Key.Key_PageDown)
    hand.wait(lambda: bool(late))  # the report of the opened page is on its way
    monkeypatch.undo()
    hand.key(Qt.Key.Key_PageUp)
    hand.wait(lambda: not pages._turning)
    replace_image(late[0])
    hand.wait(lambda: pages.number == 2)
    hand.wait(lambda: pages.number == 1 and not pages.is_turning)
    settled(stack, hand)
    np.testing.assert_array_equal(stack.session.image.values, shifted(0))
    go(stack, hand, Qt.Key.Key_PageDown, 2)


def test_a_page_that_is_run_again_while_the_pages_are_linked_keeps_what_is_new(stack, hand) -> None:
    run_all(stack, hand)
    pages = stack.workspace.pages
    pages._link_pages()  # as after another change
    failed = Page(2, None, error="no edges")
    pages._on_page_done(pages.source.path, None, failed, failed, KeptPage(stack.session.document))
    settled(stack, hand)
    assert [page.error for page in pages.result.pages if page.number == 2] == ["no edges"]


def test_a_page_with_a_start_of_its_own_keeps_it(stack, hand) -> None:
    session, own = stack.session, Circle((30.0, 30.0), 4.0)
    go(stack, hand, page=2)
    go(stack, hand, page=3)
    session.edit("draw", lambda document: edits.add_shape(document, own))
    go(stack, hand, Qt.Key.Key_PageUp, page=2)
    go(stack, hand, Qt.Key.Key_PageUp, page=1)
    run_all(stack, hand)
    go(stack, hand, page=2)
    go(stack, hand, page=3)
    assert own in session.document.shapes


def test_stop_keeps_the_pages_that_are_done(stack, hand) -> None:
    pages = stack.workspace.pages
    bar = stack.get_feature(PagesFeature).bar
    hand.qtbot.mouseClick(bar.run, LEFT)
    assert bar.run.text() == "Stop"
    hand.wait(lambda: 1 in pages._found_pages)
    hand.qtbot.mouseClick(bar.run, LEFT)
    settled(stack, hand)
    assert bar.run.text() == "Run all pages"
    done = [page.number for page in pages.result.pages]
    assert done == list(range(1, len(done) + 1))
    assert len(done) < 5 or pages.result.results


def test_a_session_keeps_the_pages(stack, hand, tmp_path) -> None:
    run_all(stack, hand)
    documents = stack.get_feature(OpenSaveFeature).document_file
    assert documents.unsaved
    assert documents.save_and_wait(tmp_path / "a.cpm")
    assert not documents.unsaved
    before = [
        (page.number, [one.points.tolist() for one in page.contours]) for page in stack.workspace.pages.result.pages
    ]
    stack.session.open_file(tmp_path / "a.cpm")
    hand.wait(lambda: stack.session.idle and stack.workspace.pages.result is not None)
    settled(stack, hand)
    assert vertices(stack) == before
    assert not documents.unsaved
    stack.canvas_area.canvas.setFocus()
    go(stack, hand, page=2)
    hand.wait(lambda: bool(stack.session.scene.contours))
    assert stack.session.status.phase == "finished"
    assert documents.path == tmp_path / "a.cpm"
    assert not documents.unsaved


def test_paging_asks_nothing_and_loses_nothing(stack, hand, monkeypatch) -> None:
    asked = []
    monkeypatch.setattr(dialogs, "ask_about_unsaved", lambda *question: asked.append(question) or "discard")
    documents = stack.get_feature(OpenSaveFeature).document_file
    assert documents.unsaved
    go(stack, hand, page=2)
    assert documents.unsaved  # the circle on the page before
    assert "the other pages" in documents.unsaved_parts
    assert asked == []
