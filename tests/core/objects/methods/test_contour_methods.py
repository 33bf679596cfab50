"""What all methods share: a start, states in order, an end, contours, settings with words."""

import dataclasses

import numpy as np
import pytest

from cpm_core.contours.ground_truth import truth_of_mask
from cpm_core.image.image import Image
from cpm_core.objects.methods import (
    CONTOUR_METHODS,
    Start,
    facts_of,
    method_named,
    moments,
    run_method,
    runnable,
)
from cpm_core.objects.methods.level_sets import (
    GeodesicSettings,
    distance_of,
    moved,
    signed_distance,
)
from cpm_core.objects.methods.regions import MorphologicalGacSettings
from cpm_core.objects.methods.states import level_contours

from .published import ring

ROW, COL = np.indices((64, 64))
DISK = np.hypot(ROW - 31, COL - 33) < 16
IMAGE = Image(np.where(DISK, 200.0, 40.0))
START = Start((ring((31.0, 33.0), 10.0),))
OWN = {"snake": Start((ring((31.0, 33.0), 20.0),))}
"""Starts of methods that would collapse from inside."""

NAMES = sorted(runnable())
CLASSICAL = sorted(name for name in NAMES if not CONTOUR_METHODS[name].of_particles)


@pytest.mark.parametrize("name", NAMES)
def test_a_run_gives_states_from_the_start_to_an_end(name):
    method, start = CONTOUR_METHODS[name], OWN.get(name, START)
    all_moments = list(moments(method, IMAGE, start))
    states = [moment.state for moment in all_moments]
    assert [state.step for state in states] == list(range(len(states)))
    assert [bool(state.stop_reason) for state in states] == [False] * (len(states) - 1) + [True]
    assert sorted(moment.seconds for moment in all_moments) == [moment.seconds for moment in all_moments]
    assert states[-1].step <= method.most_steps


@pytest.mark.parametrize("name", NAMES)
def test_a_plain_disk_is_found(name):
    facts = facts_of(run_method(CONTOUR_METHODS[name], IMAGE, OWN.get(name, START)), truth_of_mask(DISK))
    assert facts.contours == 1
    assert facts.dice > 0.94
    assert facts.f > 0.99
    assert facts.hausdorff < 2.0


@pytest.mark.parametrize("name", NAMES)
def test_a_later_step_leaves_earlier_states_as_they_were(name):
    states = CONTOUR_METHODS[name].evolve(IMAGE, OWN.get(name, START), CONTOUR_METHODS[name].settings())
    first, second = next(states), next(states)
    before = [contour.points.copy() for contour in second.contours], second.points.copy()
    for _ in zip(range(10), states, strict=False):
        pass
    assert first.step == 0
    again = [contour.points for contour in dataclasses.replace(second).contours]
    assert all(map(np.array_equal, before[0], again))
    assert np.array_equal(before[1], second.points)


@pytest.mark.parametrize("name", NAMES)
def test_a_run_ends_after_the_steps_that_are_asked_for(name):
    assert run_method(CONTOUR_METHODS[name], IMAGE, START, max_steps=1).state.step == 1


@pytest.mark.parametrize("name", CLASSICAL)
def test_each_setting_has_words_and_a_range_that_holds_its_default(name):
    method = CONTOUR_METHODS[name]
    table = method.settings.table()
    assert table
    assert list(table) == [field.name for field in dataclasses.fields(method.settings)]
    for key, info in table.items():
        assert info.name == key
        assert info.title and info.meaning.endswith(".") and info.more.endswith(".")
        assert info.low <= info.slider_low <= getattr(method.settings(), key) <= info.slider_high <= info.high


def test_a_setting_out_of_range_is_refused_in_one_sentence():
    with pytest.raises(ValueError, match=r"^exponent is 100 but must be a number from 0\.1 to 20\.$"):
        GeodesicSettings(exponent=100)
    with pytest.raises(ValueError, match=r"^smoothing is 1\.5 but must be a whole number from 0 to 20\.$"):
        MorphologicalGacSettings(smoothing=1.5)
    with pytest.raises(ValueError, match="balloon is nan but must be a number"):
        GeodesicSettings(balloon=float("nan"))


def test_a_start_needs_an_outline():
    with pytest.raises(ValueError, match="There is no start"):
        Start(())
    with pytest.raises(ValueError, match="three or more corners"):
        Start((np.zeros((2, 2)),))


def test_an_outline_within_others_bounds_a_hole_of_the_start():
    outer, inner, core, apart = ring((31, 33), 20.0), ring((31, 33), 12.0), ring((31, 33), 5.0), ring((8, 8), 4.0)
    disks = [Start((line,)).mask((64, 64)) for line in (outer, inner, core, apart)]
    expected = (disks[0] & ~disks[1]) | disks[2] | disks[3]
    for lines in ((outer, inner, core, apart), (apart, core, apart, inner, outer, core)):
        assert np.array_equal(Start(lines).mask((64, 64)), expected)
    across = ring((31, 50), 10.0)
    assert np.array_equal(Start((outer, across)).mask((64, 64)), disks[0] | Start((across,)).mask((64, 64)))


def test_an_unknown_method_is_refused_with_the_names_that_there_are():
    with pytest.raises(ValueError, match='"gfv" is no method: choose among cpm, object, snake, gvf'):
        method_named("gfv")


@pytest.mark.parametrize("name", sorted({*CLASSICAL, "object"} - {"snake"}))
def test_a_start_around_the_object_drives_a_contour_inwards(name):
    start = Start((ring((31.0, 33.0), 24.0),), around=True)
    assert facts_of(run_method(CONTOUR_METHODS[name], IMAGE, start), truth_of_mask(DISK)).f > 0.99


def test_several_outlines_start_together():
    objects = np.hypot(ROW - 31, COL - 16) < 9, np.hypot(ROW - 31, COL - 47) < 9
    image = Image(np.where(objects[0] | objects[1], 200.0, 40.0))
    start = Start((ring((31.0, 16.0), 6.0), ring((31.0, 47.0), 6.0)))
    for name in ("gvf", "gac", "morph_gac", "random_walker", "cpm", "object"):
        found = facts_of(run_method(CONTOUR_METHODS[name], image, start), truth_of_mask(objects[0] | objects[1]))
        assert found.contours == 2, name
        assert found.f > 0.98, name


def test_the_object_of_the_particles_is_closed_across_a_gap_in_the_line_around_it():
    distance, gap = np.hypot(ROW - 31, COL - 33), np.abs(np.arctan2(ROW - 31, COL - 33)) < 0.4
    image = Image(np.where((np.abs(distance - 16) < 1.5) & ~gap, 40.0, 200.0))
    inside = truth_of_mask(distance < 14.5)
    line, enclosed = (facts_of(run_method(CONTOUR_METHODS[name], image, START), inside) for name in ("cpm", "object"))
    assert line.dice < 0.2  # the contour runs along both sides of the line
    assert (enclosed.contours, enclosed.closed) == (1, 1)
    assert enclosed.dice > 0.95


def test_starts_in_one_object_propose_it_once():
    start = Start((ring((31.0, 27.0), 4.0), ring((31.0, 39.0), 4.0)))
    facts = facts_of(run_method(CONTOUR_METHODS["object"], IMAGE, start), truth_of_mask(DISK))
    assert facts.contours == 1
    assert facts.dice > 0.97


def test_a_region_at_the_border_has_a_closed_contour():
    inside = np.zeros((20, 30))
    inside[:8, :10] = 1.0
    (contour,) = level_contours(inside, 0.5)
    assert contour.closed
    assert contour.points.min() >= -0.5
    assert abs(contour.area - 80.0) < 4.0


def flow(phi, steps, time, curvature=0.0, pressure=0.0, velocity=(0.0, 0.0)):
    """A function after some steps with uniform speeds, made a distance again every five."""
    flat = np.ones(phi.shape)
    speeds = curvature * flat, pressure * flat, np.stack([velocity[0] * flat, velocity[1] * flat])
    for step in range(steps):
        phi = moved(phi, *speeds, time)
        if step % 5 == 4:
            phi = signed_distance(phi)
    return phi


def test_distances_are_those_to_the_zero_of_the_function():
    exact = 14.3 - np.hypot(ROW - 31.2, COL - 32.7)
    found = signed_distance(3.0 * exact)
    near = np.abs(exact) < 7.5
    assert np.abs(found - exact)[near].max() < 0.35
    assert (np.sign(found) == np.sign(exact)).all()


def test_a_front_moves_at_the_speed_of_its_pressure():
    for pressure in (1.0, -1.0):
        phi = flow(distance_of(np.hypot(ROW - 31.5, COL - 31.5) < 15), 24, 0.25, pressure=pressure)
        radius = np.sqrt((phi > 0.0).sum() / np.pi)
        assert abs(radius - (15.0 + 6.0 * pressure)) < 0.5


def test_curvature_shrinks_a_circle_as_it_should():
    phi = flow(distance_of(np.hypot(ROW - 31.5, COL - 31.5) < 20), 500, 0.2, curvature=1.0)
    assert abs(np.sqrt((phi > 0.0).sum() / np.pi) - np.sqrt(200.0)) < 0.6  # dr/dt = -1/r: from 20 to sqrt(400 - 200)


def test_a_front_drifts_with_the_velocity():
    phi = flow(distance_of(np.hypot(ROW - 31.5, COL - 24.5) < 12), 32, 0.25, velocity=(0.0, 1.0))
    center = np.argwhere(phi > 0.0).mean(axis=0)
    assert np.abs(center - [31.5, 32.5]).max() < 0.6


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("given", [{}, np.zeros((2, 2)), "x"], ids=["a dictionary", "an array", "a text"])
def test_settings_of_another_kind_are_refused_in_a_sentence(name, given):
    with pytest.raises(ValueError, match=r"the settings are .* but must be \w+, those of .*\.$"):
        run_method(CONTOUR_METHODS[name], IMAGE, START, given)


@pytest.mark.parametrize("steps", [-1, 0.5, "x", np.nan])
def test_a_number_of_steps_that_is_none_is_refused_in_a_sentence(steps):
    with pytest.raises(ValueError, match=r"max_steps is .* but must be at least 0, and whole\.$"):
        run_method(CONTOUR_METHODS["snake"], IMAGE, START, max_steps=steps)
