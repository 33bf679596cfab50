"""Objects as a session keeps them: their measures by analytic truth, their limits, and the union of two."""

from __future__ import annotations

import math
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cpm_core.formats.sessions.session_file import SessionFile, load_session, save_session
from cpm_core.image.region import Region
from cpm_core.image.surface import Surface
from cpm_core.objects.segmented.areas import unite_objects
from cpm_core.objects.segmented.segmented_object import (
    Click,
    SegmentedObject,
    SegmentedObjects,
    contours_from_object,
)


def circle(row: float, col: float, radius: float, corners: int = 200) -> tuple[tuple[float, float], ...]:
    """Corners on a circle."""
    angle = 2.0 * np.pi * np.arange(corners) / corners
    return tuple(zip((row + radius * np.sin(angle)).tolist(), (col + radius * np.cos(angle)).tolist(), strict=True))


def made(*boundary, **parts) -> SegmentedObject:
    return SegmentedObject(parts.pop("number", 1), (Click(((20.0, 20.0),)),), Region(boundary), **parts)


RING = made(circle(20, 20, 12), circle(20, 20, 5))


def test_a_ring_has_the_area_and_the_perimeter_of_a_ring() -> None:
    assert RING.region.size == pytest.approx(math.pi * (144 - 25), rel=1e-3)
    assert RING.measure_perimeter() == pytest.approx(2 * math.pi * 17, rel=1e-3)
    assert RING.measure_perimeter((2.0, 2.0)) == pytest.approx(4 * math.pi * 17, rel=1e-3)
    assert RING.region.outer_curves == RING.region.boundary[:1]


@example(11.0, 0.0, 4.383081355689567)  # corners at the height of pixels, between two of the bands of `winds_around`
@given(st.floats(10.2, 30.2), st.floats(-4.0, 50.0), st.floats(1.0, 12.0))
def test_the_mask_holds_the_pixels_whose_centers_lie_inside(row: float, col: float, radius: float) -> None:
    item = made(circle(row, col, radius), circle(row, col, radius / 2))
    rows, cols = np.indices((40, 44))
    away = np.hypot(rows - row, cols - col)
    sure = np.minimum(np.abs(away - radius), np.abs(away - radius / 2)) > 0.01
    truth = (away < radius) & (away > radius / 2)
    np.testing.assert_array_equal(item.region.paste((40, 44))[sure], truth[sure])


def test_the_innermost_pixel_of_a_ring_lies_in_the_middle_between_its_boundaries() -> None:
    assert math.dist(RING.region.find_innermost_pixel((40, 44)), (20.0, 20.0)) == pytest.approx(8.5, abs=1.0)
    assert RING.region.encloses(np.array([RING.region.find_innermost_pixel((40, 44))])).all()


def test_the_innermost_voxel_lies_in_the_volume_and_without_any_it_is_a_vertex() -> None:
    tapered = np.zeros((6, 11, 11), bool)
    tapered[:4], tapered[4:, 3:8, 3:8] = True, True
    half = Region.from_mask(tapered, (-4, 0, 0))
    assert half.find_innermost_pixel((5, 20, 20)) == (0.0, 5.0, 5.0)
    corners = np.array([(0.0, 0.0, 0.0), (0.2, 0.0, 0.0), (0.0, 0.2, 0.0), (0.0, 0.0, 0.2)]) + 4.3
    speck = Region.from_surface(Surface(corners, np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])))
    assert speck.find_innermost_pixel((20, 20, 20)) == pytest.approx((4.3, 4.3, 4.3))


FAR = made(((-1e6, -1e6), (-1e6, 12.0), (1e6, 12.0), (1e6, -1e6)), number=2)
"""An object that reaches far beyond every image: all columns up to the twelfth."""


def test_an_object_that_reaches_far_beyond_an_image_takes_the_memory_of_the_image() -> None:
    tracemalloc.start()
    mask, (_, col) = FAR.region.paste((40, 44)), FAR.region.find_innermost_pixel((40, 44))
    whole = unite_objects(FAR, RING)
    largest = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert mask[:, :12].all()
    assert not mask[:, 13:].any()
    assert 3 <= col <= 8
    assert (whole.region.paste((40, 44)) != mask | RING.region.paste((40, 44))).sum() <= 8
    assert largest < 10e6


def test_frozen_objects_are_barriers_around_which_no_particle_gets() -> None:
    assert SegmentedObjects((RING,)).barriers == ()
    lines = SegmentedObjects((replace(RING, frozen=True),)).barriers
    assert [line[0] == line[-1] for line in lines] == [True, True]


def test_the_union_of_two_that_lie_apart_is_both() -> None:
    both = unite_objects(RING, made(circle(20, 50, 8), number=2))
    assert both.region.size == pytest.approx(RING.region.size + math.pi * 64, rel=0.01)
    assert len(both.region.boundary) == 3


@pytest.mark.parametrize("slit", [0.0, 0.5, 1.0])
def test_the_union_closes_the_slit_between_two_that_touch(slit: float) -> None:
    left, right = (((10.0, a), (10.0, a + 10.0), (30.0, a + 10.0), (30.0, a)) for a in (5.0, 15.0 + slit))
    whole = unite_objects(made(left), made(right, number=2))
    assert len(whole.region.boundary) == 1
    assert whole.region.size == pytest.approx(20.0 * (20.0 + slit), rel=0.02)


@given(st.floats(4.0, 12.0), st.floats(4.0, 12.0), st.floats(0.0, 30.0))
def test_the_union_covers_both_and_nothing_else(one: float, other: float, apart: float) -> None:
    first, second = made(circle(20, 20, one)), made(circle(20, 20 + apart, other), number=2)
    shape = (40, 70)
    found, truth = (
        unite_objects(first, second).region.paste(shape),
        first.region.paste(shape) | second.region.paste(shape),
    )
    assert (found != truth).sum() <= 8 + 0.02 * truth.sum()


def test_the_union_of_an_object_with_itself_is_that_object() -> None:
    assert unite_objects(RING, RING).region.size == pytest.approx(RING.region.size, rel=0.01)


LINE = SegmentedObject(3, (), line=((2.0, 2.0), (2.0, 12.0), (7.0, 12.0)))
"""An open object."""


def test_an_open_object_has_the_length_of_its_line_and_encloses_nothing() -> None:
    assert LINE.measure_perimeter() == pytest.approx(15.0)
    assert LINE.measure_perimeter((1.0, 0.5)) == pytest.approx(10.0)
    assert LINE.region.size == 0.0 and not LINE.region.paste((20, 20)).any()
    assert not LINE.region.encloses(np.array([(4.0, 10.0)])).any()
    assert [bound.tolist() for bound in LINE.box] == [[2.0, 2.0], [7.0, 12.0]]
    (contour,) = contours_from_object(LINE)
    assert not contour.closed and contour.points.tolist() == [list(place) for place in LINE.line]


def test_a_frozen_open_object_is_an_open_barrier() -> None:
    assert SegmentedObjects((replace(LINE, frozen=True),)).barriers == (LINE.line,)


@pytest.mark.parametrize("parts", [{"line": ((1.0, 1.0), (1.0, 1.0))}, {"line": LINE.line, "region": RING.region}, {}])
def test_an_object_is_a_line_or_closed_curves_and_not_less_than_either(parts) -> None:
    with pytest.raises(ValueError, match="object"):
        SegmentedObject(1, (), **parts)


def test_a_session_file_keeps_every_part_of_the_objects(tmp_path) -> None:
    item = replace(RING, gaps=(((1.0, 2.0), (3.5, 4.25)),), name="ring", color="#102030", frozen=True, hidden=True)
    objects = SegmentedObjects((item, LINE), clicks=(Click(((1.0, 2.0),), inside=False),), edited=1, category=4)
    save_session(SessionFile(objects=objects), tmp_path / "a.cpm")
    assert load_session(tmp_path / "a.cpm").objects == objects
