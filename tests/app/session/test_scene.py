"""A view that draws the scene of a session shows the same as the session, and draws no part twice."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from threading import Event

import numpy as np
import pytest
from cpm_app.session.scene import Scene
from cpm_app.session.worker.reconstruction import ReconstructionRequest
from cpm_app.views.canvas.image_view import ImageView
from cpm_app.views.items.curves import Curves
from cpm_app.views.items.discs import Discs
from PySide6.QtCore import QCoreApplication, QEvent, Qt

from tests.app.reading import contour_counts

pytestmark = pytest.mark.shared_window


@pytest.fixture
def other(window) -> Iterator[ImageView]:
    """A second view, which has not followed the session from the beginning."""
    made = ImageView()
    made.resize(200, 200)
    yield made
    made.deleteLater()
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)


def test_a_view_that_comes_late_shows_all_that_the_canvas_shows(rested, hand, other) -> None:
    other.draw_scene(rested.session.scene)
    layers, expected = other.layers, hand.canvas.layers
    assert contour_counts(layers.contours) == contour_counts(expected.contours) == (1, 0)
    np.testing.assert_array_equal(layers.particles.position, expected.particles.position)
    assert len(layers.particles.position) > 10
    np.testing.assert_array_equal(layers["image"].shades, expected["image"].shades)
    assert other.shape == hand.canvas.shape


def test_another_scene_on_another_view_leaves_the_session_and_its_canvas_alone(rested, hand, other) -> None:
    before, count = rested.session.scene, hand.canvas.layers.particles.count
    other.draw_scene(replace(before, snapshot=None, reconstruction=None))
    assert (other.layers.particles.count, contour_counts(other.layers.contours)) == (0, (0, 0))
    assert (hand.canvas.layers.particles.count, contour_counts(hand.canvas.layers.contours)) == (count, (1, 0))
    assert rested.session.scene is before


def test_only_those_parts_are_drawn_that_have_changed(rested, hand, monkeypatch) -> None:
    drawn: list[object] = []
    for kind, name in ((Curves, "show_paths"), (Discs, "show_discs")):
        show = getattr(kind, name)
        monkeypatch.setattr(
            kind, name, lambda item, *what, kind=kind, show=show: (drawn.append(kind), show(item, *what))
        )
    session = rested.session
    session.store.set_scene(replace(session.scene))
    assert drawn == []
    session.store.set_scene(replace(session.scene, snapshot=replace(session.scene.snapshot)))
    assert drawn == [Discs, Discs]
    drawn.clear()
    session.store.set_scene(replace(session.scene, hovered_contour=0))
    assert drawn == [Curves]


def test_another_image_leaves_nothing_of_the_one_before_in_the_scene(rested, hand, tmp_path) -> None:
    np.save(tmp_path / "other.npy", np.indices((40, 50)).sum(axis=0) % 17 * 1.0)
    rested.session.open_file(tmp_path / "other.npy")
    hand.wait(lambda: rested.session.idle and rested.session.image.shape == (40, 50))
    scene, empty = rested.session.scene, Scene()
    assert scene.document.image.name == "other.npy"
    for part in ("snapshot", "skeleton", "truth", "probed", "selected_shape", "hovered_contour"):
        assert getattr(scene, part) is None, part
    assert (scene.contours, scene.differences, scene.selected_contours) == (empty.contours, (), frozenset())
    assert contour_counts(hand.canvas.layers.contours) == (0, 0)


def test_the_window_says_that_contours_are_made_while_that_takes_long(ready, hand, monkeypatch) -> None:
    make, may_go_on = ReconstructionRequest.reconstruct, Event()
    monkeypatch.setattr(ReconstructionRequest, "reconstruct", lambda one: may_go_on.wait(60.0) and make(one))
    hand.key(Qt.Key.Key_Space)
    hand.wait(lambda: ready.session.status.busy == "Making the contours…")
    may_go_on.set()
    hand.wait(lambda: ready.session.idle)
    assert not ready.session.status.busy
    assert ready.session.scene.contours
