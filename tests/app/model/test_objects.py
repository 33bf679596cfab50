"""Edits of objects are pure, and what is exported is what the objects are."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.model.document import objects
from cpm_app.model.document.document import Document, ImageReference
from cpm_app.model.document.saving import describe_changes
from cpm_app.session.features.object_rows import ObjectRow
from cpm_app.session.features.object_selection import format_confidence
from cpm_app.views.panels.objects import build_object_columns

from cpm_core.contours.contour import Contour
from cpm_core.formats import to_bytes
from cpm_core.formats.masks.labels import paint_labels
from cpm_core.image.region import Region
from cpm_core.objects.segmented.segmented_object import Click, SegmentedObjects
from cpm_core.objects.selection import Selection
from cpm_core.results import Result, boundaries_result, is_likely
from cpm_core.shapes import Barrier, Polygon, Stroke

HERE, THERE, NOT_THERE = Click(((15.0, 15.0),)), Click(((30.0, 30.0),)), Click(((1.0, 1.0),), inside=False)
IMAGE = ImageReference("a.png", "a.png", (40, 40), 1.0, spacing=(0.5, 0.5), unit="mm")


def square(low: float, high: float) -> np.ndarray:
    return np.array([[low, low], [low, high], [high, high], [high, low]])


def selected(*squares: tuple[float, float], confidence: float = 0.5) -> Selection:
    """A selection bounded by squares, each inside the one before it; the first side of the first is a gap."""
    row, col = np.indices((40, 40))
    mask = np.zeros((40, 40), bool)
    for low, high in squares:
        mask ^= (np.minimum(row, col) > low) & (np.maximum(row, col) < high)
    curves = tuple(Contour(square(*each), True, 3.0) for each in squares)
    gap = square(*squares[0])[:2]
    inside, outside = np.array([[15.0, 15.0]]), np.empty((0, 2))
    return Selection(Region.from_mask(mask), mask.shape, inside, outside, curves, (gap,), confidence)


FRAME, DOT = selected((4.5, 25.5), (9.5, 20.5)), selected((11.5, 18.5))


def accepted(document: Document, selection: Selection, clicks: tuple[Click, ...], number: int = 0) -> Document:
    known = document.objects
    given = objects.object_from_selection(selection, clicks, number or known.next_number, known.category)
    return objects.accept_objects(document, (given,), ends=True)


@pytest.fixture
def document() -> Document:
    """A document with a frame, and a dot of another class in its hole."""
    one = accepted(Document(IMAGE), FRAME, (HERE,))
    return accepted(objects.classify_objects(one, (), 2), DOT, (THERE,))


def numbers(document: Document) -> list[int]:
    return [item.number for item in document.objects.items]


def test_what_is_taken_has_the_boundary_of_the_selection_and_a_number_of_its_own(document) -> None:
    frame, dot = document.objects.items
    assert (frame.number, dot.number) == (1, 2)
    assert [np.array(curve).tolist() for curve in frame.region.boundary] == [c.points.tolist() for c in FRAME.contours]
    assert (frame.clicks, frame.confidence, frame.strength, dot.category) == ((HERE,), 0.5, 3.0, 2)
    assert numbers(accepted(objects.delete_objects(document, (1,)), FRAME, (HERE,))) == [2, 3]


@pytest.mark.parametrize("confidence", [0.9146, 0.7, 0.696, 0.4996, 0.00449])
def test_an_object_is_as_likely_everywhere_as_the_selection_that_it_was(confidence) -> None:
    selection = selected((4.5, 25.5), confidence=confidence)
    item = objects.object_from_selection(selection, (HERE,), 1, 1)
    assert item.confidence == selection.confidence
    columns = {column.name: column for column in build_object_columns(SegmentedObjects((item,)))}
    cell = columns["confidence"].format_cell(ObjectRow(("object", 1), "object", "object 1", item), 1.0)
    assert cell == format_confidence(selection)
    assert (int(cell.split()[0]) >= 70) == is_likely(selection)


def test_rejected_objects_are_kept_and_leave_no_gap_in_the_numbers(document) -> None:
    offered = objects.object_from_selection(selected((30.5, 36.5)), (HERE,), 3, 1)
    left = objects.reject_objects(document, (2,), (offered,))
    assert numbers(left) == [1]
    assert left.objects.rejected == (document.objects[2], offered)
    again = accepted(accepted(left, FRAME, (HERE,)), FRAME, (THERE,))
    assert numbers(again) == [1, 2, 3]
    assert again.objects.rejected == left.objects.rejected
    assert objects.delete_objects(again, (2, 3)).objects.rejected == left.objects.rejected


def test_deleted_and_rejected_objects_are_dismissed_and_told_apart(document) -> None:
    first, second = document.objects.items
    left = objects.reject_objects(objects.delete_objects(document, (1,)), (2,), ()).objects
    assert (left.deleted, left.rejected) == ((first,), (second,))
    assert left.dismissed == (second, first)


def test_a_changed_object_keeps_its_number_name_and_class(document) -> None:
    named = objects.rename_objects(document, (2,), " dot ")
    changing = objects.set_selection_clicks(named, objects.initial_clicks(named.objects[2], IMAGE.shape), 2)
    assert (changing.objects.clicks, changing.objects.edited, changing.objects.category) == ((THERE,), 2, 2)
    changed = accepted(changing, FRAME, (THERE, HERE), 2)
    item = changed.objects[2]
    assert (item.name, item.category, len(item.region.boundary), item.clicks) == ("dot", 2, 2, (THERE, HERE))
    assert changed.objects.edited == 0


def test_voxels_that_clicks_select_keep_them_and_painted_ones_have_none() -> None:
    ball, clicks = np.linalg.norm(np.indices((9, 9, 9)) - 4.0, axis=0).T < 3.0, (Click(((4.0, 4.0, 4.0),)),)
    part = Selection(Region.from_mask(ball), ball.shape, np.full((1, 3), 4.0), np.empty((0, 3)))
    known = accepted(Document(ImageReference("a.nii", "a.nii", ball.shape, 1.0, (1.0,) * 3)), part, clicks)
    again = (*clicks, Click(((4.0, 4.0, 6.0),)))
    assert accepted(known, part, again, 1).objects[1].clicks == again
    painted = objects.accept_objects(known, (known.objects[1].redrawn(part.region),))
    assert accepted(painted, part, again, 1).objects[1].clicks == ()


def test_deleting_the_object_that_is_being_changed_ends_the_change(document) -> None:
    rest = objects.delete_objects(objects.set_selection_clicks(document, (HERE,), 2), (2,))
    assert (numbers(rest), rest.objects.edited, rest.objects.clicks) == ([1], 0, ())


def test_names_colors_classes_and_states_are_those_of_the_objects_given(document) -> None:
    changed = objects.update_objects(
        objects.update_objects(document, (1,), hidden=True, color="#123456"), (2,), frozen=True
    )
    frame, dot = changed.objects.items
    assert (frame.hidden, frame.frozen, dot.hidden, dot.frozen) == (True, False, False, True)
    assert (changed.objects.color_of(frame), changed.objects.color_of(dot)) == (
        "#123456",
        changed.objects.classes[1].color,
    )
    again = objects.classify_objects(changed, (1,), 3)
    assert again.objects.color_of(again.objects[1]) == again.objects.classes[2].color


def test_frozen_objects_are_barriers_of_a_run(document) -> None:
    assert document.regions is None
    frozen = objects.update_objects(document, (1,), frozen=True)
    assert len(frozen.regions.barriers) == 2
    assert frozen.regions.barriers[0][0] == frozen.regions.barriers[0][-1]


def test_the_start_from_an_object_is_its_outer_boundary(document) -> None:
    (shape,) = objects.add_objects_as_starts(document, (1,)).shapes
    assert isinstance(shape, Polygon)
    assert set(shape.points) == {tuple(corner) for corner in square(4.5, 25.5).tolist()}


def found_contours(*curves: Contour) -> Result:
    return boundaries_result((40, 40), "a.png", (0.5, 0.5), "mm", contours=tuple(curves))


RINGS = tuple(Contour(square(low, 40.0 - low), True, 3.0) for low in (3.5, 7.5, 11.5, 15.5))
"""Closed contours, each in the one before."""

FIBER = Contour(np.array([[1.0, 1.0], [1.0, 21.0]]), False, 2.0)


@pytest.mark.parametrize(
    ("copied", "holes"),
    [((0,), [1]), ((1,), [1]), ((3,), [0]), ((0, 1), [1]), ((0, 2), [1, 1]), ((0, 1, 2, 3), [1, 1])],
)
def test_copied_contours_are_objects_with_their_direct_holes(document, copied, holes) -> None:
    made = objects.copy_contours_to_objects(document.objects, found_contours(*RINGS), copied)
    assert [len(item.region.boundary) - 1 for item in made] == holes
    assert all(item.category == document.objects.category and not item.clicks for item in made)


def test_a_copied_open_contour_is_an_open_object_that_files_of_lines_hold_and_label_masks_leave_out(document) -> None:
    (fiber,) = objects.copy_contours_to_objects(document.objects, found_contours(*RINGS, FIBER), (4,))
    assert np.array(fiber.line).tolist() == FIBER.points.tolist()
    named = objects.rename_objects(objects.accept_objects(Document(IMAGE), (fiber,)), (1,), "fiber")
    result = objects.build_objects_result(named)
    text = to_bytes(result, ".geojson").decode()
    assert "LineString" in text and "fiber" in text
    both = objects.build_objects_result(objects.accept_objects(document, (fiber,)))
    assert paint_labels(both).max() == paint_labels(objects.build_objects_result(document)).max()


def test_an_open_object_is_a_stroke_or_a_barrier_of_the_next_run_and_no_region(document) -> None:
    (fiber,) = objects.copy_contours_to_objects(document.objects, found_contours(FIBER), (0,))
    whole = objects.accept_objects(Document(IMAGE), (fiber,))
    assert objects.add_objects_as_starts(whole, (1,)).shapes == (Stroke(fiber.line),)
    assert objects.add_objects_as_barriers(whole, (1,)).shapes == (Barrier(fiber.line),)
    assert objects.add_objects_as_regions(whole, (1,)).shapes == ()


def test_exported_labels_are_the_numbers_of_the_objects_and_holes_have_none(document) -> None:
    rest = objects.delete_objects(accepted(document, selected((30.5, 36.5)), (HERE,)), (2,))
    labels = paint_labels(objects.build_objects_result(rest))
    assert labels[7, 7] > 0
    assert labels[15, 15] == 0
    assert labels[33, 33] not in (0, labels[7, 7])


def test_an_export_names_the_objects_and_tells_what_was_bridged(document) -> None:
    result = objects.build_objects_result(objects.name_class(document, 2, "nucleus"))
    assert {contour.name for contour in result.contours} == {"object 1", "nucleus 2"}
    assert {contour.group for contour in result.contours} == {1, 2}
    assert [bridge.length for bridge in result.bridges] == [21.0, 7.0]
    text = to_bytes(result, ".geojson").decode()
    assert "nucleus 2" in text
    assert "ridged" in text
    assert "Net area mm^2" in text
    hidden = objects.update_objects(document, (1, 2), hidden=True)
    assert objects.build_objects_result(hidden) is None


def test_a_guard_counts_the_objects_that_are_not_saved() -> None:
    none = Document(IMAGE)
    two = accepted(accepted(none, FRAME, (HERE,)), selected((2.0, 3.5)), (THERE,))
    assert describe_changes(two, none) == ("2 objects",)
    assert describe_changes(objects.rename_objects(two, (2,), "spot"), two) == ("1 object",)
    assert describe_changes(objects.delete_objects(two, [1]), two) == ("the objects",)
