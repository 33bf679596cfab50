"""A trail contains the earlier positions of its particle, and no others."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.model.display.lines import Trails

pytestmark = pytest.mark.shared_window


def ways_of(trails: Trails, moments: list[dict[int, tuple[float, float]]]) -> list[set[tuple[float, ...]]]:
    """Add moments with the particles in any order, and return the trails, newest first."""
    rng = np.random.default_rng(len(moments))
    for step, moment in enumerate(moments):
        identity = rng.permutation(np.array(sorted(moment), dtype=np.int64))
        position = np.array([moment[int(i)] for i in identity], dtype=float).reshape(-1, 2)
        trails.add(step, identity, position)
    return [{tuple(pair.ravel()) for pair in pairs} for pairs in trails]


MOMENTS = st.lists(
    st.dictionaries(st.integers(0, 12), st.tuples(st.integers(0, 30), st.integers(0, 30)), max_size=8), max_size=7
)


@given(MOMENTS, st.integers(1, 4))
def test_trails_are_the_earlier_positions_of_the_same_particle(moments, length):
    expected = [
        {(*before[i], *after[i]) for i in before.keys() & after.keys() if before[i] != after[i]}
        for before, after in pairwise(moments)
    ]
    assert ways_of(Trails(length), moments) == expected[::-1][:length]


def test_going_back_in_time_clears_the_trails():
    trails = Trails(5)
    at, identity = np.array([[1.0, 2.0]]), np.array([0])
    for step in range(4):
        trails.add(step, identity, at + step)
    assert len(trails) == 3
    trails.add(1, identity, at)
    assert len(trails) == 0
    trails.add(2, identity, at + 1.0)
    assert len(trails) == 1


def test_the_trails_on_the_canvas_are_where_the_particles_came_from(ready, hand):
    session, layer = ready.session, hand.canvas.layers["trails"]
    ready.actions_by_name["layer_trails"].trigger()
    places: dict[int, dict[int, tuple[float, float]]] = {}

    def note() -> None:
        shown = session.scene.snapshot
        if shown is not None:
            identity = shown.state.particles.identity.tolist()
            places[shown.state.step] = dict(zip(identity, map(tuple, shown.position), strict=True))

    session.scene_changed.connect(note)
    for step in range(1, 6):
        session.step()
        hand.wait(lambda step=step: session.status.step == step)
    before, after = places[4], places[5]
    newest = next(iter(layer.trails))
    assert len(newest) > 5
    identity = {place: identity for identity, place in after.items()}
    for start, end in newest:
        assert before[identity[tuple(end)]] == tuple(start)
    session.reset()
    hand.wait(lambda: session.idle)
    assert len(layer.trails) == 0
