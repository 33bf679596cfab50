"""Candidates: floods, holes and links against brute force, and what further clicks may change."""

import numpy as np
import pytest
import scipy.ndimage as ndi
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from cpm_core import partition
from cpm_core.objects.candidates.flooding import flood
from cpm_core.objects.candidates.grids import grid_over, linked, without_holes
from cpm_core.objects.candidates.ranking import Ranking

SIDES = st.integers(4, 12)
LEVELS = 6

levels = st.tuples(SIDES, SIDES).flatmap(lambda shape: hnp.arrays(np.int16, shape, elements=st.integers(0, LEVELS - 1)))
masks = st.tuples(SIDES, SIDES).flatmap(lambda shape: hnp.arrays(np.bool_, shape))


@settings(deadline=None)
@given(levels, st.data())
def test_what_a_flood_reaches_is_the_component_of_the_threshold_that_holds_the_seed(level, data):
    seed = tuple(data.draw(st.integers(0, size - 1)) for size in level.shape)
    found = flood(level, LEVELS, np.ones(level.shape, np.bool_), np.array([seed]), level.size + 1)
    assert found.counts[-1] == level.size
    for count, box, reached in zip(found.counts, found.boxes, found.levels, strict=True):
        parts, _ = ndi.label(level <= reached)
        component = parts == parts[seed]
        assert np.array_equal(found.position < count, component)
        rows, cols = np.nonzero(component)
        assert box.tolist() == [rows.min(), rows.max() + 1, cols.min(), cols.max() + 1]


@settings(deadline=None)
@given(levels, st.data())
def test_a_flood_stays_where_it_is_allowed(level, data):
    allowed = data.draw(hnp.arrays(np.bool_, level.shape))
    seed = tuple(data.draw(st.integers(0, size - 1)) for size in level.shape)
    allowed[seed] = True
    found = flood(level, LEVELS, allowed, np.array([seed]), level.size)
    parts, _ = ndi.label(allowed)
    assert np.array_equal(found.position < level.size, parts == parts[seed])


@settings(deadline=None)
@given(masks)
def test_holes_are_those_of_scipy(mask):
    nowhere = np.empty((0, 2), np.int64)
    assert np.array_equal(without_holes(mask, nowhere), ndi.binary_fill_holes(mask))


def test_a_hole_that_holds_a_place_outside_stays_open():
    mask = np.ones((7, 14), np.bool_)
    mask[2:5, 2:5] = mask[2:5, 9:12] = False
    filled = without_holes(mask, np.array([[3, 3]]))
    assert not filled[2:5, 2:5].any()
    assert filled[2:5, 9:12].all()


@settings(deadline=None)
@given(masks, st.data())
def test_what_is_linked_are_the_components_of_the_seeds(mask, data):
    place = st.tuples(*(st.integers(0, size - 1) for size in mask.shape))
    seeds = np.array(data.draw(st.lists(place, max_size=4)), np.int64).reshape(-1, 2)
    parts, _ = ndi.label(mask)
    wanted = set(parts[seeds[:, 0], seeds[:, 1]]) - {0}
    assert np.array_equal(linked(mask, seeds), np.isin(parts, list(wanted)))


@pytest.mark.parametrize("box", [(3, 9, 0, 20), (0, 300, 10, 400), (100, 500, 100, 130)])
def test_a_grid_covers_its_box_and_points_are_found_again(box):
    grid = grid_over(box, (500, 401))
    stride = 1 << grid.scale
    assert grid.rows[0] <= box[0] + stride
    assert grid.rows[-1] >= box[1] - 1 - stride
    assert grid.cols[0] <= box[2] + stride
    assert grid.cols[-1] >= box[3] - 1 - stride
    pixels = np.stack(np.meshgrid(grid.rows[:5], grid.cols[:5], indexing="ij"), axis=-1).reshape(-1, 2)
    points = grid.nearest(pixels)
    assert np.array_equal(grid.rows[points[:, 0]], pixels[:, 0])
    assert np.array_equal(grid.cols[points[:, 1]], pixels[:, 1])


def test_a_score_is_linear_and_limited():
    ranking = Ranking({"a": (1.0, 2.0, 3.0), "b": (0.0, 1.0, -1.0)})
    assert ranking.scores(np.array([[3.0, 2.0], [1e6, 0.0]])).tolist() == [3.0 - 2.0, 9.0]


@pytest.fixture(scope="module")
def speckled():
    """A partition of an image of blobs with noise."""
    noise = np.random.default_rng(3).normal(0.0, 1.0, (96, 96))
    values = 100.0 + 60.0 * (ndi.gaussian_filter(noise, 7.0) > 0.01) + 6.0 * noise
    return partition(values)


places = st.tuples(st.integers(0, 95), st.integers(0, 95))


@settings(max_examples=10, deadline=None)
@given(st.lists(places, min_size=1, max_size=4, unique=True), st.lists(places, max_size=3, unique=True))
def test_an_object_holds_every_place_inside_and_none_outside(speckled, inside, outside):
    outside = [place for place in outside if place not in inside]
    mask = speckled.select(inside, outside).mask
    assert all(mask[place] for place in inside)
    assert not any(mask[place] for place in outside)


@settings(max_examples=10, deadline=None)
@given(st.lists(places, min_size=3, max_size=3, unique=True))
def test_a_place_inside_only_adds_and_one_outside_only_takes_away(speckled, three):
    first, second, third = three
    before = speckled.select([first])
    larger = speckled.select([first, second], previous=before)
    assert not (before.mask & ~larger.mask).any()
    smaller = speckled.select([first, second], [third], previous=larger)
    assert not (smaller.mask & ~larger.mask).any()


def test_taking_back_a_click_gives_the_object_before_it(speckled):
    one = speckled.select([(20, 20)])
    speckled.select([(20, 20), (60, 70)])
    assert np.array_equal(speckled.select([(20, 20)]).mask, one.mask)
