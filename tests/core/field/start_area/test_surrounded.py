"""A start that has been drawn around a thing: it is that thing which is found, not what lies around the start."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from cpm_core.contours.contour import sample_contours
from cpm_core.field.start_area.drawn_area import drawn_area, hollow_part
from cpm_core.field.start_area.start_area import object_enclosed_by
from cpm_core.model.starts import circle, uniform_grid
from cpm_core.parameters import PRESETS
from cpm_core.segmentation.evolve import segment
from cpm_core.segmentation.select import partition

ROW, COL = np.indices((120, 160))
CELL, OTHERS = (60.0, 60.0), ((60.0, 112.0), (20.0, 95.0), (102.0, 98.0))
RADIUS = 18.0
NOWHERE_CLOSED = np.zeros(ROW.shape, bool)


def disk(center, radius=RADIUS):
    return np.hypot(ROW - center[0], COL - center[1]) <= radius


def cells(seed=0):
    """Four cells with texture on uneven ground; no part of the image is flat."""
    rng = np.random.default_rng(seed)
    bright = np.any([disk(center) for center in (CELL, *OTHERS)], axis=0)
    return 60.0 + 0.2 * COL + 80.0 * bright + rng.normal(0.0, 12.0, bright.shape)


VALUES = cells()


def dice(one, other):
    return 2.0 * np.count_nonzero(one & other) / (np.count_nonzero(one) + np.count_nonzero(other))


@pytest.mark.parametrize("radius", [RADIUS + 3.0, 1.4 * RADIUS])
def test_a_circle_around_a_cell_finds_that_cell_alone(radius):
    seeds = circle(CELL, radius)
    result = segment(VALUES, seeds, PRESETS["shape"])
    found = sample_contours(result.contours)
    assert len(found)
    assert (np.abs(np.hypot(*(found - CELL).T) - RADIUS) < 3.0).mean() > 0.95
    near = cKDTree(found).query(circle(CELL, RADIUS, 0.5))[0]
    assert (near < 3.0).mean() > 0.8
    assert dice(partition(result).select(seeds).mask, disk(CELL)) > 0.93


@pytest.mark.parametrize("radius", [0.3 * RADIUS, 0.6 * RADIUS, 0.85 * RADIUS])
def test_a_circle_in_a_cell_is_drawn_around_nothing(radius):
    assert object_enclosed_by(VALUES, circle(CELL, radius), NOWHERE_CLOSED) is None


@pytest.mark.parametrize("shift", [3.0, 5.0, 8.0])
def test_the_outline_of_a_disk_before_it_moved_is_drawn_around_nothing_and_still_finds_it(shift):
    values = np.where(disk((60.0, 60.0 + shift), 10.0), 200.0, 0.0)
    outline = circle((60.0, 60.0), 10.0)
    assert object_enclosed_by(values, outline, NOWHERE_CLOSED) is None
    (contour,) = segment(values, outline, PRESETS["shape"]).contours
    assert contour.closed
    assert contour.area == pytest.approx(np.pi * 10.0**2, rel=0.05)


def test_one_circle_around_a_cell_and_one_in_another_find_both():
    result = segment(VALUES, np.concatenate([circle(CELL, 22.0), circle(OTHERS[0], 8.0)]), PRESETS["shape"])
    found = cKDTree(sample_contours(result.contours))
    for center in (CELL, OTHERS[0]):
        assert (found.query(circle(center, RADIUS, 0.5))[0] < 3.0).mean() > 0.8
    for center in OTHERS[1:]:
        assert (found.query(circle(center, RADIUS, 0.5))[0] < 3.0).mean() < 0.1


def test_further_clicks_change_the_object_within_a_circle_and_asking_again_does_not():
    cut = partition(VALUES)
    seeds = circle(CELL, 22.0)
    first = cut.select(seeds)
    assert (cut.select(seeds).mask == first.mask).all()
    both = cut.select(np.concatenate([seeds, [OTHERS[0]]]), previous=first)
    assert dice(both.mask, disk(CELL) | disk(OTHERS[0])) > 0.9
    assert not both.mask[tuple(np.rint(circle(CELL, 24.0)).astype(int).T)].any()
    less = cut.select(np.concatenate([seeds, [OTHERS[0]]]), [OTHERS[0]], previous=both)
    assert dice(less.mask, disk(CELL)) > 0.9


@pytest.mark.parametrize(("center", "radius"), [((60.0, 8.0), 25.0), ((60.0, 80.0), 68.0)])
def test_a_circle_that_leaves_the_image_once_or_twice_encloses_what_the_border_cuts_off(center, radius):
    points = circle(center, radius)
    kept = points[((points >= 0.0) & (points <= np.array(ROW.shape) - 1.0)).all(axis=1)]
    area = drawn_area(kept, ROW.shape)
    away = np.hypot(ROW - center[0], COL - center[1])
    assert area[away < radius - 2.0].all()
    assert not area[away > radius + 2.0].any()


def test_only_a_closed_line_encloses_more_than_it_covers():
    shape = ROW.shape
    for filled in (uniform_grid(shape), np.argwhere(disk(CELL)).astype(float), np.array([CELL]), np.array([CELL] * 9)):
        assert not hollow_part(filled, drawn_area(filled, shape)).any()
    ring = circle(CELL, 22.0)
    hollow = hollow_part(ring, drawn_area(ring, shape))
    assert hollow[disk(CELL, 12.0)].all()
    assert not hollow[~disk(CELL, 21.0)].any()
