"""What particles have closed beyond doubt is offered exactly; what is doubtful is left to others."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.model.starts import circle
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.segmentation.evolve import segment
from cpm_core.segmentation.select import partition, select_all

ROW, COL = np.indices((112, 120)).astype(float)


def disk(center, radius):
    return np.clip(radius + 0.5 - np.hypot(ROW - center[0], COL - center[1]), 0.0, 1.0)


def box(top, left, bottom, right):
    return ((top < ROW) & (bottom > ROW) & (left < COL) & (right > COL)).astype(float)


def noisy(image, deviation=8.0):
    return image + np.random.default_rng(3).normal(0.0, deviation, image.shape)


RING = disk((56, 60), 40) - disk((50, 64), 14)
U = box(14.5, 20.5, 98.5, 98.5) - box(14.5, 46.5, 70.5, 72.5)


SHAPE = PRESETS["shape"]


@cache
def ring_cut():
    return partition(noisy(200.0 * RING))


def dice(one, other):
    return 2 * np.count_nonzero(one & other) / (np.count_nonzero(one) + np.count_nonzero(other))


@pytest.mark.parametrize(
    ("shape", "start"),
    [(RING, circle((84, 60), 7)), (RING, circle((92, 60), 9)), (U, circle((60, 33), 8)), (U, circle((60, 24), 9))],
    ids=["in a ring", "across a ring", "in a U", "across a U"],
)
def test_an_object_that_particles_close_from_a_circle_is_offered_exactly(shape, start):
    chosen = partition(segment(noisy(200.0 * shape), start, SHAPE)).select(start)
    assert dice(chosen.mask, shape > 0.5) > 0.985
    assert not chosen.gaps


def test_a_region_inside_is_a_hole_if_the_image_changes_the_same_way_as_around_the_object_and_else_a_part():
    dark, bright = partition(200.0 * RING), partition(100.0 * disk((56, 60), 40) + 100.0 * disk((50, 64), 14))
    assert dice(dark.select([(84, 60)]).mask, RING > 0.5) > 0.985
    assert dice(bright.select([(84, 60)]).mask, disk((56, 60), 40) > 0.5) > 0.985
    assert dice(bright.select([(50, 64)]).mask, disk((50, 64), 14) > 0.5) > 0.97


@settings(max_examples=15, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 111), st.integers(0, 119)), min_size=1, max_size=6, unique=True))
def test_a_further_click_that_is_right_never_makes_the_object_worse(places):
    truth, selection = RING > 0.5, ring_cut().select([(84, 60)])
    inside, outside, before = [(84.0, 60.0)], [], dice(selection.mask, truth)
    for place in places:
        (inside if truth[place] else outside).append(place)
        selection = ring_cut().select(inside, outside, previous=selection)
        assert dice(selection.mask, truth) >= before
        before = dice(selection.mask, truth)


def test_a_click_in_another_closed_object_adds_just_that_one_and_outside_takes_just_that_one_away():
    one, other = disk((30, 30), 16), disk((80, 84), 22)
    cut = partition(noisy(180.0 * (one + other)))
    first = cut.select([(30, 30)])
    both = cut.select([(30, 30), (80, 84)], previous=first)
    assert dice(first.mask, one > 0.5) > 0.985
    assert dice(both.mask, one + other > 0.5) > 0.985
    assert cut.select([(30, 30)], [(84, 80)], previous=both).has_same_region(first)


def test_a_start_across_the_boundary_of_an_object_traces_all_of_it_and_nothing_of_its_neighbor():
    object_, neighbor = disk((56, 36), 26), disk((56, 92), 22)
    result = segment(noisy(200.0 * (object_ + neighbor)), circle((56, 18), 13), SHAPE)
    assert [contour.closed for contour in result.contours] == [True]
    assert abs(result.contours[0].area - np.pi * 26**2) < 0.01 * np.pi * 26**2


@pytest.mark.parametrize(
    ("values", "objects"),
    [
        (noisy(200.0 * RING), [RING]),
        (noisy(200.0 * RING + 200.0 * disk((50, 64), 6)), [RING, disk((50, 64), 6)]),
        (100.0 * disk((56, 60), 40) + 100.0 * disk((50, 64), 14), [disk((56, 60), 40), disk((50, 64), 14)]),
    ],
    ids=["a hole", "an object in a hole", "a part"],
)
def test_everywhere_parts_and_what_lies_in_holes_are_objects_and_holes_are_not(values, objects):
    found = select_all(values, parameters=Parameters(smoothing=1.5))
    assert len(found) == len(objects)
    for truth in objects:
        assert max(dice(one.mask, truth > 0.5) for one in found) > 0.95
