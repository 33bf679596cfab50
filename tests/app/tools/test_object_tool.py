"""The tool for objects: what a click takes is shown before it, and clicks, strokes and keys do what they say."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt

from app.model.document.objects import made
from app.session.features import object_selection
from app.session.features.selector import Selector
from app.session.storage.session_file import DocumentFile
from cpm_core import circle, partition
from cpm_core.objects.segmented.segmented_object import Click
from cpm_core.shapes import Barrier, Circle, Polygon, Region

pytestmark = pytest.mark.shared_window

KEY, NONE = Qt.Key, Qt.KeyboardModifier.NoModifier
ALT, CONTROL = Qt.KeyboardModifier.AltModifier, Qt.KeyboardModifier.ControlModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier
SMALL, LARGE = ((18.0, 18.0), 9.0), ((43.0, 42.0), 12.0)


def disk(center: tuple[float, float], radius: float) -> np.ndarray:
    """Which pixels of the image lie in a disk."""
    row, col = np.indices((64, 64))
    return np.hypot(row - center[0], col - center[1]) < radius


@pytest.fixture
def image_file(tmp_path):
    """A file with two disks of different gray levels."""
    path = tmp_path / "disks.npy"
    np.save(path, np.where(disk(*SMALL), 140.0, np.where(disk(*LARGE), 220.0, 20.0)))
    return path


@pytest.fixture
def objects(window, hand):
    """The selection of objects of a window in which the tool is in use and ready."""
    selection = window.workspace.object_selection
    hand.canvas.setFocus()
    hand.key(KEY.Key_W)
    hand.wait(lambda: selection.ready)
    return selection


@pytest.fixture
def layer(window):
    return window.canvas_area.canvas.layers["objects"]


def taken(window):
    return window.session.document.objects.items


def overlap(one: np.ndarray, other: np.ndarray) -> float:
    return (one & other).sum() / (one | other).sum()


def click(hand, row: float, col: float, modifier: Qt.KeyboardModifier = NONE) -> None:
    """A click with the keys held, and the answer to it."""
    selection = hand.window.workspace.object_selection
    for act in (hand.qtbot.mousePress, hand.qtbot.mouseRelease):
        act(hand.canvas.viewport(), Qt.MouseButton.LeftButton, modifier, hand.at(row, col))
    hand.wait(lambda: selection.idle and bool(selection.proposals) == selection.selecting)
    hand.qtbot.wait(20)


def take(hand) -> None:
    """Take what is offered, and leave the name as it is."""
    hand.key(KEY.Key_Return)
    hand.key(KEY.Key_Return)


def offered(objects) -> np.ndarray:
    (proposal,) = objects.proposals
    return proposal.selection.mask


def test_the_pointer_shows_what_a_click_takes_and_the_click_takes_that(window, hand, objects, layer) -> None:
    hand.move(18, 18)
    hand.wait(lambda: window.session.scene.objects.preview is not None)
    preview = window.session.scene.objects.preview.mask
    assert overlap(preview, disk(*SMALL)) > 0.9
    assert layer.previewed
    click(hand, 18, 18)
    np.testing.assert_array_equal(offered(objects), preview)
    assert taken(window) == ()
    hand.canvas.leave()
    assert not layer.previewed


def test_enter_takes_the_object_asks_for_its_name_and_the_next_click_begins_the_next(window, hand, objects) -> None:
    click(hand, 18, 18)
    hand.key(KEY.Key_Return)
    for letter in (KEY.Key_N, KEY.Key_O):
        hand.key(letter)
    hand.key(KEY.Key_Return)
    (item,) = taken(window)
    assert item.name == "no"
    assert overlap(item.mask((64, 64)), disk(*SMALL)) > 0.9
    assert not objects.selecting
    click(hand, 43, 42)
    assert overlap(offered(objects), disk(*LARGE)) > 0.9
    hand.key(KEY.Key_Return)
    assert [item.number for item in taken(window)] == [1, 2]


def test_undo_takes_one_click_back_and_redo_repeats_it(window, hand, objects) -> None:
    click(hand, 18, 18)
    one = offered(objects)
    click(hand, 43, 42)
    both = offered(objects)
    assert both[43, 42]
    assert both[18, 18]
    hand.key(KEY.Key_Z, CONTROL)
    hand.wait(lambda: objects.idle and not offered(objects)[43, 42])
    np.testing.assert_array_equal(offered(objects), one)
    hand.key(KEY.Key_Z, CONTROL)
    hand.wait(lambda: not objects.proposals)
    assert not objects.selecting
    hand.key(KEY.Key_Y, CONTROL)
    hand.wait(lambda: bool(objects.proposals))
    np.testing.assert_array_equal(offered(objects), one)


@pytest.mark.parametrize("held", [SHIFT, ALT])
def test_a_click_with_shift_or_alt_removes_what_does_not_belong_to_the_object(window, hand, objects, held) -> None:
    click(hand, 18, 18)
    click(hand, 43, 42)
    assert "Shift-click to remove" in window.canvas_area.strip.hint.text()
    click(hand, 43, 40, held)
    assert [said.inside for said in window.session.document.objects.clicks] == [True, True, False]
    assert not offered(objects)[43, 40]
    assert offered(objects)[18, 18]


def test_a_stroke_says_the_same_of_all_that_it_crosses_and_is_one_step_of_undo(window, hand, objects) -> None:
    hand.drag((18, 18), (26, 26), (34, 33), (43, 42))
    hand.wait(lambda: bool(objects.proposals))
    (said,) = window.session.document.objects.clicks
    assert len(said.places) > 2
    assert offered(objects)[18, 18]
    assert offered(objects)[43, 42]
    hand.key(KEY.Key_Z, CONTROL)
    assert not objects.selecting


def test_what_the_pointer_showed_where_a_stroke_begins_does_not_count(window, hand, objects, monkeypatch) -> None:
    partition, begun_with = objects.partitions.partition, []
    select = type(partition).select

    def recording(self, inside, outside=(), *, previous=None):
        begun_with.append(previous)
        return select(self, inside, outside, previous=previous)

    monkeypatch.setattr(type(partition), "select", recording)
    hand.move(5, 50)  # a pointer that is there already does not move
    hand.move(18, 18)
    hand.wait(lambda: window.session.scene.objects.preview is not None)
    hand.drag((18, 18), (26, 26), (34, 33), (43, 42))
    hand.wait(lambda: bool(objects.proposals))
    stroke = objects.proposals[0].clicks
    assert len(stroke) == 1 and len(stroke[0].places) > 2
    assert len(begun_with) >= 2
    assert all(previous is not None and not previous.mask.any() for previous in begun_with[:2])


def test_escape_drops_the_proposal_and_backspace_takes_a_click_back(window, hand, objects, layer) -> None:
    click(hand, 18, 18)
    click(hand, 43, 42)
    hand.key(KEY.Key_Backspace)
    assert len(window.session.document.objects.clicks) == 1
    hand.key(KEY.Key_Escape)
    hand.wait(lambda: not objects.proposals)
    assert not objects.selecting
    assert layer.offered == 0


def test_digits_set_the_class_of_the_next_object_and_of_a_chosen_one(window, hand, objects) -> None:
    click(hand, 18, 18)
    hand.key(KEY.Key_3)
    take(hand)
    assert taken(window)[0].category == 3
    hand.canvas.setFocus()
    hand.key(KEY.Key_5)
    assert taken(window)[0].category == 5
    assert window.session.document.objects.category == 5


def test_delete_removes_the_chosen_object_and_undo_brings_it_back(window, hand, objects) -> None:
    click(hand, 18, 18)
    take(hand)
    before = taken(window)
    hand.key(KEY.Key_Delete)
    assert taken(window) == ()
    hand.key(KEY.Key_Z, CONTROL)
    assert taken(window) == before


def test_a_click_in_an_object_changes_it_and_keeps_its_number(window, hand, objects) -> None:
    click(hand, 18, 18)
    take(hand)
    click(hand, 20, 20)
    assert window.session.document.objects.edited == 1
    assert overlap(offered(objects), disk(*SMALL)) > 0.9
    click(hand, 43, 42)
    take(hand)
    (item,) = taken(window)
    assert item.number == 1
    assert item.encloses(np.array([[18.0, 18.0], [43.0, 42.0]])).all()


def test_escape_leaves_an_object_that_was_being_changed_as_it_was(window, hand, objects) -> None:
    click(hand, 18, 18)
    take(hand)
    before = taken(window)
    click(hand, 20, 20)
    click(hand, 43, 42)
    hand.key(KEY.Key_Escape)
    assert taken(window) == before
    assert window.session.document.objects.edited == 0


def test_objects_are_selected_by_keys_alone(window, hand, objects) -> None:
    hand.canvas.leave()
    crosshair = window.canvas_area.crosshair
    crosshair.show()
    crosshair.move(18.0 - crosshair.at[0], 18.0 - crosshair.at[1])
    hand.key(KEY.Key_Return)
    crosshair.move(43.0 - 18.0, 42.0 - 18.0)
    hand.key(KEY.Key_Return, SHIFT)
    hand.wait(lambda: objects.idle and bool(objects.proposals))
    clicks = window.session.document.objects.clicks
    assert clicks == (Click(((18.0, 18.0),)), Click(((43.0, 42.0),), inside=False))
    hand.key(KEY.Key_Return, CONTROL)
    assert len(taken(window)) == 1


def test_who_draws_a_circle_in_an_object_and_runs_gets_it_offered_and_enter_takes_it(window, hand) -> None:
    selection, session = window.workspace.object_selection, window.session
    hand.drag((18, 18), (18, 20), (18, 22))
    session.select(None)
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: bool(selection.proposals))
    assert overlap(offered(selection), disk(*SMALL)) > 0.9
    assert "Enter accepts what was found" in window.canvas_area.hint.text()
    hand.key(KEY.Key_Return)
    (item,) = taken(window)
    assert overlap(item.mask((64, 64)), disk(*SMALL)) > 0.9
    hand.wait(lambda: selection.idle and not selection.proposals)


def test_escape_drops_what_is_offered_around_a_start_until_a_run_ends_again(window, hand) -> None:
    selection, session = window.workspace.object_selection, window.session
    session.edit("draw", lambda d: replace(d, shapes=(Circle(SMALL[0], 4.0),)))
    session.run()
    hand.wait(lambda: bool(selection.proposals))
    hand.canvas.setFocus()
    hand.key(KEY.Key_Escape)
    hand.wait(lambda: not selection.proposals)
    session.reset()
    session.run()
    hand.wait(lambda: bool(selection.proposals))
    assert taken(window) == ()


def test_a_run_that_is_reset_or_looked_back_into_offers_nothing_and_its_end_offers_again(window, hand) -> None:
    selection, session = window.workspace.object_selection, window.session
    session.edit("draw", lambda d: replace(d, shapes=(Circle(SMALL[0], 4.0),)))
    session.run()
    hand.wait(lambda: bool(selection.proposals))
    hand.canvas.setFocus()
    hand.key(KEY.Key_Comma)
    hand.wait(lambda: session.idle and selection.idle and not selection.proposals)
    hand.key(KEY.Key_End, Qt.KeyboardModifier.ControlModifier)
    hand.wait(lambda: bool(selection.proposals))
    hand.key(KEY.Key_R)
    hand.wait(lambda: session.idle and selection.idle and not selection.proposals)


def test_on_a_large_image_objects_are_found_only_for_who_uses_the_tool(window, hand, monkeypatch) -> None:
    monkeypatch.setattr(object_selection, "MOST_OFFERED", 64 * 64 - 1)
    selection, session = window.workspace.object_selection, window.session
    session.edit("draw", lambda d: replace(d, shapes=(Circle(SMALL[0], 4.0),)))
    session.run()
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.idle and selection.idle and session.scene.contours.result is not None)
    assert not selection.ready and not selection.proposals
    hand.canvas.setFocus()
    hand.key(KEY.Key_W)
    hand.wait(lambda: bool(selection.proposals))


def test_each_start_offers_its_own_object_and_all_are_taken_in_one_step(window, hand) -> None:
    selection, session = window.workspace.object_selection, window.session
    for center, _ in (SMALL, LARGE):
        session.edit("draw", lambda d, at=center: d.__class__(d.image, (*d.shapes, Circle(at, 4.0)), d.parameters))
    session.run()
    hand.wait_for_phase("finished")
    hand.wait(lambda: len(selection.proposals) == 2)
    selection.take()
    assert len(taken(window)) == 2
    session.undo()
    assert taken(window) == ()


def test_a_start_around_which_no_object_is_found_offers_none() -> None:
    values = np.zeros((64, 64))
    values[:, 26:38] = 200.0
    selector = Selector(partition(values), (), 0)
    across, within = (circle(center=(32.0, 32.0), radius=radius) for radius in (14.0, 3.0))
    assert selector.proposals([across]) == ()
    assert len(selector.proposals([across, within])) == 1


def test_a_circle_around_an_object_offers_it_once() -> None:
    row, col = np.indices((80, 80))
    noise = np.random.default_rng(0).normal(0.0, 10.0, (80, 80))
    cut = partition(60.0 + 90.0 * (np.hypot(row - 40, col - 40) <= 16) + noise)
    around = circle(center=(40.0, 40.0), radius=21.0)
    (proposal,) = Selector(cut, (), 0).proposals([around])
    taken = made(proposal.selection, proposal.clicks, 1, 1)
    assert Selector(cut, (taken,), 0).proposals([around]) == ()


def test_what_is_frozen_is_not_offered_again_and_holds_particles_back(window, hand, objects) -> None:
    click(hand, 18, 18)
    take(hand)
    window.actions_by_name["freeze_object"].trigger()
    (item,) = taken(window)
    assert item.frozen
    assert window.session.document.regions.barriers == window.session.document.objects.barriers
    session, starts = window.session, tuple(Circle(center, 4.0) for center, _ in (SMALL, LARGE))
    session.edit("draw", lambda d: d.__class__(d.image, starts, d.parameters, objects=d.objects))
    session.run()
    hand.wait_for_phase("finished")
    hand.wait(lambda: bool(objects.proposals))
    assert overlap(offered(objects), disk(*LARGE)) > 0.9


@pytest.mark.parametrize(
    ("action", "kind"), [("object_start", Polygon), ("object_region", Region), ("object_barrier", Barrier)]
)
def test_an_object_becomes_a_start_a_region_or_a_barrier(window, hand, objects, action, kind) -> None:
    click(hand, 18, 18)
    take(hand)
    window.actions_by_name[action].trigger()
    (shape,) = window.session.document.shapes
    assert isinstance(shape, kind)
    away = np.hypot(*(np.array(shape.points) - SMALL[0]).T)
    assert np.abs(away - SMALL[1]).max() < 2.0


def test_a_session_file_keeps_objects_classes_and_the_selection_in_progress(window, hand, objects, tmp_path) -> None:
    click(hand, 18, 18)
    take(hand)
    window.workspace.object_list.name_class(1, "nucleus", "#112233")
    click(hand, 43, 42)
    before = window.session.document.objects
    kept = DocumentFile(window.session, dict)
    assert kept.save_at_once(tmp_path / "kept.cpm")
    hand.key(KEY.Key_Escape)
    window.workspace.object_list.choose((1,))
    window.workspace.object_list.delete()
    window.session.open(tmp_path / "kept.cpm")
    hand.wait(lambda: window.session.document.objects == before)
    hand.wait(lambda: bool(objects.proposals))
    assert overlap(offered(objects), disk(*LARGE)) > 0.9


def test_all_like_a_chosen_one_are_added_in_one_step_of_undo(window, hand, objects) -> None:
    values = np.full((64, 64), 20.0)
    for center in ((16.0, 16.0), (16.0, 46.0), (46.0, 18.0)):
        values[disk(center, 8.0)] = 200.0
    session = window.session
    path = Path(session.document.image.path).with_name("like.npy")
    np.save(path, values)
    session.open(path)
    hand.wait(lambda: session.document.image.name == "like.npy" and objects.ready)
    click(hand, 16, 16)
    take(hand)
    hand.key(KEY.Key_L, CONTROL)
    hand.wait(lambda: len(taken(window)) == 3)
    for item, center in zip(taken(window), ((16.0, 16.0), (16.0, 46.0), (46.0, 18.0)), strict=True):
        assert overlap(item.mask((64, 64)), disk(center, 8.0)) > 0.85
    session.undo()
    assert len(taken(window)) == 1


def test_an_object_is_fitted_to_the_contours_of_another_run_unless_it_is_frozen(window, hand, objects) -> None:
    click(hand, 18, 18)
    take(hand)
    click(hand, 43, 42)
    take(hand)
    window.workspace.object_list.toggle_frozen()
    before = taken(window)
    window.workspace.object_list.choose((1, 2))
    session = window.session
    grown = tuple(replace(item, boundary=item.boundary[:1] + item.boundary[:0], confidence=0.1) for item in before)
    session.edit("spoil", lambda d: replace(d, objects=replace(d.objects, items=grown)))
    window.actions_by_name["fit_objects"].trigger()
    hand.wait(lambda: taken(window)[0] == before[0])
    assert taken(window)[1] == grown[1]


def test_clicks_on_an_image_that_is_not_prepared_yet_are_answered_later(window, hand) -> None:
    selection = window.workspace.object_selection
    hand.canvas.setFocus()
    hand.key(KEY.Key_W)
    hand.click(18, 18)
    assert selection.selecting
    hand.wait(lambda: bool(selection.proposals))
    assert overlap(offered(selection), disk(*SMALL)) > 0.9


def test_the_proposal_follows_the_contours_of_a_run(window, hand, objects) -> None:
    click(hand, 18, 18)
    before = objects.proposals[0].selection
    session = window.session
    session.edit("draw", lambda d: replace(d, shapes=(Circle(LARGE[0], 4.0),)))
    session.run()
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.scene.contours.result is not None and session.scene.contours.result.stop_reason != "")
    hand.wait(lambda: objects.partitions.source is session.scene.contours.result)
    hand.wait(lambda: objects.proposals[0].selection is not before)
    assert overlap(offered(objects), disk(*SMALL)) > 0.85
    session.reset()
    hand.wait(lambda: np.array_equal(offered(objects), before.mask))


def test_the_proposal_stays_while_another_tool_is_used(window, hand, objects) -> None:
    click(hand, 18, 18)
    hand.key(KEY.Key_C)
    assert objects.selecting
    hand.key(KEY.Key_W)
    assert objects.selecting


def test_a_click_that_changes_nothing_says_so(window, hand, objects) -> None:
    said: list[str] = []
    window.session.said.connect(lambda sentence, trouble: said.append(sentence))
    click(hand, *LARGE[0])
    hand.wait(lambda: objects.idle and len(objects.proposals) == 1 and bool(objects.proposals[0].clicks))
    assert not any("changes nothing" in words for words in said)
    click(hand, LARGE[0][0] + 3.0, LARGE[0][1])
    hand.wait(lambda: any("belongs to the object already" in words for words in said))
    click(hand, 5.0, 58.0, SHIFT)
    hand.wait(lambda: any("does not belong to the object" in words for words in said))
