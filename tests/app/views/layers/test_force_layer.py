"""The forces shown are those of the engine on the particle under the pointer."""

from __future__ import annotations

import numpy as np
import pytest
from cpm_app.session.worker.requests import FORCE_NAMES
from cpm_app.views.layers.forces import FORCE_KINDS


@pytest.fixture
def held(ready, hand):
    """A window with a run held after some steps, and the layer of forces shown."""
    session = ready.session
    ready.actions_by_name["layer_forces"].trigger()
    for step in range(1, 7):
        session.step()
        hand.wait(lambda step=step: session.status.step == step)
    hand.wait(lambda: session.idle)
    return hand.canvas.layers["forces"]


def moment(window):
    """Engine, state and parameters of the run; nothing steps."""
    run = window.session._worker_thread.run
    return run.method, run.state, run.parameters


def test_the_forces_on_the_particle_under_the_pointer_are_those_of_the_engine(held, ready, hand):
    engine, state, parameters = moment(ready)
    for index in (0, state.count // 2, state.count - 1):
        at = state.position[index]
        hand.move(*at)
        hand.wait(lambda index=index: held.probed and held.probed.identity == state.particles.identity[index])
        probed = held.probed
        assert probed.position == pytest.approx(at)
        assert probed.step == 6
        expected = engine.forces(state, parameters, (), index)
        size = 2.0**state.scale
        for name in FORCE_NAMES:
            assert probed.forces[name] == pytest.approx(size * getattr(expected, name)[0]), name
        features = np.sum([probed.forces[name] for name in FORCE_NAMES if name != "total"], axis=0)
        assert features == pytest.approx(probed.forces["total"])
        assert held.legend.isVisible()


def test_every_force_is_listed_with_its_magnitude(held, ready, hand):
    at = moment(ready)[1].position[3]
    hand.move(*at)
    hand.wait(lambda: held.probed is not None)
    listed = {name: figure for name, _, figure in held.lines}
    assert {"Coulomb", "Lorentz", "Damping", "Total"} <= listed.keys()
    for kind, (title, _) in FORCE_KINDS.items():
        if title in listed:
            assert listed[title] == f"{np.hypot(*held.probed.forces[kind]):.3f}"


def test_far_from_all_particles_no_forces_are_shown(held, ready, hand):
    hand.move(*moment(ready)[1].position[0])
    hand.wait(lambda: held.probed is not None)
    hand.canvas.zoom_by(4.0)
    hand.move(32, 32)
    hand.wait(lambda: held.probed is None)
    assert not held.legend.isVisible()


def test_the_forces_follow_a_run_and_vanish_with_it(held, ready, hand):
    hand.move(*moment(ready)[1].position[0])
    hand.wait(lambda: held.probed is not None)
    ready.session.step()
    hand.wait(lambda: held.probed is not None and held.probed.step == 7)
    ready.session.reset()
    hand.wait(lambda: ready.session.idle)
    assert held.probed is None
    assert not held.legend.isVisible()
