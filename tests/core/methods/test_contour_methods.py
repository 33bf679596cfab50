"""What all methods share: a start, states in order, an end, contours, settings with words."""

import dataclasses

import numpy as np
import pytest
import skimage

from cpm_core.contours.ground_truth import truth_from_mask
from cpm_core.image.image import Image
from cpm_core.methods import CONTOUR_METHODS, Start, iterate_method, report_run, run_method
from cpm_core.methods.level_sets import GeodesicSettings, advance_front, reinitialize_distance
from cpm_core.methods.method import signed_region_distance, trace_boundary, unit_gray
from cpm_core.methods.regions import (
    MorphologicalChanVeseSettings,
    MorphologicalGacSettings,
    RandomWalkerSettings,
    label_seeds,
)
from cpm_core.methods.snakes import Elasticity, build_edge_force, find_sobel_edges
from cpm_core.methods.snakes import advance_curve as moved_curve

from .published import ring

ROW, COL = np.indices((64, 64))
DISK = np.hypot(ROW - 31, COL - 33) < 16
IMAGE = Image(np.where(DISK, 200.0, 40.0) + np.random.default_rng(5).normal(0.0, 3.0, DISK.shape))
START = Start((ring((31.0, 33.0), 10.0),))
OWN = {"snake": Start((ring((31.0, 33.0), 20.0),))}
"""Starts of methods that would collapse from inside."""

NAMES = sorted(CONTOUR_METHODS)
CLASSICAL = sorted(name for name in NAMES if not CONTOUR_METHODS[name].of_particles)

VOLUME = Image(np.arange(720.0).reshape(8, 9, 10), source="ball")


@pytest.mark.parametrize("name", NAMES)
def test_a_disk_is_found_in_steps_that_stay_as_they_are(name):
    found = list(iterate_method(CONTOUR_METHODS[name], IMAGE, OWN.get(name, START)))
    states = [moment.state for moment in found]
    assert [state.step for state in states] == list(range(len(states)))
    assert [bool(state.stop_reason) for state in states] == [False] * (len(states) - 1) + [True]
    assert sorted(moment.seconds for moment in found) == [moment.seconds for moment in found]
    assert states[-1].step <= 4000
    facts = report_run(found[-1], truth_from_mask(DISK))
    assert facts.contours == 1
    assert facts.dice > 0.94
    assert facts.f > 0.99
    assert facts.hausdorff < 2.0
    again = run_method(CONTOUR_METHODS[name], IMAGE, OWN.get(name, START), max_steps=1).state
    assert again.step == 1  # and what is computed late of an early state is what was computed at once
    assert all(np.array_equal(a.points, b.points) for a, b in zip(states[1].contours, again.contours, strict=True))


@pytest.mark.parametrize("name", CLASSICAL)
def test_each_setting_has_a_range_that_holds_its_default(name):
    for setting in dataclasses.fields(CONTOUR_METHODS[name].settings):
        low, high = setting.metadata["range"]
        assert low <= setting.default <= high


def test_a_setting_out_of_range_is_refused_in_one_sentence():
    with pytest.raises(ValueError, match=r"^exponent is 100 but must be a number from 0\.1 to 20\.$"):
        GeodesicSettings(exponent=100)
    with pytest.raises(ValueError, match=r"^smoothing is 1\.5 but must be a whole number from 0 to 20\.$"):
        MorphologicalGacSettings(smoothing=1.5)


def test_an_outline_within_others_bounds_a_hole_of_the_start():
    outer, inner, core, apart = ring((31, 33), 20.0), ring((31, 33), 12.0), ring((31, 33), 5.0), ring((8, 8), 4.0)
    disks = [Start((line,)).mask((64, 64)) for line in (outer, inner, core, apart)]
    expected = (disks[0] & ~disks[1]) | disks[2] | disks[3]
    for lines in ((outer, inner, core, apart), (apart, core, apart, inner, outer, core)):
        assert np.array_equal(Start(lines).mask((64, 64)), expected)
    across = ring((31, 50), 10.0)
    assert np.array_equal(Start((outer, across)).mask((64, 64)), disks[0] | Start((across,)).mask((64, 64)))


@pytest.mark.parametrize("name", sorted({*CLASSICAL, "object"} - {"snake"}))
def test_a_start_around_the_object_drives_a_contour_inwards(name):
    start = Start((ring((31.0, 33.0), 24.0),), around=True)
    assert report_run(run_method(CONTOUR_METHODS[name], IMAGE, start), truth_from_mask(DISK)).f > 0.99


@pytest.mark.parametrize("name", ["gvf", "geodesic", "morph_gac", "random_walker", "cpm", "object"])
def test_several_outlines_start_together(name):
    objects = np.hypot(ROW - 31, COL - 16) < 9, np.hypot(ROW - 31, COL - 47) < 9
    image = Image(np.where(objects[0] | objects[1], 200.0, 40.0))
    start = Start((ring((31.0, 16.0), 6.0), ring((31.0, 47.0), 6.0)))
    found = report_run(run_method(CONTOUR_METHODS[name], image, start), truth_from_mask(objects[0] | objects[1]))
    assert found.contours == 2
    assert found.f > 0.98


def test_the_object_of_the_particles_is_closed_across_a_gap_in_the_line_around_it():
    distance, gap = np.hypot(ROW - 31, COL - 33), np.abs(np.arctan2(ROW - 31, COL - 33)) < 0.4
    image = Image(np.where((np.abs(distance - 20) < 1.5) & ~gap, 40.0, 200.0))
    inside = truth_from_mask(distance < 20)  # the middle of the line, which may belong to the object or not
    line, enclosed = (report_run(run_method(CONTOUR_METHODS[name], image, START), inside) for name in ("cpm", "object"))
    assert line.dice < 0.2  # the contour runs along both sides of the line
    assert (enclosed.contours, enclosed.closed) == (1, 1)
    assert enclosed.dice > 0.85


def test_a_region_at_the_border_has_a_closed_contour():
    inside = np.zeros((20, 30))
    inside[:8, :10] = 1.0
    (contour,) = trace_boundary(inside, 0.5)
    assert contour.closed
    assert contour.points.min() >= -0.5
    assert abs(contour.area - 80.0) < 4.0


def flow(phi, steps, time, curvature=0.0, pressure=0.0, velocity=(0.0, 0.0)):
    """A function after some steps with uniform speeds, made a distance again every five."""
    flat = np.ones(phi.shape)
    speeds = curvature * flat, pressure * flat, np.stack([velocity[0] * flat, velocity[1] * flat])
    for step in range(steps):
        phi = advance_front(phi, *speeds, time)
        if step % 5 == 4:
            phi = reinitialize_distance(phi)
    return phi


def test_distances_are_those_to_the_zero_of_the_function():
    exact = 14.3 - np.hypot(ROW - 31.2, COL - 32.7)
    found = reinitialize_distance(3.0 * exact)
    near = np.abs(exact) < 7.5
    assert np.abs(found - exact)[near].max() < 0.35
    assert (np.sign(found) == np.sign(exact)).all()


def test_fronts_move_by_pressure_curvature_and_drift_at_the_speed_of_theory():
    for pressure in (1.0, -1.0):
        phi = flow(signed_region_distance(np.hypot(ROW - 31.5, COL - 31.5) < 15), 24, 0.25, pressure=pressure)
        assert abs(np.sqrt((phi > 0.0).sum() / np.pi) - (15.0 + 6.0 * pressure)) < 0.5
    phi = flow(signed_region_distance(np.hypot(ROW - 31.5, COL - 31.5) < 20), 500, 0.2, curvature=1.0)
    assert abs(np.sqrt((phi > 0.0).sum() / np.pi) - np.sqrt(200.0)) < 0.6  # dr/dt = -1/r: from 20 to sqrt(400 - 200)
    phi = flow(signed_region_distance(np.hypot(ROW - 31.5, COL - 24.5) < 12), 32, 0.25, velocity=(0.0, 1.0))
    assert np.abs(np.argwhere(phi > 0.0).mean(axis=0) - [31.5, 32.5]).max() < 0.6


def test_the_classical_snake_moves_as_active_contour_does():
    curve = ring((30.0, 34.0), 20.0, 90)
    smooth = skimage.filters.gaussian(unit_gray(IMAGE), 2.0, mode="nearest", truncate=4.0)
    theirs = skimage.segmentation.active_contour(
        smooth, curve, alpha=0.05, beta=10.0, gamma=0.01, max_num_iter=60, convergence=0.0
    )
    force, own = build_edge_force(find_sobel_edges(IMAGE, 2.0), 1.0), curve
    for _ in range(60):
        own = moved_curve(own, force, Elasticity(0.05, 10.0, 0.01), IMAGE.shape)
    assert np.allclose(own, theirs, rtol=0.0, atol=1e-7)


def test_methods_of_scikit_image_give_step_by_step_what_its_functions_give():
    mask, gray = START.mask(IMAGE.shape).astype(np.int8), unit_gray(IMAGE)
    walk = RandomWalkerSettings(beta=90.0)
    cases = {
        "morph_gac": (MorphologicalGacSettings(smoothing=2, sigma=1.0), lambda: (
            skimage.segmentation.morphological_geodesic_active_contour(
                skimage.segmentation.inverse_gaussian_gradient(gray, 100.0, 1.0), 7, mask, 2, 0.6, 1.0
            )
        )),
        "morph_chan_vese": (MorphologicalChanVeseSettings(smoothing=2), lambda: (
            skimage.segmentation.morphological_chan_vese(gray, 7, mask, 2, 0.7, 1.0)
        )),
        "random_walker": (walk, lambda: (
            skimage.segmentation.random_walker(gray, label_seeds(START, IMAGE.shape, walk), 90.0, "bf", prob_tol=1.0)
            == 1
        )),
    }  # fmt: skip
    for name, (chosen, theirs) in cases.items():
        own = run_method(CONTOUR_METHODS[name], IMAGE, START, chosen, max_steps=7).state
        expected = trace_boundary(theirs(), 0.5)
        for one, other in zip(own.contours, expected, strict=True):
            assert np.array_equal(one.points, other.points), name


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Start(()), "There is no start"),
        (lambda: Start((np.zeros((2, 2)),)), "three or more corners"),
        (lambda: run_method(CONTOUR_METHODS["snake"], IMAGE, START, max_steps=0.5), "must be at least 0, and whole"),
        (
            lambda: next(iterate_method(CONTOUR_METHODS["gvf"], IMAGE, START, {})),
            "must be GvfSnakeSettings, those of GVF",
        ),
        (
            lambda: next(iterate_method(CONTOUR_METHODS["gvf"], VOLUME, START)),
            "ball is a volume, but methods",
        ),
    ],
)
def test_what_does_not_fit_is_refused_in_a_sentence(make, sentence):
    with pytest.raises(ValueError, match=sentence):
        make()
