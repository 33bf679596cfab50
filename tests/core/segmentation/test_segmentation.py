"""Complete runs on scenes whose boundaries are known exactly."""

import dataclasses

import numpy as np
import pytest

from cpm_core import Engine, Parameters, Particles, circle, segment, uniform_grid

from ..scenes import blob, disk, mirrored, outline_distance, ring, square, turned, u_shape

DISK = disk((72, 68), (35.3, 33.6), 20.0)


def paths(result):
    return [contour.path for contour in result.contours]


def apart(one, other):
    """Distances of the vertices of two sets of contours to the other set."""
    ones, others = paths(one), paths(other)
    assert len(ones) == len(others) > 0
    there, back = outline_distance(np.concatenate(ones), others), outline_distance(np.concatenate(others), ones)
    return np.concatenate([there, back])


@pytest.mark.parametrize(
    "start",
    [circle((35.0, 34.0), 8.0), circle((15.0, 33.0), 9.0), circle((35.0, 34.0), 28.0), circle((40.0, 30.0), 1.0)],
    ids=["inside", "across", "outside", "tiny"],
)
def test_a_disk_is_one_closed_contour_from_any_start(start):
    """Every vertex within 0.1 px of the true circle; measured: 0.05."""
    result = segment(DISK.values, start)
    (contour,) = result.contours
    assert contour.closed
    assert DISK.distance(contour.points).max() < 0.1
    assert contour.area == pytest.approx(np.pi * 400.0, rel=0.01)
    assert contour.length == pytest.approx(2.0 * np.pi * 20.0, rel=0.01)
    assert result.converged
    assert outline_distance(DISK.boundary, paths(result)).max() < 0.15


def test_a_ring_is_two_closed_contours():
    scene = ring((80, 80), (39.6, 40.3), 13.0, 27.0)
    result = segment(scene.values, circle((40.0, 40.0), 20.0))
    assert [contour.closed for contour in result.contours] == [True, True]
    for contour, radius in zip(result.contours, (27.0, 13.0), strict=True):
        assert np.abs(np.hypot(*(contour.points - (39.6, 40.3)).T) - radius).max() < 0.1


@pytest.mark.parametrize(
    "start",
    [circle((30.0, 28.0), 6.0), np.array([(70.0, 30.0), (70.0, 48.0), (72.0, 66.0), (40.0, 28.0), (30.0, 68.0)])],
    ids=["a circle over one arm", "five particles"],
)
def test_a_u_is_recovered_completely(start):
    scene = u_shape()
    result = segment(scene.values, start)
    assert outline_distance(scene.boundary, paths(result)).max() < 1.5
    assert scene.distance(np.concatenate([c.points for c in result.contours])).max() < 1.5
    assert result.contours[0].closed


@pytest.mark.parametrize("share", [0.2, 0.6])
@pytest.mark.parametrize("kind", ["uniform", "salt and pepper"])
def test_contours_are_closed_where_noise_has_replaced_pixels(kind, share):
    rng = np.random.default_rng(4)
    shape = (110, 104)
    scene = ring(shape, (55.0, 51.0), 18.0, 38.0)
    other = rng.uniform(0.0, 255.0, shape) if kind == "uniform" else 255.0 * (rng.random(shape) < 0.5)
    image = np.where(rng.random(shape) < share, other, scene.values)
    result = segment(image, circle((55.0, 51.0), 45.0), Parameters(smoothing="auto"))
    assert [contour.closed for contour in result.contours] == [True, True]
    assert scene.distance(np.concatenate([c.points for c in result.contours])).mean() < 0.8


SHAPE = (71, 66)
BLOB = blob(SHAPE, (33.3, 31.6))
CORNERS = np.maximum(disk(SHAPE, (30.3, 28.6), 17.0).values, 0.8 * square(SHAPE, (34.25, 30.75), 24.0).values)
UNEVEN_START = circle((33.0, 30.0), 9.0)
"""Scenes and a start without any symmetry: a smooth one, and one of corners and a junction of three gray levels."""


@pytest.fixture(scope="module")
def uneven():
    return segment(BLOB, UNEVEN_START)


@pytest.fixture(scope="module")
def corners():
    return segment(CORNERS, UNEVEN_START)


def moved(result, change):
    contours = tuple(dataclasses.replace(c, points=change(c.points)) for c in result.contours)
    return dataclasses.replace(result, contours=contours)


def turn(image):
    return np.rot90(image).copy()


CHANGES = [
    pytest.param(lambda image: np.flip(image, 0), lambda points: mirrored(points, SHAPE, 0), id="mirrored"),
    pytest.param(lambda image: np.flip(image, 1), lambda points: mirrored(points, SHAPE, 1), id="mirrored sideways"),
    pytest.param(turn, lambda points: turned(points, SHAPE), id="turned"),
    pytest.param(lambda image: image, lambda points: np.random.default_rng(0).permutation(points), id="shuffled"),
    pytest.param(lambda image: image, lambda points: np.random.default_rng(1).permutation(points), id="shuffled again"),
]
"""Transforms of an image and of its points."""


def unshuffled(image_change, point_change):
    """Transforms of contours: the order of their vertices stays."""
    probe = np.zeros(SHAPE)
    return point_change if image_change(probe) is not probe else lambda points: points


@pytest.mark.parametrize(("image_change", "point_change"), CHANGES)
def test_a_transformed_image_has_transformed_contours(uneven, image_change, point_change):
    """Within 0.1 px; measured: 0.03 at most."""
    result = segment(image_change(BLOB), point_change(UNEVEN_START))
    truth = moved(uneven, unshuffled(image_change, point_change))
    assert apart(result, truth).max() < 0.1
    assert [c.closed for c in result.contours] == [c.closed for c in truth.contours]


def test_segment_runs_the_engine_to_its_end(uneven):
    engine = Engine(BLOB, Parameters())
    state = engine.start(UNEVEN_START)
    while not state.stop_reason:
        state = engine.step(state, Parameters())
    result = engine.result(state, Parameters())
    assert (result.steps, result.stop_reason, result.converged) == (uneven.steps, uneven.stop_reason, uneven.converged)
    assert result.particles.tobytes() == uneven.particles.tobytes()
    assert [p.tobytes() for p in paths(result)] == [p.tobytes() for p in paths(uneven)]


@pytest.mark.parametrize("most", [1, 7])
def test_max_steps_is_the_greatest_number_of_steps(most):
    seen = []
    result = segment(DISK.values, circle((35.0, 34.0), 8.0), max_steps=most, progress=seen.append)
    assert len(seen) == result.steps == most
    assert not result.converged
    assert f"stopped after {most} steps" in result.stop_reason


def three_disks():
    """A large bright disk, a small bright one and a large faint one."""
    large, small, faint = (
        disk((90, 110), center, radius).values - 40.0
        for center, radius in (((30.0, 30.0), 18.0), ((30.0, 80.0), 7.0), ((65.0, 75.0), 17.0))
    )
    return large + small + 0.4 * faint


@pytest.fixture(scope="module")
def three():
    engine = Engine(three_disks(), Parameters())
    state = engine.start(uniform_grid((90, 110), 7.0))
    while not state.stop_reason:
        state = engine.step(state, Parameters())
    return engine, state


def test_short_and_weak_contours_are_left_out(three):
    engine, state = three
    everything = engine.result(state, Parameters()).contours
    strengths = sorted(c.strength for c in everything)
    for parameters in (
        Parameters(min_length=60.0),
        Parameters(min_strength=0.5 * (strengths[0] + strengths[1])),
        Parameters(min_length=60.0, min_strength=0.5 * (strengths[0] + strengths[1])),
        Parameters(min_length=1e6),
    ):
        truth = [
            c.points.tobytes()
            for c in everything
            if c.length >= parameters.min_length and c.strength >= parameters.min_strength
        ]
        assert len(truth) < 3
        assert [c.points.tobytes() for c in engine.result(state, parameters).contours] == truth


@pytest.mark.parametrize("apart", [5, 6, 7, 8, 12])
@pytest.mark.parametrize("level", [30.0, 40.0])
def test_a_weak_edge_beside_a_strong_one_keeps_its_particles(apart, level):
    """A faint square around a bright one, whose field dominates on the whole faint edge."""
    image = np.zeros((112, 112))
    image[20:92, 20:92] = level
    image[20 + apart : 92 - apart, 20 + apart : 92 - apart] = 255.0
    contours = segment(image, uniform_grid(image.shape), Parameters(w1=0.6, w2=0.7, beta=0.4)).contours
    assert [c.closed for c in contours] == [True, True]
    assert [c.area for c in contours] == pytest.approx([72.0**2, (72.0 - 2 * apart) ** 2], rel=0.005)


def test_no_particle_is_left_where_there_is_no_edge():
    """Including the one that has come to rest at the center of the disk, where all attractions cancel."""
    scene = disk((96, 90), (50.0, 41.0), 20.0)
    engine = Engine(scene.values, Parameters())
    state = engine.start(uniform_grid(scene.values.shape))
    while not state.stop_reason:
        before, state = state, engine.step(state, Parameters())
    assert state.converged
    assert np.abs(scene.distance(state.position)).max() < 2.0
    left = before.particles.append(Particles.at_rest(np.array([(50.0, 41.0)]), before.next_identity))
    left.distance[-1] = np.hypot(50.0, 41.0)
    last = engine.step(dataclasses.replace(before, particles=left), Parameters())
    assert last.converged
    assert len(left) == len(before.particles) + 1
    np.testing.assert_array_equal(last.particles.identity, state.particles.identity)
