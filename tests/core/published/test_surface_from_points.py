import numpy as np
import pytest

from cpm_core import reconstruct_surface
from tests.core.reconstruction.surface import solids
from tests.core.reconstruction.surface.solids import ball, brick, ring, thinned, without, zero_surface


def on_ball(radius, apart=1.5, center=solids.MIDDLE):
    count = int(4.0 * np.pi * radius**2 / (0.87 * apart**2))
    k = np.arange(count) + 0.5
    down, turn = 1.0 - 2.0 * k / count, np.pi * (1.0 + np.sqrt(5.0)) * k
    across = np.sqrt(1.0 - down**2)
    return center + radius * np.stack([down, across * np.sin(turn), across * np.cos(turn)], 1)


def on_ring(radius, tube, axis=0, center=solids.MIDDLE, apart=1.5):
    rows = int(np.ceil(2.0 * np.pi * tube / (0.87 * apart)) // 2 * 2)
    places = []
    for row in range(rows):
        around = 2.0 * np.pi * row / rows
        out = radius + tube * np.cos(around)
        count = round(2.0 * np.pi * out / apart)
        turn = 2.0 * np.pi * (np.arange(count) + 0.5 * (row % 2)) / count
        places.append(np.stack([tube * np.sin(around) + 0.0 * turn, out * np.cos(turn), out * np.sin(turn)], 1))
    ordered = center + np.roll(np.concatenate(places), axis, axis=1)
    return ordered + np.random.default_rng(0).normal(0.0, 0.02, ordered.shape)


SHELL, ON_SHELL = without(ball(16), ball(8)), np.concatenate([on_ball(16), on_ball(8)])


@pytest.mark.parametrize(
    ("solid", "points", "euler", "parts"),
    [
        (ball(13), on_ball(13), 2, 1),
        (ring(11, 5), on_ring(11, 5), 0, 1),
        (SHELL, ON_SHELL, 4, 2),
    ],
    ids=["ball", "torus", "shell"],
)
def test_points_alone_give_the_surface(solid, points, euler, parts):
    surface = reconstruct_surface(points)
    assert (surface.euler, surface.components, surface.closed) == (euler, parts, True)
    assert np.abs(solid(surface.vertices)).mean() < 0.15
    assert surface.volume == pytest.approx((solid(solids.grid()) > 0.0).sum(), rel=0.1)
    assert surface.unsupported == 0.0


def test_a_thin_plate_has_two_sides():
    solid = brick(2, 12, 12)
    surface = reconstruct_surface(thinned(zero_surface(solid(solids.grid()).astype(np.float32))[0], 1.5))
    assert (surface.euler, surface.closed) == (2, True)
    assert np.abs(solid(surface.vertices)).mean() < 0.4


def test_given_normals_tell_the_outside():
    points = on_ball(13)
    outward = points - solids.MIDDLE
    surface = reconstruct_surface(points, outward)
    assert surface.volume > 0.0 and surface.euler == 2
    assert (surface.normals * (surface.vertices - solids.MIDDLE)).sum(1).min() > 0.0
