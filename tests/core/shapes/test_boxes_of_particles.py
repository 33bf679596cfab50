"""Grids and thresholds in boxes of a volume, and starts at its centers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cpm_core import Image, example, seeds_at_centers, seeds_everywhere, segment
from cpm_core.formats.common.json_values import shape_from_json, shape_to_json
from cpm_core.model.volume.starts import volume_edge_strength
from cpm_core.parameters import PRESETS
from cpm_core.shapes import BoxGrid, BoxThreshold, Threshold
from cpm_core.shapes.document_shapes import compute_seeds
from cpm_core.shapes.image_starts import SeedCache

corners = st.tuples(*[st.floats(0, 40)] * 3)


@given(corners, corners, st.floats(2, 20), st.tuples(*[st.floats(0.5, 5)] * 3))
def test_a_grid_fills_its_box_evenly(one, size, spacing, sides):
    last = tuple(a + b + 1 for a, b in zip(one, size, strict=True))
    grid = BoxGrid(one, last, spacing, tuple(side / min(sides) for side in sides))
    seeds = grid.seeds()
    assert (seeds >= np.array(grid.first) - 1e-6).all()
    assert (seeds <= np.array(grid.last) + 1e-6).all()
    for axis in range(3):
        along = np.unique(np.round(seeds[:, axis] * grid.sides[axis], 6))
        assert np.allclose(np.diff(along), spacing, atol=1e-4)
        room = (grid.last[axis] - grid.first[axis]) * grid.sides[axis] - np.ptp(along)
        assert room < spacing + 1e-4
    assert shape_from_json(shape_to_json(grid), "shape 1") == grid


@pytest.mark.parametrize("smoothing", [0.0, 1.5])
def test_a_threshold_takes_the_voxels_above_a_fraction_of_the_strongest_in_its_box(smoothing):
    volume = example("ball")
    box = BoxThreshold((2.0, 3.0, 4.0), (15.0, 28.0, 29.0), 0.5)
    (seeds,) = SeedCache(volume).seeds_for([box], smoothing).values()
    strength = volume_edge_strength(volume, smoothing)[2:16, 3:29, 4:30]
    assert np.array_equal(seeds, np.argwhere(strength > 0.5 * strength.max()) + np.array((2, 3, 4)))
    assert box.resized_by(1).fraction == 0.52
    assert box.resized_by(100).fraction == 0.98
    outside = BoxThreshold((90.0, 90.0, 90.0), (99.0, 99.0, 99.0))
    assert SeedCache(volume).seeds_for([outside], smoothing)[outside].shape == (0, 3)
    assert shape_from_json(shape_to_json(box), "shape 1") == box


def test_areas_of_images_and_boxes_of_volumes_are_not_taken_for_each_other():
    corners = ((0.0, 0.0), (0.0, 9.0), (9.0, 9.0))
    with pytest.raises(ValueError, match="is for images, but ball is taken as a volume"):
        compute_seeds(example("ball"), [Threshold(corners)], 1.0)
    with pytest.raises(ValueError, match="is for volumes, but disk is taken as an image"):
        compute_seeds(example("disk"), [BoxThreshold((0, 0, 0), (9, 9, 9))], 1.0)


@pytest.mark.parametrize("sides", [(1.0, 1.0, 1.0), (3.0, 1.0, 1.0)])
def test_centers_lie_in_the_middle_of_objects_and_lead_to_the_same_surface(sides):
    places = np.moveaxis(np.indices((16 if sides[0] > 1 else 40, 40, 60)), 0, -1) * sides
    away = np.minimum(*(np.linalg.norm(places - np.array(at), axis=-1) for at in ((21, 20, 16), (21, 20, 44))))
    volume = Image(20.0 + 180.0 * np.clip(10.5 - away, 0, 1), spacing=sides)
    seeds = seeds_at_centers(volume)
    for center in ((21, 20, 16), (21, 20, 44)):
        assert np.linalg.norm(seeds * sides - center, axis=1).min() < 3.0
    assert len(seeds) < 0.5 * len(seeds_everywhere(volume))
    found = segment(volume, seeds, PRESETS["volume"])
    assert found.surface.components == 2
