"""Starts in volumes: spheres and boxes."""

import numpy as np
import pytest
import scipy

from cpm_core import (
    PRESETS,
    Image,
    circle,
    seeds_everywhere,
    seeds_in_slice,
    seeds_on_box,
    seeds_on_strong_edges,
    segment,
    sphere,
    stroke,
)


def test_particles_lie_evenly_on_a_sphere():
    points = sphere((5.0, 6.0, 7.0), 4.0, 400)
    np.testing.assert_allclose(np.linalg.norm(points - (5.0, 6.0, 7.0), axis=1), 4.0)
    nearest = scipy.spatial.KDTree(points).query(points, 2)[0][:, 1]
    assert nearest.min() > 0.6 * np.sqrt(4.0 * np.pi * 16.0 / 400)


def test_a_sphere_is_round_in_units_of_length_where_voxels_are_no_cubes():
    points = sphere((5.0, 6.0, 7.0), 4.0, 50, voxel_size=(2.0, 1.0, 0.5))
    away = (points - (5.0, 6.0, 7.0)) * (2.0, 1.0, 0.5)
    np.testing.assert_allclose(np.linalg.norm(away, axis=1), 4.0)


def test_particles_on_a_box_lie_on_its_faces_each_once():
    points = seeds_on_box((1.0, 2.0, 3.0), (5.0, 9.0, 6.0), spacing=1.0)
    low, high = np.array((1.0, 2.0, 3.0)), np.array((5.0, 9.0, 6.0))
    assert ((points >= low) & (points <= high)).all()
    assert ((points == low) | (points == high)).any(axis=1).all()
    assert len(points) == 5 * 8 * 4 - 3 * 6 * 2
    np.testing.assert_array_equal(points, seeds_on_box((5.0, 2.0, 6.0), (1.0, 9.0, 3.0), spacing=1.0))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: sphere((1.0, 2.0), 3.0), "center is"),
        (lambda: sphere((1.0, 2.0, np.nan), 3.0), "center is"),
        (lambda: sphere((1.0, 2.0, 3.0), 0.0), "radius is 0 but must be above 0"),
        (lambda: sphere((1.0, 2.0, 3.0), np.inf), "radius is inf"),
        (lambda: sphere((1.0, 2.0, 3.0), 1.0, 0), "count is 0 but must be a whole number"),
        (lambda: sphere((1.0, 2.0, 3.0), 1.0, 5, (1.0, 0.0, 1.0)), "voxel_size is"),
        (lambda: sphere("auto", 3.0), "center is"),
        (lambda: sphere(np.full((3, 2), np.nan), 3.0), "center is"),
        (lambda: sphere((1.0, 2.0, 3.0), 1j), "radius is"),
        (lambda: seeds_on_box((1j, 2.0, 3.0), (2.0, 5.0, 6.0)), "first is"),
        (lambda: seeds_on_box(object(), (2.0, 5.0, 6.0)), "first is"),
        (lambda: seeds_on_box((1.0, 2.0, 3.0), (1.0, 5.0, 6.0)), "must differ along every axis"),
        (lambda: seeds_on_box((1.0, 2.0, 3.0), (2.0, 5.0, 6.0), 0.0), "spacing is 0"),
        (lambda: seeds_on_box((0.0, 0.0, 0.0), (1e4, 1e4, 1e4), 0.5), "choose a larger one"),
    ],
)
def test_impossible_starts_are_refused_in_one_sentence(make, words):
    with pytest.raises(ValueError, match=words) as caught:
        make()
    assert str(caught.value).endswith(".")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("axis", "center"), [(0, (13.0, 14.0)), (1, (12.0, 14.0)), (2, (12.0, 13.0))])
def test_a_circle_in_a_slice_is_round_in_units_of_length_and_lies_in_it(axis, center):
    sides = np.array((2.0, 1.0, 0.5))
    places = seeds_in_slice(circle(center, 5.0), 3.0, axis, tuple(sides))
    np.testing.assert_array_equal(places[:, axis], 3.0)
    away = np.delete(places * sides, axis, axis=1) - center
    np.testing.assert_allclose(np.linalg.norm(away, axis=1), 5.0)


SPACING = (2.0, 1.0, 1.0)
CENTER = np.array((14.0, 14.5, 15.0))


def ball():
    """A ball of radius 8 and contrast 200, in voxels of unequal sides, with a little noise."""
    grid = np.moveaxis(np.indices((15, 30, 31)), 0, -1) * SPACING
    away = np.linalg.norm(grid - CENTER, axis=-1)
    values = 200.0 * np.clip(0.5 - (away - 8.0) / 2.0, 0.0, 1.0)
    return Image(values + np.random.default_rng(0).normal(0.0, 1.0, values.shape), spacing=SPACING)


STARTS = {
    "points": lambda: [CENTER / SPACING, np.array((14.0, 17.5, 15.0)) / SPACING],
    "a circle in a slice": lambda: seeds_in_slice(circle((14.5, 15.0), 4.0), 7.0, 0, SPACING),
    "circles in three slices": lambda: np.concatenate(
        [
            seeds_in_slice(circle((14.5, 15.0), 5.0), 7.0, 0, SPACING),
            seeds_in_slice(circle((14.0, 15.0), 4.0), 15.0, 1, SPACING),
            seeds_in_slice(circle((14.0, 14.5), 3.0), 13.0, 2, SPACING),
        ]
    ),
    "strokes through two slices": lambda: np.concatenate(
        [seeds_in_slice(stroke([(10.0, 10.0), (16.0, 18.0)]), at, 0, SPACING) for at in (6.0, 8.0)]
    ),
    "a path from slice to slice": lambda: stroke([(5.0, 12.0, 15.0), (7.0, 16.0, 15.0), (9.0, 15.0, 12.0)], 0.7),
    "everywhere": lambda: seeds_everywhere(ball(), 5.0),
    "strong edges": lambda: seeds_on_strong_edges(ball(), 0.5),
}


@pytest.mark.parametrize("name", STARTS)
def test_every_start_leads_to_the_whole_surface_in_voxels_of_unequal_sides(name):
    result = segment(ball(), STARTS[name](), PRESETS["volume"])
    assert result.converged
    surface = CENTER + sphere((0.0, 0.0, 0.0), 8.0, 1000)
    found = result.particles * SPACING
    assert scipy.spatial.KDTree(found).query(surface)[0].max() < 2.0
    assert np.abs(np.linalg.norm(found - CENTER, axis=1) - 8.0).max() < 0.6


def test_particles_everywhere_are_as_far_apart_along_all_axes():
    volume = Image(np.random.default_rng(0).random((20, 40, 33)), spacing=(0.6, 0.3, 0.3))
    places = seeds_everywhere(volume, 6.0) * (2.0, 1.0, 1.0)
    nearest = scipy.spatial.KDTree(places).query(places, 2)[0][:, 1]
    np.testing.assert_allclose(nearest, 6.0)
    low, high = places.min(axis=0), np.array((38.0, 39.0, 32.0)) - places.max(axis=0)
    np.testing.assert_allclose(low, high, atol=1e-9)
