"""Large images: as many scales as particles need, no less smoothing than noise asks for, and runs in windows."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cpm_core.field.edge_map import automatic_smoothing
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.formats.sessions.particle_state import state_from_json, state_to_json
from cpm_core.image.pyramid import max_scales, shape_at_scale
from cpm_core.model.coverage import NEVER_COVERED, no_coverage
from cpm_core.model.plane import state as plane_state
from cpm_core.model.starts import circle
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.segmentation import large_images, local_fields
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.large_images import large_image_settings

from ..scenes import disk

SCENE = disk((300, 300), (180.0, 190.0), 60.0).values


@pytest.fixture
def small_counts_as_large(monkeypatch):
    for name, value in (("LARGE_IMAGE_PIXELS", 100), ("_COARSEST_SCALE_SIDE", 64), ("_SAMPLE_SIDE", 128)):
        monkeypatch.setattr(large_images, name, value)


@given(st.integers(2049, 40_000), st.integers(2049, 40_000))
def test_the_coarsest_scale_is_just_small_enough(rows, cols):
    scales = large_images.scales_for((rows, cols))
    assert max(shape_at_scale((rows, cols), scales - 1)) <= 512 < max(shape_at_scale((rows, cols), scales - 2))
    assert scales <= max_scales((rows, cols))


@pytest.mark.parametrize("noise", [5.0, 30.0, 60.0])
def test_the_smoothing_is_that_of_the_strongest_edge_not_of_the_empty_background(small_counts_as_large, noise):
    values = SCENE + np.random.default_rng(2).normal(0.0, noise, SCENE.shape)
    found = large_image_settings(values)
    assert found.scales == 4
    assert abs(found.smoothing - automatic_smoothing(values[120:240, 130:250])) <= 0.5
    assert found.smoothing >= (1.0 if noise < 10.0 else 1.5)


@pytest.fixture
def windows(monkeypatch):
    monkeypatch.setattr(local_fields, "LARGE_IMAGE_PIXELS", 100)
    monkeypatch.setattr(plane_state, "_MIN_WINDOWED_PIXELS", 100)
    monkeypatch.setattr(plane_state, "_MIN_WINDOW_ROOM", 24)


BLOB = disk((120, 130), (60.0, 65.0), 40.0).values
BLOBS = np.pad(np.tile(BLOB, (3, 3)), ((120, 120), (125, 125)), "edge")
START = circle((300.0, 320.0), 9.0)


def ended(engine, state, parameters, charges=()):
    while not state.stop_reason:
        state = engine.step(state, parameters, charges)
    return state


@pytest.mark.parametrize("name", ["paper", "automatic", "shape"])
def test_a_run_in_a_window_finds_what_one_in_the_whole_image_does(request, name):
    parameters = PRESETS.get(name, Parameters())
    engine = Engine(BLOBS, parameters)
    (whole,) = engine.result(ended(engine, engine.start(START), parameters), parameters).contours
    request.getfixturevalue("windows")
    engine = Engine(BLOBS, parameters)
    state = engine.start(START)
    first = state.window
    state = ended(engine, state, parameters)
    assert first is not None and state.window is not None
    assert np.prod(state.coverage.found.shape) < 0.1 * np.prod(BLOBS.shape) / 16
    (found,) = engine.result(state, parameters).contours
    assert found.closed == whole.closed
    assert np.abs(np.hypot(*(found.points - (300.0, 320.0)).T) - 40.0).max() < 0.2
    assert found.area == pytest.approx(whole.area, rel=1e-4)


def test_a_window_widens_for_particles_near_its_end_and_forgets_nothing(windows):
    engine, parameters = Engine(BLOBS), Parameters()
    state = ended(engine, engine.start(START), parameters)
    more = engine.add_particles(state, circle((300.0, 450.0), 9.0))
    assert more.window[1].stop > state.window[1].stop
    np.testing.assert_allclose(more.position[: state.count], state.position, rtol=0, atol=1e-9)
    assert more.coverage.size == state.coverage.size == np.count_nonzero(more.coverage.found != NEVER_COVERED)
    assert len(engine.result(ended(engine, more, parameters), parameters).contours) == 2
    everywhere = engine.add_particles(state, [(10.0, 10.0), (590.0, 630.0)])
    assert everywhere.window is None and everywhere.coverage.found.shape == no_coverage(BLOBS.shape).found.shape


def test_placed_charges_act_at_their_place_in_the_image(windows):
    engine, parameters, charge = Engine(BLOBS), Parameters(), PlacedCharge((300.0, 356.0), -3.0)
    state = engine.step(engine.start(START), parameters, [charge])
    pushed = engine.forces(state, parameters, [charge]).placed
    toward = (state.position - charge.position) * pushed
    near = np.hypot(*(state.position - charge.position).T) < 40.0
    assert near.any() and (toward.sum(axis=1)[near] > 0.0).all()
    read = state_from_json(json.loads(json.dumps(state_to_json(state))), BLOBS.shape, 3)
    assert read.window == state.window and read.position.tobytes() == state.position.tobytes()
