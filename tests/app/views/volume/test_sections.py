"""Slices, and the sections of shapes and surfaces by them."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.model.volume.shape_sections import cut_shape
from cpm_app.model.volume.slices import Slice
from cpm_app.model.volume.surface_section import cut_surface as lines_of
from hypothesis import assume, given
from hypothesis import strategies as st
from skimage.measure import marching_cubes

from cpm_core.image.surface import Surface
from cpm_core.shapes import (
    Barrier,
    Box,
    BoxRegion,
    Charge,
    Polygon,
    PrismRegion,
    Shape,
    Sphere,
    Stroke,
    Wall,
)

SQUARE = ((2.0, 3.0), (2.0, 9.0), (8.0, 9.0), (8.0, 3.0))
IN_SPACE: tuple[Shape, ...] = (
    Box((1.0, 2.0, 3.0), (7.0, 9.0, 12.0)),
    BoxRegion((1.0, 2.0, 3.0), (7.0, 9.0, 12.0)),
    PrismRegion(SQUARE, 1, 2.0, 11.0),
    Wall(SQUARE[:3], 2, 4.0, 10.0),
    Stroke(((1.0, 2.0, 3.0), (4.0, 8.0, 6.0), (9.0, 9.0, 9.0))),
    Polygon(((5.0, 2.0, 3.0), (5.0, 8.0, 6.0), (5.0, 2.0, 9.0))),
    Charge((5.0, 6.0, 7.0), -2.0),
)
"""One shape of each kind that a volume has besides spheres and points."""

pytestmark = pytest.mark.shared_window

axes, places = st.integers(0, 2), st.floats(-50, 50)
triples = st.tuples(places, places, places)


@given(axes, st.integers(0, 40), places, places)
def test_a_position_in_a_slice_is_found_again_in_the_volume(axis, index, row, col) -> None:
    here = Slice(axis, index)
    place = here.lift_position((row, col))
    assert place[axis] == index
    assert here.drop_axis(place) == (row, col)
    np.testing.assert_array_equal(here.project_points(np.array([place])), [(row, col)])


@given(triples, st.floats(1, 40), st.tuples(*[st.floats(1, 4)] * 3), axes, st.integers(-60, 60))
def test_the_section_of_a_sphere_lies_on_the_sphere(center, radius, sides, axis, index) -> None:
    sphere = Sphere(center, radius, sides)
    found = next(iter(cut_shape(sphere, Slice(axis, index))), None)
    assert found is not None or abs(index - center[axis]) * sides[axis] >= radius
    if found is not None and min(np.ptp(found.outline, axis=0)) > 1.0:  # the least radius that a shape has
        outline = [Slice(axis, index).lift_position(tuple(corner)) for corner in found.outline.tolist()]
        assert max(map(sphere.distance_to, outline)) < 1e-6 * (1 + radius + max(map(abs, center)))


def hollow_ball() -> Surface:
    away = np.linalg.norm(np.indices((30, 30, 30)) - 14.3, axis=0)
    vertices, faces, _, _ = marching_cubes(np.minimum(11.2 - away, away - 5.1), 0.0)
    return Surface(vertices, faces)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_slice_cuts_a_closed_surface_in_closed_lines_that_lie_on_it(axis) -> None:
    surface, center = hollow_ball(), np.array([14.3, 14.3])
    for index, radii in ((14, [5.1, 11.2]), (22, [8.1]), (2, []), (29, [])):
        found = lines_of(surface, Slice(axis, index))
        assert all(line.closed for line in found)
        sizes = sorted(float(np.linalg.norm(line.points - center, axis=1).mean()) for line in found)
        assert sizes == pytest.approx([r if len(radii) > 1 else np.sqrt(11.2**2 - 7.7**2) for r in radii], abs=0.1)


def test_a_surface_with_a_rim_is_cut_in_an_open_line() -> None:
    whole = hollow_ball()
    half = whole.faces[(whole.vertices[whole.faces][:, :, 2] < 14).all(axis=1)]
    found = lines_of(Surface(whole.vertices, half), Slice(0, 14))
    assert len(found) == 2
    assert not any(line.closed for line in found)


def test_vertices_in_the_slice_leave_no_gap() -> None:
    row, col = np.indices((5, 5)).reshape(2, -1)
    upright = np.stack([row, np.full(25, 2), col], axis=1).astype(float)
    corners = [(i * 5 + j, i * 5 + j + 1, (i + 1) * 5 + j) for i in range(4) for j in range(4)]
    corners += [(i * 5 + j + 1, (i + 1) * 5 + j + 1, (i + 1) * 5 + j) for i in range(4) for j in range(4)]
    (line,) = lines_of(Surface(upright, np.array(corners)), Slice(0, 2))
    assert line.length == pytest.approx(4.0)


@given(axes, triples, triples, st.integers(-60, 60))
def test_a_slice_shows_of_a_box_the_rectangle_between_its_faces(axis, one, other, index) -> None:
    low, high = np.sort([one, other], axis=0)
    high = np.maximum(high, low + 1.0)
    inside = low[axis] <= index <= high[axis]
    assume(inside or not low[axis] - 1 <= index <= high[axis] + 1)
    for kind in (Box, BoxRegion):
        found = cut_shape(kind(tuple(low), tuple(high)), Slice(axis, index))
        assert len(found) == (inside or kind is BoxRegion), "a region that the slice does not cut leaves nothing of it"
        assert all(bool(len(cut.outline)) == inside for cut in found)
        for cut in found if inside else ():
            expected = np.delete([low, high], axis, axis=1)
            np.testing.assert_allclose([np.min(cut.outline, axis=0), np.max(cut.outline, axis=0)], expected)


@pytest.mark.parametrize("kind", [Box, BoxRegion])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_handles_of_a_box_move_the_faces_that_they_lie_on(kind, axis) -> None:
    box = kind((10.0, 20.0, 30.0), (16.0, 28.0, 40.0))
    here = Slice(axis, (12, 25, 36)[axis])
    (cut,) = cut_shape(box, here)
    for handle in cut.handles():
        for by in ((3.0, 0.0), (-2.0, 5.0), (50.0, -50.0)):
            place, to = here.lift_position(handle), here.lift_position(tuple(np.add(handle, by).tolist()))
            changed = box.with_handle_at(place, to)
            moved = set()
            for name in ("first", "last"):
                for along in np.flatnonzero(np.subtract(getattr(changed, name), getattr(box, name))).tolist():
                    moved.add(along)
            assert axis not in moved, "a slice moves only what it shows"
            ends = zip(place, box.first, box.last, strict=True)
            held = {along for along, (at, low, high) in enumerate(ends) if min(abs(at - low), abs(at - high)) < 1e-9}
            assert moved <= held
            assert min(np.subtract(changed.last, changed.first)) >= 1.0


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_what_is_drawn_through_slices_is_a_line_in_its_own_and_strips_in_the_others(axis) -> None:
    others = [other for other in range(3) if other != axis]
    region, wall = PrismRegion(SQUARE, axis, 2.0, 11.0), Wall(SQUARE[:3], axis, 2.0, 11.0)
    (cut,), (line,) = cut_shape(region, Slice(axis, 5)), cut_shape(wall, Slice(axis, 5))
    np.testing.assert_array_equal(cut.outline, [*SQUARE, SQUARE[0]])
    assert line == Barrier(SQUARE[:3])
    assert cut_shape(wall, Slice(axis, 14)) == ()
    assert not len(cut_shape(region, Slice(axis, 14))[0].outline)
    for along, across in (others, others[::-1]):
        at = 5.0  # where both are cut
        (strip,) = cut_shape(region, Slice(along, at))
        low, high = np.min(strip.outline, axis=0), np.max(strip.outline, axis=0)
        expected = {axis: (2.0, 11.0), across: (3.0, 9.0) if across == others[1] else (2.0, 8.0)}
        shown = sorted((axis, across))
        np.testing.assert_allclose(np.stack([low, high], axis=1), [expected[one] for one in shown])
        here = Slice(along, int(at))
        handle = here.lift_position(strip.handles()[1])
        to = tuple(7.0 if one == axis else value for one, value in enumerate(handle))
        assert region.with_handle_at(handle, to).last == 7.0


def test_a_charge_is_seen_where_it_acts_and_held_where_it_lies() -> None:
    charge = Charge((20.0, 30.0, 40.0), 2.0)
    (here,), (near,) = cut_shape(charge, Slice(0, 20)), cut_shape(charge, Slice(0, 26))
    assert here.distance_to((30.0, 40.0)) == 0.0
    assert near.distance_to((30.0, 40.0)) == np.inf
    assert cut_shape(charge, Slice(0, 40)) == ()
