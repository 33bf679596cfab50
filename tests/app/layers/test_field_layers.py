"""Flow lines follow the field, are evenly spaced, and never cross; the potential is constant along its iso-lines."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.model.display.display_image import display_of_potential
from app.model.display.flow_lines import Seen, flow_lines
from app.model.display.iso_lines import LINES, iso_lines
from app.views.canvas.layers.fields import line_points
from cpm_core.segmentation.engine import Engine

pytestmark = pytest.mark.shared_window

SIDE = 120
ROW, COL = np.indices((SIDE, SIDE)) - (SIDE - 1) / 2
WHOLE = Seen(0.0, 0.0, SIDE - 1.0, SIDE - 1.0)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.0, 6.28), st.floats(8.0, 20.0))
def test_in_a_uniform_field_lines_are_straight_and_follow_its_direction(angle, spacing):
    way = np.array([np.sin(angle), np.cos(angle)])
    lines = flow_lines(np.broadcast_to(way[:, None, None], (2, SIDE, SIDE)), WHOLE, spacing)
    assert lines
    for line in lines:
        assert ((line >= 0) & (line <= SIDE - 1)).all()
        steps = np.diff(line, axis=0)
        steps /= np.linalg.norm(steps, axis=1, keepdims=True)
        assert steps == pytest.approx(np.broadcast_to(way, steps.shape), abs=1e-6)


def test_around_a_center_lines_are_circles():
    radius = np.hypot(ROW, COL) + 1e-9
    lines = flow_lines(np.stack([COL, -ROW]) / radius, WHOLE, 12.0)
    for line in lines:
        distance = np.hypot(*(line - (SIDE - 1) / 2).T)
        if distance.mean() > 20.0:
            # Euler's steps drift outwards, by half their square over the radius each
            assert np.ptp(distance) < 0.08 * distance.mean()
    assert len(lines) > 40


def test_no_two_lines_share_a_place():
    lines = flow_lines(np.stack([-ROW, -COL]), WHOLE, 10.0)
    cells = [set(map(tuple, (line[:-1] / (0.34 * 10.0)).astype(int))) for line in lines]
    for index, cell in enumerate(cells):
        for other in cells[:index]:
            assert not cell & other


def test_lines_lie_in_the_visible_part_and_there_are_none_without_a_field():
    field = np.ones((2, SIDE, SIDE))
    seen = Seen(30.0, 40.0, 70.0, 100.0)
    for line in flow_lines(field, seen, 6.0):
        assert ((line >= (30.0, 40.0)) & (line <= (70.0, 100.0))).all()
    assert flow_lines(np.zeros((2, SIDE, SIDE)), WHOLE, 6.0) == []
    assert flow_lines(field, Seen(500.0, 500.0, 600.0, 600.0), 6.0) == []


def test_lines_and_their_heads_are_not_connected():
    lines = [np.array([[0.0, 0.0], [0.0, 5.0], [0.0, 10.0]]), np.array([[3.0, 0.0], [8.0, 0.0]])]
    points, connected = line_points(lines, 2.0)
    pieces = np.split(points, np.flatnonzero(connected == 0)[:-1] + 1)
    assert [piece.tolist() for piece in pieces[:2]] == [line.tolist() for line in lines]
    assert pieces[2].tolist() == [[-1.0, 8.0], [0.0, 10.0], [1.0, 8.0]] or pieces[2].tolist() == [
        [1.0, 8.0],
        [0.0, 10.0],
        [-1.0, 8.0],
    ]
    assert pieces[3][1].tolist() == [8.0, 0.0]


def test_lines_of_equal_potential_of_a_bowl_are_circles():
    bowl = np.hypot(ROW, COL)
    points = iso_lines(bowl)
    ends = np.flatnonzero(np.isnan(points[:, 0]))
    assert ends[-1] == len(points) - 1
    levels = []
    for line in np.split(points, ends):
        known = line[np.isfinite(line[:, 0])]
        if len(known):
            distance = np.hypot(*(known - (SIDE - 1) / 2).T)
            assert np.ptp(distance) < 0.1
            levels.append(round(float(distance.mean()), 1))
    assert len(set(levels)) == LINES


def test_where_the_potential_is_higher_it_is_shown_no_darker():
    potential = ROW + 0.3 * COL
    shown = display_of_potential(potential).ravel()[np.argsort(potential, axis=None)]
    assert (np.diff(shown.astype(int)) >= 0).all()
    assert (shown[0], shown[-1]) == (0, 255)


def test_potential_and_flow_lines_are_shown_on_request(ready, hand):
    session, layers = ready.session, hand.canvas.layers
    potential, field = layers["potential"], layers["field"]
    ready.actions_by_name["layer_potential"].trigger()
    hand.wait(lambda: potential.shades is not None and potential.lined)
    parameters = session.document.parameters
    engine = Engine(session.image, parameters)
    assert np.array_equal(potential.shades, display_of_potential(engine.potential(parameters)))
    potential.choose("lines", False)
    hand.wait(lambda: not potential.lined and session.idle)
    assert potential.shades is not None
    ready.actions_by_name["layer_field"].trigger()
    hand.wait(lambda: len(field.drawn) > 0)
    arrows = field.drawn
    field.choose("way", "lines")
    lines = field.drawn
    assert not np.array_equal(lines, arrows)
    hand.canvas.zoom(3.0)
    hand.wait(lambda: not np.array_equal(field.drawn, lines))
    seen = hand.canvas.view.viewRect()
    inside = field.drawn[(field.drawn[:, 1] > seen.left() - 1) & (field.drawn[:, 1] < seen.right() + 1)]
    assert len(inside) == len(field.drawn)
    ready.actions_by_name["layer_potential"].trigger()
    assert potential.shades is None
