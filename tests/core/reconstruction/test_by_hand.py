"""Live wires, and curves redrawn with them, on a disk whose boundary is known."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.contours.contour import Contour
from cpm_core.field.scale_field import build_scale_field
from cpm_core.reconstruction.by_hand.live_wire import LiveWire, snap_place_to_ridge
from cpm_core.reconstruction.by_hand.redrawing import CurvePlace, pull_curve, replace_stretch
from tests.core.scenes import circle_points, disk

SHAPE, CENTER, RADIUS = (100, 120), (48.3, 60.7), 30.2
AREA = np.pi * RADIUS**2


@cache
def field():
    return build_scale_field(disk(SHAPE, CENTER, RADIUS).values, 1.0, 0.0)


def at(angle, radius=RADIUS):
    return CENTER[0] + radius * np.sin(angle), CENTER[1] + radius * np.cos(angle)


def arc(first, last):
    angle = np.linspace(first, last, 8 + int(RADIUS * abs(last - first)))
    return Contour(np.stack(at(angle), axis=1), False)


def whole():
    return Contour(circle_points(CENTER, RADIUS, 190), True)


def off_circle(points):
    return np.abs(np.hypot(*(points - CENTER).T) - RADIUS)


def place_on(curve, angle, radius=RADIUS):
    return CurvePlace.from_nearest_place(curve, at(angle, radius))


def area(curve):
    return Contour(curve.points, True).area


@settings(max_examples=25, deadline=None)
@given(st.floats(0.0, 6.28), st.floats(0.2, 2.6))
def test_a_live_wire_follows_the_edge_between_two_places_on_it(first, width):
    path = LiveWire(field(), at(first)).path_to(at(first + width))
    np.testing.assert_allclose(path[[0, -1]], [at(first), at(first + width)])
    assert off_circle(path).max() < 0.15
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).sum() == pytest.approx(width * RADIUS, rel=0.02, abs=0.1)


def test_a_wire_does_not_run_back_along_a_line_that_it_avoids():
    """The way back along the edge found is the cheaper one where the gap is faint."""
    drawn = arc(0.5, 2.0 * np.pi).points
    wire = LiveWire(field(), tuple(drawn[0].tolist()), [drawn], [tuple(drawn[-1].tolist())])
    path = wire.path_to(tuple(drawn[-1].tolist()))
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).sum() < 0.6 * RADIUS


def test_a_place_snaps_to_an_edge_only_within_reach():
    assert off_circle(np.array([snap_place_to_ridge(at(1.0, RADIUS + 1.5), field(), 4.0)])).max() < 0.15
    assert snap_place_to_ridge(CENTER, field(), 4.0) == CENTER


@settings(max_examples=25, deadline=None)
@given(st.floats(0.0, 6.28), st.floats(-20.0, 20.0))
def test_the_nearest_place_of_a_curve_is_as_near_as_any_sample_of_it(angle, aside):
    curve, to = whole(), at(angle, RADIUS + aside)
    place = CurvePlace.from_nearest_place(curve, to)
    samples = np.linspace(curve.path[:-1], curve.path[1:], 20).reshape(-1, 2)
    assert place.distance_to(to) <= np.linalg.norm(samples - to, axis=1).min() + 1e-9
    assert place.distance_to(to) == pytest.approx(abs(aside), abs=0.02)


@pytest.mark.parametrize("middle", [0.0, 1.3, 3.1, 6.2])
@pytest.mark.parametrize("turned", [False, True])
def test_a_path_between_two_places_takes_the_place_of_the_nearer_stretch(middle, turned):
    angle = middle + np.linspace(0.4, -0.4, 30)[:: -1 if turned else 1]
    path = np.stack(at(angle, RADIUS + 6.0 * np.cos(np.pi * (angle - middle) / 0.8)), axis=1)
    curve = whole()
    ends = (CurvePlace.from_nearest_place(curve, tuple(path[n].tolist())) for n in (0, -1))
    redrawn = replace_stretch(*ends, path)
    assert redrawn.closed and area(redrawn) == pytest.approx(AREA + 6.0 * RADIUS * 0.8 * 2.0 / np.pi, abs=30.0)
    assert off_circle(redrawn.points).max() == pytest.approx(6.0, abs=0.1)
    assert redrawn.length < 2.0 * np.pi * RADIUS + 8.0


def test_a_stretch_of_an_open_curve_is_replaced_and_its_ends_stay():
    curve = arc(0.0, 3.0)
    chord = np.array([at(2.0), at(1.0)])
    redrawn = replace_stretch(place_on(curve, 2.0), place_on(curve, 1.0), chord)
    assert not redrawn.closed
    np.testing.assert_allclose(redrawn.points[[0, -1]], curve.points[[0, -1]])
    assert redrawn.length == pytest.approx(2.0 * RADIUS + 2.0 * RADIUS * np.sin(0.5), rel=2e-3)


def test_a_stretch_beside_the_edge_snaps_to_it_when_it_is_pulled_there():
    """A curve that runs straight across a part of the disk is pulled onto its boundary."""
    chord = np.linspace(at(0.45), at(-0.45), 20)[1:-1]
    curve = Contour(np.concatenate([arc(0.45, 2.0 * np.pi - 0.45).points, chord[::-1]]), True)
    held = CurvePlace.from_nearest_place(curve, tuple(chord[9].tolist()))
    assert off_circle(curve.points).max() > 2.5
    redrawn = pull_curve(held, at(0.0, RADIUS + 1.0), field())
    assert redrawn.closed and area(redrawn) == pytest.approx(AREA, rel=5e-3)


@pytest.mark.parametrize("angle", [0.0, 2.0, 6.2])
def test_without_edges_a_pulled_stretch_bends_to_the_place(angle):
    redrawn = pull_curve(place_on(whole(), angle), at(angle, RADIUS + 10.0))
    assert redrawn.closed
    assert np.linalg.norm(redrawn.points - at(angle, RADIUS + 10.0), axis=1).min() < 0.5
    assert off_circle(redrawn.points).max() == pytest.approx(10.0, abs=0.2)


@pytest.mark.parametrize("snapping", [False, True])
@pytest.mark.parametrize("end", [0, -1])
def test_the_end_of_an_open_curve_moves_when_it_is_pulled(snapping, end):
    curve, to = arc(0.5, 2.5), at(0.3 if end == 0 else 2.7)
    held = CurvePlace.from_nearest_place(curve, tuple(curve.points[end].tolist()))
    redrawn = pull_curve(held, to, field() if snapping else None)
    assert not redrawn.closed
    np.testing.assert_allclose(redrawn.points[end], to, atol=0.3)
    np.testing.assert_allclose(redrawn.points[-1 - end], curve.points[-1 - end])
    if snapping:
        assert off_circle(redrawn.points).max() < 0.3
        assert redrawn.length == pytest.approx(2.2 * RADIUS, rel=0.02)
