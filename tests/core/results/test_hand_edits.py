"""Edits of contours by hand, on circles and straight lines whose lengths and areas are known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.contours.contour import Bridge, Contour
from cpm_core.contours.hand_edits import HandEdit, apply_hand_edits
from cpm_core.results import apply_edits_to_result
from cpm_core.results.result import Result

RADIUS, CENTER = 20.0, 50.0
CIRCLE = 2.0 * np.pi * RADIUS


def on_circle(first, last, count=160, radius=RADIUS):
    """Points of a circle between two angles."""
    angle = np.linspace(first, last, count)
    return CENTER + radius * np.stack([np.sin(angle), np.cos(angle)], axis=1)


def at(angle, radius=RADIUS):
    return tuple(on_circle(angle, angle, 1, radius)[0].tolist())


def places(points):
    return tuple(map(tuple, points.tolist()))


def whole():
    return Contour(on_circle(0.0, 2.0 * np.pi, 401)[:-1], True)


def arc(first=0.3, last=2.0 * np.pi - 0.3):
    return Contour(on_circle(first, last), False)


CLOSE = HandEdit(added=places(on_circle(-0.3, 0.3, 20)), before=(at(-0.6),), after=(at(0.6),))


def line(*points):
    return Contour(np.array(points, dtype=float), False)


def test_a_piece_between_both_ends_closes_a_contour():
    (closed,), missed = apply_hand_edits([arc()], [CLOSE])
    assert closed.closed and missed == ()
    assert closed.length == pytest.approx(CIRCLE, rel=1e-3)
    assert closed.area == pytest.approx(np.pi * RADIUS**2, rel=1e-3)
    assert closed.length_by_hand == pytest.approx(0.6 * RADIUS, rel=1e-3)


def test_a_join_makes_one_contour_of_two():
    edit = HandEdit(added=((10.0, 20.0), (10.0, 30.0)), before=((10.0, 15.0),), after=((10.0, 35.0),))
    (one,), missed = apply_hand_edits([line((10, 0), (10, 20)), line((10, 50), (10, 30))], [edit])
    assert not one.closed and missed == ()
    assert one.length == pytest.approx(50.0) and one.length_by_hand == pytest.approx(10.0)
    assert np.ptp(one.points[:, 1]) == 50.0


def test_a_cut_closed_contour_is_open_and_as_long():
    (one,), missed = apply_hand_edits([whole()], [HandEdit(removed=(at(1.0),))])
    assert not one.closed and missed == () and one.length == pytest.approx(CIRCLE, rel=1e-3)
    np.testing.assert_allclose(one.points[[0, -1]], [at(1.0), at(1.0)], atol=0.01)


@settings(max_examples=30, deadline=None)
@given(st.floats(0.0, 6.0), st.floats(0.3, 3.0))
def test_a_deleted_stretch_is_gone_and_the_rest_stays(first, width):
    (rest,), missed = apply_hand_edits([whole()], [HandEdit(removed=places(on_circle(first, first + width)))])
    assert missed == () and not rest.closed
    assert rest.length == pytest.approx(CIRCLE - width * RADIUS, abs=0.1)
    assert np.linalg.norm(rest.points - at(first + 0.5 * width), axis=1).min() > 0.45 * width


def test_a_redrawn_stretch_takes_the_place_of_the_old_one():
    bulge = on_circle(-0.5, 0.5, 30, 1.2 * RADIUS)
    edit = HandEdit(places(on_circle(-0.5, 0.5)), places(bulge), False, (at(-0.9),), (at(0.9),))
    (one,), missed = apply_hand_edits([whole()], [edit])
    assert one.closed and missed == ()
    assert one.area == pytest.approx(np.pi * RADIUS**2 + 0.5 * (1.44 - 1.0) * RADIUS**2, rel=1e-2)
    np.testing.assert_allclose(np.linalg.norm(one.by_hand[0] - CENTER, axis=1).max(), 1.2 * RADIUS, rtol=1e-6)


def test_an_outline_takes_the_place_of_open_contours_along_it_and_of_nothing_else():
    """A piece of the outline that goes on elsewhere, one that crosses, one inside, and a closed neighbor."""
    leaving = Contour(np.concatenate([on_circle(0.0, 1.5, 60, RADIUS + 0.4), [[CENTER + 60.0, CENTER]]]), False)
    crossing = line((CENTER, CENTER), (CENTER, CENTER + 40))
    inside = Contour(on_circle(0.0, 3.0, 60, 0.5 * RADIUS), False)
    neighbor = Contour(on_circle(0.0, 6.2, 200, RADIUS + 0.3), True)
    everything = [leaving, crossing, inside, neighbor]
    found, _ = apply_hand_edits(everything, [HandEdit(added=places(whole().points), closed=True)])
    assert {crossing, inside, neighbor} <= set(found) and leaving not in found and len(found) == 5
    (rest,) = [one for one in found if not one.closed and one not in everything]
    assert rest.length == pytest.approx(60.0 - RADIUS, abs=3.0)


@settings(max_examples=40, deadline=None)
@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-2.0, 2.0))
def test_a_join_finds_its_contours_again_after_they_have_moved(down, right, longer):
    """A next run moves contours by about a pixel, and ends them some pixels earlier or later."""
    off = 0.5 * longer / RADIUS
    moved = Contour(on_circle(0.3 - off, 2.0 * np.pi - 0.3 + off) + np.array([down, right]), False)
    (one,), missed = apply_hand_edits([moved], [CLOSE])
    assert one.closed and missed == ()
    assert one.area == pytest.approx(np.pi * RADIUS**2, rel=0.03)


def test_nothing_is_added_where_a_later_run_has_closed_the_gap():
    contour = whole()
    assert apply_hand_edits([contour], [CLOSE]) == ((contour,), ())


def test_a_piece_stays_and_is_told_when_its_contours_are_gone():
    elsewhere = line((0, 0), (0, 30))
    found, missed = apply_hand_edits([elsewhere], [CLOSE])
    assert missed == (0,) and found[0] is elsewhere
    assert found[1].length == pytest.approx(0.6 * RADIUS, rel=1e-2) and found[1].length_by_hand == found[1].length


def test_edits_act_in_order_on_what_earlier_ones_have_made():
    cut = HandEdit(removed=(at(0.0),))
    (one, other), missed = apply_hand_edits([arc()], [CLOSE, cut, HandEdit(removed=(at(np.pi),))])
    assert missed == () and not one.closed and not other.closed
    assert one.length + other.length == pytest.approx(CIRCLE, rel=1e-3)


def test_a_deleted_stretch_takes_its_bridge_along():
    bridge = Bridge(on_circle(0.9, 1.1, 5), 4.0, 1.0)
    other = Bridge(on_circle(3.0, 3.1, 5), 2.0, 1.0)
    result = Result(np.empty((0, 2)), (whole(),), None, 1, True, "", (100, 100), (1.0, 1.0), None, "x", (bridge, other))
    edited, _ = apply_edits_to_result(result, [HandEdit(removed=places(on_circle(0.5, 1.5)))], None)
    assert edited.bridges == (other,)


@settings(max_examples=30, deadline=None)
@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.sampled_from(["deletion", "redrawing"]))
def test_a_stretch_is_found_again_after_its_contour_has_moved(down, right, kind):
    bulge = places(on_circle(-0.5, 0.5, 30, 1.2 * RADIUS)) if kind == "redrawing" else ()
    ties = {"before": (at(-0.9),), "after": (at(0.9),)} if bulge else {}
    moved = Contour(whole().points + np.array([down, right]), True)
    (one,), missed = apply_hand_edits([moved], [HandEdit(places(on_circle(-0.5, 0.5)), bulge, **ties)])
    assert missed == () and one.closed == (kind == "redrawing")
    assert np.linalg.norm(one.points - at(0.0), axis=1).min() > 3.0


# to a thousandth of a pixel, finer than any pointer: the square of a length of 1e-237 is zero
COORDINATE = st.floats(0.0, 60.0).map(lambda value: round(value, 3))
PLACE = st.tuples(COORDINATE, COORDINATE)
LINES = st.lists(PLACE, min_size=3, max_size=6, unique=True).map(tuple)
END = st.lists(PLACE, max_size=1).map(tuple)
EDITS = st.one_of(
    st.builds(HandEdit, removed=LINES | PLACE.map(lambda place: (place,))),
    st.builds(HandEdit, removed=LINES | st.just(()), added=LINES, before=END, after=END),
    st.builds(HandEdit, added=LINES, closed=st.just(True)),
)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(LINES, st.booleans()), max_size=4), st.lists(EDITS, max_size=5), st.integers(0, 3))
def test_whatever_is_edited_contours_remain_contours(drawn, edits, own):
    """Arbitrary lines, and edits of which some act on places of these lines."""
    found = [Contour(np.array(points), closed) for points, closed in drawn]
    if drawn:
        points = drawn[own % len(drawn)][0]
        edits = [*edits, HandEdit(removed=points[:2]), HandEdit(added=points[:2], before=points[:1], after=points[-1:])]
    edited, missed = apply_hand_edits(found, edits)
    assert all(0 <= number < len(edits) for number in missed)
    for contour in edited:
        assert np.isfinite(contour.points).all() and len(contour.points) >= (3 if contour.closed else 2)
        assert contour.length_by_hand <= contour.length + 1e-6
