"""Vessels: a place in a tree of fine lines means the tree, and a place in or beside anything else does not."""

from functools import cache

import numpy as np
import pytest
import scipy

from cpm_core import circle, partition
from cpm_core.image.image import as_image
from cpm_core.numerics.grids import compute_iou
from cpm_core.objects.partition import Partition
from cpm_core.objects.prior.object_predictor import ObjectPredictor, Prediction
from cpm_core.objects.vessels import find_thin_object

from ..scenes import antialiased, disk, ring

SIDE = 320
TREE = [((20, 30), (160, 140)), ((160, 140), (300, 125)), ((160, 140), (215, 300)), ((90, 85), (50, 270))]
"""Branches from place to place."""
WIDTH = 4.0


def away(row, col):
    """Distance of places from the middle lines of the tree."""
    distances = []
    for first, last in np.array(TREE, float):
        along = last - first
        share = np.clip(((row - first[0]) * along[0] + (col - first[1]) * along[1]) / (along @ along), 0.0, 1.0)
        distances.append(np.hypot(row - first[0] - share * along[0], col - first[1] - share * along[1]))
    return np.min(distances, axis=0)


DISTANCE = away(*np.indices((SIDE, SIDE), float))


@cache
def lines():
    return antialiased((SIDE, SIDE), lambda row, col: away(row, col) < 0.5 * WIDTH)


def drawn(sign, contrast=0.3, noise=2.0):
    """The tree, bright or dark, in uneven light."""
    values = (
        120.0 + sign * contrast * scipy.ndimage.gaussian_filter(lines() - 40.0, 0.8) + 0.2 * np.indices((SIDE, SIDE))[1]
    )
    return values + np.random.default_rng(2).normal(0.0, noise, values.shape)


def tree_around(values, place):
    """Pixels of the tree that holds a place; None without one."""
    found = find_thin_object(values, np.array([place]))
    return found.mask if found is not None and found.is_tree else None


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("place", [(48, 52), (160, 140), (260, 129), (182, 204), (68, 187)])
def test_a_place_anywhere_in_a_tree_means_the_whole_tree(sign, place):
    found = tree_around(drawn(sign), place)
    assert found is not None
    assert found[DISTANCE < 0.5].mean() > 0.95
    assert (DISTANCE[found] < 0.5 * WIDTH + 3.0).mean() > 0.95


@pytest.mark.parametrize("given", [{"inside": [(104, 96)]}, {"stroke": [(48, 52), (104, 96), (125, 112)]}])
def test_a_click_or_stroke_on_a_vessel_selects_its_tree(given):
    chosen = Partition(as_image(drawn(-1.0)), ()).select(**given)
    assert chosen.mask[DISTANCE < 0.5].mean() > 0.95
    assert (DISTANCE[chosen.mask] < 0.5 * WIDTH + 3.0).mean() > 0.95


@pytest.mark.parametrize("place", [(104, 115), (5, 5), (220, 60)])
def test_a_place_beside_a_tree_is_not_in_it(place):
    assert tree_around(drawn(-1.0), place) is None


def test_what_is_beyond_a_gap_belongs_to_another_tree():
    values = drawn(1.0)
    values[205:235] = drawn(0.0)[205:235]
    found = tree_around(values, (104, 96))
    assert found is not None
    assert not found[240:].any()


def test_disks_their_edges_and_rings_are_no_trees():
    for radius in (2.0, 4.0, 8.0, 30.0):
        scene = disk((96, 96), (47.3, 46.6), radius)
        for place in ((47, 47), (47, round(46.6 + radius)), (47, round(46.6 - radius))):
            assert tree_around(scene.values, place) is None
    rim = ring((96, 96), (47.3, 46.6), 27.0, 30.0)
    assert tree_around(rim.values, (47, 75)) is None


def test_noise_has_no_trees():
    values = np.random.default_rng(4).normal(100.0, 20.0, (200, 200))
    places = np.random.default_rng(5).integers(0, 200, (60, 2))
    assert all(tree_around(values, place) is None for place in places)


def test_a_circle_drawn_across_a_vessel_does_not_mean_the_tree():
    chosen = partition(drawn(-1.0)).select(circle((60, 150), 12.0))
    assert chosen.mask[DISTANCE < 0.5].mean() < 0.5


def test_a_click_on_a_crack_selects_all_of_it_where_the_network_finds_nothing_likely():
    row, col = np.indices((200, 200), float)
    crack = (np.abs(col - 100.0 - 25.0 * np.sin(row / 20.0)) < 1.5) & (np.abs(row - 100.0) < 70.0)
    values = 120.0 - 60.0 * scipy.ndimage.gaussian_filter(crack * 1.0, 0.8)
    cut = Partition(as_image(values + np.random.default_rng(3).normal(0.0, 8.0, values.shape)), ())
    chosen = cut.select([np.argwhere(crack)[crack.sum() // 2]])
    assert chosen.mask[crack].mean() > 0.95
    assert (scipy.ndimage.distance_transform_edt(~crack)[chosen.mask] < 3.5).mean() > 0.9


def test_a_line_within_a_much_larger_answer_does_not_precede_it(monkeypatch):
    row, col = np.indices((200, 200), float)
    line = (np.abs(col - 100.0) < 1.5) & (np.abs(row - 100.0) < 70.0)
    for radius, first in ((6.0, line), (60.0, np.hypot(row - 100.0, col - 100.0) < 60.0)):
        found = np.hypot(row - 100.0, col - 100.0) < radius
        unlikely = Prediction(found, 1.0, 0.05, 0.05, 0.05, 0.05)
        monkeypatch.setattr(ObjectPredictor, "predict_objects", lambda *_, one=unlikely: iter([one]))
        chosen = Partition(as_image(120.0 - 60.0 * line), ()).select([(100.0, 100.0)])
        assert compute_iou(chosen.mask, first) > 0.7
