"""Objects in a volume as limits and as parts of a larger object: voxels inside, surfaces that stay closed."""

import numpy as np
import pytest

from cpm_core import VolumeTruth, segment, sphere
from cpm_core.image.region import Region
from cpm_core.objects.segmented.areas import unite_bodies
from cpm_core.parameters import PRESETS
from cpm_core.shapes.document_shapes import collect_regions

SHAPE = (28, 30, 40)
RADIUS = 6.0


def ball(center, radius=RADIUS, shape=SHAPE):
    return np.linalg.norm(np.moveaxis(np.indices(shape), 0, -1) - center, axis=-1) <= radius


def packed(mask):
    """The surface of a mask, closed also at the border."""
    surface = VolumeTruth(np.pad(mask, 2)).surface
    return Region.from_surface(type(surface)(surface.vertices - 2.0, surface.faces))


ONE, FAR = ball((13, 14, 10)), ball((13, 14, 28))


def test_a_surface_that_spans_far_more_than_a_volume_is_refused():
    surface = VolumeTruth(ONE).surface
    with pytest.raises(ValueError, match=r"spans .* voxels, but at most .* make it smaller"):
        Region.from_surface(type(surface)(100.0 * surface.vertices, surface.faces))


def filled(region, shape=SHAPE):
    return region.paste(shape)


def test_the_voxels_of_a_surface_are_those_inside_wherever_they_are():
    one = packed(ONE)
    assert np.array_equal(filled(one), ONE)
    moved = one.translated((1, 2, 3))
    assert np.array_equal(filled(moved), ball((14, 16, 13)))
    outside = one.translated((0, 0, -10))  # half of it lies beyond the volume
    assert np.array_equal(filled(outside), ball((13, 14, 0)))
    for step in ((0, 0, -90), (0, 50, 0)):  # all of it does
        assert not filled(one.translated(step)).any()


def test_the_shell_parts_inside_from_outside():
    one = packed(ONE)
    shell = filled(one.shell)
    assert (shell & ~ONE).sum() == 0
    inner = ONE & ~shell
    assert inner[13, 14, 10]
    beside = np.zeros(SHAPE, bool)
    for axis in range(3):
        for step in (-1, 1):
            beside |= np.roll(inner, step, axis)
    assert not (beside & ~ONE).any()


@pytest.mark.parametrize("apart", [4, 8, 11])
def test_objects_that_overlap_have_one_closed_surface_around_all_voxels(apart):
    other = ball((13, 14, 10 + apart))
    both = unite_bodies(packed(ONE), packed(other))
    assert (both.surface.components, both.surface.closed, both.surface.euler) == (1, True, 2)
    found = filled(both)
    assert (found ^ (ONE | other)).sum() <= 0.02 * found.sum()


def test_objects_with_a_wall_in_common_become_one_without_it():
    box = np.zeros(SHAPE, bool)
    box[6:20, 6:20, 6:16] = True
    beside = np.zeros(SHAPE, bool)
    beside[6:20, 6:20, 16:30] = True
    both = unite_bodies(packed(box), packed(beside))
    assert (both.surface.components, both.surface.closed) == (1, True)
    assert filled(both)[8:18, 8:18, 8:28].all()


def test_no_particle_of_a_run_enters_a_frozen_object():
    values = 20.0 + 150.0 * (ball((13, 14, 10), RADIUS) | ball((13, 14, 22), RADIUS))
    regions = collect_regions((), (packed(ball((13, 14, 22), RADIUS)).shell,))
    seeds = sphere((13, 14, 10), 3, 60)
    free = segment(values, seeds, PRESETS["volume"])
    held = segment(values, seeds, PRESETS["volume"], regions=regions)
    assert free.labels[13, 14, 22] > 0
    assert held.labels[13, 14, 10] > 0
    assert regions.allows(held.particles).all()
