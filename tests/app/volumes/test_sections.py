"""Slices, and the sections of shapes and surfaces by them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from skimage.measure import marching_cubes

from app.model.volume.slices import Slice, Slices
from app.model.volume.surface_section import section as lines_of
from cpm_core.contours.surface import Surface
from cpm_core.formats.sessions.plain_values import shape_from_plain, shape_to_plain
from cpm_core.shapes import Circle, Points, Sphere
from cpm_core.shapes.sections import section

pytestmark = pytest.mark.shared_window

axes, places = st.integers(0, 2), st.floats(-50, 50)
triples = st.tuples(places, places, places)


@given(axes, st.integers(0, 40), places, places)
def test_a_position_in_a_slice_is_found_again_in_the_volume(axis, index, row, col) -> None:
    here = Slice(axis, index)
    place = here.lifted((row, col))
    assert place[axis] == index
    assert here.within(place) == (row, col)
    np.testing.assert_array_equal(here.flattened(np.array([place])), [(row, col)])


@given(axes, st.integers(-100, 100))
def test_slices_stay_in_the_volume(axis, index) -> None:
    slices = Slices.of((5, 6, 7)).turned(axis).at(index)
    assert 0 <= slices.current.index < slices.count
    assert all(slices.across(other).index == (5, 6, 7)[other] // 2 for other in range(3) if other != axis)


@given(triples, st.floats(1, 40), st.tuples(*[st.floats(1, 4)] * 3), axes, st.integers(-60, 60))
def test_the_section_of_a_sphere_lies_on_the_sphere(center, radius, sides, axis, index) -> None:
    sphere = Sphere(center, radius, sides)
    found = section(sphere, axis, index)
    if found is None:
        assert abs(index - center[axis]) * sides[axis] >= radius
        return
    if min(found.radii) > 0.5:  # the least radius that a shape has
        outline = [Slice(axis, index).lifted(tuple(corner)) for corner in found.outline.tolist()]
        assert max(map(sphere.distance, outline)) < 1e-6 * (1 + radius + max(map(abs, center)))


@given(triples, st.floats(1, 40), triples)
def test_a_sphere_passes_through_the_place_that_its_handle_is_dragged_to(center, radius, to) -> None:
    dragged = Sphere(center, radius).with_handle_at(center, to)
    assert dragged.center == center
    assert dragged.distance(to) == pytest.approx(0.0, abs=1.0 + 1e-9)  # a sphere is not smaller than a voxel


@given(triples, triples, st.floats(1, 40))
def test_a_sphere_moves_with_its_particles(center, by, radius) -> None:
    sphere = Sphere(center, radius)
    np.testing.assert_allclose(sphere.moved(by).seeds(), sphere.seeds() + np.array(by), atol=1e-9)


@pytest.mark.parametrize("shape", [Sphere((1.0, 2.0, 3.0), 4.0, (2.0, 1.0, 1.0)), Points(((1.0, 2.0, 3.0),)),
                                   Points(((1.0, 2.0),)), Circle((1.0, 2.0), 3.0)])  # fmt: skip
def test_shapes_of_images_and_of_volumes_are_read_as_they_were_written(shape) -> None:
    assert shape_from_plain(shape_to_plain(shape), "shape 1") == shape


@pytest.mark.parametrize(
    "plain",
    [
        {"shape": "sphere", "center": [1.0, 2.0], "radius": 3.0},
        {"shape": "circle", "center": [1.0, 2.0, 3.0], "radius": 3.0},
        {"shape": "points", "positions": [[1.0, 2.0, 3.0, 4.0]]},
        {"shape": "points", "positions": [[1.0, 2.0], [1.0, 2.0, 3.0]]},
        {"shape": "polygon", "points": [[1.0, 2.0, 0.0], [3.0, 4.0, 0.0], [5.0, 0.0, 0.0]]},
    ],
)
def test_a_shape_with_too_few_or_too_many_numbers_is_refused(plain) -> None:
    with pytest.raises(ValueError, match="shape 1"):
        shape_from_plain(plain, "shape 1")


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
