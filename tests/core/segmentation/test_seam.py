"""The contract of methods: code that runs, records or shows a method relies only on these laws."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

import cpm_core as cpm
from cpm_core import PARAMETERS, Parameters, PlacedCharge
from cpm_core.segmentation.method import RUN_METHODS

from ..scenes import ring

PARAMS = Parameters(scales=1, smoothing=1.5)
SEEDS = cpm.circle((48.4, 49.7), 24.0)


@pytest.fixture(scope="module", params=RUN_METHODS)
def method(request):
    return RUN_METHODS[request.param](ring((96, 100), (48.4, 49.7), 20.0, 40.0).values, PARAMS)


@pytest.fixture(scope="module")
def states(method):
    found = [method.start(SEEDS)]
    while not found[-1].stop_reason:
        found.append(method.step(found[-1], PARAMS))
        assert found[-1].step == found[-2].step + 1 < 2000
    return found


def arrays(state):
    return [array.tobytes() for array in state.list_arrays()]


def test_a_step_depends_on_the_state_alone_and_changes_nothing(method, states):
    for before, after in [(states[0], states[1]), (states[-2], states[-1])]:
        held = arrays(before)
        again = method.step(before, PARAMS)
        assert arrays(again) == arrays(after)
        assert (again.step, again.stop_reason, again.converged) == (after.step, after.stop_reason, after.converged)
        assert arrays(before) == held
        with pytest.raises(FrozenInstanceError):
            before.step = 7


def test_a_run_ends_with_contours_and_stays_at_its_end_until_it_is_resumed(method, states):
    last = states[-1]
    assert last.converged
    assert method.step(last, PARAMS) is last
    assert not last.resume().stop_reason
    assert method.step(last.resume(), PARAMS).step == last.step + 1
    result = method.result(last, PARAMS)
    assert result.shape == (96, 100)
    # a ring has two closed outlines, and one closed center line; the crust of particles that jitter has more
    least = 1 if method.name == "skeleton" else 2
    closed = sum(contour.closed for contour in result.contours)
    assert closed == least or (method.name == "published" and closed > least)


def test_a_state_has_positions_in_the_image_and_metrics_by_name(method, states):
    for state in states[:3]:
        positions, figures = state.position, method.measure_state(state, PARAMS)
        assert positions.shape == (state.count, 2) == state.particles.position.shape
        assert ((positions > -2.0) & (positions < 102.0)).all()
        assert len(set(state.particles.identity.tolist())) == state.count
        assert figures["count"] == state.count
        assert all(isinstance(value, int | float) for value in figures.values())


def test_only_parameters_with_an_effect_are_steering(method):
    free = Parameters(w1=0.01, w2=50.0, scales=1, smoothing=1.5)
    changing = set()
    for name, info in PARAMETERS.items():
        end = info.slider_low if getattr(free, name) == info.slider_high else info.slider_high
        if method.steering(replace(free, **{name: end})) != method.steering(free):
            changing.add(name)
    own = {name: info for name, info in PARAMETERS.items() if name in method.parameters}
    of_steps = {name for name, info in own.items() if info.invalidates in ("nothing", "field")}
    assert (own.keys() if method.name == "skeleton" else of_steps) <= changing <= own.keys()


def test_the_skeleton_of_a_run_is_that_of_the_function_also_after_other_parameters():
    image = cpm.Image(ring((96, 100), (48.4, 49.7), 20.0, 40.0).values)
    method = RUN_METHODS["skeleton"](image, PARAMS)
    state = method.start(())
    for parameters in (PARAMS, replace(PARAMS, smoothing=2.5), replace(PARAMS, smoothing=2.5, sure_edge=0.9)):
        while not state.stop_reason:
            state = method.step(state, parameters, (PlacedCharge((4.0, 4.0), 1.0),))
        found, expected = method.result(state, parameters), cpm.skeleton(image, parameters)
        assert len(found.contours) == len(expected.contours) > 0
        for one, other in zip(found.contours, expected.contours, strict=True):
            np.testing.assert_array_equal(one.points, other.points)
        state = state.resume()
    assert state.step == 9
