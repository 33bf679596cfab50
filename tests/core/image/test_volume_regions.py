"""Regions of interest and barriers of volumes: no particle leaves the former or crosses the latter."""

from dataclasses import replace
from functools import cache
from itertools import pairwise, product

import numpy as np
import pytest
import scipy
from hypothesis import example, given, settings
from hypothesis import strategies as st

import cpm_core as cpm
from cpm_core.numerics import polyline

VOLUME = cpm.PRESETS["volume"]
SHAPE, SPACING = (14, 26, 27), (2.0, 1.0, 1.0)
CENTER = np.array([13.2, 12.4, 13.1]) / SPACING
RADIUS = 8.0
START = cpm.sphere(tuple(CENTER), 4.0, 60, voxel_size=SPACING)


@cache
def ball():
    grid = np.moveaxis(np.indices(SHAPE), 0, -1)
    away = np.linalg.norm((grid - CENTER) * SPACING, axis=-1)
    return cpm.Image(200.0 * np.clip(0.5 - (away - RADIUS) / 2.0, 0.0, 1.0), spacing=SPACING)


def painted(*parts):
    mask = np.zeros(SHAPE, bool)
    for part in parts:
        mask[part] = True
    return mask


def samples(a, b, n=400):
    """Places along straight moves, shapes (N, 3), into shape (n, N, 3)."""
    return a + np.linspace(0.0, 1.0, n)[:, None, None] * (b - a)


def run(engine, parameters, most=60):
    state = engine.start(START)
    states = [state]
    while not state.stop_reason and state.step < most:
        state = engine.step(state, parameters)
        states.append(state)
    return states


WALL = painted((slice(None), slice(None), 17))
STAIRS = painted(*((slice(None), i, i + 3) for i in range(24)))
CASES = {
    "box": cpm.VolumeRegions(interest=[((2, 3, 4), (11, 22, 15))]),
    "boxes": cpm.VolumeRegions(interest=[((2, 3, 4), (11, 22, 12)), ((5, 9, 10), (7, 14, 24))]),
    "mask": cpm.VolumeRegions(interest=[~painted((slice(0, 6), slice(10, 14), slice(9, 30)))]),
    "plane": cpm.VolumeRegions(barriers=[((6.5, 12.0, 18.2), (0.4, -1.0, 2.0))]),
    "stairs": cpm.VolumeRegions(barriers=[STAIRS]),
    "drawn region": cpm.VolumeRegions([cpm.Extrusion(((3, 4), (3, 20), (22, 22), (20, 3)), 0, 2.0, 11.0)]),
    "wall across the rows": cpm.VolumeRegions(
        barriers=[cpm.Extrusion(((-1, 15.2), (14, 19.7)), 1, 3.0, 20.0, closed=False)]
    ),
    "all": cpm.VolumeRegions(
        [((1, 2, 2), (12, 23, 24))], [painted((7, slice(5), slice(None))), ((0, 14.4, 0), (0, 1, 0))]
    ),
}


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("closed", [True, False])
def test_a_line_through_slices_holds_the_voxels_that_it_fills(axis, closed):
    line = ((2.0, 3.0), (4.5, 20.0), (11.0, 12.0), (9.0, 1.0))
    drawn = cpm.Extrusion(line, axis, 3.0, 9.0, closed)
    limits = cpm.VolumeRegions([drawn]) if closed else cpm.VolumeRegions(barriers=[drawn])
    filled = limits.voxel_mask(SHAPE) if closed else limits.build_walls(SHAPE).closed
    places = np.argwhere(np.ones(SHAPE, bool)).astype(float)
    np.testing.assert_array_equal(limits.contains(places), filled.ravel() | (not closed))
    assert filled.any()
    assert set(np.nonzero(filled)[axis].tolist()) == set(range(3, 10))
    one = np.take(filled, 5, axis=axis)
    if closed:
        others = [side for k, side in enumerate(SHAPE) if k != axis]
        centers = np.indices(others).reshape(2, -1).T.astype(float)
        np.testing.assert_array_equal(one.ravel(), polyline.points_inside(line, centers))
    else:
        assert scipy.ndimage.label(one, np.ones((3, 3)))[1] == 1, "a wall has no gap"


FAST = replace(VOLUME, time_step=1.0, w2=6.0, w1=3.0, beta=0.1)


@pytest.mark.parametrize("name", CASES)
def test_no_particle_leaves_a_region_or_crosses_a_barrier(name):
    regions = CASES[name]
    for parameters in (VOLUME, FAST):
        states = run(cpm.Engine(ball(), parameters, regions), parameters)
        closed = regions.build_walls(SHAPE).closed
        for before, after in pairwise(states):
            assert regions.allows(after.position).all()
            _, old, new = np.intersect1d(before.particles.identity, after.particles.identity, return_indices=True)
            ways = samples(before.position[old], after.position[new], 60)
            voxels = np.clip(np.floor(ways + 0.5).astype(int), 0, np.array(SHAPE) - 1)
            assert not closed[tuple(np.moveaxis(voxels, -1, 0))].any()
        assert max(state.count for state in states) > 40


def test_limits_hold_at_every_scale():
    """The limits are those of the full size: a coarse voxel half outside keeps its particles in the inner half."""
    parameters = replace(VOLUME, scales=2)
    grid = np.moveaxis(np.indices((26, 26, 26)), 0, -1) - 12.4
    values = 200.0 * np.clip(8.5 - np.linalg.norm(grid, axis=-1), 0.0, 1.0)
    mask = np.zeros((26, 26, 26), bool)
    mask[:, 13, :] = True
    regions = cpm.VolumeRegions([((1, 1, 1), (25, 25, 17))], [mask])
    engine = cpm.Engine(values, parameters, regions)
    state = engine.start(cpm.sphere((12.4, 9.0, 12.4), 2.5, 40))
    scales = set()
    while not state.stop_reason:
        state = engine.step(state, parameters)
        scales.add(state.scale)
        assert regions.allows(state.position).all()
        assert (state.position[:, 1] < 12.5).all()
    assert scales == {0, 1}
    assert state.converged
    assert state.count > 40


moves = st.tuples(*[st.floats(-3.0, 9.0)] * 3)


@settings(max_examples=24, deadline=None)
@given(st.integers(0, 2**32 - 1), moves, moves, st.floats(0.0, 1.0))
@example(1, (0.5, 0.5, 0.0), (0.5, 0.5, 3.0), 0.3)
def test_a_move_crosses_a_wall_exactly_where_a_sampled_one_does(seed, a, b, filled):
    random = np.random.default_rng(seed)
    mask = random.random((7, 7, 7)) < 0.3 * filled
    walls = cpm.VolumeRegions(barriers=[mask]).build_walls(mask.shape)
    one, other = np.array([a]), np.array([b])
    ways = samples(one, other, 4000)[:, 0]
    voxel = np.clip(np.floor(ways + 0.5).astype(int), 0, 6)
    inside = ((ways > -0.5) & (ways < 6.5)).all(axis=1)
    hit, crossed = (inside & mask[tuple(voxel.T)]).any(), walls.is_crossed_by(one, other)[0]
    assert crossed >= hit
    if inside.all() and not hit:  # what the samples miss is within a thousandth of a voxel of them
        around = (ways[:, None] + np.array(list(product((-2e-3, 2e-3), repeat=3)))).reshape(-1, 3)
        beside = mask[tuple(np.clip(np.floor(around + 0.5).astype(int), 0, 6).T)].any()
        assert crossed <= beside


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_plane_is_a_wall_of_the_voxels_that_it_passes_through(seed):
    random = np.random.default_rng(seed)
    point, across = random.uniform(0, 6, 3), random.normal(0, 1, 3)
    walls = cpm.VolumeRegions(barriers=[(tuple(point), tuple(across))]).build_walls((7, 7, 7))
    voxels = np.argwhere(np.ones((7, 7, 7), bool))
    corners = voxels[:, None] + np.array(list(product((-0.5, 0.5), repeat=3)))
    sides = (corners - point) @ across > 0.0
    np.testing.assert_array_equal(walls.closed.ravel(), sides.any(axis=1) & ~sides.all(axis=1))


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_no_move_leads_from_one_room_to_another(seed):
    random = np.random.default_rng(seed)
    mask = random.random((9, 9, 9)) < 0.45
    walls = cpm.VolumeRegions(barriers=[mask]).build_walls(mask.shape)
    start = random.uniform(0.0, 8.0, (400, 3))
    end = start + random.normal(0.0, 1.0, start.shape)
    inside = ((end > 0.0) & (end < 8.0)).all(axis=1)
    free = inside & ~walls.is_crossed_by(start, end)
    assert free.any()
    rooms = walls.find_rooms(start)
    np.testing.assert_array_equal(rooms[free], walls.find_rooms(end)[free])
    closed = mask[tuple(np.rint(start).astype(int).T)]
    np.testing.assert_array_equal(rooms < 0, closed)


def faces_of(result):
    """Euler characteristic, and edges that do not belong to two triangles."""
    faces = result.surface.faces
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    kinds, count = np.unique(edges, axis=0, return_counts=True)
    return len(np.unique(faces)) - len(kinds) + len(faces), int((count != 2).sum())


def test_the_part_of_an_object_in_a_region_is_covered_and_its_surface_ends_there():
    box = ((0, 0, 0), (13, 25, 15))
    result = cpm.segment(ball(), START, VOLUME, regions=cpm.VolumeRegions([box]))
    assert result.converged
    surface = CENTER + RADIUS * cpm.sphere((0.0, 0.0, 0.0), 1.0, 3000) / SPACING
    surface = surface[surface[:, 2] < 15.0]
    covered = scipy.spatial.KDTree(result.particles * SPACING).query(surface * SPACING)[0]
    assert covered.max() < 2.0
    assert result.surface.vertices[:, 2].max() < 16.0
    assert faces_of(result) == (2, 0)


@pytest.mark.parametrize("wall", [((0.0, 0.0, 17.2), (0.0, 0.0, 1.0)), WALL], ids=["plane", "painted"])
def test_a_wall_through_an_object_keeps_a_run_on_its_side(wall):
    regions = cpm.VolumeRegions(barriers=[wall])
    here = START[START[:, 2] < 17.0]
    one = cpm.segment(ball(), here, VOLUME, regions=regions)
    assert one.particles[:, 2].max() < 17.5
    assert one.surface.vertices[:, 2].max() < 17.6
    assert faces_of(one) == (2, 0)
    both = cpm.segment(ball(), np.concatenate([here, [(CENTER[0], CENTER[1], 18.5)]]), VOLUME, regions=regions)
    assert both.particles[:, 2].max() > 20.0
    assert faces_of(both) == (4, 0)


def test_voxels_outside_the_regions_carry_no_charge_and_do_not_count():
    regions = cpm.VolumeRegions([((2, 3, 4), (11, 22, 15))])
    bright = ball().values.copy()
    bright[:, :, 20:] += 4000.0 * np.random.default_rng(0).random((14, 26, 7))
    one, other = (cpm.Engine(cpm.Image(v, spacing=SPACING), VOLUME, regions) for v in (ball().values, bright))
    edges = one.edge_map(VOLUME)
    inside = regions.voxel_mask(SHAPE)
    assert not edges[~inside].any()
    assert edges[inside].any()
    assert other.scale_field(VOLUME).floor == one.scale_field(VOLUME).floor
    np.testing.assert_allclose(other.edge_map(VOLUME)[:, :, :16], edges[:, :, :16], atol=1e-3)


def test_other_regions_act_at_the_next_step():
    engine = cpm.Engine(ball(), VOLUME)
    state = engine.start(START)
    for _ in range(12):
        state = engine.step(state, VOLUME)
    regions = CASES["box"]
    after = engine.with_regions(regions).step(state, VOLUME)
    assert regions.allows(after.position).all()
    assert after.regions == regions
    assert 0 < after.count < state.count


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: cpm.VolumeRegions(3), "the limits of one kind must be a list, not 3: give a list of"),
        (lambda: cpm.VolumeRegions(WALL), "the limits of one kind must be a list, not"),
        (lambda: cpm.VolumeRegions([(1, 2, 3)]), "region of interest 1 must be a box of two corners, each"),
        (lambda: cpm.VolumeRegions([((0, 0), (1, 1))]), "region of interest 1 must be a box"),
        (lambda: cpm.VolumeRegions([((0, 0, 0), (1, 1, np.nan))]), "has coordinates that are not finite"),
        (lambda: cpm.VolumeRegions(barriers=[((0, 0, 0), (0, 0, 0))]), "the direction across barrier 1 is .* above 0"),
        (lambda: cpm.VolumeRegions(barriers=["wall"]), "barrier 1 must be a plane of a point and a direction"),
        (lambda: cpm.Engine(ball(), VOLUME, cpm.Regions()), "this is a volume of 14 x 26 x 27: use VolumeRegions"),
        (lambda: cpm.Engine(ball().values[7], None, CASES["box"]), "the image is one of 26 x 27 pixels: use Regions"),
        (lambda: cpm.Engine(ball(), VOLUME, cpm.VolumeRegions([WALL[1:]])), "has 13 x 26 x 27 voxels but must have"),
        (
            lambda: cpm.Engine(ball(), VOLUME, cpm.VolumeRegions([((20, 0, 0), (30, 9, 9))])),
            "region of interest 1 contains no voxel of the volume",
        ),
        (
            lambda: cpm.Engine(ball(), VOLUME, cpm.VolumeRegions([((0, 0, 0), (1, 1, 1))])),
            "there are no edges in the regions of interest",
        ),
        (
            lambda: cpm.segment(ball(), START, VOLUME, regions=cpm.VolumeRegions([((0, 0, 18), (13, 25, 26))])),
            "none of the 60 starting particles lies inside the regions of interest, clear of barriers",
        ),
    ],
)
def test_limits_that_cannot_be_used_are_refused_in_one_sentence(make, says):
    with pytest.raises(ValueError, match=says) as caught:
        make()
    assert "\n" not in str(caught.value)
    assert str(caught.value).endswith(".")
