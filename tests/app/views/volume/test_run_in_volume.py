"""Starts are drawn in slices and run in the volume, by mouse and keys."""

from __future__ import annotations

import math

import numpy as np
import pytest
from PySide6.QtCore import Qt

from cpm_core.shapes import Everywhere, Sphere

pytestmark = pytest.mark.shared_window

KEY, CONTROL = Qt.Key, Qt.KeyboardModifier.ControlModifier
PIXEL = 0.5


def sphere_of(window) -> Sphere:
    (sphere,) = window.session.document.shapes
    assert isinstance(sphere, Sphere)
    return sphere


def section_of(window):
    """The only shape that the slice shows."""
    (section,) = window.canvas_area.canvas.drawn_scene.document.shapes
    return section


def test_a_drag_draws_a_sphere_that_each_slice_shows_as_its_circle(volume, hand) -> None:
    hand.drag((14, 16), (14, 18), (14, 22))
    sphere = sphere_of(volume)
    assert sphere.center == pytest.approx((12, 14, 16), abs=PIXEL)
    assert sphere.radius == pytest.approx(6, abs=PIXEL)
    assert volume.session.selected_shape == 0
    for off in (0, 3, -3):
        volume.workspace.slices.go_to(12 + off)
        section = section_of(volume)
        away = np.linalg.norm(section.outline - sphere.center[1:], axis=1)
        assert away == pytest.approx(math.sqrt(sphere.radius**2 - off**2))
    volume.workspace.slices.go_to(12 + 8)
    assert volume.canvas_area.canvas.drawn_scene.document.shapes == ()
    assert volume.canvas_area.canvas.drawn_scene.selected_shape is None


def test_a_sphere_is_moved_and_resized_in_any_slice_that_cuts_it(volume, hand) -> None:
    hand.drag((14, 16), (14, 18), (14, 22))
    before = sphere_of(volume)
    volume.workspace.slices.go_to(15)
    row, col = section_of(volume).handles()[0]
    hand.drag((row, col), (row, col + 1), (row, col + 3))
    grown = sphere_of(volume)
    assert grown.center == before.center
    radius = 0.5 * np.ptp(section_of(volume).outline[:, 1])
    assert radius == pytest.approx(math.sqrt(before.radius**2 - 9) + 3, abs=PIXEL)
    hand.key(KEY.Key_S)
    hand.drag((14, 16), (15, 16), (17, 18))
    moved = sphere_of(volume)
    assert moved.radius == grown.radius
    assert moved.center == pytest.approx((12, 17, 18), abs=2 * PIXEL)
    assert moved.center[0] == before.center[0], "a slice moves within itself"
    hand.key(KEY.Key_Z, CONTROL)
    assert sphere_of(volume) == grown
    hand.key(KEY.Key_Down)
    assert sphere_of(volume).center == pytest.approx(np.add(grown.center, (0, 1, 0)))


def test_a_run_covers_the_ball_and_each_slice_shows_the_particles_near_it(volume, hand) -> None:
    hand.drag((14, 16), (14, 18), (14, 20))
    hand.key(KEY.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: volume.session.idle)  # the last snapshot may still be on its way
    assert volume.session.status.converged
    snapshot, canvas = volume.session.scene.snapshot, volume.canvas_area.canvas
    away = np.linalg.norm(snapshot.position - np.array([11.5, 13.5, 15.5]), axis=1)
    assert np.abs(away - 7.0).max() < 1.0
    reach = volume.session.document.parameters.d_min
    for axis, index in ((0, 12), (0, 5), (1, 13), (2, 20)):
        volume.workspace.slices.set_axis(axis)
        volume.workspace.slices.go_to(index)
        near = np.abs(snapshot.position[:, axis] - index) < reach
        expected = np.delete(snapshot.position[near], axis, axis=1)
        drawn = canvas.layers.particles.position
        np.testing.assert_allclose(drawn[np.lexsort(drawn.T)], expected[np.lexsort(expected.T)])


def test_without_a_start_a_run_says_what_a_volume_starts_from(volume, hand) -> None:
    hand.key(KEY.Key_Space)
    assert "sphere" in volume.canvas_area.messages.text


def test_the_automatic_mode_starts_everywhere_in_a_volume_and_keeps_its_parameters(volume, hand) -> None:
    parameters = volume.session.document.parameters
    hand.canvas.setFocus()
    hand.key(Qt.Key.Key_F2, Qt.KeyboardModifier.ControlModifier)
    document = volume.session.document
    assert (document.mode, document.parameters) == ("automatic", parameters)
    assert document.starts == (Everywhere("grid"),)
    hand.wait(lambda: volume.session.idle)
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    hand.wait(lambda: volume.session.idle and volume.session.scene.reconstruction is not None)
    surface = volume.session.scene.reconstruction.result.surface
    assert (surface.closed, surface.components, surface.euler) == (True, 1, 2)
    hand.key(Qt.Key.Key_F1, Qt.KeyboardModifier.ControlModifier)
    assert (volume.session.document.mode, volume.session.document.starts) == ("shape", ())
