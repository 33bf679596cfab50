"""States of a run in a file: the same in every bit, and refused in one sentence when they could not be one."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from cpm_core import Engine, Parameters
from cpm_core.formats.sessions.particle_state import state_from_plain, state_to_plain
from cpm_core.formats.sessions.plain_arrays import array_from_plain, array_to_plain
from cpm_core.particles.initialization import circle
from cpm_core.particles.state import State

_row, _col = np.indices((48, 56))
ENGINE = Engine(np.where(np.hypot(_row - 24, _col - 28) < 14.0, 200.0, 20.0), Parameters(scales=2))
SHAPE = ENGINE.image.shape


@pytest.fixture(scope="module")
def states(compiled_loops: None) -> list[State]:
    """The states of a run to its end, over two scales."""
    found = [ENGINE.start(circle((24.0, 28.0), 9.0))]
    while not found[-1].stop_reason:
        found.append(ENGINE.step(found[-1], Parameters(scales=2)))
    return found


@given(
    hnp.arrays(
        st.sampled_from([np.float64, np.float32, np.int32, np.int64]),
        hnp.array_shapes(max_dims=3, min_side=0, max_side=6),
    )
)
def test_arrays_are_read_back_bit_for_bit(array: np.ndarray) -> None:
    plain = json.loads(json.dumps(array_to_plain(array)))
    read = array_from_plain(plain, array.dtype, (None,) * array.ndim, "array")
    assert read.dtype == array.dtype
    assert read.shape == array.shape
    assert read.tobytes() == array.tobytes()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"shape": [3, 2]}, "does not hold what its shape says"),
        ({"shape": [2**40, 2]}, "no array that can be read"),
        ({"shape": [-1, 2]}, "has the shape"),
        ({"shape": "2"}, "has the shape"),
        ({"data": "%%%"}, "is damaged"),
        ({"data": "aGVsbG8="}, "is damaged"),
        ({"data": 7}, "no array that can be read"),
    ],
)
def test_a_damaged_array_is_refused_in_one_sentence(change: dict, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        array_from_plain({**array_to_plain(np.zeros((2, 2))), **change}, float, (None, 2), "array")


@settings(max_examples=20, deadline=None)
@given(data=st.data())
def test_a_run_goes_on_from_a_state_that_was_read_as_from_the_state_itself(data: st.DataObject, states) -> None:
    state = states[data.draw(st.integers(1, len(states) - 1))]
    read = state_from_plain(json.loads(json.dumps(state_to_plain(state))), SHAPE, 2)
    assert read.particles.distance.tobytes() == state.particles.distance.tobytes()
    assert (read.step, read.stop_reason, read.converged) == (state.step, state.stop_reason, state.converged)
    same = [state.resumed(), state.resumed()]
    same[1] = type(state)(**{**{n: getattr(read.resumed(), n) for n in state.__slots__}, "steering": state.steering})
    one, other = (ENGINE.step(each, Parameters(scales=2)) for each in same)
    assert one.particles.position.tobytes() == other.particles.position.tobytes()
    assert one.particles.force.tobytes() == other.particles.force.tobytes()


def broken(states, **changes: object) -> dict:
    return {**state_to_plain(states[20]), **changes}


def test_no_state_is_read_that_compiled_loops_cannot_bear(states) -> None:
    state = states[20]
    outside = state.particles.position.copy()
    outside[0] = (1e6, 0.0)
    twice = state.particles.identity.copy()
    twice[1] = twice[0]
    bad = {
        "outside the image": {"position": array_to_plain(outside)},
        "twice": {"identity": array_to_plain(twice)},
        "yet to come": {"next_identity": 1},
        "found": {"found": array_to_plain(np.zeros((1, 1), np.int32))},
        "scale of state": {"scale": 9},
        "reach of state": {"mesh": {"reach": 0.0}},
        "mesh of state": {"mesh": {"reach": 30.0, "force": array_to_plain(np.zeros((2, 2, 2), np.float32))}},
        "velocity": {"velocity": array_to_plain(np.full_like(outside, np.nan))},
        "less than nothing": {"idle": -4},
        "stop_reason": {"stop_reason": 3},
    }
    for says, changes in bad.items():
        with pytest.raises(ValueError, match=says):
            state_from_plain(broken(states, **changes), SHAPE, 2)
