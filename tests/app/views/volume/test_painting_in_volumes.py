"""Objects painted in the slices of a volume by mouse and keys: brush and eraser, locks, undo, sessions, exports."""

from __future__ import annotations

import numpy as np
import pytest
import scipy
import tifffile
from cpm_app.model.document import objects
from cpm_app.views.features.files import OpenSaveFeature
from cpm_app.views.features.volumes import SlicesFeature, SpaceFeature
from PySide6.QtCore import QEvent, Qt

from cpm_core.formats.sessions.session_file import load_session
from cpm_core.medial_axis import SkeletonMethod
from cpm_core.numerics import polyline
from cpm_core.parameters import PRESETS
from tests.app.exporting import asked, check, export, order
from tests.app.reading import accepted_items
from tests.app.views.volume.conftest import SHAPE, Button, send

pytestmark = pytest.mark.shared_window

KEY, KEYS = Qt.Key, Qt.KeyboardModifier
NONE, SHIFT, CTRL = KEYS.NoModifier, KEYS.ShiftModifier, KEYS.ControlModifier
PLACES = np.moveaxis(np.indices(SHAPE), 0, -1)


@pytest.fixture
def brush(volume, hand):
    """The brush in use, of a small radius."""
    hand.canvas.setFocus()
    hand.key(KEY.Key_J)
    tool = hand.canvas.dispatcher.tool
    assert tool.name == "mend"
    tool.set_radius(3.0)
    settings = volume.workspace.object_brush
    settings.paints_in_space = False
    return tool


def stroke(view, *places, keys=NONE) -> None:
    """A stroke of the left button through (row, col) of a view."""
    send(view, QEvent.Type.MouseMove, places[0], Button.NoButton, Button.NoButton, keys=keys)
    send(view, QEvent.Type.MouseButtonPress, places[0], Button.LeftButton, Button.LeftButton, keys=keys)
    for place in places[1:]:
        send(view, QEvent.Type.MouseMove, place, Button.NoButton, Button.LeftButton, keys=keys)
    send(view, QEvent.Type.MouseButtonRelease, places[-1], Button.LeftButton, Button.NoButton, keys=keys)


def masks(window) -> list[np.ndarray]:
    return [item.region.paste(SHAPE) for item in accepted_items(window)]


def covered(*path) -> np.ndarray:
    """Distance of each voxel from a way in the volume."""
    if len(path) == 1:
        return np.linalg.norm(PLACES - np.array(path[0]), axis=-1)
    ends = np.array(path, float)
    return np.min([np.linalg.norm(PLACES - (ends[0] + s * (ends[1] - ends[0])), axis=-1)
                   for s in np.linspace(0, 1, 100)], axis=0)  # fmt: skip


def assert_is(mask, away, radius=3.0) -> None:
    """A mask is what is nearer than the radius, except for voxels at the rim, which a pixel of the screen decides."""
    sure = np.abs(away - radius) > 0.2
    assert np.array_equal(mask[sure], (away < radius)[sure])


def in_slice(away, axis, index) -> np.ndarray:
    return np.where(np.indices(SHAPE)[axis] == index, away, np.inf)


def test_a_stroke_in_a_slice_paints_voxels_of_that_slice_and_one_undo_takes_it_back(volume, hand, brush) -> None:
    stroke(hand.canvas, (12, 8), (12, 14), (12, 20))
    (item,) = accepted_items(volume)
    assert_is(item.region.paste(SHAPE), in_slice(covered((12, 12, 8), (12, 12, 20)), 0, 12))
    assert volume.workspace.object_list.selected_numbers == {item.number}
    assert volume.actions_by_name["undo"].text() == "Undo paint object"
    before = masks(volume)[0]
    volume.workspace.slices.go_to(15)
    stroke(hand.canvas, (14, 10))
    assert [each.number for each in accepted_items(volume)] == [item.number]  # the chosen one continues in other slices
    stroke(hand.canvas, (14, 22), keys=CTRL)
    assert len(accepted_items(volume)) == 2
    for _ in range(2):
        hand.key(KEY.Key_Z, CTRL)
    assert np.array_equal(masks(volume)[0], before)
    hand.key(KEY.Key_Z, CTRL)
    assert accepted_items(volume) == ()


def test_shift_erases_what_the_ring_goes_over_and_nothing_is_left_of_a_whole_erased_stroke(volume, hand, brush) -> None:
    stroke(hand.canvas, (12, 8), (12, 20))
    stroke(hand.canvas, (12, 20), keys=SHIFT)
    kept = in_slice(covered((12, 12, 8), (12, 12, 20)), 0, 12)
    assert_is(masks(volume)[0], np.where(covered((12, 12, 20)) < 3.0, np.inf, kept))
    stroke(hand.canvas, (12, 8), (12, 20), keys=SHIFT)
    assert accepted_items(volume) == ()


def test_other_slices_are_painted_across_their_axes(volume, hand, brush) -> None:
    hand.wait(lambda: len(volume.get_feature(SlicesFeature).sides) == 2)
    sides = volume.get_feature(SlicesFeature).sides
    for view, axis in zip(sides, (1, 2), strict=True):
        before = masks(volume)[0] if accepted_items(volume) else np.zeros(SHAPE, bool)
        index = volume.session.scene.slices.voxel[axis]
        stroke(view, (9, 11))
        place = [9, 11]
        place.insert(axis, index)
        added = masks(volume)[0] & ~before
        away = in_slice(covered(tuple(place)), axis, index)
        assert_is(added | before, np.where(before, 0.0, away))


def test_the_lines_in_slices_enclose_the_voxels_that_have_been_painted(volume, hand, brush) -> None:
    volume.workspace.object_brush.paints_in_space = True
    stroke(hand.canvas, (12, 10), (15, 18))
    mask = masks(volume)[0]
    assert_is(mask, covered((12, 12, 10), (12, 15, 18)))
    for view in (hand.canvas, *volume.get_feature(SlicesFeature).sides):
        here = view.drawn_scene.slices.current
        (cut,) = view.drawn_scene.document.objects.items
        expected = here.slice_array(mask)
        pixels = np.moveaxis(np.indices(expected.shape), 0, -1).reshape(-1, 2).astype(float)
        inside = np.zeros(len(pixels), bool)
        for line in cut.region.boundary:
            inside ^= polyline.points_inside(line, pixels)
        assert np.array_equal(inside.reshape(expected.shape), expected)


def test_a_frozen_object_keeps_every_voxel_and_others_are_painted_over_if_objects_may_overlap(
    volume, hand, brush
) -> None:
    listed = volume.workspace.object_list
    stroke(hand.canvas, (12, 8), (12, 14))
    first = masks(volume)[0]
    volume.workspace.object_commands.toggle_state("frozen")
    stroke(hand.canvas, (12, 16), (12, 10), keys=CTRL)
    assert np.array_equal(masks(volume)[0], first)
    assert not (masks(volume)[1] & first).any()
    stroke(hand.canvas, (12, 8), keys=SHIFT)  # the chosen one, which is not frozen, has nothing there
    assert np.array_equal(masks(volume)[0], first)
    listed.select_objects((1,))
    stroke(hand.canvas, (20, 8))
    assert np.array_equal(masks(volume)[0], first)
    assert "frozen" in volume.canvas_area.messages.text
    volume.workspace.object_commands.toggle_state("frozen")
    stroke(hand.canvas, (12, 16), (12, 8), keys=CTRL)
    assert np.array_equal(masks(volume)[0], first)
    volume.trigger_action("objects_overlap")
    stroke(hand.canvas, (12, 8), keys=CTRL)
    left, new = masks(volume)[0], masks(volume)[-1]
    assert np.array_equal(left, first & ~new)
    assert 0 < left.sum() < first.sum()


def test_a_stroke_over_a_hidden_object_says_why_it_does_nothing_and_is_no_step_of_undo(volume, hand, brush) -> None:
    stroke(hand.canvas, (12, 8), (12, 14))
    volume.workspace.object_commands.toggle_state("hidden")
    before = volume.session.document
    stroke(hand.canvas, (12, 10), (12, 12))
    assert "hidden: show it" in volume.canvas_area.messages.text
    volume.workspace.object_list.select_objects(())
    volume.canvas_area.messages.dismiss_message()
    stroke(hand.canvas, (12, 10), (12, 12))
    assert "hidden: show it" in volume.canvas_area.messages.text
    assert volume.session.document is before


def test_painted_objects_are_measured_drawn_in_space_saved_and_exported(volume, hand, brush, tmp_path) -> None:
    listed = volume.workspace.object_list
    volume.workspace.object_brush.paints_in_space = True
    stroke(hand.canvas, (12, 10), (14, 18))
    stroke(hand.canvas, (20, 24), keys=CTRL)
    hand.wait(lambda: all(listed.measurer.figures_of(item) is not None for item in accepted_items(volume)))
    counts = [int(mask.sum()) for mask in masks(volume)]
    assert [listed.measurer.figures_of(item).volume for item in accepted_items(volume)] == counts
    hand.wait(lambda: len(volume.get_feature(SpaceFeature).panel.contents.objects) == 2)
    path, file = tmp_path / "painted.cpm", volume.get_feature(OpenSaveFeature).document_file
    assert file.save_and_wait(path)
    kept = load_session(path).objects.items
    assert kept == accepted_items(volume)
    assert [item.region.paste(SHAPE).sum() for item in kept] == counts
    labels = np.sum([mask * number for mask, number in zip(masks(volume), (1, 2), strict=True)], axis=0)
    (made,) = export(hand.qtbot, volume, tmp_path, "objects:.tif")
    assert np.array_equal(tifffile.imread(made), labels)


def test_a_surface_is_smoothed_at_export_and_the_message_says_how_far_that_moves_it(
    volume, hand, brush, tmp_path
) -> None:
    volume.workspace.object_brush.paints_in_space = True
    stroke(hand.canvas, (12, 10), (14, 18))
    dialog = asked(hand.qtbot, volume)
    check(hand.qtbot, dialog, "objects:.stl")
    assert dialog.rounds.isVisible()
    dialog.rounds.setValue(10)
    (made,) = order(hand.qtbot, volume, dialog, tmp_path)
    assert made.stat().st_size > 1000
    hand.wait(lambda: "on average" in volume.canvas_area.messages.text)


def test_a_key_fills_the_slices_between_and_says_how_many(volume, hand, brush) -> None:
    for plane, radius in ((5, 2.0), (15, 7.0)):
        volume.workspace.slices.go_to(plane)
        brush.set_radius(radius)
        stroke(hand.canvas, (14, 16))
    before = masks(volume)[0]
    hand.key(KEY.Key_I, SHIFT)
    hand.wait(lambda: masks(volume)[0].sum() > before.sum())
    filled = masks(volume)[0]
    assert np.array_equal(filled[[5, 15]], before[[5, 15]])
    plane, away = np.indices(SHAPE)[0], np.hypot(*(np.indices(SHAPE)[1:] - np.array([14, 16])[:, None, None, None]))
    cone = np.where((plane >= 5) & (plane <= 15), 2.0 + 0.5 * (plane - 5), -1.0)
    sure = np.abs(away - cone) > 1.5
    assert np.array_equal(filled[sure], (away < cone)[sure])
    assert "9" in volume.canvas_area.messages.text
    hand.key(KEY.Key_Z, CTRL)
    assert np.array_equal(masks(volume)[0], before)
    hand.key(KEY.Key_J, SHIFT)
    assert volume.workspace.object_brush.paints_in_space
    assert volume.actions_by_name["paint_in_space"].isChecked()


def test_painted_objects_limit_the_next_run_start_it_and_have_center_lines(volume, hand, brush) -> None:
    volume.workspace.object_brush.paints_in_space = True
    stroke(hand.canvas, (12, 6), (12, 26))
    mask = masks(volume)[0]
    for edit in (objects.add_objects_as_regions, objects.add_objects_as_barriers, objects.add_objects_as_starts):
        volume.session.edit("use", lambda document, edit=edit: edit(document, (1,)))
    region, wall, points = volume.session.document.shapes
    assert not (volume.session.document.regions.voxel_mask(SHAPE) & ~mask).any()
    found = np.zeros(SHAPE, bool)
    region.limit.fill_into(found)
    assert np.array_equal(found, mask)
    shell = np.zeros(SHAPE, bool)
    wall.limit.fill_into(shell)
    assert np.array_equal(shell, mask & ~scipy.ndimage.binary_erosion(mask))
    away = np.abs(covered((12, 12, 6), (12, 12, 26)) - 3.0)
    nearest = np.rint(points.seeds()).astype(int)
    assert (away[tuple(nearest.T)] < 1.5).all()
    assert region.translated((1.0, 0.0, 0.0)).center == pytest.approx(np.add(region.center, (1, 0, 0)))
    skeleton = SkeletonMethod(volume.session.image).for_objects([volume.session.document.objects[1].region])
    state = skeleton.start()
    while not state.stop_reason:
        state = skeleton.step(state, PRESETS["volume"])
    assert len(state.points)


def test_the_objects_tool_takes_up_a_painted_object_and_escape_leaves_it_as_it_was(volume, hand, brush) -> None:
    volume.workspace.object_brush.paints_in_space = True
    stroke(hand.canvas, (12, 12))
    before = accepted_items(volume)
    hand.key(KEY.Key_W)
    stroke(hand.canvas, (12, 12))
    hand.key(KEY.Key_Escape)
    assert accepted_items(volume) == before
    assert not volume.session.document.objects.clicks
