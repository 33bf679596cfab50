"""Shapes: where their particles lie, how they are moved, resized and reshaped, and how far a position is from them."""

from __future__ import annotations

import math
from dataclasses import fields
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cpm_core import Image, gradient_threshold
from cpm_core.field.edge_map import automatic_smoothing, edge_map
from cpm_core.field.placed_charges import MAX_CHARGE_STRENGTH
from cpm_core.numerics import polyline
from cpm_core.shapes import (
    SHAPES_BY_NAME,
    Barrier,
    Charge,
    Circle,
    Ellipse,
    Everywhere,
    Grid,
    Points,
    Polygon,
    PolygonRegion,
    Sphere,
    Stroke,
    Threshold,
)
from cpm_core.shapes.image_starts import ImageStart, SeedCache

coordinates = st.floats(-100, 200, allow_nan=False).map(lambda number: round(number, 3))
positions = st.tuples(coordinates, coordinates)
radii = st.floats(2, 80)
ellipses = st.builds(Ellipse, positions, st.tuples(radii, radii), st.floats(-math.pi, math.pi))
charges = st.builds(Charge, positions, st.floats(0.5, MAX_CHARGE_STRENGTH) | st.floats(-MAX_CHARGE_STRENGTH, -0.5))


@st.composite
def stars(draw) -> tuple[tuple[float, float], ...]:
    """Corners around a center, at any distance from it."""
    row, col = draw(positions)
    reach = draw(st.lists(st.floats(5, 60), min_size=3, max_size=9))
    angles = 2 * math.pi * np.arange(len(reach)) / len(reach)
    return tuple((row + r * math.sin(a), col + r * math.cos(a)) for r, a in zip(reach, angles.tolist(), strict=True))


polygons, grids = st.builds(Polygon, stars()), st.builds(Grid, stars(), st.floats(2, 20))
thresholds = st.builds(Threshold, stars(), st.floats(0.05, 0.9))
areas = polygons | grids | thresholds | st.builds(PolygonRegion, stars())
seeded = ellipses | polygons | grids


def around(outline: np.ndarray) -> np.ndarray:
    """Many positions along a line."""
    share = np.linspace(0.0, 1.0, 200)[:, None]
    pairs = pairwise(outline)
    return np.concatenate([begin + share * (end - begin) for begin, end in pairs])


def wound_around(corners, position) -> bool:
    """Whether the angles under which the sides are seen from a position sum to at least a full turn."""
    at = np.array([*corners, corners[0]]) - position
    angle = np.unwrap(np.arctan2(at[:, 0], at[:, 1]))
    return abs(angle[-1] - angle[0]) > math.pi


@settings(deadline=None)  # the first call loads compiled loops
@given(seeded | areas | charges, positions, positions)
def test_a_moved_shape_is_as_far_from_a_moved_position(shape, by, position) -> None:
    there = (position[0] + by[0], position[1] + by[1])
    assert shape.translated(by).distance_to(there) == pytest.approx(shape.distance_to(position), abs=1e-6)
    assert shape.translated(by).translated((-by[0], -by[1])).distance_to(position) == pytest.approx(
        shape.distance_to(position)
    )


@given(ellipses | polygons, positions)
def test_particles_move_with_their_shape_and_lie_two_px_apart_along_its_line(shape, by) -> None:
    seeds = shape.seeds()
    np.testing.assert_allclose(shape.translated(by).seeds(), seeds + by, atol=1e-6)
    line = shape.outline
    assert polyline.distances_to_path([tuple(p) for p in line.tolist()], seeds).max() < 1e-6
    along = np.hypot(*np.diff(line, axis=0).T).sum()
    count = max(1, round(along / 2.0))
    assert len(seeds) == count
    step = np.hypot(*(seeds - np.roll(seeds, 1, axis=0)).T)
    assert step.max() <= along / count + 1e-6


@given(areas, positions)
def test_an_area_encloses_positions_that_its_line_winds_around(shape, position) -> None:
    assume(polyline.distance_to_path((*shape.points, shape.points[0]), position) > 1e-6)
    inside = wound_around(shape.points, position)
    assert bool(polyline.points_inside(shape.points, np.array([position]))[0]) == inside
    assert shape.encloses(position) == (inside and not isinstance(shape, PolygonRegion))


@given(ellipses, positions)
def test_a_handle_of_an_ellipse_changes_one_radius_or_its_direction_alone(ellipse, to) -> None:
    first, second, _, _, turning = ellipse.handles()
    one, other = ellipse.with_handle_at(first, to), ellipse.with_handle_at(second, to)
    assert (one.center, one.angle, one.radii[1]) == (ellipse.center, ellipse.angle, ellipse.radii[1])
    assert (other.center, other.angle, other.radii[0]) == (ellipse.center, ellipse.angle, ellipse.radii[0])
    turned = ellipse.with_handle_at(turning, to)
    assert (turned.center, turned.radii) == (ellipse.center, ellipse.radii)
    if math.dist(ellipse.center, to) > 1e-3:
        end = turned.handles()[0]
        towards = [(to[i] - turned.center[i]) / math.dist(turned.center, to) for i in range(2)]
        assert [(end[i] - turned.center[i]) / turned.radii[0] for i in range(2)] == pytest.approx(towards, abs=1e-6)


@given(polygons | st.builds(PolygonRegion, stars()), st.floats(0.5, 5))
def test_an_enlarged_area_keeps_its_center_and_reaches_farther_by_the_given_distance(shape, by) -> None:
    center = np.mean(shape.points, axis=0)
    farthest = max(math.dist(center, point) for point in shape.points)
    resized = shape.resized_by(by)
    np.testing.assert_allclose(np.mean(resized.points, axis=0), center, atol=1e-6)
    assert max(math.dist(center, point) for point in resized.points) == pytest.approx(farthest + by)
    np.testing.assert_allclose(resized.resized_by(-by).points, shape.points, atol=1e-6)


@given(grids)
def test_the_particles_of_a_grid_fill_its_area_at_its_spacing(grid) -> None:
    seeds = grid.seeds()
    assume(len(seeds) > 1)
    assert polyline.points_inside(grid.points, seeds).all()
    off = (seeds - seeds[0]) / grid.spacing
    np.testing.assert_allclose(off, np.round(off), atol=1e-6)
    assert len(np.unique(np.round(off), axis=0)) == len(seeds)
    low, high = np.min(grid.points, axis=0), np.max(grid.points, axis=0)
    reach = np.ceil((high - low) / grid.spacing) + 1
    steps = np.stack(np.meshgrid(*(np.arange(-n, n + 1) for n in reach), indexing="ij"), axis=-1).reshape(-1, 2)
    every = seeds[0] + grid.spacing * steps
    well_inside = polyline.points_inside(grid.points, every) & (
        polyline.distances_to_path(grid.outline.tolist(), every) > 1e-6
    )
    assert len(seeds) >= np.count_nonzero(well_inside)


@pytest.fixture(scope="module")
def values() -> np.ndarray:
    row, col = np.indices((60, 80))
    strong = np.where(np.hypot(row - 30, col - 20) < 10, 200.0, 20.0)
    return strong + np.where(np.hypot(row - 30, col - 60) < 10, 30.0, 0.0)


def test_a_threshold_is_relative_to_the_strongest_edge_in_its_own_area(values) -> None:
    area = Threshold(((15.0, 42.0), (15.0, 78.0), (45.0, 78.0), (45.0, 42.0)), 0.5)
    image_seeds = SeedCache(Image(values)).seeds_for((area,), 1.0)[area]
    strength = edge_map(values, 1.0)
    row, col = np.indices(values.shape)
    within = (row >= 15) & (row < 45) & (col >= 42) & (col < 78)
    expected = np.argwhere(within & (strength > 0.5 * strength[within].max()))
    np.testing.assert_array_equal(np.unique(image_seeds, axis=0), expected)
    assert len(expected) > 20


@pytest.mark.parametrize("smoothing", [0.0, 1.7, "auto"])
def test_strong_edges_are_those_of_the_smoothing_in_use(values, smoothing) -> None:
    noisy = values + np.random.default_rng(1).normal(0, 20, values.shape)
    sigma = automatic_smoothing(noisy) if smoothing == "auto" else smoothing
    image_seeds = SeedCache(Image(noisy)).seeds_for((Everywhere("gradient"),), smoothing)[Everywhere("gradient")]
    np.testing.assert_array_equal(image_seeds, gradient_threshold(noisy, smoothing=sigma))


def test_every_shape_is_a_small_frozen_value_of_plain_numbers_under_a_name_of_its_own() -> None:
    assert list(SHAPES_BY_NAME) == [
        "circle", "ellipse", "polygon", "stroke", "points", "grid", "threshold", "everywhere", "sphere", "box",
        "boxgrid", "boxthreshold", "region", "barrier", "boxregion", "prismregion", "wall", "enclosedregion",
        "enclosingwall", "charge", "ruler", "angle", "oval",
    ]  # fmt: skip
    for kind in SHAPES_BY_NAME.values():
        assert fields(kind)
        assert isinstance(kind.title, str | property)
    corners = ((0.0, 0.0), (0.0, 9.0), (9.0, 9.0))
    made = [Ellipse((1.0, 2.0), (3.0, 4.0)), Polygon(corners), Grid(corners), Threshold(corners), Charge((1.0, 2.0))]
    assert len({hash(shape) for shape in made}) == len(made)
    assert [isinstance(shape, ImageStart) for shape in made] == [False, False, False, True, False]


CORNERS = ((0.0, 0.0), (0.0, 9.0), (9.0, 9.0))


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Circle((1.0, 2.0), 0.4), "radius is 0.4 but must be a number from 0.5 to 100000"),
        (lambda: Circle((1.0, 2.0), math.nan), "radius is nan"),
        (lambda: Ellipse((1.0, 2.0), (3.0, 2e5)), "radii is 200000"),
        (lambda: Grid(CORNERS, 0.0), "spacing is 0"),
        (lambda: Threshold(CORNERS, 1.1), "fraction is 1.1 but must be a number from 0 to 1"),
        (lambda: Charge((1.0, 2.0), -11.0), "strength is -11 but must be a number from -10 to 10"),
        (lambda: Points(()), "0 different positions are given but at least 1"),
        (lambda: Stroke(()), "0 different points are given but at least 1"),
        (lambda: Barrier((CORNERS[0], CORNERS[0])), "1 different points are given but at least 2"),
        *(
            (lambda kind=kind: kind((*CORNERS[:2], CORNERS[0])), "2 different points are given but at least 3")
            for kind in (Polygon, PolygonRegion, Grid, Threshold)
        ),
    ],
)
def test_an_invalid_shape_is_refused_in_one_sentence(make, sentence) -> None:
    with pytest.raises(ValueError, match=sentence) as caught:
        make()
    assert str(caught.value).endswith(".")


@pytest.mark.parametrize("shape", [Polygon(CORNERS), PolygonRegion(CORNERS), Barrier(CORNERS[:2]), Grid(CORNERS, 4.0)])
def test_a_corner_dragged_onto_another_leaves_a_valid_shape(shape) -> None:
    assert shape.with_handle_at(CORNERS[0], CORNERS[1]) == shape


@pytest.mark.parametrize("shape", [Circle((10.0, 20.0), 5.0), Sphere((10.0, 20.0, 30.0), 5.0)])
@pytest.mark.parametrize("away", [0.0, 3.0, 5.0, 9.0])
def test_a_line_or_surface_is_as_far_as_its_radius_from_its_center(shape, away) -> None:
    position = (*shape.center[:-1], shape.center[-1] + away)
    assert shape.distance_to(position) == pytest.approx(abs(away - 5.0))
