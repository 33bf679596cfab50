"""Merged basins: each node is what its basins cover, any region between edges is one, and units make no difference."""

import numpy as np
import pytest
import scipy

from cpm_core.field.edge_map import edge_map
from cpm_core.objects.merged_basins import MergedBasins

LABELS = scipy.spatial.cKDTree([(20, 15), (20, 60), (60, 30), (60, 75), (90, 50)]).query(
    np.stack(np.indices((100, 90)), axis=-1)
)[1]
LEVELS = np.array([40.0, 120.0, 200.0, 80.0, 160.0])
VALUES = scipy.ndimage.gaussian_filter(LEVELS[LABELS], 1.0) + np.random.default_rng(1).normal(0.0, 2.0, LABELS.shape)


def merged(values):
    return MergedBasins.from_edges(edge_map(values, 1.5), np.zeros(values.shape, bool), float(np.ptp(values)))


@pytest.fixture(scope="module")
def tree():
    return merged(VALUES)


def test_every_node_has_the_area_of_its_basins_and_the_last_one_is_the_image(tree):
    areas = np.bincount(tree.labels.ravel(), minlength=len(tree.area)).astype(float)[:, None]
    assert (tree.accumulate(areas, np.add)[1:, 0] == tree.area[1:]).all()
    assert tree.area[-1] == VALUES.size
    assert np.flatnonzero(tree.parent == 0)[1:].tolist() == [len(tree.parent) - 1]


def test_each_region_between_edges_is_a_node(tree):
    common = np.zeros((len(tree.area), 5))
    np.add.at(common, (tree.labels.ravel(), LABELS.ravel()), 1.0)
    tree.accumulate(common, np.add)
    overlaps = common / (tree.area[:, None] + np.bincount(LABELS.ravel()) - common)
    assert (overlaps.max(axis=0) > 0.9).all()


def test_each_region_found_is_a_node_with_all_its_pixels_in_the_smallest_box(tree):
    span = float(np.ptp(VALUES))
    sizes = {float(area) for area in tree.area}
    found = list(tree.find_regions(VALUES, span))
    assert found
    for box, mask in found:
        assert float(mask.sum()) in sizes
        assert mask.shape == tuple(side.stop - side.start for side in box)
        assert all(mask.any(axis=axis)[[0, -1]].all() for axis in (0, 1))
        assert np.array_equal(np.isin(tree.labels[box], tree.labels[box][mask]), mask)


def test_the_nodes_around_a_pixel_are_those_that_hold_it_each_in_the_next(tree):
    pixel, before = (20, 15), np.zeros(VALUES.shape, bool)
    for box, mask in tree.find_regions_around(pixel):
        now = np.zeros(VALUES.shape, bool)
        now[box] = mask
        assert now[pixel]
        assert now[before].all()
        assert now.sum() > before.sum()
        before = now
    assert before.all()


def test_the_unit_of_gray_levels_makes_no_difference(tree):
    again = merged(VALUES / 8.0)
    assert (again.labels == tree.labels).all()
    assert (again.parent == tree.parent).all()


def test_an_image_without_edges_is_one_basin():
    flat = MergedBasins.from_edges(np.zeros((20, 30)), np.zeros((20, 30), bool), 1.0)
    assert (flat.labels == 1).all()
    assert flat.area[1:].tolist() == [600.0]
