"""The area of a start: what encloses it, from the image and the start alone."""

from dataclasses import replace

import numpy as np
import pytest

from cpm_core.field import scale_field
from cpm_core.field.start_area.drawn_area import drawn_area, is_everywhere, typical_radius
from cpm_core.field.start_area.start_area import find_start_area
from cpm_core.image.regions import Regions
from cpm_core.model.starts import circle, uniform_grid
from cpm_core.parameters import PRESETS, UNLIMITED_REACH
from cpm_core.segmentation import local_fields
from cpm_core.segmentation.engine import Engine

SHAPE = PRESETS["shape"]
ROW, COL = np.indices((96, 160))
LEFT, RIGHT, RADIUS = (48.0, 40.0), (48.0, 120.0), 22.0
START = circle(LEFT, 10.0)
BAND = 5.0
"""Width around an object that its area includes: the edge itself, its smoothing, and a pixel [px]."""


def within(center, radius=RADIUS):
    return np.hypot(ROW - center[0], COL - center[1]) <= radius


def disk(center, radius=RADIUS, level=200.0):
    return level * np.clip(radius + 0.5 - np.hypot(ROW - center[0], COL - center[1]), 0.0, 1.0)


TWO = disk(LEFT) + disk(RIGHT)


def area_of(values, start, closed=None):
    found = find_start_area(values, start, np.zeros(values.shape, bool) if closed is None else closed)
    return None if found is None else found[0]


def bounds(area, *objects):
    """Whether an area holds all objects, disks as (center, radius), and nothing farther from them than their edge."""
    held = np.any([within(*each) for each in objects], axis=0)
    around = np.any([within(center, radius + BAND) for center, radius in objects], axis=0)
    return bool(area[held].all() and not area[~around].any())


@pytest.mark.parametrize(
    ("start", "objects"),
    [
        (START, [(LEFT, RADIUS)]),
        (circle((48.0, 52.0), 16.0), [(LEFT, RADIUS)]),
        (circle(LEFT, 28.0), [(LEFT, RADIUS)]),
        (np.array([LEFT]), [(LEFT, RADIUS)]),
        (np.concatenate([START, circle(RIGHT, 10.0)]), [(LEFT, RADIUS), (RIGHT, RADIUS)]),
    ],
    ids=["in it", "across its edge", "around it", "one click", "in each of two"],
)
def test_the_area_of_a_start_is_the_object_that_it_is_in_across_or_around(start, objects):
    assert bounds(area_of(TWO, start), *objects)


@pytest.mark.parametrize("center", [(48.0, 26.0), (26.0, 26.0), (69.0, 133.0)])
def test_an_object_near_the_border_of_the_image_is_enclosed_as_any_other(center):
    assert bounds(area_of(disk(center), circle(center, 8.0)), (center, RADIUS))


def test_noise_does_not_open_an_object():
    values = TWO + np.random.default_rng(0).normal(0.0, 20.0, TWO.shape)
    assert bounds(area_of(values, START), (LEFT, RADIUS))


def test_a_start_in_the_open_or_from_everywhere_has_no_area():
    assert area_of(TWO, circle((20.0, 80.0), 6.0)) is None
    assert area_of(TWO, uniform_grid(TWO.shape)) is None


def test_a_second_start_in_the_open_takes_nothing_from_one_in_an_object():
    both = np.concatenate([START, circle((20.0, 80.0), 6.0)])
    assert area_of(TWO, both)[within(LEFT)].all()


@pytest.mark.parametrize("start", [(48.0, 56.0), (48.0, 104.0)])
def test_two_disks_that_touch_are_one_area_where_the_edge_around_them_is_stronger(start):
    """A gray and a bright disk on black: the step between them is less than either's to the ground."""
    values = np.maximum(disk((48.0, 56.0), 24.5, 120.0), disk((48.0, 104.0), 24.5))
    found = area_of(values, circle(start, 10.0))
    assert found[within((48.0, 56.0), 24.0) | within((48.0, 104.0), 24.0)].all()
    assert not found[~(within((48.0, 56.0), 29.0) | within((48.0, 104.0), 29.0))].any()


def test_a_line_as_strong_as_the_edge_around_two_disks_parts_them():
    values = np.where(np.abs(COL - 80) < 2, 0.0, np.maximum(disk((48.0, 56.0), 24.5), disk((48.0, 104.0), 24.5)))
    found = area_of(values, circle((48.0, 104.0), 10.0))
    assert found[within((48.0, 104.0), 24.0) & (COL > 82)].all()
    assert not found[:, :75].any()


def test_the_same_object_in_a_large_image_has_the_same_area():
    """Searched in a window: an image of five million pixels is not flooded."""
    large = np.zeros((2100, 2400), np.float32)
    corner = np.array((900, 1000))
    place = (slice(900, 996), slice(1000, 1160))
    large[place] = TWO
    found = Engine(large, SHAPE).start_area(START + corner, SHAPE)
    assert found.sum() == found[place].sum()
    np.testing.assert_array_equal(found[place], area_of(TWO, START))


@pytest.fixture
def searches(monkeypatch):
    """Starts whose area was searched, and fields that were packed."""
    calls = {"areas": 0, "fields": 0}

    def counting(name, whole):
        def call(*given, **named):
            calls[name] += 1
            return whole(*given, **named)

        return call

    monkeypatch.setattr(local_fields, "find_start_area", counting("areas", local_fields.find_start_area))
    monkeypatch.setattr(scale_field, "pack_force", counting("fields", scale_field.pack_force))
    return calls


def test_the_area_is_made_once_for_a_start_and_no_slider_makes_it_or_a_field_again(searches):
    engine = Engine(TWO, SHAPE)
    state = engine.start(START)
    states = [state]
    while state.scale or state.step_of_scale < 3:
        state = engine.step(state, SHAPE)
        states.append(state)
    area, before = engine.start_area(state.start, SHAPE), dict(searches)
    assert before["areas"] == 1
    for name, values in (("beta", (0.1, 2.0)), ("w1", (0.0, 1.74)), ("w2", (1.65, 3.0)), ("annealing", (0.9, 1.0))):
        for value in values:
            moved = replace(SHAPE, **{name: value})
            for state in states[:: len(states) // 3]:
                engine.step(state, moved)
            assert engine.start_area(state.start, moved) is area
    assert searches == before


def test_without_a_limit_there_is_neither_an_area_nor_a_weakest_edge(searches):
    free = replace(SHAPE, reach=UNLIMITED_REACH)
    engine = Engine(TWO, free)
    state = engine.start(START)
    assert engine.start_area(state.start, free) is None
    assert engine._field_of(state, free) is engine.scale_field(free, state.scale)
    assert searches["areas"] == 0


def test_edges_weaker_than_a_fraction_of_those_around_the_area_hold_no_particle():
    values = disk(LEFT) + disk(RIGHT, level=60.0)
    engine = Engine(values, SHAPE)
    state = engine.start(START)
    for weakest, holds in ((0.2, True), (0.5, False)):
        field = engine._local_fields.field_at(0, state.start, replace(SHAPE, weakest_edge=weakest), None)
        first, other = field.strength_at(np.array([(48.0, 40.0 + RADIUS), (48.0, 120.0 + RADIUS)])) >= field.floor
        assert first
        assert other == holds


@pytest.mark.parametrize(
    "regions",
    [Regions(barriers=(((4.0, 46.0), (92.0, 46.0)),)), Regions(interest=(((0, 0), (95, 0), (95, 46), (0, 46)),))],
    ids=["barrier", "region of interest"],
)
def test_an_area_ends_where_particles_may_not_go(regions):
    values = TWO + np.random.default_rng(0).normal(0.0, 20.0, TWO.shape)
    start = circle((48.0, 30.0), 8.0)
    found = Engine(values, SHAPE, regions).start_area(start, SHAPE)
    assert found[drawn_area(start, values.shape)].all()
    assert not found[:, 50:].any()


def test_what_a_closed_row_of_places_covers_is_its_inside():
    area = drawn_area(circle((30.0, 40.0), 12.0), (64, 96))
    row, col = np.indices(area.shape)
    away = np.hypot(row - 30.0, col - 40.0)
    assert area[away < 11.0].all()
    assert not area[away > 13.5].any()
    assert typical_radius(area) == pytest.approx(12.0, abs=1.5)


@pytest.mark.parametrize("rows", [24, 37, 64, 100, 331])
@pytest.mark.parametrize("cols", [24, 50, 97, 160, 398])
def test_a_grid_is_everywhere_in_an_image_of_any_size_but_no_line_and_no_half_of_it(rows, cols):
    assert is_everywhere(uniform_grid((rows, cols)), (rows, cols))
    assert not is_everywhere(uniform_grid((rows, cols // 2)), (rows, cols))
    assert not is_everywhere(circle((rows / 2, cols / 2), 0.4 * min(rows, cols)), (rows, cols))
