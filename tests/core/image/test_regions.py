"""Regions of interest and barriers: no particle leaves the former or crosses the latter, with any parameters."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cpm_core import Engine, Parameters, Regions, circle, segment, uniform_grid
from cpm_core.image.pyramid import build_pyramid, to_image
from cpm_core.image.regions import build_barrier_map

from ..scenes import disk, ring

SHAPE = (56, 60)
SCENE = ring(SHAPE, (27.3, 29.6), 9.0, 19.0)
GRID = uniform_grid(SHAPE, 6.0)


def crossing(a, b, p, q):
    """Which of the ways ab, shapes (N, 2), cross the segment pq, by Cramer's rule for the place."""
    way, side, away = (np.moveaxis(np.asarray(v), -1, 0) for v in (b - a, q - p, p - a))
    turn = way[0] * side[1] - way[1] * side[0]
    safe = np.where(np.abs(turn) < 1e-12, np.nan, turn)
    t = (away[0] * side[1] - away[1] * side[0]) / safe
    s = (away[0] * way[1] - away[1] * way[0]) / safe
    return (t > 0.0) & (t < 1.0) & (s > 0.0) & (s < 1.0)


def winding(polygon, points):
    """Turns of a polygon around points, by the sum of the angles."""
    corners = np.array([*polygon, polygon[0]])
    away = corners[None] - points[:, None]
    angle = np.arctan2(away[..., 0], away[..., 1])
    turn = np.diff(angle, axis=1)
    return np.rint(((turn + np.pi) % (2.0 * np.pi) - np.pi).sum(axis=1) / (2.0 * np.pi)).astype(int)


def in_union(polygons, points):
    return np.any([winding(polygon, points) != 0 for polygon in polygons], axis=0)


places = st.tuples(st.integers(-32, 480), st.integers(-32, 512)).map(lambda p: (p[0] / 8.0, p[1] / 8.0))
barriers = st.lists(places, min_size=2, max_size=4, unique=True).map(tuple)
polygons = st.lists(places, min_size=3, max_size=6, unique=True).map(tuple)


@st.composite
def settings_of_a_run(draw):
    """Parameters anywhere within what a slider offers, and the extremes."""
    w2 = draw(st.floats(0.2, 6.0))
    return Parameters(
        beta=draw(st.sampled_from([0.0, 0.1, 0.8, 4.0])),
        time_step=draw(st.sampled_from([0.05, 0.5, 1.0])),
        w2=w2,
        w1=w2 * draw(st.floats(0.0, 0.99)),
        d_min=draw(st.floats(1.0, 6.0)),
        d_max=draw(st.floats(0.0, 10.0)),
        scales=draw(st.integers(1, 3)),
    )


def steps(regions, parameters, seeds=GRID, count=30):
    """Pairs of states that follow each other."""
    engine = Engine(SCENE.values, parameters, regions)
    state = engine.start(seeds)
    for _ in range(count):
        after = engine.step(state, parameters)
        yield state, after
        if after.stop_reason:
            return
        state = after


@settings(max_examples=12, deadline=None)
@given(barriers, settings_of_a_run())
def test_no_particle_ever_crosses_a_barrier(barrier, parameters):
    lines = np.array(barrier)
    made = steps(Regions(barriers=(barrier,)), parameters)
    at_one_scale = [(before, after) for before, after in made if before.scale == after.scale]
    assert at_one_scale
    for before, after in at_one_scale:
        both, old, new = np.intersect1d(before.particles.identity, after.particles.identity, return_indices=True)
        assert len(both) or not before.count or not after.count
        for p, q in pairwise(lines):
            assert not crossing(before.position[old], after.position[new], p, q).any()


@settings(max_examples=12, deadline=None)
@given(st.tuples(st.floats(-0.3, 0.3), st.floats(10.0, 45.0)), settings_of_a_run())
def test_no_particle_gets_or_is_born_beyond_a_barrier_across_the_image(line, parameters):
    slope, offset = line
    seeds = GRID[GRID[:, 1] < offset + slope * GRID[:, 0] - 1.0]
    barrier = ((-9.0, offset - 9.0 * slope), (25.0, offset + 25.0 * slope), (70.0, offset + 70.0 * slope))
    for _, after in steps(Regions(barriers=(barrier,)), parameters, seeds):
        assert (after.position[:, 1] < offset + slope * after.position[:, 0] + 1e-9).all()


@settings(max_examples=12, deadline=None)
@given(st.lists(polygons, min_size=1, max_size=2), settings_of_a_run())
def test_every_particle_stays_in_the_union_of_the_regions_of_interest(interest, parameters):
    regions = Regions(interest=tuple(interest))
    try:
        run = list(steps(regions, parameters))
    except ValueError as refused:  # too small or too thin for a pixel, a particle or an edge
        assert "of interest" in str(refused)
        return
    for _, after in run:
        assert in_union(interest, after.position).all()


# a crossing whose place is rounded, where two pieces met in a crack
CRACKED = [
    ((0.0, 0.0), (0.0, 24.625), (42.375, 64.0)),
    ((13.625, 60.625), (34.625, 56.0), (16.0, -0.625), (2.5, 40.5), (19.0, 0.0), (-3.75, 25.625)),
]


@settings(max_examples=24, deadline=None)
@given(st.lists(polygons, min_size=1, max_size=3), st.integers(0, 10**6))
@example(CRACKED, 0)
def test_the_rim_parts_the_inside_of_a_union_from_its_outside_and_nothing_else(interest, seed):
    regions = Regions(interest=tuple(interest))
    barrier_map = build_barrier_map(regions, SHAPE)
    rng = np.random.default_rng(seed)
    start = rng.uniform(-5.0, 65.0, (60, 2))
    end = start + rng.normal(0.0, 1.0, (60, 2)) * rng.choice([1.0, 20.0], (60, 1))
    crossed = barrier_map.is_crossed_by(start, end)
    along = np.linspace(0.0, 1.0, 200)[:, None]
    on_the_way = np.array([in_union(interest, a + along * (b - a)) for a, b in zip(start, end, strict=True)])
    within = ((np.minimum(start, end) >= 0) & (np.maximum(start, end) <= np.array(SHAPE) - 1)).all(axis=1)
    assert not (within & ~crossed & (on_the_way != on_the_way[:, :1]).any(axis=1)).any()
    # every rim that is crossed is one: just before or behind it lies the outside
    for a, b in zip(start[crossed], end[crossed], strict=True):
        sides = [s for s in barrier_map.segments if crossing(a, b, s[:2], s[2:])]
        for p, q in ((s[:2], s[2:]) for s in sides if np.linalg.norm(s[2:] - s[:2]) > 1e-3):
            normal = (q - p)[::-1] * (1.0, -1.0) / np.linalg.norm(q - p)
            middle = 0.5 * (p + q)
            beside = in_union(interest, middle + 2e-6 * np.array([normal, -normal]))
            assert beside.sum() == 1


def test_moves_are_tested_alike_near_and_far_from_barriers():
    """The clearance only saves time: with it or without, the same moves cross."""
    regions = Regions(barriers=(((3.2, 4.1), (30.7, 33.3), (31.0, 80.0)), ((50.1, -3.0), (40.2, 20.9))))
    barrier_map = build_barrier_map(regions, SHAPE)
    rng = np.random.default_rng(3)
    start = rng.uniform(0.0, 55.0, (4000, 2))
    end = start + rng.normal(0.0, 1.0, start.shape) * rng.choice([0.5, 3.0, 15.0], (4000, 1))
    slow = barrier_map._replace(clearance=np.zeros((1, 1)))
    np.testing.assert_array_equal(barrier_map.is_crossed_by(start, end), slow.is_crossed_by(start, end))
    truth = np.any([crossing(start, end, s[:2], s[2:]) for s in barrier_map.segments], axis=0)
    np.testing.assert_array_equal(barrier_map.is_crossed_by(start, end), truth)


ONE, OTHER = disk((80, 110), (36.3, 30.2), 18.0), disk((80, 110), (42.0, 80.4), 20.0)
BOTH = ONE.values + 2.5 * (OTHER.values - OTHER.values.min())
AROUND_ONE = Regions(interest=(((3, 3), (3, 54), (70, 54), (70, 3)),))


def test_strong_edges_outside_do_not_hide_faint_ones_inside():
    """Floors are fractions of the strongest edge: here one that is 40 times as strong."""
    image = ONE.values + 40.0 * (OTHER.values - OTHER.values.min())
    seeds = uniform_grid((80, 110))
    assert not any(ONE.distance(c.points).max() < 1.0 for c in segment(image, seeds).contours)
    (contour,) = segment(image, seeds, regions=AROUND_ONE).contours
    assert contour.closed
    assert ONE.distance(contour.points).max() < 0.15


@pytest.mark.parametrize("setting", [{}, {"beta": 0.0}, {"beta": 0.1, "time_step": 1.0}], ids=str)
def test_behind_a_barrier_nothing_is_found_and_particles_held_back_come_to_rest(setting):
    barrier = Regions(barriers=(((-1, 56), (30, 53), (81, 55)),))
    found = segment(BOTH, circle((36.0, 30.0), 21.0), Parameters(**setting), regions=barrier)
    assert found.converged
    assert [c.closed for c in found.contours] == [True]
    assert ONE.distance(found.contours[0].points).max() < 0.15


@settings(max_examples=12, deadline=None)
@example(((0.0, 0.0), (28.75, 48.5)), 0.0)  # ends on the curve itself, within a hundredth of a pixel
@given(barriers, st.sampled_from([0.0, 25.0]))
def test_no_contour_and_no_bridge_crosses_a_barrier(barrier, max_gap):
    parameters, lines = Parameters(scales=1, max_gap=max_gap), np.array(barrier)
    engine = Engine(SCENE.values, parameters, Regions(barriers=(barrier,)))
    state = engine.start(GRID)
    for _ in range(50):
        state = engine.step(state, parameters)
    for contour in engine.result(state, parameters).contours:
        for p, q in pairwise(lines):
            assert not crossing(contour.path[:-1], contour.path[1:], p, q).any()


def test_the_rim_is_no_edge():
    """A region inside a disk, where the image has next to no edge, and one that cuts through its boundary."""
    with pytest.raises(ValueError, match="no edges in the regions of interest"):
        Engine(ONE.values, Parameters(scales=1), Regions(interest=(((32, 26), (32, 34), (40, 34), (40, 26)),)))
    across = Regions(interest=(((20, 20), (20, 60), (52, 60), (52, 20)),))
    found = segment(ONE.values, uniform_grid((80, 110), 4.0), regions=across)
    assert len(found.contours) > 0
    assert max(ONE.distance(c.points).max() for c in found.contours) < 0.2


@pytest.mark.parametrize("scale", [0, 1, 2])
def test_regions_lie_where_they_do_at_every_scale(scale):
    polygon = ((5.0, 6.0), (7.5, 50.0), (50.0, 42.0))
    shape = build_pyramid(SCENE.values, 3)[scale].shape
    points = np.random.default_rng(1).uniform(0.0, 1.0, (500, 2)) * shape
    scaled = Regions((polygon,)).at_scale(scale, SHAPE).contains(points)
    np.testing.assert_array_equal(scaled, winding(polygon, to_image(points, scale, SHAPE)) != 0)


@pytest.mark.parametrize(
    ("interest", "lines", "words"),
    [
        ([[(0, 0), (1, 1)]], [], "region of interest 1 has 2 different points but must have at least 3"),
        ([[(0, 0), (9, 0), (9, 9)], [(0, 0), (1, 1), (0, 0)]], [], "region of interest 2 has 2 different points"),
        ([[(0, 0), (np.nan, 1), (2, 3)]], [], "region of interest 1 has coordinates that are not finite"),
        ([], [[(0, 0)]], "barrier 1 has 1 different points but must have at least 2"),
        ([], [[(0, 0), (np.inf, 1)]], "barrier 1 has coordinates that are not finite"),
        ([], [[(0, 0, 0), (1, 1, 1)]], r"barrier 1 must be a sequence of at least 2 points \(row, col\)"),
        ([5], [], "must be a sequence of"),
        ([[(0, 0), (1,), (2, 3)]], [], "must be a sequence of"),
        ([["a", "b", "c"]], [], "must be a sequence of"),
    ],
    ids=str,
)
def test_what_is_no_region_is_refused(interest, lines, words):
    with pytest.raises(ValueError, match=words):
        Regions(interest, lines)


@pytest.mark.parametrize(
    "polygon", [((-30, -30), (-30, -5), (-5, -5)), ((5.2, 5.2), (5.4, 5.2), (5.4, 5.4)), ((0, 0), (5, 5), (20, 20))]
)
def test_a_region_without_a_pixel_of_the_image_is_refused(polygon):
    around = ((1, 1), (1, 50), (50, 50))
    with pytest.raises(ValueError, match=r"region of interest 2 contains no pixel of the image \(56 x 60 pixels\)"):
        Engine(SCENE.values, Parameters(), Regions((around, polygon)))
