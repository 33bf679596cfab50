"""Edits are pure: they make the next document and do not change the one before."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.model.document.document import Document
from cpm_app.model.parameters.controls import build_controls, control_value, slider_range
from hypothesis import given
from hypothesis import strategies as st

from cpm_core.parameters import Parameters
from cpm_core.shapes import SEEDING_KINDS, Barrier, Circle, Everywhere, Points, PolygonRegion, Shape, Stroke

coordinates = st.floats(-200, 200, allow_nan=False)
positions = st.tuples(coordinates, coordinates)
circles = st.builds(Circle, positions, st.floats(1, 100))
points = st.builds(Points, st.lists(positions, min_size=1, max_size=5).map(tuple))
lines = st.lists(positions, min_size=3, max_size=5, unique=True).map(tuple)
shapes = st.one_of(circles, points, *(st.builds(kind, lines) for kind in (Stroke, PolygonRegion, Barrier)))


@given(st.lists(shapes, max_size=4), shapes)
def test_deleting_what_was_added_gives_the_document_before(drawn: list[Shape], shape: Shape) -> None:
    before = Document(shapes=tuple(drawn))
    after = edits.add_shape(before, shape)
    assert after.shapes == (*drawn, shape)
    assert before.shapes == tuple(drawn)
    assert edits.delete_shape(after, len(drawn)) == before


@given(circles, positions)
def test_a_moved_circle_keeps_its_radius_and_a_resized_one_its_center(circle: Circle, by: tuple[float, float]) -> None:
    document = Document(shapes=(circle,))
    moved = edits.move_shape(document, 0, by).shapes[0]
    assert isinstance(moved, Circle)
    assert moved.radius == circle.radius
    assert moved.center == (circle.center[0] + by[0], circle.center[1] + by[1])
    resized = circle.with_handle_at(circle.handles()[0], (circle.center[0] + 30.0, circle.center[1] + 40.0))
    assert isinstance(resized, Circle)
    assert resized.center == circle.center
    assert resized.radius == pytest.approx(50.0)


def test_every_kind_of_start_gives_seeds_and_no_limit_does() -> None:
    line = ((10.0, 10.0), (10.0, 30.0))
    image_seeds = {Everywhere("grid"): np.array([[1.0, 1.0], [9.0, 9.0]])}
    document = Document(shapes=(Barrier(line), Stroke(line), PolygonRegion((*line, (40.0, 30.0))), Everywhere("grid")))
    assert document.starts == (Stroke(line), Everywhere("grid"))
    seeds = document.collect_seeds(image_seeds)
    assert seeds[-2:].tolist() == image_seeds[Everywhere("grid")].tolist()
    stroke = seeds[:-2]
    assert (stroke[:, 0] == 10.0).all()
    assert np.diff(stroke[:, 1]) == pytest.approx(2.0, abs=0.2)


@given(st.lists(shapes, max_size=4), st.sampled_from(SEEDING_KINDS))
def test_starting_everywhere_twice_over_is_starting_nowhere(drawn: list[Shape], kind) -> None:
    before = Document(shapes=tuple(drawn))
    once = edits.toggle_everywhere(before, kind)
    assert once.image_starts == (Everywhere(kind),)
    assert edits.toggle_everywhere(once, kind) == before


@given(st.lists(shapes, max_size=5))
def test_regions_and_barriers_of_the_document_are_those_drawn_in_their_order(drawn: list[Shape]) -> None:
    regions = Document(shapes=tuple(drawn)).regions
    interest = tuple(shape.points for shape in drawn if isinstance(shape, PolygonRegion))
    barriers = tuple(shape.points for shape in drawn if isinstance(shape, Barrier))
    assert (regions.interest, regions.barriers) == (interest, barriers) if regions else not (interest or barriers)


@given(st.floats(0.05, 0.99), st.floats(0.1, 3.0))
def test_the_ratio_sets_w1_and_survives_a_change_of_w2(ratio: float, w2: float) -> None:
    document = edits.set_parameter(Document(), "ratio", ratio)
    assert document.parameters.w2 == Parameters().w2
    assert document.parameters.w1 == pytest.approx(ratio * Parameters().w2)
    document = edits.set_parameter(document, "w2", w2)
    assert document.parameters.w2 == w2
    assert control_value(document.parameters, "ratio") == pytest.approx(ratio)


@pytest.mark.parametrize("control", build_controls(), ids=lambda control: control.name)
def test_every_control_shows_its_default_and_takes_both_ends_of_its_slider(control) -> None:
    assert control_value(Parameters(), control.name) == pytest.approx(control.default)
    assert control.meaning.endswith(".")
    assert control.effect_of_larger.endswith(".")
    for value in (control.slider_low, control.slider_high):
        changed = edits.set_parameter(Document(), control.name, value)
        assert control_value(changed.parameters, control.name) == pytest.approx(value)


@pytest.mark.parametrize("control", build_controls(), ids=lambda control: control.name)
def test_sliders_in_gray_levels_go_with_the_contrast_of_the_image_and_no_others(control) -> None:
    plain = (control.slider_low, control.slider_high)
    half, full, twice = (slider_range(control, contrast) for contrast in (127.5, 255.0, 510.0))
    assert full == pytest.approx(plain)
    if "gray" in control.unit:
        assert (half[1], twice[1]) == pytest.approx((0.5 * full[1], 2.0 * full[1]))
    else:
        assert half == twice == plain
