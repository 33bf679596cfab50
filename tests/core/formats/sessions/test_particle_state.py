"""States of a run in a file: the same in every bit, and refused in one sentence when they could not be one."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from cpm_core import PRESETS, Engine, Image, Parameters, PlacedCharge, sphere
from cpm_core.formats.common.json_values import array_from_json, array_to_json
from cpm_core.formats.sessions.particle_state import state_from_json, state_to_json
from cpm_core.model.starts import circle
from cpm_core.model.state import State

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


@settings(max_examples=30)
@given(
    hnp.arrays(
        st.sampled_from([np.float64, np.float32, np.int32, np.int64]),
        hnp.array_shapes(max_dims=3, min_side=0, max_side=6),
    )
)
def test_arrays_are_read_back_bit_for_bit(array: np.ndarray) -> None:
    plain = json.loads(json.dumps(array_to_json(array)))
    read = array_from_json(plain, array.dtype, (None,) * array.ndim, "array")
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
        array_from_json({**array_to_json(np.zeros((2, 2))), **change}, float, (None, 2), "array")


@settings(max_examples=8, deadline=None)
@given(data=st.data())
def test_a_run_goes_on_from_a_state_that_was_read_as_from_the_state_itself(data: st.DataObject, states) -> None:
    state = states[data.draw(st.integers(1, len(states) - 1))]
    read = state_from_json(json.loads(json.dumps(state_to_json(state))), SHAPE, 2)
    assert read.particles.distance.tobytes() == state.particles.distance.tobytes()
    assert (read.step, read.stop_reason, read.converged) == (state.step, state.stop_reason, state.converged)
    same = [state.resume(), state.resume()]
    same[1] = type(state)(**{**{n: getattr(read.resume(), n) for n in vars(state)}, "steering": state.steering})
    one, other = (ENGINE.step(each, Parameters(scales=2)) for each in same)
    assert one.particles.position.tobytes() == other.particles.position.tobytes()
    assert one.particles.force.tobytes() == other.particles.force.tobytes()


def broken(states, **changes: object) -> dict:
    return {**state_to_json(states[20]), **changes}


def test_no_state_is_read_that_compiled_loops_cannot_bear(states) -> None:
    state = states[20]
    outside = state.particles.position.copy()
    outside[0] = (1e6, 0.0)
    bad = {
        "outside the image": {"position": array_to_json(outside)},
        "found": {"found": array_to_json(np.zeros((1, 1), np.int32))},
        "scale of state": {"scale": 9},
        "reach of state": {"mesh": {"reach": 0.0}},
        "mesh of state": {"mesh": {"reach": 30.0, "force": array_to_json(np.zeros((2, 2, 2), np.float32))}},
        "velocity": {"velocity": array_to_json(np.full_like(outside, np.nan))},
        "crept of state has the shape": {"crept": array_to_json(np.zeros(state.count + 1))},
        "crept of state contains a distance below 0": {"crept": array_to_json(np.full(state.count, -1.0))},
        "crept of state contains a value": {"crept": array_to_json(np.full(state.count, np.nan))},
        "less than nothing": {"idle": -4},
        "stop_reason": {"stop_reason": 3},
    }
    for says, changes in bad.items():
        with pytest.raises(ValueError, match=says):
            state_from_json(broken(states, **changes), SHAPE, 2)


def test_how_far_each_particle_has_crept_is_read_back_and_a_state_without_it_begins_with_none(states) -> None:
    particles = replace(states[20].particles, crept=np.linspace(0.0, 3.0, states[20].count))
    plain = json.loads(json.dumps(state_to_json(replace(states[20], particles=particles))))
    np.testing.assert_array_equal(state_from_json(plain, SHAPE, 2).particles.crept, particles.crept)
    del plain["crept"]
    older = state_from_json(plain, SHAPE, 2)
    np.testing.assert_array_equal(older.particles.crept, np.zeros(states[20].count))
    assert ENGINE.step(older.resume(), Parameters(scales=2)).step == older.step + 1


SPACING = (1.5, 1.0, 1.0)
VOLUME = replace(PRESETS["volume"], scales=2)
_away = np.linalg.norm((np.moveaxis(np.indices((20, 28, 27)), 0, -1) - (9.5, 13.0, 13.0)) * SPACING, axis=-1)
SOLID = Engine(Image(np.clip(9.0 - _away, 0.0, 1.0) * 200.0, spacing=SPACING), VOLUME)
CHARGES = (PlacedCharge((9.0, 13.0, 22.0), 0.5),)


@pytest.fixture(scope="module")
def solid_states(compiled_loops: None) -> list[State]:
    """The states of a run in a volume to its end, over two scales."""
    found = [SOLID.start(sphere((9.5, 13.0, 13.0), 4.0, 50, voxel_size=SPACING))]
    while not found[-1].stop_reason:
        found.append(SOLID.step(found[-1], VOLUME, CHARGES))
    return found


def test_a_run_in_a_volume_goes_on_from_a_state_that_was_read_to_the_same_end(solid_states) -> None:
    """Parameters, regions and charges are told by the actions of the run."""
    for number in (1, 2 * len(solid_states) // 3):
        state = solid_states[number]
        read = state_from_json(json.loads(json.dumps(state_to_json(state))), SOLID.image.shape, 2, SPACING)
        read = replace(read, steering=state.steering, regions=state.regions, charges=state.charges)
        for later in solid_states[number + 1 :]:
            read = SOLID.step(read, VOLUME, CHARGES)
            assert [a.tobytes() for a in read.list_arrays()] == [a.tobytes() for a in later.list_arrays()]
            assert (read.step, read.stop_reason) == (later.step, later.stop_reason)
        one, other = (SOLID.result(end, VOLUME) for end in (read, solid_states[-1]))
        assert one.surface is not None
        assert other.surface is not None
        assert one.surface.vertices.tobytes() == other.surface.vertices.tobytes()


def test_no_state_of_a_volume_is_read_that_compiled_loops_cannot_bear(solid_states) -> None:
    state = solid_states[20]
    outside = state.particles.position.copy()
    outside[0] = (19.7 * 1.5, 3.0, 3.0)
    bad = {
        "outside the image": {"position": array_to_json(outside)},
        "position of state has the shape": {"position": array_to_json(outside[:, :2])},
        "normal of state": {"normal": array_to_json(np.full_like(outside, np.nan))},
        "seated of state": {"seated": array_to_json(np.zeros(3, np.int32))},
        "strength of state": {"strength": array_to_json(np.full(state.count, np.inf))},
        "woken of state": {"woken": 3},
        "side of state": {"side": 0.0},
    }
    for says, changes in bad.items():
        with pytest.raises(ValueError, match=says):
            state_from_json({**state_to_json(state), **changes}, SOLID.image.shape, 2, SPACING)
