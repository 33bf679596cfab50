"""The sides of a voxel are such that areas and volumes in them can be computed."""

import numpy as np
import pytest

import cpm_core as cpm

BALL = np.where(np.linalg.norm(np.indices((12, 12, 12)) - 5.5, axis=0) < 3.5, 200.0, 20.0)


@pytest.mark.parametrize(
    "sides", [(5e-324, 5e-324, 5e-324), (1e200, 1e200, 1e200), (1e-9, 1.0, 1.0), (1.0, 1.0, 2000.0)]
)
@pytest.mark.parametrize(
    "use",
    [
        lambda sides: cpm.Image(BALL, sides),
        lambda sides: cpm.centerlines(BALL > 99.0, sides),
        lambda sides: cpm.sphere((5.5, 5.5, 5.5), 2.0, voxel_size=sides),
    ],
)
def test_sides_that_make_no_sense_are_refused_in_a_sentence(use, sides):
    with pytest.raises(ValueError, match=r"(spacing|voxel_size).* is \(.*\.$"):
        use(sides)


@pytest.mark.parametrize("axis", [0, 2])
def test_along_voxels_of_any_length_particles_are_as_many_as_the_voxels_can_tell_apart(axis):
    found = []
    for length in (10.0, 1000.0):
        sides = np.insert([1.0, 1.0], axis, length)
        image = cpm.Image(BALL, tuple(sides))
        start = cpm.sphere((5.5, 5.5, 5.5), 2.0, 40)
        found.append(cpm.segment(image, start, cpm.PRESETS["volume"]))
    long, longer = found
    np.testing.assert_array_equal(longer.particles, long.particles)
    np.testing.assert_array_equal(longer.surface.vertices, long.surface.vertices)
    assert longer.surface.volume == pytest.approx(100.0 * long.surface.volume)
