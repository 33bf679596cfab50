"""What slices show of forces and fields: arrows along the slice, lines of equal potential, forces on a particle."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.model.volume.slices import SampledForce, Slice
from cpm_app.views.features.volumes import SlicesFeature
from PySide6.QtCore import Qt

from tests.app.reading import arrow_ends

pytestmark = pytest.mark.shared_window

KEY, ALT = Qt.Key, Qt.KeyboardModifier.AltModifier
CENTER = np.array([11.5, 13.5, 15.5])


def test_arrows_of_the_field_point_to_the_surface_in_every_slice(volume, hand) -> None:
    hand.canvas.setFocus()
    hand.key(KEY.Key_9, ALT)
    views = (hand.canvas, *volume.get_feature(SlicesFeature).sides)
    hand.wait(lambda: all(len(arrow_ends(view.layers["field"])) for view in views))
    for view in views:
        field = view.drawn_scene.overlays["field"]
        assert field.shape[1:] == view.shape
        center = view.drawn_scene.slices.current.project_points(CENTER[None])[0]
        places = np.argwhere(np.ones(view.shape))
        away = np.linalg.norm(places - center, axis=1)
        outward = ((places - center) * field[:, places[:, 0], places[:, 1]].T).sum(axis=1)
        assert (outward[(away > 9.5) & (away < 12.0)] < 0.0).all()
        assert (outward[(away > 2.5) & (away < 4.5)] > 0.0).all()
    hand.key(KEY.Key_9, ALT)
    assert not len(arrow_ends(hand.canvas.layers["field"])) or not hand.canvas.layers["field"].shown


def test_forces_on_the_particle_under_the_pointer_are_shown_along_the_slice(volume, hand) -> None:
    hand.canvas.setFocus()
    hand.drag((14, 16), (14, 18), (14, 20))
    hand.key(KEY.Key_3, ALT)
    hand.key(KEY.Key_Period)
    hand.wait(lambda: volume.session.status.step >= 1 and volume.session.idle)
    layer = hand.canvas.layers["forces"]
    near = hand.canvas.drawn_scene.near_particles
    nearest = int(np.argmin(near.distance))
    hand.move(*hand.canvas.drawn_scene.snapshot.position[nearest].tolist())
    number = volume.session.scene.snapshot.state.particles.identity[near.index[nearest]]
    hand.wait(lambda: layer.probed is not None and layer.probed.identity == number)
    whole = volume.session.scene.probed
    for name, force in layer.probed.forces.items():
        np.testing.assert_allclose(force, whole.forces[name][1:])
        assert layer.probed.sizes[name] == pytest.approx(float(np.linalg.norm(whole.forces[name])))
    assert layer.probed.position == pytest.approx(hand.canvas.drawn_scene.snapshot.position[nearest])
    volume.workspace.slices.go_to(0)
    assert hand.canvas.drawn_scene.probed.identity == -1


def test_a_sampled_force_is_interpolated_and_counts_in_pixels_of_the_slice() -> None:
    planes, rows, cols = np.meshgrid(*(np.arange(side, dtype=float) for side in (96, 80, 72)), indexing="ij")
    force = np.stack([planes, rows + cols, 2.0 * cols])
    sampled = SampledForce.from_force(force, (3.0, 1.0, 2.0))
    assert sampled.stride > 1
    found = sampled.interpolate_slice(Slice(0, 33), (80, 72))
    inner = (slice(0, 70), slice(0, 60))
    np.testing.assert_allclose(found[0][inner], (rows + cols)[33][inner], rtol=1e-5, atol=1e-3)
    np.testing.assert_allclose(found[1][inner], cols[33][inner], rtol=1e-5, atol=1e-3)
    across = sampled.interpolate_slice(Slice(2, 11), (96, 80))
    np.testing.assert_allclose(across[0][:80, :70], planes[:80, :70, 11] / 3.0, rtol=1e-5, atol=1e-3)
