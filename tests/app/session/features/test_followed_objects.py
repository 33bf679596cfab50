"""Objects followed through the pages of a stack in the window: offered on the next page, accepted on all of them."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
import tifffile
from cpm_app.model.display.plots import build_page_plots
from cpm_app.model.document import edits, objects
from cpm_app.session.features.outcome import describe_outcome
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.features.volumes import PagesFeature
from PySide6.QtCore import QPointF, Qt

import cpm_core as cpm
from cpm_core.cli import main
from cpm_core.shapes import Everywhere
from tests.app.exporting import asked, export
from tests.app.reading import column_texts

pytestmark = pytest.mark.shared_window

KEY, LEFT, SHIFT = Qt.Key, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.ShiftModifier
ALL = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier


def disk(row: float, col: float, radius: float) -> np.ndarray:
    rows, cols = np.indices((64, 64))
    return np.hypot(rows - row, cols - col) < radius


def page(*disks: tuple[float, ...]) -> np.ndarray:
    """A dark image with a soft noise, and bright disks, perhaps with gray levels of their own."""
    values = np.full((64, 64), 30.0)
    for row, col, radius, *level in disks:
        values[disk(row, col, radius)] = level[0] if level else 200.0
    return (values + np.random.default_rng(1).normal(0.0, 3.0, values.shape)).astype(np.uint8)


MOVING = [((20 + 2 * step, 18 + 3 * step, 9), (46, 44 - 2 * step, 7)) for step in range(4)]
DIVIDING = [((32, 20, 9),), ((32, 20, 9),), ((25, 20, 6), (39, 20, 6)), ((22, 20, 6), (42, 20, 6))]


@pytest.fixture
def stack(window, hand, tmp_path: Path):
    """Opens a stack of pages with disks, with the tool for objects in use."""

    def opened(pages, axes="TYX"):
        path = tmp_path / "cells.tif"
        tifffile.imwrite(path, np.array([page(*disks) for disks in pages]), imagej=True, metadata={"axes": axes})
        window.open_image(str(path))
        hand.wait(lambda: window.session.document.image.name == "cells.tif" and window.session.idle)
        hand.canvas.setFocus()
        hand.key(KEY.Key_W)
        settled(window, hand)
        return window

    return opened


def settled(window, hand) -> None:
    pages, selection = window.workspace.pages, window.workspace.object_selection
    hand.wait(lambda: window.session.idle and not pages._turning and selection.ready and selection.idle)
    hand.wait(lambda: not pages._later.isActive() and pages._linking.idle and window.session.idle and selection.idle)
    hand.qtbot.wait(20)


def followed(window, hand) -> None:
    """Follow the objects of the page through all others."""
    hand.key(KEY.Key_F, ALL)
    assert window.workspace.followed_objects.running
    hand.wait(lambda: not window.workspace.followed_objects.running)
    settled(window, hand)


def take(window, hand, *places: tuple[float, float]) -> None:
    """Select objects by clicks, and accept each."""
    selection = window.workspace.object_selection
    for place in places:
        hand.click(*place)
        hand.wait(lambda: selection.selecting and [each.key for each in selection.proposals[:1]] == [0])
        hand.key(KEY.Key_Return)
    settled(window, hand)


def go(window, hand, number: int, key=KEY.Key_PageDown) -> None:
    hand.canvas.setFocus()
    hand.key(key)
    hand.wait(lambda: window.workspace.pages.number == number)
    settled(window, hand)


def items(window) -> dict[int, object]:
    return {item.number: item for item in window.session.document.objects.items}


def is_disk(item, disk_of: tuple[float, float, float]) -> bool:
    one, other = item.region.paste((64, 64)), disk(*disk_of)
    return (one & other).sum() / (one | other).sum() > 0.85


def numbers_offered(window) -> list[int]:
    return [each.proposed_object.number for each in window.workspace.object_selection.proposals]


def toggle_following(window, hand) -> None:
    """Press the button Follow below the image."""
    button = window.get_feature(PagesFeature).bar.follow
    hand.qtbot.mouseClick(button, LEFT)
    settled(window, hand)


@pytest.mark.parametrize(("axes", "told"), [("TYX", True), ("CYX", False)], ids=["in time", "in another channel"])
def test_an_object_that_is_not_found_again_ends_in_time_and_not_between_channels(stack, hand, axes, told):
    window, shown = stack([MOVING[0], MOVING[0][:1]], axes), []
    window.session.messages.shown.connect(lambda message, *_: shown.append(message))
    take(window, hand, *(each[:2] for each in MOVING[0]))
    go(window, hand, 2)
    assert window.get_feature(PagesFeature).bar.run.text() == ("Run all pages" if told else "Run all channels")
    assert numbers_offered(window) == ([1] if told else [])  # channels are followed when the user says so
    if not told:
        toggle_following(window, hand)
    assert numbers_offered(window) == [1]
    assert any("ends" in message for message in shown) == told
    toggle_following(window, hand)
    assert numbers_offered(window) == []


def test_another_candidate_of_what_is_followed_is_accepted_by_enter_alone_with_number_name_and_color(stack, hand):
    nucleus = [((30.0, col, 16.0, 110.0), (30.0, col, 7.0)) for col in (28.0, 31.0)]
    window = stack(nucleus)
    selection = window.workspace.object_selection
    take(window, hand, (30.0, 28.0))
    window.session.edit("name", lambda d: objects.update_objects(d, (1,), name="left", color="#123456", category=3))
    go(window, hand, 2)
    offered = selection.proposals[0].selection
    hand.key(KEY.Key_BracketRight)
    hand.wait(lambda: selection.selecting)
    settled(window, hand)
    assert window.session.history.undo_name == "larger candidate"
    assert not items(window)
    assert numbers_offered(window) == [1]
    larger = selection.proposals[0].selection
    assert larger.region.count > offered.region.count
    hand.key(KEY.Key_Escape)
    settled(window, hand)
    assert not items(window)
    assert selection.proposals[0].selection.has_same_region(offered)
    hand.key(KEY.Key_BracketRight)
    hand.wait(lambda: selection.selecting)
    settled(window, hand)
    hand.key(KEY.Key_Return)
    settled(window, hand)
    (item,) = items(window).values()
    assert (item.number, item.name, item.color, item.category) == (1, "left", "#123456", 3)
    assert item.region.paste((64, 64)).sum() == larger.region.count


def test_what_was_accepted_is_offered_on_the_next_page_with_its_number_name_class_and_color(stack, hand):
    window = stack(MOVING)
    take(window, hand, *(each[:2] for each in MOVING[0]))
    window.session.edit("name", lambda d: objects.update_objects(d, (2,), name="left", color="#123456", category=3))
    go(window, hand, 2)
    assert not items(window)
    assert numbers_offered(window) == [1, 2]
    hand.key(KEY.Key_Return)
    found = items(window)
    assert all(is_disk(found[number], MOVING[1][number - 1]) for number in (1, 2))
    assert (found[2].name, found[2].color, found[2].category) == ("left", "#123456", 3)
    settled(window, hand)
    go(window, hand, 3)
    hand.key(KEY.Key_Return)
    assert all(is_disk(items(window)[number], MOVING[2][number - 1]) for number in (1, 2))


def test_keys_count_in_their_order_while_a_page_is_left_and_what_is_followed_on_the_next_is_sought(
    stack, hand, monkeypatch
):
    window = stack(MOVING)
    selection, pages, select = window.workspace.object_selection, window.workspace.pages, cpm.Partition.select
    monkeypatch.setattr(cpm.Partition, "select", lambda *given, **more: (time.sleep(0.1), select(*given, **more))[1])
    hand.click(*MOVING[0][0][:2])
    hand.key(KEY.Key_Return)
    for number in (2, 3):
        hand.key(KEY.Key_PageDown)
        if number == 3:  # the keys for page 2 are pressed before it is open
            hand.wait(lambda: pages.number == 3 and selection.awaits_offer)
            assert not selection.proposals
        hand.key(KEY.Key_Return)
    settled(window, hand)
    assert [len(pages.documents[number].objects.items) for number in (1, 2, 3)] == [1, 1, 1]
    hand.key(KEY.Key_PageDown)
    hand.wait(lambda: pages.number == 4 and selection.awaits_offer)
    hand.key(KEY.Key_Return)
    window.session.tasks.current[-1].cancel()
    settled(window, hand)
    assert not items(window)
    assert "nothing to accept" in window.canvas_area.messages.text


def test_a_click_corrects_what_is_followed_under_its_number_and_a_new_object_gets_another_one(stack, hand):
    window = stack(MOVING)
    take(window, hand, MOVING[0][1][:2])
    go(window, hand, 2)
    take(window, hand, MOVING[1][0][:2])
    assert is_disk(items(window)[2], MOVING[1][0])
    hand.click(*MOVING[1][1][:2])  # what is offered, which is corrected by the next click
    settled(window, hand)
    hand.qtbot.mouseClick(hand.canvas.viewport(), LEFT, SHIFT, hand.at(46, 48))
    hand.wait(lambda: window.workspace.object_selection.selecting)
    settled(window, hand)
    assert sorted(items(window)) == [2]
    hand.key(KEY.Key_Return)
    settled(window, hand)
    assert sorted(items(window)) == [1, 2]


def test_all_pages_are_followed_and_a_page_with_objects_stays_as_it_is(stack, hand):
    window = stack(MOVING)
    pages = window.workspace.pages
    take(window, hand, MOVING[0][0][:2])
    go(window, hand, 2)
    go(window, hand, 3)
    take(window, hand, MOVING[2][1][:2])
    kept = items(window)
    go(window, hand, 2, KEY.Key_PageUp)
    go(window, hand, 1, KEY.Key_PageUp)
    followed(window, hand)
    documents = pages.documents
    assert is_disk(documents[2].objects[1], MOVING[1][0])
    assert {item.number: item for item in documents[3].objects.items} == kept
    assert [is_disk(item, MOVING[3][1]) for item in documents[4].objects.items] == [True]
    go(window, hand, 2)
    assert window.session.history.undo_name == "follow objects"
    window.session.undo()
    assert not items(window)


def test_a_division_is_reported_with_its_page_and_the_table_and_files_hold_the_numbers(stack, hand, tmp_path):
    window = stack(DIVIDING)
    take(window, hand, (32, 20))
    followed(window, hand)
    assert "Page 3: track 2 splits off track 1." in window.canvas_area.messages.text
    hand.key(KEY.Key_F11, Qt.KeyboardModifier.ShiftModifier)
    table = window.get_feature(PagesFeature).panel.table
    assert sorted(zip(column_texts(table, "page"), column_texts(table, "track"), strict=True)) == [
        ("1", "1"), ("2", "1"), ("3", "1"), ("3", "2"), ("4", "1"), ("4", "2")]  # fmt: skip
    assert "splits off track 1" in column_texts(table, "happens")
    assert all(float(gray) == pytest.approx(190.0, abs=20.0) for gray in column_texts(table, "gray")), column_texts(
        table, "gray"
    )
    dialog = asked(hand.qtbot, window)
    assert ("pages", ".measures.csv") in dialog.list.checked_formats
    dialog.reject()
    labels, rows = export(hand.qtbot, window, tmp_path, "pages:.tif", "pages:.measures.csv")
    hand.wait(lambda: labels.exists() and rows.exists())
    assert [sorted(np.unique(one)) for one in tifffile.imread(labels)] == [[0, 1], [0, 1], [0, 1, 2], [0, 1, 2]]
    assert "mean_gray" in rows.read_text().splitlines()[0]


def test_a_click_in_the_table_or_in_the_plot_goes_to_the_page_and_selected_objects_are_plotted(stack, hand):
    window = stack(MOVING[:3])
    take(window, hand, *(each[:2] for each in MOVING[0]))
    followed(window, hand)
    hand.key(KEY.Key_F11, Qt.KeyboardModifier.ShiftModifier)
    panel = window.get_feature(PagesFeature).panel
    table, chart = panel.table, panel.chart
    hand.wait(lambda: table.model().rowCount() == 6 and bool(chart._items))
    assert len(chart._curves) == 4
    row = column_texts(table, "page").index("3") + 1
    hand.qtbot.mouseClick(table.viewport(), LEFT, pos=table.visualRect(table.model().index(row, 0)).center())
    hand.wait(lambda: window.workspace.pages.number == 3 and window.workspace.object_list.selected_numbers == {2})
    settled(window, hand)
    assert len(chart._curves) == 2
    pages, areas = chart._curves[0][2].getData()
    assert pages.tolist() == [1, 2, 3]
    np.testing.assert_allclose(areas, np.pi * 49, rtol=0.12)
    place = chart._items[0].getViewBox().mapViewToScene(QPointF(2.1, areas[1]))
    hand.qtbot.mouseClick(chart.viewport(), LEFT, pos=chart.mapFromScene(place))
    hand.wait(lambda: window.workspace.pages.number == 2)


def test_a_page_lists_the_contours_of_its_run_until_it_has_objects(stack, hand):
    window = stack(MOVING[:2])
    panel = window.get_feature(PagesFeature).panel
    hand.key(KEY.Key_F11, Qt.KeyboardModifier.ShiftModifier)
    window.session.edit("start", lambda document: edits.add_shape(document, Everywhere("grid")))
    window.session.run()
    hand.wait_for_phase("finished")
    settled(window, hand)
    assert column_texts(panel.table, "kind") == ["closed", "closed"]
    assert not any(row.is_object for row in panel.table.rows.items)
    hand.click(*MOVING[0][0][:2])
    hand.canvas.setFocus()
    hand.key(KEY.Key_Return)
    settled(window, hand)
    assert [row.is_object for row in panel.table.rows.items] == [True]


def test_following_can_be_cancelled_and_a_session_keeps_the_objects_of_all_pages(stack, hand, tmp_path):
    window = stack(MOVING)
    pages = window.workspace.pages
    take(window, hand, *(each[:2] for each in MOVING[0]))
    hand.key(KEY.Key_F, ALL)
    hand.wait(lambda: bool(pages.documents.get(2) and pages.documents[2].objects.items))
    window.session.tasks.current[-1].cancel()
    hand.wait(lambda: window.session.tasks.idle)
    settled(window, hand)
    done = [number for number, one in pages.documents.items() if one.objects.items]
    assert 2 in done
    followed(window, hand)
    rows = pages.table[1]
    documents = window.get_feature(OpenSaveFeature).document_file
    assert documents.save_and_wait(tmp_path / "a.cpm")
    window.session.open_file(tmp_path / "a.cpm")
    hand.wait(lambda: window.session.idle and set(pages.documents) == {1, 2, 3, 4})
    settled(window, hand)
    again = pages.table[1]
    assert [(row.page, row.track, row.gray) for row in again] == [(row.page, row.track, row.gray) for row in rows]
    assert len(rows) == 8
    assert not documents.unsaved


def test_following_stops_with_a_report_where_nothing_is_found(stack, hand):
    window = stack([MOVING[0], MOVING[1], [(60, 60, 2)], MOVING[2]])
    take(window, hand, MOVING[0][0][:2])
    followed(window, hand)
    assert "Page 3" in window.canvas_area.messages.text
    assert [number for number, one in window.workspace.pages.documents.items() if one.objects.items] == [2, 1]


def run_all(window, hand) -> None:
    window.session.edit("start", lambda document: edits.add_shape(document, Everywhere("grid")))
    hand.qtbot.mouseClick(window.get_feature(PagesFeature).bar.run, LEFT)
    settled(window, hand)
    hand.wait(lambda: not window.workspace.pages.running)
    settled(window, hand)


def test_a_page_is_done_once_all_that_it_offers_is_rejected_and_not_before(stack, hand):
    window = stack([MOVING[0]] * 2)
    run_all(window, hand)
    selection, panel = window.workspace.object_selection, window.panels["pages"]
    for page in (1, 2):
        if page == 2:
            go(window, hand, 2)
        hand.wait(lambda: len(selection.proposals) == 2 and selection.idle)
        for left in (1, 0):
            assert "Enter accepts" in panel.summary.text()
            window.workspace.object_list.select_objects([selection.proposals[0].key])
            hand.canvas.setFocus()
            hand.key(KEY.Key_X)
            hand.wait(lambda left=left: len(selection.proposals) == left)
            settled(window, hand)
    hand.wait(lambda: panel.summary.text() == "2 of 2 pages finished; tracks: 2.")


def propose_two(window, hand) -> None:
    """Run everywhere on the open page, and wait for the two objects that are found there."""
    selection = window.workspace.object_selection
    window.session.edit("start", lambda document: edits.add_shape(document, Everywhere("grid")))
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: selection.offer_is_known and selection.idle and len(selection.proposals) == 2)


@pytest.mark.parametrize("saved", ["kept", pytest.param("open", marks=pytest.mark.long), "other"])
def test_a_deleted_object_is_proposed_again_by_another_run_alone_whatever_is_opened_between(
    stack, hand, tmp_path, saved
):
    window = stack([MOVING[0]] * 2)
    selection, listed = window.workspace.object_selection, window.workspace.object_list
    propose_two(window, hand)
    hand.key(KEY.Key_Return)
    hand.wait(lambda: len(window.session.document.objects.items) == 2 and selection.idle)
    listed.select_objects((1,))
    hand.canvas.setFocus()
    hand.key(KEY.Key_Delete)
    hand.wait(lambda: len(window.session.document.objects.items) == 1 and selection.idle)
    if saved != "open":
        go(window, hand, 2)
    if saved != "kept":
        path = tmp_path / "deleted.cpm"
        assert window.get_feature(OpenSaveFeature).document_file.save_and_wait(path)
        with hand.qtbot.waitSignal(window.session.image_changed):
            window.session.open_file(path)
        settled(window, hand)
    if saved != "open":
        go(window, hand, 1, KEY.Key_PageUp)
    hand.wait(lambda: window.session.status.phase == "finished" and selection.offer_is_known and selection.idle)
    assert selection.proposals == ()
    assert window.session.document.objects.rejected == ()
    hand.canvas.setFocus()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: selection.offer_is_known and selection.idle and len(selection.proposals) == 1)


def test_what_was_rejected_before_all_pages_are_run_is_offered_on_no_page_and_takes_no_number(stack, hand):
    window = stack([MOVING[0]] * 2)
    selection, pages = window.workspace.object_selection, window.workspace.pages
    propose_two(window, hand)

    def reject_one(left: int) -> None:
        window.workspace.object_list.select_objects([selection.proposals[0].key])
        hand.canvas.setFocus()
        hand.key(KEY.Key_X)
        hand.wait(lambda: selection.idle and len(selection.proposals) == left)

    reject_one(1)
    hand.qtbot.mouseClick(window.get_feature(PagesFeature).bar.run, LEFT)
    settled(window, hand)
    hand.wait(lambda: not pages.running)
    settled(window, hand)
    assert {one.number for page in pages._proposed.values() for one in page.contours} == {1, 2}
    hand.wait(lambda: selection.offer_is_known and selection.idle and len(selection.proposals) == 1)
    reject_one(0)
    assert pages.offers_objects
    go(window, hand, 2)
    hand.wait(lambda: selection.offer_is_known and selection.idle and len(selection.proposals) == 2)
    reject_one(1)
    reject_one(0)
    assert not pages.offers_objects


def number_at(labels, disk) -> int:
    return int(labels[round(disk[0]), round(disk[1])])


def test_window_command_line_and_library_propose_the_same_objects_under_the_same_numbers(stack, hand, tmp_path):
    pages = [(*disks, (48, 46, 8)) for disks in DIVIDING]
    window = stack(pages)
    run_all(window, hand)
    assert "4 of 4 pages were run" in window.canvas_area.messages.text
    selection, path = window.workspace.object_selection, tmp_path / "cells.tif"
    seen = []
    for at in range(1, 5):
        if at > 1:
            hand.key(KEY.Key_PageDown)
            hand.wait(lambda at=at: window.workspace.pages.number == at)
            settled(window, hand)
        # before the run of the page is back, the objects that are followed from the page before are offered
        hand.wait(lambda: window.session.status.phase == "finished" and selection.idle and bool(selection.proposals))
        assert describe_outcome(window.workspace).startswith(f"{len(selection.proposals)} proposals")
        seen.append({each.number for each in selection.proposals})
        hand.canvas.setFocus()
        hand.key(KEY.Key_Return)
        settled(window, hand)
        assert {item.number for item in window.session.document.objects.items} == seen[-1]
    given = ("run", str(path), "--pages", "all", "--objects", "--follow", "--export", str(tmp_path / "a.tif"))
    parameters = window.session.document.parameters
    assert main([*given, "--preset", "shape", "--reach", str(parameters.reach)]) == 0
    labels = tifffile.imread(tmp_path / "a.tif")
    grid = cpm.uniform_grid((64, 64))
    found = list(cpm.follow_pages(cpm.load_pages(path), grid, parameters, objects=True))
    for number, (numbers, one, disks) in enumerate(zip(seen, found, pages, strict=True)):
        assert numbers == {contour.number for contour in one.contours}
        assert numbers == {number_at(labels[number], each) for each in disks}
    assert [len(numbers) for numbers in seen] == [2, 2, 3, 3]
    assert [(event.kind, event.page) for one in found for event in one.events] == [("splits", 3)]


def test_without_a_start_run_all_pages_follows_the_accepted_objects_in_colors_of_their_own(stack, hand):
    window = stack(MOVING[:2])
    take(window, hand, *(each[:2] for each in MOVING[0]))
    hand.qtbot.mouseClick(window.get_feature(PagesFeature).bar.run, LEFT)
    hand.wait(lambda: not window.workspace.followed_objects.running)
    settled(window, hand)
    assert [row.track for row in window.workspace.pages.table[1]] == [1, 2, 1, 2]
    curves = build_page_plots(range(1, 11), "", "")[0].curves
    assert len({curve.colors for curve in curves}) == 10
