"""Starts in volumes: spheres and boxes."""

import numpy as np
import pytest
import scipy

from cpm_core import box, sphere


def test_particles_lie_evenly_on_a_sphere():
    points = sphere((5.0, 6.0, 7.0), 4.0, 400)
    np.testing.assert_allclose(np.linalg.norm(points - (5.0, 6.0, 7.0), axis=1), 4.0)
    nearest = scipy.spatial.KDTree(points).query(points, 2)[0][:, 1]
    assert nearest.min() > 0.6 * np.sqrt(4.0 * np.pi * 16.0 / 400)


def test_a_sphere_is_round_in_units_of_length_where_voxels_are_no_cubes():
    points = sphere((5.0, 6.0, 7.0), 4.0, 50, spacing=(2.0, 1.0, 0.5))
    away = (points - (5.0, 6.0, 7.0)) * (2.0, 1.0, 0.5)
    np.testing.assert_allclose(np.linalg.norm(away, axis=1), 4.0)


def test_particles_on_a_box_lie_on_its_faces_each_once():
    points = box((1.0, 2.0, 3.0), (5.0, 9.0, 6.0), spacing=1.0)
    low, high = np.array((1.0, 2.0, 3.0)), np.array((5.0, 9.0, 6.0))
    assert ((points >= low) & (points <= high)).all()
    assert ((points == low) | (points == high)).any(axis=1).all()
    assert len(points) == 5 * 8 * 4 - 3 * 6 * 2
    np.testing.assert_array_equal(points, box((5.0, 2.0, 6.0), (1.0, 9.0, 3.0), spacing=1.0))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: sphere((1.0, 2.0), 3.0), "center is"),
        (lambda: sphere((1.0, 2.0, np.nan), 3.0), "center is"),
        (lambda: sphere((1.0, 2.0, 3.0), 0.0), "radius is 0 but must be above 0"),
        (lambda: sphere((1.0, 2.0, 3.0), np.inf), "radius is inf"),
        (lambda: sphere((1.0, 2.0, 3.0), 1.0, 0), "count is 0 but must be a whole number"),
        (lambda: sphere((1.0, 2.0, 3.0), 1.0, 5, (1.0, 0.0, 1.0)), "spacing is"),
        (lambda: sphere("auto", 3.0), "center is"),
        (lambda: sphere(np.full((3, 2), np.nan), 3.0), "center is"),
        (lambda: sphere((1.0, 2.0, 3.0), 1j), "radius is"),
        (lambda: box((1j, 2.0, 3.0), (2.0, 5.0, 6.0)), "first is"),
        (lambda: box(object(), (2.0, 5.0, 6.0)), "first is"),
        (lambda: box((1.0, 2.0, 3.0), (1.0, 5.0, 6.0)), "must differ along every axis"),
        (lambda: box((1.0, 2.0, 3.0), (2.0, 5.0, 6.0), 0.0), "spacing is 0"),
        (lambda: box((0.0, 0.0, 0.0), (1e4, 1e4, 1e4), 0.5), "choose a larger one"),
    ],
)
def test_impossible_starts_are_refused_in_one_sentence(make, words):
    with pytest.raises(ValueError, match=words) as caught:
        make()
    assert str(caught.value).endswith(".")
    assert "\n" not in str(caught.value)
