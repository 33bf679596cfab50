"""Objects in a volume: bodies that the surface encloses are selected by clicks in slices and in space, and kept."""

from __future__ import annotations

import threading

import numpy as np
import pytest
import tifffile
from cpm_app.model.document import objects
from cpm_app.model.volume.shape_sections import Cut
from cpm_app.session.storage.session_file import DocumentFile
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.features.volumes import SpaceFeature
from PySide6.QtCore import QPoint, Qt

from cpm_core.formats.sessions.session_file import load_session
from cpm_core.image.region import Region
from cpm_core.image.surface import Surface
from cpm_core.objects import VolumePartition
from cpm_core.objects.segmented.segmented_object import SegmentedObject
from cpm_core.shapes import EnclosedRegion
from tests.app.conftest import Hand
from tests.app.exporting import export
from tests.app.reading import accepted_items, treat_as_saved
from tests.app.views.volume.conftest import SHAPE, Button

pytestmark = pytest.mark.shared_window

KEY, SHIFT = Qt.Key, Qt.KeyboardModifier.ShiftModifier
ONE, OTHER, RADIUS = (11.0, 8.0, 9.0), (12.0, 18.0, 22.0), 5.5


def balls() -> np.ndarray:
    """Two bright balls in a dark volume."""
    places = np.moveaxis(np.indices(SHAPE), 0, -1)
    away = np.minimum(*(np.linalg.norm(places - np.array(center), axis=-1) for center in (ONE, OTHER)))
    return np.round(20.0 + 180.0 * np.clip(RADIUS + 0.5 - away, 0.0, 1.0))


@pytest.fixture
def volume_file(tmp_path):
    path = tmp_path / "balls.npy"
    np.save(path, balls().astype(np.uint8))
    return path


@pytest.fixture
def found(volume, hand, monkeypatch):
    """A window on the balls after a run from both, in which the tool for objects is in use and ready."""
    monkeypatch.setattr(hand, "patience", 120_000)
    for plane, row, col in (ONE, OTHER):
        volume.workspace.slices.go_to(round(plane))
        hand.drag((row, col), (row, col + 2), (row, col + 3))
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: volume.session.idle and volume.session.scene.reconstruction is not None)
    hand.canvas.setFocus()
    hand.key(KEY.Key_W)
    hand.wait(lambda: len(volume.workspace.object_selection.proposals) == 2)
    return volume


def click(hand: Hand, at: tuple[float, float], keys: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier) -> None:
    """A click in the slice on the canvas, and the answer to it."""
    begin_click(hand, at, keys)
    settle(hand)


def begin_click(
    hand: Hand, at: tuple[float, float], keys: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier
) -> None:
    """A click in the slice on the canvas, whose answer is not waited for."""
    for act in (hand.qtbot.mousePress, hand.qtbot.mouseRelease):
        act(hand.canvas.viewport(), Button.LeftButton, keys, hand.at(*at))


def settle(hand: Hand) -> None:
    selection = hand.window.workspace.object_selection
    clicks = hand.window.session.document.objects.clicks
    hand.wait(lambda: selection.idle and ([each.clicks for each in selection.proposals[:1]] == [clicks] or not clicks))
    hand.qtbot.wait(20)


def take(hand: Hand) -> None:
    """Take what is offered, and leave the name as it is."""
    hand.key(KEY.Key_Return)
    hand.key(KEY.Key_Return)


def bodies(window) -> list[float]:
    """Volumes of the objects [voxels]."""
    return [item.region.surface.volume for item in accepted_items(window)]


BALL = 4.0 / 3.0 * np.pi * RADIUS**3


def forget_offer(window, hand) -> None:
    """What is offered around the starts is dropped, so that clicks begin with nothing."""
    hand.wait(lambda: len(window.workspace.object_selection.proposals) == 2)
    hand.key(KEY.Key_X)
    hand.wait(lambda: not window.workspace.object_selection.proposals)


def test_the_bodies_of_the_starts_are_offered_and_taken_by_enter(found, hand) -> None:
    selection = found.workspace.object_selection
    hand.wait(lambda: len(selection.proposals) == 2)
    assert hand.canvas.layers["objects"].proposal_fill.count > 0
    hand.key(KEY.Key_Return)
    assert bodies(found) == pytest.approx([BALL, BALL], rel=0.08)
    assert {item.number for item in accepted_items(found)} == {1, 2}


def test_a_run_from_everywhere_in_a_volume_ends_at_bodies_that_enter_accepts(volume, hand, monkeypatch) -> None:
    monkeypatch.setattr(hand, "patience", 120_000)
    volume.actions_by_name["start_grid"].trigger()
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    selection = volume.workspace.object_selection
    hand.wait(lambda: selection.idle and len(selection.proposals) == 2)
    hand.key(KEY.Key_Return)
    assert bodies(volume) == pytest.approx([BALL, BALL], rel=0.08)
    hand.wait(lambda: selection.idle and not selection.proposals)


def test_clicks_in_slices_add_bodies_and_take_them_away(found, hand) -> None:
    forget_offer(found, hand)
    selection = found.workspace.object_selection
    click(hand, OTHER[1:])
    (proposal,) = selection.proposals
    assert proposal.selection.size == pytest.approx(BALL, rel=0.08)
    layer = hand.canvas.layers["objects"]
    assert layer.proposal_fill.count == 1
    found.workspace.slices.go_to(1)
    assert layer.proposal_fill.count == 0
    found.workspace.slices.go_to(round(ONE[0]))
    click(hand, ONE[1:])
    assert selection.proposals[0].selection.size == pytest.approx(2 * BALL, rel=0.08)
    click(hand, OTHER[1:], SHIFT)
    assert selection.proposals[0].selection.contains(np.array([ONE, OTHER])).tolist() == [True, False]
    hand.key(KEY.Key_Backspace)
    settle(hand)
    take(hand)
    assert bodies(found) == pytest.approx([2 * BALL], rel=0.08)
    hand.key(KEY.Key_Z, Qt.KeyboardModifier.ControlModifier)
    hand.wait(lambda: not accepted_items(found))


def test_a_click_on_the_surface_in_space_selects_the_body_behind_it(found, hand) -> None:
    forget_offer(found, hand)
    view = found.get_feature(SpaceFeature).panel.view
    hand.wait(lambda: view.is_idle and view._frame is not None)
    beside = np.array([OTHER]) + 5.0 * view.camera.axes[0]  # off the lines of the start in it
    seen = view.camera.project(beside, view.picture_size)[0] / view.devicePixelRatioF()
    at = QPoint(round(seen[0]), round(seen[1]))
    hand.qtbot.mouseClick(view, Button.LeftButton, SHIFT, at)
    assert [said.inside for said in found.session.document.objects.clicks] == [False]
    found.workspace.object_selection.discard_clicks()
    hand.qtbot.mouseClick(view, Button.LeftButton, pos=at)
    settle(hand)
    take(hand)
    assert bodies(found) == pytest.approx([BALL], rel=0.08)
    assert accepted_items(found)[0].region.surface.vertices.mean(axis=0) == pytest.approx(OTHER, abs=0.5)
    assert len(found.get_feature(SpaceFeature).panel.contents.objects) == 1
    hand.window.actions_by_name["hide_object"].trigger()
    assert found.get_feature(SpaceFeature).panel.contents.objects == ()
    assert hand.canvas.layers["objects"].fills.count == 0


def test_the_table_measures_objects_in_units_of_the_volume(found, hand) -> None:
    hand.key(KEY.Key_Return)
    found.docks.reveal_panel("objects")
    table = found.panels["objects"].table
    hand.wait(
        lambda: all(found.workspace.object_list.measurer.figures_of(item) is not None for item in accepted_items(found))
    )
    model = table.model()
    heads = [model.headerData(k, Qt.Orientation.Horizontal) for k in range(model.columnCount())]
    assert "Volume" in heads
    row = dict(zip(heads, (model.index(0, k).data() for k in range(model.columnCount())), strict=True))
    assert float(row["Volume"].replace(",", "")) == pytest.approx(BALL, rel=0.08)
    assert float(row["Area"].replace(",", "")) == pytest.approx(4.0 * np.pi * RADIUS**2, rel=0.08)
    assert (row["Surfaces"], row["Euler number"]) == ("1", "2")
    assert 150.0 < float(row["Mean gray"]) <= 200.0


def test_objects_are_exported_as_a_surface_and_as_labels_of_their_own(found, hand, tmp_path) -> None:
    hand.key(KEY.Key_Return)
    hand.key(KEY.Key_Return)
    labels, mesh = export(hand.qtbot, found, tmp_path, "objects:.tif", "objects:.ply")
    assert mesh.stat().st_size > 1000
    assert found.canvas_area.messages.text.startswith("2 files written: ")
    assert "(2 objects)" in found.canvas_area.messages.text
    labels = tifffile.imread(labels)
    there = [labels[tuple(map(round, center))] for center in (ONE, OTHER)]
    assert set(there) == {item.number for item in accepted_items(found)}
    for number in there:
        assert (labels == number).sum() == pytest.approx(BALL, rel=0.1)


def test_objects_come_back_with_a_session(found, hand, tmp_path) -> None:
    hand.key(KEY.Key_Return)
    before = accepted_items(found)
    file: DocumentFile = found.get_feature(OpenSaveFeature).document_file
    path = tmp_path / "balls.cpm"
    assert file.save_and_wait(path)
    found.session.edit("delete", lambda document: type(document)(document.image))
    treat_as_saved(found)
    open_file_again(found, hand, path)
    assert accepted_items(found) == before
    for one, other in zip(accepted_items(found), before, strict=True):
        assert isinstance(one.region.surface, Surface)
        np.testing.assert_array_equal(one.region.surface.vertices, other.region.surface.vertices)
    found.workspace.slices.go_through(OTHER)
    assert hand.canvas.layers["objects"].fills.count >= 1


def open_file_again(window, hand, path) -> None:
    window.open_image(str(path))
    hand.wait(lambda: bool(accepted_items(window)) and window.session.idle)


def chosen_by_menu(window, hand, name: str, numbers: set[int]) -> None:
    """Do something to some objects by the menu."""
    window.workspace.object_list.select_objects(numbers)
    if name in window.actions_by_name:
        window.actions_by_name[name].trigger()
        return
    submenu = next(action.menu() for action in window.menus["Objects"].actions() if "se as" in action.text())
    submenu.aboutToShow.emit()
    next(action for action in submenu.actions() if action.text().replace("&", "").startswith(name)).trigger()


def test_an_object_is_a_region_of_interest_in_all_slices_and_in_sessions(found, hand, tmp_path) -> None:
    hand.key(KEY.Key_Return)
    chosen_by_menu(found, hand, "Region", {1})
    region = found.session.document.shapes[-1]
    assert isinstance(region, EnclosedRegion)
    inside = found.session.document.regions.voxel_mask(found.session.image.shape)
    assert inside.sum() == pytest.approx(BALL, rel=0.1)
    found.workspace.slices.go_through(ONE)
    cuts = [cut for cut in found.canvas_area.canvas.drawn_scene.document.shapes if isinstance(cut, Cut)]
    (shown,) = (cut for cut in cuts if cut.shape is region)
    assert len(shown.outline)
    path, file = tmp_path / "region.cpm", found.get_feature(OpenSaveFeature).document_file
    assert file.save_and_wait(path)
    assert load_session(path).shapes[-1] == region
    hand.key(KEY.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert found.session.document.regions is None


def test_a_click_in_any_slice_gives_the_body_before_a_run(volume, hand) -> None:
    hand.canvas.setFocus()
    hand.key(KEY.Key_W)
    volume.workspace.slices.go_through(OTHER)
    selection = volume.workspace.object_selection
    hand.wait(lambda: selection.ready)
    click(hand, OTHER[1:])
    (proposal,) = selection.proposals
    assert proposal.selection.size == pytest.approx(BALL, rel=0.08)
    assert hand.canvas.layers["objects"].proposal_fill.count == 1
    volume.workspace.slices.go_to(1)
    assert hand.canvas.layers["objects"].proposal_fill.count == 0
    volume.workspace.slices.go_through(ONE)
    click(hand, ONE[1:])
    assert selection.proposals[0].selection.contains(np.array([ONE, OTHER])).all()
    assert selection.proposals[0].selection.size == pytest.approx(2 * BALL, rel=0.1)
    click(hand, ONE[1:], SHIFT)
    assert selection.proposals[0].selection.contains(np.array([ONE, OTHER])).tolist() == [False, True]
    hand.key(KEY.Key_Backspace)
    hand.key(KEY.Key_Backspace)
    settle(hand)
    take(hand)
    assert bodies(volume) == pytest.approx([BALL], rel=0.08)
    assert volume.session.scene.reconstruction is None


def test_clicks_correct_a_painted_body_near_them_and_leave_the_rest_as_it_was(volume, hand, monkeypatch) -> None:
    monkeypatch.setattr(hand, "patience", 120_000)
    hand.canvas.setFocus()
    hand.key(KEY.Key_J)
    hand.canvas.dispatcher.tool.set_radius(2.0)
    volume.workspace.slices.go_through(OTHER)
    hand.drag(OTHER[1:], (18, 25), (18, 19))
    hand.drag((3, 4), (3, 6), (3, 10))
    (painted,) = accepted_items(volume)
    hand.key(KEY.Key_W)
    selection = volume.workspace.object_selection
    hand.wait(lambda: selection.ready)
    click(hand, OTHER[1:])
    assert selection.selecting
    volume.workspace.slices.go_to(15)
    click(hand, OTHER[1:])
    take(hand)
    (corrected,) = accepted_items(volume)
    mask, ball = corrected.region.paste(SHAPE), np.zeros(SHAPE, bool)
    ball[:, 11:, 13:] = balls()[:, 11:, 13:] > 110
    np.testing.assert_array_equal(mask[:, :8], painted.region.paste(SHAPE)[:, :8])
    assert (mask & ball).sum() > 0.9 * ball.sum()
    hand.key(KEY.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert accepted_items(volume) == (painted,)


def test_two_clicks_split_a_body_in_space_and_one_undo_joins_it(volume, hand) -> None:
    hand.canvas.setFocus()
    hand.key(KEY.Key_J)
    hand.canvas.dispatcher.tool.set_radius(3.0)
    volume.workspace.slices.go_to(10)
    hand.drag((10, 6), (10, 7))
    hand.drag((10, 12), (10, 13))
    (whole,) = accepted_items(volume)
    hand.key(KEY.Key_K)
    click(hand, (10, 6))
    click(hand, (10, 13))
    hand.wait(lambda: len(accepted_items(volume)) == 2)
    one, other = (item.region.paste(SHAPE)[10] for item in accepted_items(volume))
    np.testing.assert_array_equal(one ^ other, whole.region.paste(SHAPE)[10])
    assert (one[10, 5:15] != other[10, 5:15]).all()
    assert (one[10, 6], other[10, 13]) == (True, True)
    hand.key(KEY.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert accepted_items(volume) == (whole,)


def test_what_is_typed_after_the_key_for_names_before_the_answer_goes_into_the_name(volume, hand) -> None:
    hand.canvas.setFocus()
    hand.key(KEY.Key_W)
    selection = volume.workspace.object_selection
    hand.wait(lambda: selection.ready)
    volume.workspace.slices.go_through(ONE)
    begin_click(hand, ONE[1:])
    hand.key(KEY.Key_Return)
    assert not selection.answered
    hand.key(KEY.Key_F2)
    hand.qtbot.keyClicks(hand.canvas, "corxx")
    for _ in range(2):
        hand.key(KEY.Key_Backspace)
    hand.qtbot.keyClicks(hand.canvas, "tex")
    hand.key(KEY.Key_Return)
    assert not selection.answered
    hand.wait(lambda: selection.idle and [item.name for item in accepted_items(volume)] == ["cortex"])
    assert selection.proposals == ()
    hand.wait(hand.canvas.hasFocus)


def test_the_search_for_another_candidate_of_a_proposal_is_said_whatever_slice_is_shown(
    found, hand, monkeypatch
) -> None:
    selection = found.workspace.object_selection
    answer, find = threading.Event(), VolumePartition.find_candidates
    monkeypatch.setattr(
        VolumePartition, "find_candidates", lambda *given, **more: (answer.wait(60), find(*given, **more))[1]
    )
    found.workspace.object_list.select_objects([selection.proposals[0].key])
    found.workspace.slices.go_to(2)
    hand.key(KEY.Key_BracketRight)
    assert found.canvas_area.hint.text() == "Finding the body…"
    answer.set()
    hand.wait(lambda: selection.idle and not found.session.scene.objects.awaited)
    assert found.canvas_area.hint.text() != "Finding the body…"


def test_a_click_in_the_background_is_marked_says_that_it_finds_nothing_and_binds_no_later_click(volume, hand) -> None:
    hand.key(KEY.Key_W)
    volume.workspace.slices.go_to(round(ONE[0]))
    selection = volume.workspace.object_selection
    hand.click(24.0, 5.0)
    assert [each.places[0][1:] for each in volume.session.scene.objects.awaited] == [
        pytest.approx((24.0, 5.0), abs=0.5)
    ]
    assert volume.canvas_area.hint.text() == "Finding the body…"
    hand.wait(lambda: selection.answered and selection.idle)
    assert "No body was found at this place." in volume.canvas_area.messages.text
    assert volume.canvas_area.hint.text() != "Finding the body…"
    assert not volume.workspace.object_list.rows
    hand.click(*ONE[1:])
    hand.wait(lambda: selection.answered and selection.idle)
    assert len(volume.session.document.objects.clicks) == 1
    assert selection.proposals[0].selection.contains(np.array([ONE]))[0]


@pytest.mark.parametrize(
    "key",
    [KEY.Key_Delete, KEY.Key_K, *(pytest.param(key, marks=pytest.mark.long) for key in (KEY.Key_Backspace, KEY.Key_M))],
)
def test_what_follows_enter_before_the_answer_is_done_after_it(volume, hand, key) -> None:
    hand.canvas.setFocus()
    hand.key(KEY.Key_W)
    selection = volume.workspace.object_selection
    hand.wait(lambda: selection.ready)
    volume.workspace.slices.go_through(ONE)
    if key == KEY.Key_M:
        click(hand, ONE[1:])
        hand.key(KEY.Key_Return)
        volume.workspace.slices.go_through(OTHER)
    begin_click(hand, (OTHER if key == KEY.Key_M else ONE)[1:])
    hand.key(KEY.Key_Return)
    assert not selection.answered
    if key == KEY.Key_M:
        hand.key(KEY.Key_A, Qt.KeyboardModifier.ControlModifier)
    hand.key(key)
    if key == KEY.Key_K:
        begin_click(hand, (ONE[1] - 3, ONE[2]))
        begin_click(hand, (ONE[1] + 3, ONE[2]))
    hand.wait(lambda: selection.idle)
    count, whole = {KEY.Key_M: (1, 2 * BALL), KEY.Key_K: (2, BALL)}.get(key, (0, 0.0))
    hand.wait(lambda: len(accepted_items(volume)) == count)
    assert sum(item.region.size for item in accepted_items(volume)) == pytest.approx(whole, rel=0.1)


def test_all_like_a_body_are_found_by_one_key(volume, hand) -> None:
    inside = np.linalg.norm(np.moveaxis(np.indices(SHAPE), 0, -1) - ONE, axis=-1) < RADIUS
    one = SegmentedObject(1, (), Region.from_mask(inside))
    volume.session.edit("add", lambda document: objects.accept_objects(document, [one]))
    hand.key(KEY.Key_W)
    hand.wait(lambda: volume.workspace.object_selection.ready)
    volume.workspace.object_list.select_objects([1])
    hand.wait(volume.actions_by_name["objects_alike"].isEnabled)
    hand.key(KEY.Key_L, Qt.KeyboardModifier.ControlModifier)
    hand.wait(lambda: bool(volume.workspace.object_selection.proposals))
    hand.key(KEY.Key_Return)
    hand.wait(lambda: len(accepted_items(volume)) == 2)
    assert accepted_items(volume)[1].region.contains(OTHER)
    assert np.count_nonzero(accepted_items(volume)[1].region.mask) == pytest.approx(BALL, rel=0.1)
