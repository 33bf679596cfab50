"""The tool for objects: what a click takes is shown before it, and clicks, strokes and keys do what they say."""

from __future__ import annotations

import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from cpm_app.model.document.objects import accept_objects, delete_objects
from cpm_app.model.text.assets import find_asset_folder
from cpm_app.session.features import object_measures, object_selection, selector
from cpm_app.session.features.object_selection import format_confidence
from cpm_app.session.features.selector import find_proposals
from cpm_app.session.scene import Proposal
from cpm_app.session.storage.session_file import DocumentFile
from cpm_app.views.features.objects import ObjectsFeature
from PySide6.QtCore import Qt

from cpm_core import Partition, partition
from cpm_core.image.region import Region
from cpm_core.objects.segmented import Click, SegmentedObject
from cpm_core.objects.selection import UNLIKELY_REMARK
from cpm_core.shapes import Barrier, Circle, Polygon, PolygonRegion
from tests.app.reading import accepted_items

pytestmark = pytest.mark.shared_window

KEY, NONE = Qt.Key, Qt.KeyboardModifier.NoModifier
CONTROL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
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
    hand.wait(lambda: selection.ready and selection.idle)
    return selection


@pytest.fixture
def layer(window):
    return window.canvas_area.canvas.layers["objects"]


def overlap(one: np.ndarray, other: np.ndarray) -> float:
    return (one & other).sum() / (one | other).sum()


def click(hand, row: float, col: float, modifier: Qt.KeyboardModifier = NONE) -> None:
    """A click with the keys held, and the answer to it."""
    selection = hand.window.workspace.object_selection
    for act in (hand.qtbot.mousePress, hand.qtbot.mouseRelease):
        act(hand.canvas.viewport(), Qt.MouseButton.LeftButton, modifier, hand.at(row, col))
    hand.wait(
        lambda: selection.idle and (not selection.selecting or [each.key for each in selection.proposals[:1]] == [0])
    )
    hand.qtbot.wait(20)


def take(hand) -> None:
    """Accept what is offered."""
    hand.key(KEY.Key_Return)


def offered(objects) -> np.ndarray:
    return objects.proposals[0].selection.mask


def run_everywhere(hand, count: int = 2) -> None:
    """Start on a grid over the whole image, and wait for what is found."""
    selection = hand.window.workspace.object_selection
    hand.window.actions_by_name["start_grid"].trigger()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: selection.idle and len(selection.proposals) == count)


def test_the_pointer_shows_what_a_click_takes_and_the_click_takes_that(window, hand, objects, layer) -> None:
    hand.move(18, 18)
    hand.wait(lambda: window.session.scene.objects.preview is not None)
    preview = window.session.scene.objects.preview.after.mask
    assert overlap(preview, disk(*SMALL)) > 0.9
    assert layer.added.count
    click(hand, 18, 18)
    np.testing.assert_array_equal(offered(objects), preview)
    assert accepted_items(window) == ()
    hand.canvas.remove_pointer()
    assert not layer.added.count


def test_no_click_is_previewed_while_a_run_goes_on(window, hand, objects) -> None:
    window.actions_by_name["start_grid"].trigger()
    hand.move(18, 18)
    hand.wait(lambda: window.session.scene.objects.preview is not None)
    window.session.set_pace(1.0)
    try:
        hand.key(KEY.Key_Space)
        hand.wait(lambda: window.session.scene.objects.preview is None)
        assert window.session.status.phase == "running"
        hand.move(19, 19)
        hand.qtbot.wait(50)
        assert window.session.scene.objects.preview is None
        hand.key(KEY.Key_Space)
        hand.wait(lambda: window.session.scene.objects.preview is not None)
    finally:
        window.session.set_pace(None)


def test_what_a_click_with_shift_would_remove_is_hatched_before_it(window, hand, objects, layer) -> None:
    click(hand, 18, 18)
    click(hand, 43, 42)
    before = offered(objects)
    hand.canvas.dispatcher.set_modifiers(SHIFT)
    hand.canvas.move_pointer_to((43.0, 40.0))
    hand.wait(lambda: layer.removed.count == 1)
    preview = window.session.scene.objects.preview
    np.testing.assert_array_equal(preview.before.mask, before)
    assert not layer.added.count
    click(hand, 43, 40, SHIFT)
    np.testing.assert_array_equal(offered(objects), preview.after.mask)


def test_enter_accepts_the_object_without_a_word_and_the_next_click_begins_the_next(window, hand, objects) -> None:
    hand.move(18, 18)
    click(hand, 18, 18)
    hand.key(KEY.Key_Return)
    assert hand.canvas.hasFocus()  # no field takes Space or another Enter
    hand.wait(lambda: objects.idle)
    hand.qtbot.wait(20)
    assert window.session.scene.objects.preview is None
    (item,) = accepted_items(window)
    assert overlap(item.region.paste((64, 64)), disk(*SMALL)) > 0.9
    assert not objects.selecting
    click(hand, 43, 42)
    assert overlap(offered(objects), disk(*LARGE)) > 0.9
    hand.key(KEY.Key_Return)
    assert [item.number for item in accepted_items(window)] == [1, 2]


def test_enter_right_after_a_click_accepts_what_it_means(window, hand, objects) -> None:
    hand.click(18, 18)
    hand.key(KEY.Key_Return)
    hand.wait(lambda: bool(accepted_items(window)))
    assert overlap(accepted_items(window)[0].region.paste((64, 64)), disk(*SMALL)) > 0.9
    assert not objects.selecting


@pytest.mark.parametrize("corrects", [False, True])
def test_delete_drops_the_object_in_progress_and_leaves_an_accepted_one(window, hand, objects, corrects) -> None:
    click(hand, 43, 42)
    take(hand)
    hand.wait(lambda: objects.idle)
    before = accepted_items(window)
    click(hand, *((43, 42) if corrects else (18, 18)))
    assert objects.selecting
    hand.key(KEY.Key_Delete)
    hand.wait(lambda: objects.idle)
    assert not objects.selecting and not objects.proposals
    assert accepted_items(window) == before


def test_enter_accepts_what_is_seen_although_another_object_changes_before(window, hand, objects, monkeypatch) -> None:
    click(hand, 43, 42)
    hand.key(KEY.Key_Return)
    click(hand, 18, 18)
    seen, select = offered(objects), Partition.select

    def select_elsewhere(there, *_, **more):
        """What is answered anew may be another object that is less likely."""
        return replace(select(there, [(58.0, 6.0)]), confidence=0.0)

    monkeypatch.setattr(Partition, "select", select_elsewhere)
    window.session.edit("delete", lambda document: delete_objects(document, frozenset({1})))
    hand.wait(lambda: objects.answered and objects.idle)
    hand.key(KEY.Key_Return)
    (item,) = accepted_items(window)
    np.testing.assert_array_equal(item.region.paste((64, 64)), seen)


Act = tuple[float, float] | tuple[float, float, Qt.KeyboardModifier] | KEY
"""A click, perhaps with keys held, or a key."""

HAND: list[Act] = [
    (366, 190), KEY.Key_Return, (362, 212), KEY.Key_Return, (360, 170), (352, 180, SHIFT), KEY.Key_Return,
    (180, 188), KEY.Key_BracketLeft, KEY.Key_BracketLeft, KEY.Key_Return, (366, 190), KEY.Key_2, (54, 183), KEY.Key_X,
    (75, 120), KEY.Key_Return, (130, 41), KEY.Key_Escape, (120, 313), (112, 316), KEY.Key_Return, (75, 250), "undo",
    "undo", KEY.Key_Return, (195, 231), KEY.Key_BracketLeft, KEY.Key_BracketRight, KEY.Key_Backspace, (75, 250),
    KEY.Key_3,
]  # fmt: skip
NUCLEI: list[Act] = [
    (35, 65), KEY.Key_Return, (70, 222), KEY.Key_Return, (76, 280), KEY.Key_X, (96, 107), KEY.Key_Return,
    (70, 222), KEY.Key_4, (225, 217), (228, 217), KEY.Key_Return, "undo", KEY.Key_Return, (165, 173), "undo",
    (242, 105), KEY.Key_Return, (35, 65, CONTROL), KEY.Key_BracketRight, KEY.Key_Return,
    (225, 217), KEY.Key_Escape, (225, 217), (228, 217, SHIFT), KEY.Key_BracketLeft, KEY.Key_Backspace,
]  # fmt: skip


@pytest.mark.parametrize(
    ("sample", "acts"),
    [
        ("nuclei.png", NUCLEI[:15]),
        pytest.param("nuclei.png", NUCLEI, marks=pytest.mark.long),
        pytest.param("hand.png", HAND, marks=pytest.mark.long),
    ],
)
def test_quick_clicks_and_keys_give_the_objects_that_slow_ones_give(
    window, hand, objects, monkeypatch, sample, acts
) -> None:
    monkeypatch.setattr(selector, "MAX_OFFERED_PIXELS", 0)  # without a run, whose end would change the answers
    window.session.open_file(find_asset_folder("samples") / sample)
    hand.wait(lambda: window.session.document.image.name == sample and window.session.idle)
    hand.key(KEY.Key_W)
    hand.wait(lambda: objects.ready and objects.idle)
    begin, select = window.session.document, Partition.select

    def select_slowly(*given, **more):
        time.sleep(0.05)
        return select(*given, **more)

    monkeypatch.setattr(Partition, "select", select_slowly)
    found = []
    for quick in (False, True):
        window.session.edit("begin", lambda document: replace(document, objects=begin.objects))
        hand.wait(lambda: objects.idle and not objects.selecting)
        waited = 0
        for act in acts:
            if act == "undo":
                hand.key(KEY.Key_Z, CONTROL)
            elif isinstance(act, KEY):
                hand.key(act)
            else:
                row, col, *keys = act
                for event in (hand.qtbot.mousePress, hand.qtbot.mouseRelease):
                    event(hand.canvas.viewport(), Qt.MouseButton.LeftButton, *(keys or [NONE]), hand.at(row, col))
            waited += not objects.idle
            hand.qtbot.wait(5)
            if not quick:
                hand.wait(lambda: objects.idle and objects.answered)
        hand.wait(lambda: objects.idle and objects.answered)
        assert waited > len(acts) / 2 or not quick
        found.append(window.session.document.objects)
    slow, quick = found
    assert len(slow.items) > 3
    assert quick == slow


def test_a_click_is_marked_as_being_worked_on_at_once_and_until_its_answer_is_shown(
    window, hand, objects, layer, monkeypatch
) -> None:
    answer, select = threading.Event(), Partition.select
    monkeypatch.setattr(Partition, "select", lambda *given, **more: (answer.wait(60), select(*given, **more))[1])
    hand.click(18, 18)
    assert layer.awaited.isVisible(), "when the click has been handled, without another turn"
    assert np.transpose(layer.awaited.getData()) == pytest.approx(np.array([[18.0, 18.0]]), abs=0.5)
    hand.key(KEY.Key_Return)
    hand.click(43, 42)
    places = [each.places[0] for each in window.session.scene.objects.awaited]
    assert np.array(places) == pytest.approx(np.array([(18.0, 18.0), (43.0, 42.0)]), abs=0.5)
    answer.set()
    hand.wait(lambda: objects.idle and objects.answered)
    assert window.session.scene.objects.awaited == ()
    assert not layer.awaited.isVisible()
    assert len(accepted_items(window)) == 1
    assert objects.selecting


@pytest.mark.parametrize("awaited", ["click", "run", "alike"])
def test_a_key_that_waits_for_an_answer_is_said_to_wait_until_it_acts(
    window, hand, objects, monkeypatch, awaited
) -> None:
    may_answer, select, hint = threading.Event(), Partition.select, window.canvas_area.hint

    def wait_for(function):
        return lambda *given, **more: (may_answer.wait(60), function(*given, **more))[1]

    if awaited == "run":
        monkeypatch.setattr(object_selection, "find_proposals", wait_for(find_proposals))
        window.actions_by_name["start_grid"].trigger()
        hand.key(KEY.Key_Space)
        hand.wait(lambda: objects.awaits_offer and not objects.idle)
    else:
        click(hand, 18, 18)
        click(hand, 20, 20)  # of which it is said, for as long as nothing else is done, that it changes nothing
        if awaited == "alike":
            take(hand)
            hand.wait(lambda: objects.idle)
            monkeypatch.setattr(
                object_selection, "find_similar_objects", wait_for(lambda cut, *_: (cut.select([LARGE[0]]),))
            )
            hand.key(KEY.Key_L, CONTROL)
        else:
            monkeypatch.setattr(Partition, "select", wait_for(select))
            hand.click(16, 18)
    assert "waits" not in hint.text()
    hand.key(KEY.Key_Return)
    assert hint.text().startswith("What you pressed waits for the answer.")
    assert hint.isVisible()
    may_answer.set()
    hand.wait(lambda: objects.idle and objects.answered and window.session.idle)
    assert len(accepted_items(window)) == (1 if awaited == "click" else 2)
    assert "waits" not in hint.text()


@pytest.mark.parametrize("accepted", [False, True])
def test_the_place_of_an_object_is_marked_while_its_next_candidate_is_sought(
    window, hand, objects, layer, monkeypatch, accepted
) -> None:
    click(hand, 18, 18)
    if accepted:
        take(hand)
        hand.wait(lambda: objects.idle)
    answer, find = threading.Event(), Partition.find_candidates
    monkeypatch.setattr(Partition, "find_candidates", lambda *given, **more: (answer.wait(60), find(*given, **more))[1])
    hand.key(KEY.Key_BracketRight)
    assert layer.awaited.isVisible(), "when the key has been handled, without another turn"
    assert np.transpose(layer.awaited.getData()) == pytest.approx(np.array([[18.0, 18.0]]), abs=0.5)
    answer.set()
    hand.wait(lambda: objects.idle and objects.answered and not layer.awaited.isVisible())


def test_what_waits_for_an_answer_that_does_not_come_is_given_up(window, hand, objects, monkeypatch) -> None:
    def fail(*given, **more):
        raise ValueError("no answer")

    with monkeypatch.context() as changed:
        changed.setattr(Partition, "select", fail)
        hand.click(18, 18)
        hand.key(KEY.Key_Return)
        hand.wait(lambda: objects.idle)
        assert "No answer" in window.canvas_area.messages.text
        assert accepted_items(window) == window.session.scene.objects.awaited == ()
        hand.key(KEY.Key_Z, CONTROL)
        assert not objects.selecting
    click(hand, 18, 18)
    take(hand)
    assert len(accepted_items(window)) == 1


def test_an_older_answer_that_does_not_come_leaves_what_waits_for_a_newer_one(
    window, hand, objects, monkeypatch
) -> None:
    started, fails, select, calls = threading.Event(), threading.Event(), Partition.select, []

    def fail_first(*given, **more):
        calls.append(given)
        if len(calls) > 1:
            return select(*given, **more)
        started.set()
        fails.wait(60)
        raise ValueError("no answer")

    monkeypatch.setattr(Partition, "select", fail_first)
    objects.preview_click((43.0, 42.0))
    hand.wait(started.is_set)
    hand.click(18, 18)
    hand.key(KEY.Key_Return)
    fails.set()
    hand.wait(lambda: objects.idle and objects.answered)
    assert len(accepted_items(window)) == 1


def test_a_stroke_or_a_start_that_reaches_into_an_accepted_object_stays_out_of_it(window, hand, objects, part) -> None:
    hand.drag((43, 50), (43, 44), (43, 38), (43, 34))
    hand.wait(lambda: objects.idle and bool(objects.proposals))
    assert offered(objects)[43, 48]
    assert not (offered(objects) & part).any()


def test_what_waits_is_dropped_with_the_image(window, hand, objects, monkeypatch, image_file) -> None:
    answer, select = threading.Event(), Partition.select
    monkeypatch.setattr(Partition, "select", lambda *given, **more: (answer.wait(60), select(*given, **more))[1])
    hand.click(18, 18)
    hand.key(KEY.Key_Return)
    opened = window.session.image
    window.session.open_file(image_file)
    hand.wait(lambda: window.session.image is not opened)
    answer.set()
    hand.wait(lambda: objects.idle and window.session.idle)
    assert accepted_items(window) == ()
    assert not objects.selecting


def test_the_first_use_of_a_class_leaves_the_keyboard_with_the_canvas(window, hand, objects) -> None:
    for center in (SMALL[0], LARGE[0]):
        click(hand, *center)
        take(hand)
    hand.key(KEY.Key_2)
    hand.key(KEY.Key_J)
    assert [item.category for item in accepted_items(window)] == [1, 2]
    assert window.session.document.objects.classes[1].name == ""
    assert hand.canvas.dispatcher.tool.name == "mend"


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


def test_a_click_with_shift_removes_what_does_not_belong_to_the_object(window, hand, objects) -> None:
    click(hand, 18, 18)
    click(hand, 43, 42)
    assert "Shift-click to remove" in window.canvas_area.strip.hint.text()
    click(hand, 43, 40, SHIFT)
    assert [said.inside for said in window.session.document.objects.clicks] == [True, True, False]
    assert overlap(offered(objects), disk(*SMALL)) > 0.9  # not a part of the other disk alone


def test_a_stroke_says_the_same_of_all_that_it_crosses_and_is_one_step_of_undo(window, hand, objects) -> None:
    hand.drag((18, 18), (26, 26), (34, 33), (43, 42))
    hand.wait(lambda: bool(objects.proposals))
    (said,) = window.session.document.objects.clicks
    assert len(said.places) > 2
    assert offered(objects)[18, 18]
    assert offered(objects)[43, 42]
    hand.key(KEY.Key_Z, CONTROL)
    assert not objects.selecting


def test_each_click_has_one_mark_a_stroke_its_line(window, hand, objects, layer) -> None:
    turns = np.linspace(0.4, 2.0 * np.pi, 30)
    hand.drag(*((18.0 + 13.0 * np.sin(turn), 18.0 + 13.0 * np.cos(turn)) for turn in turns))
    hand.wait(lambda: bool(objects.proposals))
    assert (layer.strokes.count, len(layer.points.data)) == (1, 0)
    click(hand, 43, 42)
    click(hand, 43, 42, SHIFT)
    assert (layer.strokes.count, len(layer.points.data)) == (1, 2)


def test_undo_of_enter_brings_back_the_outline_that_was_seen_whatever_would_be_found_now(
    window, hand, objects, monkeypatch
) -> None:
    click(hand, 18, 18)
    click(hand, 43, 42)
    seen = offered(objects)
    take(hand)
    (item,) = accepted_items(window)
    select = Partition.select
    monkeypatch.setattr(Partition, "select", lambda self, *given, **more: select(self, [(60.0, 5.0)]))
    hand.key(KEY.Key_Z, CONTROL)
    hand.wait(lambda: objects.idle and bool(objects.proposals))
    assert not accepted_items(window) and len(window.session.document.objects.clicks) == 2
    np.testing.assert_array_equal(offered(objects), seen)
    take(hand)
    assert accepted_items(window)[0].region == item.region


@pytest.mark.parametrize("corners", [6, 30])
def test_a_stroke_around_an_object_whose_ends_nearly_meet_selects_it(window, hand, objects, corners) -> None:
    turns = np.linspace(0.4, 2.0 * np.pi, corners)
    hand.drag(*((18.0 + 13.0 * np.sin(turn), 18.0 + 13.0 * np.cos(turn)) for turn in turns))
    hand.wait(lambda: bool(objects.proposals))
    assert overlap(offered(objects), disk(*SMALL)) > 0.9
    click(hand, 43, 42)  # the next click adds to it
    assert offered(objects)[18, 18]
    assert offered(objects)[43, 42]


def test_escape_drops_the_proposal_and_backspace_takes_a_click_back(window, hand, objects, layer) -> None:
    click(hand, 18, 18)
    click(hand, 43, 42)
    hand.key(KEY.Key_Backspace)
    assert len(window.session.document.objects.clicks) == 1
    hand.key(KEY.Key_Escape)
    hand.wait(lambda: not objects.proposals)
    assert not objects.selecting
    assert layer.proposal_fill.count == 0


def test_a_click_in_an_object_chooses_it_and_a_click_in_a_chosen_one_corrects_it(window, hand, objects) -> None:
    click(hand, 18, 18)
    take(hand)
    window.workspace.object_list.select_objects(())
    click(hand, 20, 20)
    assert window.workspace.object_list.selected_numbers == {1}
    assert not objects.selecting
    assert "Click in it: correct" in window.canvas_area.hint.text()
    click(hand, 20, 20)
    assert window.session.document.objects.edited == 1
    assert overlap(offered(objects), disk(*SMALL)) > 0.9
    click(hand, 43, 42)
    take(hand)
    (item,) = accepted_items(window)
    assert item.number == 1
    assert item.region.encloses(np.array([[18.0, 18.0], [43.0, 42.0]])).all()


def test_a_click_in_one_of_several_chosen_objects_chooses_it_alone(window, hand, objects) -> None:
    run_everywhere(hand)
    take(hand)
    assert window.workspace.object_list.selected_numbers == {1, 2}
    click(hand, *SMALL[0])
    assert not objects.selecting
    assert len(window.workspace.object_list.selected_numbers) == 1
    hand.key(KEY.Key_Delete)
    (left,) = accepted_items(window)
    assert left.region.encloses(np.array([LARGE[0]])).all()


def test_a_click_in_the_margin_is_no_point_and_deselects_as_beside_objects(window, hand, objects, layer) -> None:
    for modifier in (NONE, SHIFT):
        click(hand, 20.0, -3.0, modifier)
        assert not window.session.document.objects.clicks
    hand.move(30.0, -3.0)
    hand.qtbot.wait(20)
    assert window.session.scene.objects.preview is None
    click(hand, *SMALL[0])
    before = window.session.document.objects.clicks
    click(hand, 20.0, 67.0)
    hand.drag((10.0, -3.0), (20.0, -4.0), (30.0, -3.0))
    assert window.session.document.objects.clicks == before
    hand.key(KEY.Key_Return)
    hand.wait(lambda: bool(window.workspace.object_list.selected_numbers))
    click(hand, 20.0, -3.0)
    hand.wait(lambda: not window.workspace.object_list.selected_numbers)
    hand.drag((43.0, -3.0), (43.0, 20.0), (43.0, 42.0))  # a stroke that begins there and reaches an object counts
    (stroke,) = window.session.document.objects.clicks
    assert all(-0.5 <= at <= 63.5 for place in stroke.places for at in place)
    assert stroke.places[-1] == pytest.approx((43.0, 42.0), abs=0.5)


def test_a_lasso_keeps_its_places_in_the_margin_and_another_stroke_selects_nothing_beside_them(
    window, hand, objects
) -> None:
    hand.drag((43.0, 42.0), (43.0, 30.0), (30.0, -3.0), (20.0, -3.0), (25.0, 30.0), (41.0, 44.0))
    (lasso,) = window.session.document.objects.clicks
    assert any(place[1] < -0.5 for place in lasso.places)
    hand.key(KEY.Key_Escape)
    hand.wait(lambda: objects.idle and not objects.selecting)
    at_border = SegmentedObject(1, (), Region((((-0.5, 26.0), (-0.5, 34.0), (1.0, 34.0), (1.0, 26.0)),)))
    window.session.edit("add", lambda document: accept_objects(document, (at_border,)))
    hand.drag((-3.0, 30.0), (-3.0, 38.0), (10.0, 38.0))  # beside that object, but not into it
    assert len(window.session.document.objects.clicks) == 1


def test_a_click_with_shift_in_an_object_begins_to_correct_it_at_once(window, hand, objects) -> None:
    click(hand, 18, 18)
    click(hand, 43, 42)
    take(hand)
    window.workspace.object_list.select_objects(())
    click(hand, 43, 40, SHIFT)
    assert window.session.document.objects.edited == 1
    assert not offered(objects)[43, 40]
    assert offered(objects)[18, 18]


def test_a_click_with_control_in_an_object_selects_another_one_there(window, hand, objects) -> None:
    click(hand, 18, 18)
    take(hand)
    click(hand, 19, 19, CONTROL)
    assert window.session.document.objects.edited == 0
    assert objects.selecting
    take(hand)
    assert [item.number for item in accepted_items(window)] == [1, 2]


def test_a_click_with_control_in_the_only_proposal_does_not_correct_it(window, hand, objects) -> None:
    click(hand, *LARGE[0])
    take(hand)
    run_everywhere(hand, count=1)
    click(hand, 19, 19, CONTROL)
    (only,) = window.session.document.objects.clicks
    assert only.places[0] == pytest.approx((19.0, 19.0), abs=1.0)


@pytest.fixture
def part(window):
    """An accepted object over a part of the large disk."""
    corners = ((28.0, 25.0), (28.0, 36.5), (58.0, 36.5), (58.0, 25.0))
    item = SegmentedObject(1, (), Region((corners,)))
    window.session.edit("part", lambda document: accept_objects(document, (item,)))
    return item.region.paste((64, 64))


def test_a_click_that_waits_is_marked_at_its_place_alone_and_not_by_what_another_place_would_change(
    window, hand, objects, layer, monkeypatch
) -> None:
    click(hand, 43, 42)
    hand.canvas.dispatcher.set_modifiers(SHIFT)
    hand.canvas.move_pointer_to((43.0, 42.0))  # where all of the object would go
    hand.wait(lambda: layer.removed.count == 1)
    answer, select = threading.Event(), Partition.select
    monkeypatch.setattr(Partition, "select", lambda *given, **more: (answer.wait(60), select(*given, **more))[1])
    for act in (hand.qtbot.mousePress, hand.qtbot.mouseRelease):
        act(hand.canvas.viewport(), Qt.MouseButton.LeftButton, SHIFT, hand.at(36.0, 36.0))
    assert layer.awaited.isVisible()
    assert not layer.removed.count
    answer.set()
    hand.wait(lambda: objects.idle and not layer.awaited.isVisible())


def test_answers_stay_out_of_accepted_objects_unless_objects_may_overlap(window, hand, objects, part) -> None:
    click(hand, 43, 48)
    assert not (offered(objects) & part).any()
    assert overlap(offered(objects), disk(*LARGE) & ~part) > 0.9
    take(hand)
    assert not (accepted_items(window)[1].region.paste((64, 64)) & part).any()
    hand.key(KEY.Key_Z, CONTROL)
    hand.key(KEY.Key_Escape)
    window.actions_by_name["objects_overlap"].trigger()
    click(hand, 43, 48)
    assert overlap(offered(objects), disk(*LARGE)) > 0.9
    hand.key(KEY.Key_Escape)
    window.workspace.object_list.select_objects((1,))
    window.workspace.object_commands.toggle_state("frozen")
    window.workspace.object_list.select_objects(())
    click(hand, 43, 48)
    assert not (offered(objects) & part).any(), "a frozen object is never run over"


@pytest.mark.parametrize(("overlaps", "frozen"), [(False, False), (True, False), (True, True)])
def test_objects_like_one_stay_out_of_accepted_objects_unless_objects_may_overlap(
    window, hand, objects, part, overlaps, frozen
) -> None:
    listed = window.workspace.object_list
    click(hand, 18, 18)
    take(hand)
    hand.wait(lambda: objects.idle)
    if overlaps:
        window.actions_by_name["objects_overlap"].trigger()
    if frozen:
        listed.select_objects((1,))
        window.workspace.object_commands.toggle_state("frozen")
    listed.select_objects((2,))
    hand.key(KEY.Key_L, CONTROL)
    hand.wait(lambda: objects.idle and window.session.idle and len(objects.proposals) == 1)
    assert overlap(offered(objects), disk(*LARGE) & ~part if frozen or not overlaps else disk(*LARGE)) > 0.9


def test_proposals_of_a_run_stay_out_of_accepted_objects(window, hand, objects, part) -> None:
    run_everywhere(hand)
    masks = [each.selection.mask for each in objects.proposals]
    assert not any((mask & part).any() for mask in masks)
    assert max(overlap(mask, disk(*LARGE) & ~part) for mask in masks) > 0.9


def test_an_answer_does_not_depend_on_objects_accepted_elsewhere(window, hand, objects) -> None:
    click(hand, 43, 42)
    alone = objects.proposals[0].selection
    hand.key(KEY.Key_Escape)
    click(hand, 18, 18)
    take(hand)
    click(hand, 43, 42)
    np.testing.assert_array_equal(offered(objects), alone.mask)
    assert objects.proposals[0].selection.confidence == alone.confidence


def test_a_click_that_changes_nothing_leaves_the_confidence_and_says_so(window, hand, objects) -> None:
    click(hand, 18, 18)
    before = objects.proposals[0].selection
    click(hand, 20, 20)
    after = objects.proposals[0].selection
    assert after.has_same_region(before)
    assert after.confidence == before.confidence
    assert "changes nothing" in window.canvas_area.messages.text


@pytest.mark.parametrize("key", [KEY.Key_Return, KEY.Key_Escape, KEY.Key_Backspace])
def test_what_is_said_about_a_click_goes_with_the_next_edit(window, hand, objects, key) -> None:
    click(hand, 18, 18)
    click(hand, 20, 20)
    assert "changes nothing" in window.canvas_area.messages.text
    hand.key(key)
    assert window.canvas_area.messages.text == ""


def test_a_run_from_everywhere_ends_at_counted_objects_that_enter_accepts(window, hand, layer) -> None:
    run_everywhere(hand)
    assert "2 proposals. Enter accepts all" in window.canvas_area.hint.text()
    assert layer.proposal_fill.count == 2
    hand.key(KEY.Key_Return)
    masks = [item.region.paste((64, 64)) for item in accepted_items(window)]
    assert [max(overlap(mask, disk(*where)) for mask in masks) > 0.9 for where in (SMALL, LARGE)] == [True, True]
    selection = window.workspace.object_selection
    hand.wait(lambda: selection.idle and not selection.proposals)
    hand.key(KEY.Key_Z, CONTROL)
    hand.wait(lambda: len(selection.proposals) == 2)
    assert not accepted_items(window)


@pytest.fixture
def doubtful(window, monkeypatch):
    """What a run from everywhere finds is doubtful but for one object, at this place."""

    def chosen(sure: tuple[float, float]):
        def found(*arguments):
            return tuple(
                replace(each, selection=replace(each.selection, confidence=0.9 if holds else 0.4))
                for each in find_proposals(*arguments)
                for holds in each.selection.contains(np.array([sure]))
            )

        monkeypatch.setattr(object_selection, "find_proposals", found)

    return chosen


def test_enter_draws_the_canvas_once(window, hand, objects, monkeypatch) -> None:
    click(hand, *SMALL[0])
    drawn = []
    draw = window.canvas_area.canvas.draw_scene
    monkeypatch.setattr(window.canvas_area.canvas, "draw_scene", lambda scene: (drawn.append(scene), draw(scene)))
    accepted = window.workspace.object_list.selected_numbers
    window.workspace.object_commands.accept_pending()
    assert len(drawn) == 1
    assert drawn[0] is window.session.scene
    assert window.workspace.object_list.selected_numbers != accepted


def test_enter_accepts_what_a_run_found_although_an_object_accepted_before_was_selected(
    window, hand, objects, doubtful
) -> None:
    doubtful(LARGE[0])
    click(hand, 18, 18)
    hand.key(KEY.Key_Return)
    first = accepted_items(window)
    assert [item.number for item in window.workspace.object_list.selected_objects] == [first[0].number]
    run_everywhere(hand, 1)
    assert "1 proposal" in window.canvas_area.hint.text()
    hand.key(KEY.Key_Return)
    assert len(accepted_items(window)) == 2


@pytest.mark.parametrize("sure", [SMALL[0], LARGE[0]])
def test_what_enter_leaves_keeps_its_name_and_figures_and_the_hint_names_no_key_that_does_nothing(
    window, hand, objects, doubtful, monkeypatch, sure
) -> None:
    doubtful(sure)
    run_everywhere(hand)
    found = window.workspace.object_list
    hand.wait(lambda: all(row.figures for row in found.rows if row.kind == "proposal"))
    left = next(row for row in found.rows if row.kind == "proposal" and row.item.confidence < 0.5)
    measured = []
    monkeypatch.setattr(object_measures, "_measure_object", lambda item, image: measured.append(item))
    take(hand)
    assert len(accepted_items(window)) == 1
    hand.wait(lambda: objects.idle and len(objects.proposals) == 1)
    (row,) = [row for row in found.rows if row.kind == "proposal"]
    assert (row.title, row.key) == (left.title, left.key)
    assert row.figures is left.figures
    hand.key(KEY.Key_S)
    assert "Enter: accept" not in window.canvas_area.hint.text()
    take(hand)
    assert len(accepted_items(window)) == 1
    found.select_objects((row.key[1],))
    take(hand)
    assert len(accepted_items(window)) == 2
    hand.qtbot.wait(50)
    assert not measured


def test_the_hint_counts_what_enter_accepts_of_all_that_is_listed(window, hand, objects, monkeypatch) -> None:
    corner = (60.0, 4.0)

    def found(result, *rest):
        likely = [
            replace(each, selection=replace(each.selection, confidence=0.9)) for each in find_proposals(result, *rest)
        ]
        doubtful = replace(partition(result).select(np.array([corner])), confidence=0.4)
        return (*likely, Proposal(doubtful, (Click((corner,)),)))

    monkeypatch.setattr(object_selection, "find_proposals", found)
    hint, listed = window.canvas_area.hint, window.workspace.object_list
    run_everywhere(hand, count=3)
    assert hint.text().startswith("3 proposals, 1 doubtful. Enter accepts 2 ")
    listed.select_objects(
        row.key[1]
        for row in listed.rows
        if row.kind == "proposal" and row.item.region.encloses(np.array([SMALL[0], corner])).any()
    )
    assert hint.text().startswith("2 of 3 proposals are selected. Enter accepts them")
    take(hand)
    assert len(accepted_items(window)) == 2
    assert any(item.region.encloses(np.array([corner]))[0] for item in accepted_items(window))


@pytest.mark.parametrize("where", [SMALL, LARGE])
def test_a_proposal_that_is_clicked_again_is_accepted_by_enter(window, hand, objects, where) -> None:
    run_everywhere(hand)
    for _ in range(2):
        click(hand, *where[0])
        hand.qtbot.wait(20)
    assert objects.selecting
    take(hand)
    (item,) = accepted_items(window)
    assert overlap(item.region.paste((64, 64)), disk(*where)) > 0.9


def test_a_click_chooses_one_of_several_which_is_accepted_or_rejected_alone(window, hand, objects) -> None:
    run_everywhere(hand)
    click(hand, 18, 18)
    assert "1 of 2 proposals" in window.canvas_area.hint.text()
    take(hand)
    (item,) = accepted_items(window)
    assert overlap(item.region.paste((64, 64)), disk(*SMALL)) > 0.9
    (rest,) = objects.proposals
    hand.wait(lambda: objects.idle)
    assert rest.selection.contains(np.array([LARGE[0]])).all()
    window.workspace.object_list.select_objects((rest.key,))
    hand.key(KEY.Key_X)
    hand.wait(lambda: objects.idle and not objects.proposals)
    assert len(accepted_items(window)) == 1
    hand.key(KEY.Key_Z, CONTROL)
    hand.wait(lambda: objects.idle and len(objects.proposals) == 1)


def test_a_deleted_object_of_the_shown_run_is_not_proposed_again_until_undone_or_run_anew(
    window, hand, objects
) -> None:
    run_everywhere(hand)
    take(hand)
    hand.wait(lambda: objects.idle and not objects.proposals)
    hand.key(KEY.Key_A, CONTROL)
    hand.key(KEY.Key_Delete)
    assert accepted_items(window) == ()
    hand.wait(lambda: objects.idle)
    assert objects.proposals == ()
    hand.key(KEY.Key_Z, CONTROL)
    assert len(accepted_items(window)) == 2
    hand.key(KEY.Key_Z, CONTROL)
    hand.wait(lambda: objects.idle and len(objects.proposals) == 2)
    for _ in range(2):
        hand.key(KEY.Key_Z, CONTROL | SHIFT)
    hand.wait(lambda: objects.idle and not objects.proposals)
    assert accepted_items(window) == ()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: objects.idle and len(objects.proposals) == 2)


def test_an_object_that_was_deleted_before_the_shown_run_too_is_not_proposed_again_by_it(
    window, hand, objects, monkeypatch
) -> None:
    click(hand, *LARGE[0])
    take(hand)
    hand.key(KEY.Key_Delete)
    run_everywhere(hand)
    for _ in range(2):  # the start, and the deletion
        hand.key(KEY.Key_Z, CONTROL)
    assert len(accepted_items(window)) == 1
    window.workspace.object_list.select_objects((1,))
    hand.key(KEY.Key_Delete)
    hand.qtbot.wait(20)
    hand.wait(lambda: objects.idle and not accepted_items(window))
    objects.search_again()
    hand.wait(lambda: objects.idle and objects.offer_is_known)
    assert [each.selection.contains(np.array([SMALL[0]])).all() for each in objects.proposals] == [True]
    assert [each.key for each in objects.proposals] == [-1], "what is seen is numbered from 1"
    monkeypatch.setattr(object_selection, "find_similar_objects", lambda cut, *_: (cut.select([LARGE[0]]),))
    take(hand)
    hand.key(KEY.Key_L, CONTROL)
    hand.wait(lambda: objects.idle and window.session.idle)
    assert window.canvas_area.messages.text == "No other object like this one was found."


@pytest.mark.parametrize("repeated", [False, True], ids=["once", "repeated after another run"])
def test_a_deleted_object_is_not_proposed_again_after_reopening(window, hand, objects, tmp_path, repeated) -> None:
    run_everywhere(hand)
    take(hand)
    hand.wait(lambda: objects.idle and len(accepted_items(window)) == 2)
    window.workspace.object_list.select_objects((1,))
    hand.canvas.setFocus()
    hand.key(KEY.Key_Delete)
    hand.wait(lambda: objects.idle and len(accepted_items(window)) == 1)
    if repeated:
        hand.key(KEY.Key_Z, CONTROL)
        hand.wait(lambda: objects.idle and len(accepted_items(window)) == 2)
        hand.key(KEY.Key_Space)
        hand.wait_for_phase("finished")
        hand.key(KEY.Key_Z, CONTROL | SHIFT)
        hand.wait(lambda: window.session.idle and objects.offer_is_known and objects.idle)
        assert (len(accepted_items(window)), objects.proposals) == (1, ())
    assert window.document_file.save_and_wait(tmp_path / "deleted.cpm")
    with hand.qtbot.waitSignal(window.session.image_changed):
        window.session.open_file(tmp_path / "deleted.cpm")
    hand.wait(lambda: window.session.status.phase == "finished" and objects.offer_is_known and objects.idle)
    assert objects.proposals == ()
    assert len(accepted_items(window)) == 1


def test_delete_deletes_objects_and_rejects_only_the_proposals_among_them(window, hand, objects) -> None:
    run_everywhere(hand)
    first, second = objects.proposals
    window.workspace.object_list.select_objects((first.key,))
    hand.canvas.setFocus()
    take(hand)
    hand.wait(lambda: objects.idle and len(accepted_items(window)) == 1)
    window.workspace.object_list.select_objects((accepted_items(window)[0].number, second.key))
    hand.key(KEY.Key_Delete)
    known = window.session.document.objects
    assert (known.items, len(known.rejected), len(known.deleted)) == ((), 1, 1)
    assert window.session.history.undo_name == "delete 2 objects"


@pytest.mark.parametrize("confidence", [0.1, 0.9], ids=["doubtful", "likely"])
def test_all_like_an_object_are_proposed_and_enter_accepts_the_likely_ones_in_one_step(
    window, hand, objects, monkeypatch, confidence
) -> None:
    def find_three(cut, like, _):
        time.sleep(0.1)
        nothing = replace(like, contours=(), region=Region.from_mask(np.zeros((64, 64), bool)))
        corner = replace(cut.build_selection(disk((5, 58), 3.0), np.array([(5.0, 58.0)])), confidence=0.9)
        return replace(cut.select([LARGE[0]]), confidence=confidence), corner, nothing

    monkeypatch.setattr(object_selection, "find_similar_objects", find_three)
    hand.click(*SMALL[0])
    hand.key(KEY.Key_3)
    hand.key(KEY.Key_L, CONTROL)  # before the answer to the click
    hand.wait(lambda: objects.idle and len(objects.proposals) == 2 and window.session.idle)
    assert len(accepted_items(window)) == 1
    assert window.canvas_area.messages.text == "Objects like this one: 2."
    rows = [row.title for row in window.workspace.object_list.rows if row.kind == "proposal"]
    assert rows == ["proposal 1", "proposal 2"]
    hand.key(KEY.Key_1)  # the class of the next object
    take(hand)
    accepted = 3 if confidence > 0.7 else 2
    assert [item.category for item in accepted_items(window)] == [3] * accepted
    assert bool(window.workspace.object_list.selected_keys) == (accepted == 3), "what is left comes next"
    window.workspace.object_list.select_objects(item.number for item in accepted_items(window)[1:])
    hand.key(KEY.Key_Delete)
    hand.qtbot.wait(20)
    hand.wait(lambda: objects.idle)
    assert len(objects.proposals) == 3 - accepted, "what was deleted is not proposed again"
    for left in (accepted, 1):
        hand.key(KEY.Key_Z, CONTROL)
        assert len(accepted_items(window)) == left
    hand.qtbot.wait(20)
    hand.wait(lambda: objects.idle and len(objects.proposals) == 2)


def test_the_key_for_all_like_an_object_says_what_to_do_where_none_is_selected(window, hand, objects) -> None:
    hand.key(KEY.Key_L, CONTROL)
    assert window.canvas_area.messages.text == "Select one accepted object with an area: all like it are proposed."
    assert objects.idle


def test_enter_after_more_steps_than_there_are_candidates_accepts_the_last_one(window, hand, objects) -> None:
    hand.click(*SMALL[0])
    for _ in range(6):
        hand.key(KEY.Key_BracketRight)
    take(hand)
    hand.wait(lambda: objects.idle)
    assert len(accepted_items(window)) == 1


@pytest.mark.parametrize("in_table", [False, True], ids=["canvas", "table"])
def test_all_like_an_object_come_after_what_a_run_proposes_and_enter_right_after_accepts_both(
    window, hand, objects, monkeypatch, in_table
) -> None:
    may_find = threading.Event()

    def find_late(*given):
        may_find.wait(20.0)
        return find_proposals(*given)

    def find_one(cut, *_):
        time.sleep(0.1)
        return (replace(cut.build_selection(disk((5, 58), 3.0), np.array([(5.0, 58.0)])), confidence=0.9),)

    monkeypatch.setattr(object_selection, "find_proposals", find_late)
    monkeypatch.setattr(object_selection, "find_similar_objects", find_one)
    click(hand, *SMALL[0])
    take(hand)
    window.actions_by_name["start_grid"].trigger()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: objects.awaits_offer)
    window.workspace.object_list.select_objects((1,))
    hand.key(KEY.Key_L, CONTROL)
    if in_table:
        window.docks.reveal_panel("objects")
        window.get_feature(ObjectsFeature).panel.table.setFocus()
    take(hand)
    may_find.set()
    hand.wait(lambda: objects.idle and len(accepted_items(window)) == 3)


def test_objects_like_one_found_before_a_run_ends_stay_beside_what_it_proposes_each_once(
    window, hand, objects, monkeypatch
) -> None:
    corner = (5.0, 58.0), 3.0

    def find_two(cut, *_):
        found = (cut.build_selection(disk(*where), np.array([where[0]])) for where in (corner, LARGE))
        return [replace(each, confidence=0.9) for each in found]

    monkeypatch.setattr(object_selection, "find_similar_objects", find_two)
    click(hand, *SMALL[0])
    take(hand)
    window.actions_by_name["start_grid"].trigger()
    hand.key(KEY.Key_Period)
    hand.wait_for_phase("paused")
    window.workspace.object_list.select_objects((1,))
    hand.key(KEY.Key_L, CONTROL)
    hand.wait(lambda: objects.idle and len(objects.proposals) == 2)
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: window.session.scene.result.stop_reason and objects.idle and objects.offer_is_known)
    for place, _ in (corner, LARGE):
        assert sum(each.selection.contains(np.array([place]))[0] for each in objects.proposals) == 1
    assert [each.key for each in objects.proposals] == [-1, -2], "what is seen is numbered from 1"
    window.workspace.object_list.select_objects(each.key for each in objects.proposals if each.category)
    take(hand)
    hand.key(KEY.Key_Delete)  # what was accepted of them and deleted is for the run alone to propose again
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: objects.idle and objects.offer_is_known and len(objects.proposals) == 1)


def test_what_the_user_has_turned_to_and_what_is_proposed_stay_when_objects_like_one_are_found(
    window, hand, objects, monkeypatch
) -> None:
    may_find, listed, places = threading.Event(), window.workspace.object_list, [(5.0, 58.0), (58.0, 6.0)]

    def find_one(cut, *_):
        may_find.wait(20.0)
        place = places.pop()
        return (cut.build_selection(disk(place, 3.0), np.array([place])),)

    monkeypatch.setattr(object_selection, "find_similar_objects", find_one)
    for where in (SMALL, LARGE):
        click(hand, *where[0])
        take(hand)
    hand.key(KEY.Key_L, CONTROL)
    listed.select_objects((1,))
    may_find.set()
    hand.wait(lambda: objects.idle and len(objects.proposals) == 1)
    assert listed.selected_numbers == {1}
    hand.key(KEY.Key_L, CONTROL)
    hand.wait(lambda: objects.idle and len(objects.proposals) == 2)


@pytest.mark.parametrize("accepted", [True, False], ids=["accepted", "proposed"])
def test_nothing_that_lies_in_an_object_or_in_a_better_proposal_is_proposed_as_like_another(
    window, hand, objects, monkeypatch, tmp_path, accepted
) -> None:
    pair, single, other = disk((20, 20), 10) | disk((20, 37), 7.5), disk((46, 16), 9.0), disk((44, 46), 9.0)
    np.save(tmp_path / "pair.npy", np.where(pair | single | other, 150.0, 20.0))
    with hand.qtbot.waitSignal(window.session.image_changed):
        window.session.open_file(tmp_path / "pair.npy")
    hand.canvas.setFocus()
    hand.wait(lambda: objects.ready and objects.idle)
    whole = objects.partition_updater.partition.build_selection(pair, np.array([(20.0, 20.0)]))
    proposal = Proposal(replace(whole, confidence=0.99), (Click(((20.0, 20.0),)),))
    if accepted:
        window.session.edit("pair", lambda document: accept_objects(document, (proposal.proposed_object,)))
    else:
        monkeypatch.setattr(object_selection, "find_proposals", lambda *_: (proposal,))
        run_everywhere(hand, count=1)
    click(hand, 46, 16)
    take(hand)
    hand.wait(lambda: objects.idle and not objects.selecting)
    window.workspace.object_list.select_objects((accepted_items(window)[-1].number,))
    before = objects.proposals
    hand.key(KEY.Key_L, CONTROL)
    hand.wait(lambda: objects.idle and window.session.idle and len(objects.proposals) > len(before))
    (new,) = (each for each in objects.proposals if each.category)
    assert overlap(new.selection.mask, other) > 0.8


def test_proposals_of_a_run_are_numbered_from_one_though_others_were_accepted_before(window, hand, objects) -> None:
    click(hand, *LARGE[0])
    take(hand)
    run_everywhere(hand, count=1)
    assert [row.title for row in window.workspace.object_list.rows] == ["object 1", "proposal 1"]


def test_a_second_click_in_a_chosen_proposal_corrects_it_and_the_others_stay(window, hand, objects) -> None:
    run_everywhere(hand)
    click(hand, 18, 18)
    hand.qtbot.wait(20)
    click(hand, 18, 18)
    assert objects.selecting
    hand.wait(lambda: objects.idle and len(objects.proposals) == 2)
    assert overlap(offered(objects), disk(*SMALL)) > 0.9
    take(hand)
    (item,) = accepted_items(window)
    assert overlap(item.region.paste((64, 64)), disk(*SMALL)) > 0.9
    hand.wait(lambda: objects.idle and len(objects.proposals) == 1)


def test_the_number_of_a_candidate_is_said_of_an_unlikely_one_too(window, hand, objects, monkeypatch) -> None:
    def candidates(partition, inside, *rest, **more):
        large, small = (partition.build_selection(disk(SMALL[0], radius), np.array(inside)) for radius in (9.0, 5.0))
        return [replace(small, confidence=0.01, remark=UNLIKELY_REMARK), large]

    monkeypatch.setattr(Partition, "find_candidates", candidates)
    click(hand, 18, 18)
    hand.key(KEY.Key_BracketLeft)
    hand.wait(lambda: objects.idle and offered(objects).sum() == disk(SMALL[0], 5.0).sum())
    assert window.canvas_area.messages.text == "Candidate 1 of 2."


def test_brackets_take_the_next_candidate_and_undo_takes_the_step_back(window, hand, objects, monkeypatch) -> None:
    def candidates(partition, inside, *rest, **more):
        return [partition.build_selection(disk(SMALL[0], radius), np.array(inside)) for radius in (5.0, 9.0, 13.0)]

    monkeypatch.setattr(Partition, "find_candidates", candidates)
    click(hand, 18, 18)
    first = offered(objects)
    for key, step, said in (
        (KEY.Key_BracketRight, 1, "Candidate 3 of 3."),
        (KEY.Key_BracketRight, 1, "There is no larger candidate."),
        (KEY.Key_BracketLeft, 0, "Candidate 2 of 3."),
        (KEY.Key_BracketLeft, -1, "Candidate 1 of 3."),
    ):
        hand.key(key)
        hand.wait(lambda said=said: window.canvas_area.messages.text == said and objects.idle)
        assert window.session.document.objects.clicks[-1].step == step
    hand.wait(lambda: objects.idle and offered(objects).sum() == disk(SMALL[0], 5.0).sum())
    take(hand)
    assert "Candidate" not in window.canvas_area.messages.text
    (item,) = accepted_items(window)
    assert item.clicks[-1].step == -1
    objects.refit_objects(frozenset({1}))
    hand.wait(lambda: window.session.tasks.idle)
    assert accepted_items(window)[0].region.size == pytest.approx(item.region.size)
    for _ in range(2):
        hand.key(KEY.Key_Z, CONTROL)
    hand.wait(lambda: objects.idle and bool(objects.proposals))
    for _ in range(2):
        hand.key(KEY.Key_Z, CONTROL)
    hand.wait(lambda: objects.idle and np.array_equal(offered(objects), first))


@pytest.mark.parametrize("where", [SMALL, LARGE])
def test_a_click_a_circle_and_a_run_from_everywhere_give_the_same_object(window, hand, objects, where) -> None:
    (row, col), radius = where
    run_everywhere(hand)
    everywhere = next(each for each in objects.proposals if each.selection.contains(np.array([[row, col]]))[0])
    hand.key(KEY.Key_X)
    assert window.canvas_area.messages.text == "Rejected proposals: 2. Ctrl+Z brings them back."
    hand.wait(lambda: objects.idle and not objects.proposals)
    click(hand, row, col)
    np.testing.assert_array_equal(offered(objects), everywhere.selection.mask)
    hand.key(KEY.Key_Escape)
    window.actions_by_name["start_grid"].trigger()
    window.session.edit("forget", lambda d: replace(d, objects=replace(d.objects, rejected=())))
    window.session.edit("draw", lambda d: replace(d, shapes=(Circle((row, col), 0.5 * radius),)))
    window.session.run()
    hand.wait_for_phase("finished")
    hand.wait(lambda: objects.idle and len(objects.proposals) == 1)
    assert overlap(offered(objects), everywhere.selection.mask) > 0.95


def test_who_draws_a_circle_in_an_object_and_runs_gets_it_offered_and_enter_takes_it(window, hand) -> None:
    selection, session = window.workspace.object_selection, window.session
    hand.drag((18, 18), (18, 20), (18, 22))
    session.select_shape(None)
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: bool(selection.proposals))
    assert overlap(offered(selection), disk(*SMALL)) > 0.9
    likely = format_confidence(selection.proposals[0].selection)
    assert f"1 proposal, {likely}. Enter accepts it" in window.canvas_area.hint.text()
    hand.key(KEY.Key_Return)
    (item,) = accepted_items(window)
    assert overlap(item.region.paste((64, 64)), disk(*SMALL)) > 0.9
    hand.wait(lambda: selection.idle and not selection.proposals)


def _plain(action) -> str:
    return action.text().replace("&", "")


@pytest.mark.parametrize(
    ("use", "kind"), [("Start of the next run", Polygon), ("Region of interest", PolygonRegion), ("Barrier", Barrier)]
)
def test_an_object_becomes_a_start_a_region_or_a_barrier(window, hand, objects, use, kind) -> None:
    click(hand, 18, 18)
    take(hand)
    submenu = next(action.menu() for action in window.menus["Objects"].actions() if "Use as" in _plain(action))
    submenu.aboutToShow.emit()
    next(action for action in submenu.actions() if _plain(action) == use).trigger()
    (shape,) = window.session.document.shapes
    assert isinstance(shape, kind)
    away = np.hypot(*(np.array(shape.points) - SMALL[0]).T)
    assert np.abs(away - SMALL[1]).max() < 2.0


def test_a_session_file_keeps_objects_classes_and_the_selection_in_progress(window, hand, objects, tmp_path) -> None:
    click(hand, 18, 18)
    take(hand)
    window.workspace.object_commands.name_class(1, "nucleus", "#112233")
    window.actions_by_name["objects_overlap"].trigger()
    click(hand, 43, 42)
    before = window.session.document.objects
    kept = DocumentFile(window.session, dict)
    assert kept.save_and_wait(tmp_path / "kept.cpm")
    hand.key(KEY.Key_Escape)
    window.workspace.object_list.select_objects((1,))
    window.workspace.object_commands.delete_selected()
    window.session.open_file(tmp_path / "kept.cpm")
    hand.wait(lambda: window.session.document.objects == before)
    hand.wait(lambda: bool(objects.proposals))
    assert overlap(offered(objects), disk(*LARGE)) > 0.9


def test_each_result_of_a_run_is_partitioned_once(window, hand, objects, monkeypatch) -> None:
    prepared, at_rest = [], threading.Event()

    def slow(result, model):
        """The partition of a result; that of one on the way is ready only after the run."""
        prepared.append(result)
        if not result.stop_reason:
            at_rest.wait(60)
        return partition(result, model=model)

    monkeypatch.setattr(selector, "partition", slow)
    window.actions_by_name["start_grid"].trigger()
    hand.key(KEY.Key_Space)
    hand.wait(lambda: bool(window.session.scene.result and window.session.scene.result.stop_reason))
    at_rest.set()
    hand.wait(lambda: objects.partition_updater.source is window.session.scene.result)
    chosen = objects.partition_updater.partition
    hand.wait(lambda: objects.idle and len(objects.proposals) == 2)
    assert objects.partition_updater.partition is chosen
    assert len({id(each) for each in prepared}) == len(prepared)


def test_merged_proposals_leave_none_of_them_behind(window, hand, objects) -> None:
    starts = tuple(Circle(center, 4.0) for center, _ in (LARGE, SMALL))
    window.session.edit("draw", lambda document: replace(document, shapes=starts))
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: objects.idle and len(objects.proposals) == 2)
    hand.key(KEY.Key_A, Qt.KeyboardModifier.ControlModifier)
    hand.key(KEY.Key_M)
    hand.wait(lambda: objects.idle)
    (whole,) = window.session.document.objects.items
    assert len(whole.region.boundary) == 2 and objects.proposals == ()


def test_the_proposal_follows_the_contours_of_a_run(window, hand, objects) -> None:
    click(hand, 18, 18)
    before = objects.proposals[0].selection
    session = window.session
    session.edit("draw", lambda d: replace(d, shapes=(Circle(LARGE[0], 4.0),)))
    session.run()
    hand.wait_for_phase("finished")
    hand.wait(lambda: session.scene.result is not None and session.scene.result.stop_reason != "")
    hand.wait(lambda: objects.partition_updater.source is session.scene.result)
    hand.wait(lambda: objects.proposals[0].selection is not before)
    assert overlap(offered(objects), disk(*SMALL)) > 0.85
    session.reset()
    hand.wait(lambda: np.array_equal(offered(objects), before.mask))


def test_rejecting_a_correction_leaves_the_object_and_the_preview_of_clicks_as_they_were(window, hand, objects) -> None:
    click(hand, *SMALL[0])
    take(hand)
    before = accepted_items(window)
    for where in (SMALL, LARGE):
        click(hand, *where[0])
    assert window.session.document.objects.edited == 1
    hand.key(KEY.Key_X)
    hand.wait(lambda: objects.idle and not objects.selecting)
    assert accepted_items(window) == before
    hand.move(44, 43)
    hand.wait(lambda: window.session.scene.objects.preview is not None)
