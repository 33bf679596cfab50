"""Live wires and edits made with them, on a disk whose boundary is known."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.contours.contour import Contour
from cpm_core.contours.hand_edits import apply_hand_edits
from cpm_core.field.scale_field import build_scale_field
from cpm_core.reconstruction.by_hand.live_wire import LiveWire, snap_place_to_ridge
from cpm_core.reconstruction.by_hand.operations import (
    Contact,
    chain_contours,
    connect_by_path,
    cut_contour,
    delete_stretch,
    live_wire_from,
    pull_contour,
)
from cpm_core.results import apply_edits_to_result
from cpm_core.results.result import Result
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


def ends(contour):
    return Contact.from_contour_ends(contour)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.0, 6.28), st.floats(0.2, 2.6))
def test_a_live_wire_follows_the_edge_between_two_places_on_it(first, width):
    path = LiveWire(field(), at(first)).path_to(at(first + width))
    np.testing.assert_allclose(path[[0, -1]], [at(first), at(first + width)])
    assert off_circle(path).max() < 0.15
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).sum() == pytest.approx(width * RADIUS, rel=0.02, abs=0.1)


def test_a_place_snaps_to_an_edge_only_within_reach():
    assert off_circle(np.array([snap_place_to_ridge(at(1.0, RADIUS + 1.5), field(), 4.0)])).max() < 0.15
    assert snap_place_to_ridge(CENTER, field(), 4.0) == CENTER


@settings(max_examples=15, deadline=None)
@given(st.floats(0.0, 6.28), st.floats(0.1, 1.5))
def test_a_contour_with_a_gap_is_closed_along_the_edge(first, gap):
    open_one = arc(first + gap, first + 2.0 * np.pi)
    (edit,) = chain_contours(field(), [open_one], closing=True)
    (closed,), missed = apply_hand_edits([open_one], [edit])
    assert closed.closed and missed == ()
    assert closed.area == pytest.approx(AREA, rel=3e-3) and off_circle(closed.points).max() < 0.15


def test_a_wire_does_not_run_back_along_its_own_contour():
    """The way back along the edge found is the cheaper one where the gap is faint."""
    open_one = arc(0.5, 2.0 * np.pi)
    begin, end = ends(open_one)
    path = live_wire_from(field(), begin).path_to(end.place)
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).sum() < 0.6 * RADIUS


def test_pieces_are_chained_by_their_nearest_ends_in_whatever_order_and_direction():
    pieces = [arc(4.3, 6.1), arc(2.0, 0.1), arc(2.3, 4.0)]
    edits = chain_contours(field(), pieces, closing=True)
    (closed,), missed = apply_hand_edits(pieces, edits)
    assert len(edits) == 3 and closed.closed and missed == ()
    assert closed.area == pytest.approx(AREA, rel=3e-3)


def test_from_an_end_to_its_own_side_a_contour_is_closed_and_the_rest_stays():
    """An outline that goes on along a neighbor: the loop is closed, the tail remains."""
    tail = np.array([at(0.0, RADIUS + away) for away in (20.0, 10.0)])
    contour = Contour(np.concatenate([tail, arc(0.0, 6.1).points]), False)
    last = ends(contour)[1]
    side = Contact.from_nearest_place(contour, at(0.0))
    found, missed = apply_hand_edits(
        [contour], connect_by_path(LiveWire(field(), last.place).path_to(side.place), last, side)
    )
    assert missed == () and [one.closed for one in found] == [True, False]
    assert found[0].area == pytest.approx(AREA, rel=3e-3) and found[1].length == pytest.approx(20.0, abs=0.1)


def test_a_path_to_the_side_of_another_contour_ends_on_a_junction():
    other = Contour(np.array([[5.0, 5.0], [5.0, 100.0]]), False)
    first = Contour(np.array([[40.0, 40.0], [20.0, 40.0]]), False)
    end = ends(first)[1]
    found, missed = apply_hand_edits(
        [first, other],
        connect_by_path(np.array([end.place, (5.0, 40.0)]), end, Contact.from_nearest_place(other, (5.0, 40.0))),
    )
    assert missed == () and other in found
    grown = next(one for one in found if one is not other)
    assert grown.length == pytest.approx(35.0) and grown.junctions == (False, True)


def test_a_path_between_two_sides_takes_the_place_of_the_nearer_stretch():
    angle = np.linspace(0.4, -0.4, 30)
    path = np.stack(at(angle, RADIUS + 6.0 * np.cos(np.pi * angle / 0.8)), axis=1)
    contour = whole()
    edits = connect_by_path(
        path, Contact.from_nearest_place(contour, path[0]), Contact.from_nearest_place(contour, path[-1])
    )
    (one,), missed = apply_hand_edits([contour], edits)
    assert missed == () and one.closed and one.area > AREA + 50.0
    assert off_circle(one.points).max() == pytest.approx(6.0, abs=0.1)


def test_a_cut_is_made_at_the_place_on_the_contour():
    contour = arc(0.0, 3.0)
    found, _ = apply_hand_edits([contour], [cut_contour(Contact.from_nearest_place(contour, at(1.0, RADIUS + 3.0)))])
    assert [one.length for one in found] == pytest.approx([2.0 * RADIUS, RADIUS], rel=2e-3)


@pytest.mark.parametrize("angles", [(0.2, 1.2), (1.2, 0.2), (6.0, 0.3)])
def test_of_a_closed_contour_the_shorter_stretch_is_deleted(angles):
    contour = whole()
    one, other = (Contact.from_nearest_place(contour, at(angle)) for angle in angles)
    (rest,), _ = apply_hand_edits([contour], [delete_stretch(one, other)])
    width = abs(angles[0] - angles[1]) % (2.0 * np.pi)
    assert rest.length == pytest.approx(RADIUS * max(width, 2.0 * np.pi - width), rel=2e-3)


def test_a_stretch_beside_the_edge_snaps_to_it_when_it_is_pulled_there():
    """A contour that runs straight across a part of the disk is pulled onto its boundary."""
    chord = np.linspace(at(0.45), at(-0.45), 20)[1:-1]
    contour = Contour(np.concatenate([arc(0.45, 2.0 * np.pi - 0.45).points, chord[::-1]]), True)
    held = Contact.from_nearest_place(contour, chord[9])
    assert off_circle(contour.points).max() > 2.5
    (one,), missed = apply_hand_edits([contour], [pull_contour(held, at(0.0, RADIUS + 1.0), field())])
    assert missed == () and one.closed and one.area == pytest.approx(AREA, rel=5e-3)


def test_without_edges_a_pulled_stretch_bends_to_the_place():
    contour = whole()
    (one,), missed = apply_hand_edits(
        [contour], [pull_contour(Contact.from_nearest_place(contour, at(0.0)), at(0.0, RADIUS + 10.0))]
    )
    assert missed == () and one.closed
    assert np.linalg.norm(one.points - at(0.0, RADIUS + 10.0), axis=1).min() < 0.5
    assert off_circle(one.points).max() == pytest.approx(10.0, abs=0.2)


def test_changed_contours_have_the_strength_of_the_edge_below_them():
    open_one = arc(0.4, 2.0 * np.pi)
    result = Result(np.empty((0, 2)), (open_one,), None, 1, True, "", SHAPE, (1.0, 1.0), None, "")
    (closed,) = apply_edits_to_result(result, chain_contours(field(), [open_one], closing=True), field())[0].contours
    assert closed.strength == pytest.approx(field().strength_at(whole().points).mean(), rel=0.02)
    assert closed.contrast > 0.5
