"""A run can be iterated over, stopped, and changed between its steps; it is the very run of `segment`."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import cpm_core as cpm


@pytest.fixture(scope="module")
def image():
    return cpm.example("disk")


SEEDS = cpm.circle((32, 32), 8)


def test_the_steps_are_those_of_a_whole_run(image):
    whole = cpm.segment(image, SEEDS)
    moments = list(cpm.evolve(image, SEEDS))
    assert [moment.step for moment in moments] == list(range(whole.steps + 1))
    assert np.array_equal(moments[-1].position, whole.particles)
    assert moments[-1].stop_reason == whole.stop_reason
    assert np.array_equal(moments[-1].contours[0].points, whole.contours[0].points)
    assert moments[0].count == len(SEEDS)


def test_contours_are_found_at_any_moment_and_only_once(image):
    moment = next(moment for moment in cpm.evolve(image, SEEDS) if moment.step == 30)
    assert moment.contours is moment.result.contours
    assert moment.result.steps == 30


def test_parameters_and_charges_act_from_the_next_step_on(image):
    plain = list(cpm.evolve(image, SEEDS, max_steps=12))
    run = cpm.evolve(image, SEEDS, max_steps=12)
    steered = []
    for moment in run:
        steered.append(moment)
        if moment.step == 6:
            run.parameters = cpm.Parameters(beta=3.0)
            run.charges = [cpm.PlacedCharge((32, 60), 2.0)]
    assert np.array_equal(steered[6].position, plain[6].position)
    assert not np.array_equal(steered[7].position, plain[7].position)
    assert steered[7].state.charges == tuple(run.charges)
    assert steered[7].parameters.beta == 3.0
    assert steered[6].parameters.beta == 0.8


def test_an_update_changes_what_it_names_and_nothing_else(image):
    run = cpm.evolve(image, SEEDS, "shape")
    next(run)
    run.update(beta=0.2, w1=1.5)
    assert run.parameters == dataclasses.replace(cpm.PRESETS["shape"], beta=0.2, w1=1.5)
    assert next(run).parameters.beta == 0.2
    for wrong, says in (
        ({"betta": 1.0}, "betta is no parameter: choose one of reach"),
        ({"beta": -1.0}, "beta is -1 but must be"),
        ({"scales": 2}, "scales is 2 but must stay 3"),
    ):
        with pytest.raises(ValueError, match=says):
            run.update(**wrong)
    assert run.parameters.w1 == 1.5


def test_a_run_is_stopped_where_it_is_and_says_so(image):
    run = cpm.evolve(image, SEEDS)
    for moment in run:
        if moment.step == 9:
            run.stop("seen enough")
    assert moment.step == 9
    assert run.moment.stop_reason == run.result.stop_reason == "seen enough"
    assert list(run) == []
    run.stop("twice")
    assert run.moment.stop_reason == "seen enough"


def test_a_volume_evolves_too():
    moments = cpm.evolve(cpm.example("ball"), cpm.sphere((15, 15, 15), 4, 60), cpm.PRESETS["volume"], max_steps=3)
    assert [moment.position.shape[1] for moment in moments] == [3, 3, 3, 3]
