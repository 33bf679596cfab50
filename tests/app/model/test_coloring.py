"""Particles are colored by a quantity: a larger value never has a darker color, and unknown values have their own."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from cpm_app.model.display.coloring import QUANTITIES, SHADE_COUNT, color_particles, particle_age, particle_speed
from cpm_app.model.display.lengths import round_up
from cpm_app.session.timeline.timeline_nodes import BranchMetrics
from cpm_app.views.theme import color_maps
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import Qt

from cpm_core import Engine, Parameters
from cpm_core.model.coverage import no_coverage
from cpm_core.model.plane.state import PlaneState
from cpm_core.model.state import Particles
from tests.app.conftest import disc

NOBODY_BORN = SimpleNamespace(step=np.empty(0), numbered=np.empty(0))


def moment(count: int = 0, seed: int = 0) -> PlaneState:
    """Particles that move and have a history, but for the last of them."""
    rng = np.random.default_rng(seed)
    particles = replace(
        Particles.at_rest(rng.uniform(0, 60, (count, 2))),
        velocity=rng.normal(size=(count, 2)),
        force=rng.normal(size=(count, 2, 2)),
        distance=np.where(np.arange(count)[:, None] < count - 1, rng.uniform(0, 1, (count, 4)), np.nan),
    )
    return PlaneState(particles, particles.position, (64, 64), 0, coverage=no_coverage(()), step=7)


@pytest.mark.parametrize("name", QUANTITIES)
@given(seed=st.integers(0, 2**16), count=st.integers(2, 60))
def test_more_of_a_quantity_never_gives_a_lower_shade(name, seed, count):
    state = moment(count, seed)
    numbered = np.sort(np.random.default_rng(seed).integers(0, count + 1, 7)).astype(float)
    inserted = SimpleNamespace(step=np.arange(1.0, 8.0), numbered=numbered)
    values = QUANTITIES[name].measure(state, inserted)
    colors, _ = color_particles(QUANTITIES[name], state, inserted)
    known = np.isfinite(values)
    assert (colors[~known] == SHADE_COUNT).all()
    assert (colors[known] < SHADE_COUNT).all()
    assert (np.diff(colors[known][np.argsort(values[known], kind="stable")].astype(int)) >= 0).all()


@pytest.mark.parametrize("name", ["viridis", "cividis", "magma"])
def test_a_higher_shade_is_brighter(name):
    red, green, blue = color_maps.color_table(name, SHADE_COUNT).astype(float).T
    assert (np.diff(0.2126 * red + 0.7152 * green + 0.0722 * blue) > 0).all()


def test_speeds_of_all_scales_are_in_px_of_the_image():
    state = moment(5)
    assert particle_speed(replace(state, scale=2), NOBODY_BORN) == pytest.approx(
        4.0 * particle_speed(state, NOBODY_BORN)
    )


def test_the_age_of_every_particle_is_the_number_of_steps_since_it_appeared(compiled_loops):
    parameters = Parameters(scales=1)
    engine, recorder = Engine(disc(), parameters), BranchMetrics()
    state = engine.start([(32.0 + 10.0 * np.sin(a), 32.0 + 10.0 * np.cos(a)) for a in np.arange(0.0, 6.2, 0.7)])
    seen: dict[int, int] = {}
    for _ in range(40):
        state = engine.step(state, parameters)
        recorder.add_step(state.step, engine.measure_state(state, parameters))
        for identity in state.particles.identity.tolist():
            seen.setdefault(identity, state.step)
    metrics = recorder.metrics_until()
    told = particle_age(state, metrics)
    expected = [state.step - seen[identity] for identity in state.particles.identity.tolist()]
    assert len(set(expected)) > 2
    assert told.tolist() == expected


def test_colors_are_chosen_by_keys_and_come_with_a_legend(window, hand, ready):
    layer = hand.canvas.layers["particles"]
    ready.session.step()
    hand.wait(lambda: layer.count > 0 and ready.session.status.step == 1)
    assert not layer.legend.isVisible()
    window.docks.reveal_panel("layers")
    row = window.panels["layers"].rows["particles"]
    row.fold.setFocus()
    hand.qtbot.keyClick(row.fold, Qt.Key.Key_Return)
    box = row.settings.fields["colour"]
    box.setFocus()
    hand.qtbot.keyClick(box, Qt.Key.Key_Down)
    assert layer.get_choice("colour") == "speed"
    assert layer.legend.isVisible()
    title, _, low, *_, high = layer.legend.toPlainText().split()
    assert (title, low) == ("Speed", "0")
    assert float(high) == round_up(float(high))
    layer.set_shown(False)
    assert not layer.legend.isVisible()
