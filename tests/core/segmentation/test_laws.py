"""The laws of the whole model: rest, and what the contours of an object may not depend on.

Distances between contours are those of points every fifth of a pixel along each to the polygonal lines of the other,
both ways; the largest counts.
"""

from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree
from skimage.measure import find_contours

from cpm_core import PRESETS, Engine, Parameters, circle, segment

from ..scenes import antialiased, outline_distance, polygon

SHAPE = (72, 66)
CENTER = np.array([34.3, 32.6])


def away(row, col):
    return np.hypot(row - CENTER[0], col - CENTER[1])


def disk(row, col):
    return away(row, col) < 19.4


def ring(row, col):
    return (away(row, col) < 26.2) & (away(row, col) > 12.7)


def blob(row, col):
    angle = np.arctan2(row - CENTER[0], col - CENTER[1])
    return away(row, col) < 18.0 + 2.5 * np.cos(2.0 * angle + 0.4) + 1.5 * np.cos(3.0 * angle - 1.1)


def kidney(row, col):
    """A shape with a smooth bay."""
    angle = np.arctan2(row - CENTER[0], col - CENTER[1])
    return away(row, col) < 19.0 + 5.5 * np.cos(angle) - 3.0 * np.cos(2.0 * angle)


def square(row, col):
    """Rotated by about 20 degrees."""
    down, right = row - CENTER[0], col - CENTER[1]
    return np.maximum(np.abs(0.94 * down + 0.34 * right), np.abs(0.94 * right - 0.34 * down)) < 17.2


def u_shape(row, col):
    down, right = row - CENTER[0], col - CENTER[1]
    return (np.maximum(np.abs(down), np.abs(right)) < 21.3) & ~((np.abs(right) < 7.6) & (down < 6.8))


SMOOTH = {"disk": disk, "ring": ring, "blob": blob, "kidney": kidney}
SHAPES = {**SMOOTH, "square": square, "u": u_shape}
"""Objects, smooth and with corners, given by formulas and so at any size."""


@cache
def image(name, times=1):
    """An object enlarged by a factor; the corner of the image stays fixed."""
    inside = SHAPES[name]
    size = (times * SHAPE[0], times * SHAPE[1])
    return antialiased(size, lambda row, col: inside((row + 0.5) / times - 0.5, (col + 0.5) / times - 0.5))


@cache
def engine(name):
    return Engine(image(name), Parameters())


def final_state(with_engine, seeds, parameters):
    """Last state of a run."""
    state = with_engine.start(seeds)
    while not state.stop_reason:
        state = with_engine.step(state, parameters)
    return state


START = circle((41.3, 26.6), 16.0)
"""The circle that runs begin with; it crosses every object's boundary."""


@cache
def rest(name):
    """Last state of a run from the start."""
    return final_state(engine(name), START, Parameters())


def contours_of(name, state):
    return engine(name).result(state, Parameters()).contours


def points_along(contours, step=0.2):
    pieces = []
    for contour in contours:
        path = contour.path
        reached = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))]
        at = np.linspace(0.0, reached[-1], int(reached[-1] / step) + 2)
        pieces.append(np.stack([np.interp(at, reached, axis) for axis in path.T], axis=1))
    return np.concatenate(pieces)


def apart(ones, others):
    """Largest distance between two sets of contours, either way."""
    assert len(ones) == len(others) > 0
    there = outline_distance(points_along(ones), [contour.path for contour in others])
    back = outline_distance(points_along(others), [contour.path for contour in ones])
    return max(there.max(), back.max())


def all_closed(name, contours):
    return [contour.closed for contour in contours] == [True] * (2 if name == "ring" else 1)


@pytest.mark.parametrize("name", SHAPES)
def test_a_contour_at_rest_does_not_drift(name):
    """Three hundred further steps insert and delete no particle and move none by 0.005 px; measured: 0.0008 px."""
    state = first = rest(name)
    for _ in range(300):
        state = engine(name).step(state.resume() if state.stop_reason else state, Parameters())
    assert state.step == first.step + 300
    np.testing.assert_array_equal(state.particles.identity, first.particles.identity)
    assert np.linalg.norm(state.position - first.position, axis=1).max() < 0.005
    assert apart(contours_of(name, first), contours_of(name, state)) < 0.005


@pytest.mark.parametrize("name", SHAPES)
def test_the_order_of_the_particles_does_not_matter(name):
    """Within 0.1 px; measured: 0.03."""
    first = contours_of(name, rest(name))
    assert all_closed(name, first)
    shuffled = np.random.default_rng(0).permutation(START)
    assert apart(first, contours_of(name, final_state(engine(name), shuffled, Parameters()))) < 0.1


@pytest.mark.parametrize("name", ["blob", "square", "u"])
def test_the_start_does_not_matter(name):
    """Four circles across the boundary, no two alike, lead to the same contour; measured: 0.03 px."""
    random = np.random.default_rng(7)
    found = []
    for turn in np.linspace(0.0, 2.0 * np.pi, 4, endpoint=False):
        center = CENTER + random.uniform(5.0, 10.0) * np.array([np.sin(turn), np.cos(turn)])
        start = circle(tuple(center), random.uniform(12.0, 19.0), random.uniform(1.0, 4.0))
        found.append(contours_of(name, final_state(engine(name), start, Parameters())))
        assert all_closed(name, found[-1])
    for k, one in enumerate(found):
        for other in found[:k]:
            assert apart(one, other) < 0.1


@pytest.mark.parametrize("name", SMOOTH)
def test_twice_the_image_has_twice_the_contours(name):
    """With twice the smoothing it is the same image, sampled finer: within 0.1 px of the smaller one; measured: 0.065.

    What is left is the size of a pixel, over which the image is averaged and its differences are taken, and which does
    not double. At a right angle it shows more: 0.17 px in the square, 0.27 px in the U.
    """
    parameters = Parameters(smoothing=2.0)
    larger = Engine(image(name, 2), parameters)
    state = final_state(larger, 2.0 * START + 0.5, parameters)
    doubled = larger.result(state, parameters).contours
    assert all_closed(name, doubled)
    single = contours_of(name, rest(name))
    there = outline_distance(2.0 * points_along(single) + 0.5, [contour.path for contour in doubled])
    back = outline_distance(0.5 * (points_along(doubled) - 0.5), [contour.path for contour in single])
    assert max(0.5 * there.max(), back.max()) < 0.1


def test_too_many_scales_are_reported_with_the_number_that_the_image_has():
    with pytest.raises(ValueError, match=r"scales is 6 but must be from 1 to 4 for an image of 72 x 66 pixels"):
        Engine(image("disk"), Parameters(scales=6))
    assert Engine(image("disk"), Parameters(scales=4)).scales == 4


@pytest.mark.parametrize("distance", [60, 110])
def test_an_object_is_found_from_any_distance(distance):
    """A small circle, whose particles move for many more steps than the resting limit before they find an edge."""
    values = antialiased((120, 200), lambda row, col: np.hypot(row - 60.0, col - 170.0) < 15.0)
    result = segment(values, circle((60.0, 155.0 - distance), 6.0), Parameters(scales=1))
    assert result.converged
    assert [contour.closed for contour in result.contours] == [True]


def found_of(boundary, result):
    """Fraction of the points of a boundary within 2 px of particles."""
    return (cKDTree(result.particles).query(boundary)[0] < 2.0).mean()


def comb():
    """A body with four slits of 6 px, open to the top."""
    corners = [(8, 8)]
    for left in (28, 48, 68, 88):
        corners += [(8, left), (60, left), (60, left + 6), (8, left + 6)]
    return polygon((80, 120), np.array([*corners, (8, 112), (72, 112), (72, 8)]) + 0.375)


@pytest.mark.parametrize(("w1", "low", "high"), [(0.05 * 1.75, 0.0, 0.5), (1.6, 0.99, 1.0)])
def test_repulsion_moves_the_front_without_it_a_comb_stays_unfilled(w1, low, high):
    """Section 4.2: at the published weights particles are driven into every slit."""
    scene = comb()
    result = segment(scene.values, circle((66.0, 60.0), 4.0), Parameters(w1=w1))
    assert result.converged
    assert low <= found_of(scene.boundary, result) <= high


@pytest.mark.parametrize("parameters", [Parameters(), Parameters(scales=1), PRESETS["shape"]])
@pytest.mark.parametrize("place", [(34.0, 33.0), (28.0, 22.0)])
def test_one_clicked_point_finds_a_disk(place, parameters):
    (contour,) = segment(image("disk"), [place], parameters).contours
    assert contour.closed
    assert contour.area == pytest.approx(np.pi * 19.4**2, rel=0.02)


@pytest.mark.parametrize("scales", [3, 1])
def test_a_run_on_a_long_spiral_ends_at_rest_with_all_of_it(scales):
    """No step limit ends it before: at one scale the front comes around after more than four hundred steps."""

    def inside(row, col):
        away, angle = np.hypot(row - 79.5, col - 79.5), np.arctan2(row - 79.5, col - 79.5)
        return (np.mod(away / 12.0 - angle / (2.0 * np.pi), 1.0) < 0.5) & (away < 70.0) & (away > 6.0)

    values = antialiased((160, 160), inside)
    result = segment(values, circle((79.5, 148.5), 4.0), Parameters(scales=scales))
    assert result.converged
    assert result.steps > (400 if scales == 1 else 0)
    assert found_of(np.concatenate(find_contours(values, 120.0)), result) > 0.97
