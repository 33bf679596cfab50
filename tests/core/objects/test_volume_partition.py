"""Objects in volumes: the bodies that closed surfaces enclose, chosen by clicks."""

import json
from functools import cache

import numpy as np
import pytest
import scipy
from skimage.measure import marching_cubes

import cpm_core as cpm
from cpm_core.contours.surface import label_voxels
from cpm_core.formats.common.json_values import from_json, to_json
from cpm_core.image.region import Region
from cpm_core.image.surface import Surface
from cpm_core.objects import compute_iou
from cpm_core.objects.prior import body_predictor
from cpm_core.objects.prior.body_prediction import BodyPrediction
from cpm_core.objects.prior.crops import Crop3D
from cpm_core.objects.segmented import SegmentedObject
from tests.benchmarks.prior.bodies import scan
from tests.benchmarks.prior.meant_bodies import brain

SHAPE, SPACING = (44, 30, 30), (1.0, 1.0, 1.5)
SHELL, LONE = np.array([13.0, 14.0, 20.0]), np.array([34.0, 14.0, 20.0])
"""Middle of a shell from radius 5 to 9, and of a ball with radius 6, in units of length."""

WALL, HOLLOW, BALL = (13.0, 14.0 - 7.0, 20.0 / 1.5), SHELL / SPACING, LONE / SPACING
FULL, EMPTY, ALONE = (4.0 / 3.0 * np.pi * r**3 for r in (9.0, 5.0, 6.0))


def _away(center):
    return np.linalg.norm(np.moveaxis(np.indices(SHAPE), 0, -1) * SPACING - center, axis=-1)


@cache
def parted():
    """A shell and a ball beside it, each wall triangulated for itself."""
    inside = np.maximum(np.minimum(9.0 - _away(SHELL), _away(SHELL) - 5.0), 6.0 - _away(LONE))
    vertices, faces, _, _ = marching_cubes(inside, 0.0)
    surface = Surface(vertices, faces, SPACING, "mm")
    if surface.volume < 0.0:
        surface = Surface(vertices, faces[:, ::-1], SPACING, "mm")
    image = cpm.Image(inside.clip(-1.0, 1.0), spacing=SPACING, unit="mm")
    return cpm.VolumePartition(image, surface)


@pytest.mark.parametrize(
    ("clicks", "volume", "walls"),
    [
        pytest.param([WALL], FULL - EMPTY, 2, id="the wall of a shell"),
        pytest.param([HOLLOW], EMPTY, 1, id="the hollow in it"),
        pytest.param([BALL], ALONE, 1, id="a ball"),
        pytest.param([WALL, HOLLOW], FULL, 1, id="a shell with its hollow"),
        pytest.param([WALL, BALL], FULL - EMPTY + ALONE, 3, id="two objects"),
        pytest.param([WALL, HOLLOW, BALL], FULL + ALONE, 2, id="all"),
    ],
)
def test_a_click_selects_what_a_surface_encloses_and_further_ones_add_to_it(clicks, volume, walls):
    found = parted().select(clicks)
    assert found.remark == ""
    assert found.size == pytest.approx(volume, rel=0.04)
    assert found.mask.sum() * np.prod(SPACING) == pytest.approx(volume, rel=0.05)
    assert found.surface.closed
    assert (found.surface.components, found.surface.euler) == (walls, 2 * walls)
    assert all(found.mask[tuple(np.rint(place).astype(int))] for place in clicks)


def test_the_area_is_that_of_all_walls_of_the_body():
    assert parted().select([WALL]).surface.area == pytest.approx(4.0 * np.pi * (81.0 + 25.0), rel=0.03)
    assert parted().select([HOLLOW]).surface.area == pytest.approx(4.0 * np.pi * 25.0, rel=0.04)


def test_clicks_one_after_the_other_are_those_at_once_and_one_outside_takes_a_body_away():
    first = parted().select([WALL])
    both = parted().select([BALL], previous=first)
    np.testing.assert_array_equal(both.mask, parted().select([WALL, BALL]).mask)
    less = parted().select([], [WALL], previous=both)
    np.testing.assert_array_equal(less.mask, parted().select([BALL]).mask)
    assert "both" not in less.remark
    assert less.remark.startswith("The same body")


def test_the_result_of_a_run_is_cut_along_its_surface():
    inside = np.minimum(9.0 - _away(SHELL), _away(SHELL) - 5.0)
    image = cpm.Image(200.0 * np.clip(0.5 + inside / 1.5, 0.0, 1.0), spacing=SPACING, unit="mm")
    start = cpm.sphere(WALL, 2.0, 60, voxel_size=SPACING)
    cut = cpm.partition(cpm.segment(image, start, cpm.PRESETS["volume"]))
    assert cut.select([HOLLOW]).size == pytest.approx(EMPTY, rel=0.05)
    assert cut.select([WALL]).size == pytest.approx(FULL - EMPTY, rel=0.03)
    everything = cpm.partition(image).select([WALL, HOLLOW])
    assert everything.size == pytest.approx(FULL, rel=0.03)


def test_what_has_been_selected_is_kept_in_single_precision_and_comes_back():
    surface = parted().select([WALL]).surface
    kept = Region.from_surface(surface)
    again = from_json(SegmentedObject, json.loads(json.dumps(to_json(SegmentedObject(1, (), kept)))), "it").region
    assert again == kept
    np.testing.assert_array_equal(again.surface.faces, surface.faces)
    np.testing.assert_allclose(again.surface.vertices, surface.vertices, rtol=1e-6, atol=1e-6)


def test_objects_of_a_surface_are_labeled_by_their_own_numbers():
    ball, wall = (parted().select([place]).surface for place in (BALL, WALL))
    faces = np.concatenate([ball.faces, wall.faces + len(ball.vertices)])
    numbers = np.repeat([7, 3], [len(ball.faces), len(wall.faces)])
    both = Surface(np.concatenate([ball.vertices, wall.vertices]), faces, SPACING, "mm", numbers=numbers)
    labels = label_voxels(both, SHAPE)
    np.testing.assert_array_equal(labels == 7, parted().select([BALL]).mask)
    np.testing.assert_array_equal(labels == 3, parted().select([WALL]).mask)
    with pytest.raises(ValueError, match="numbers of a surface"):
        Surface(both.vertices, faces, SPACING, numbers=numbers[1:])


def _seen(inside, spacing, noise=4.0):
    """A volume with a body that is `inside` by so many units of length, bright, with noise."""
    values = 60.0 + 100.0 * np.clip(0.5 + inside, 0.0, 1.0)
    return cpm.Image(values + np.random.default_rng(3).normal(0.0, noise, values.shape), spacing=spacing)


def _lengths(shape, spacing, center):
    return np.linalg.norm((np.moveaxis(np.indices(shape), 0, -1) - center) * spacing, axis=-1)


def _dice(one, other):
    return 2.0 * np.count_nonzero(one & other) / (np.count_nonzero(one) + np.count_nonzero(other))


@pytest.mark.parametrize(
    ("shape", "spacing", "radius", "off"),
    [
        pytest.param((48, 48, 48), (1.0, 1.0, 1.0), 12.0, 0.1, id="cubes"),
        pytest.param((60, 60, 24), (1.0, 1.0, 3.0), 17.0, 0.45, id="long voxels", marks=pytest.mark.long),
        pytest.param((60, 60, 24), (0.2, 0.2, 0.6), 3.4, 0.09, id="long voxels in another unit"),
    ],
)
def test_a_click_in_a_ball_gives_the_ball_to_a_fraction_of_a_voxel_without_a_run(shape, spacing, radius, off):
    center = 0.5 * np.array(shape)
    away = _lengths(shape, spacing, center)
    found = cpm.partition(_seen((radius - away) / min(spacing), spacing)).select([center + 1.0])
    assert _dice(found.mask, away < radius) > 0.98
    assert found.surface.closed
    assert found.surface.euler == 2
    radii = np.linalg.norm((found.surface.vertices - center) * spacing, axis=1)
    assert np.sqrt(np.square(radii - radius).mean()) < off
    assert found.size == pytest.approx(4.0 / 3.0 * np.pi * radius**3, rel=0.02)


def test_a_body_at_the_border_of_the_volume_is_flat_there():
    away = _lengths((40, 40, 40), (1.0, 1.0, 1.0), np.array([0.0, 20.0, 20.0]))
    found = cpm.partition(_seen(13.0 - away, (1.0, 1.0, 1.0))).select([(3, 20, 20)])
    assert _dice(found.mask, away < 13.0) > 0.97
    assert found.surface.closed
    assert found.surface.vertices[:, 0].min() == -0.5


@pytest.mark.parametrize("noise", [pytest.param(4.0, marks=pytest.mark.long), 20.0])
def test_a_click_in_a_clump_selects_the_body_another_adds_the_next_and_the_clump_is_a_candidate(noise):
    centers = np.array([(24, 20, 20), (24, 20, 37), (24, 35, 28), (38, 28, 28)], float)
    away = np.array([_lengths((56, 56, 60), (1.0,) * 3, center) for center in centers])
    cut = cpm.partition(_seen(np.max(9.0 - away, axis=0), (1.0,) * 3, noise))
    balls = (away < 9.0) & (away == away.min(axis=0))
    first = cut.select(centers[:1])
    clump = cut.find_candidates(centers[:1])[-1]
    assert _dice(clump.mask, (away < 9.0).any(axis=0)) > 0.75
    both = cut.select(centers[1:2], previous=first)
    assert _dice(both.mask, balls[0] | balls[1]) > 0.93
    for found, ball in ((first, balls[0]), (cut.select(centers[3:]), balls[3])):
        assert _dice(found.mask, ball) > 0.88


def test_a_click_on_a_ball_of_a_clump_far_smaller_than_its_body_gives_the_ball_and_the_clump_is_larger():
    values, truths = scan(1, (64, 80, 80), 10.0)
    there, ball = cpm.VolumePartition(cpm.Image(values)), truths["ball 1"]
    at, clump = np.argwhere(ball).mean(axis=0), ball | truths["ball 2"] | truths["ball 3"]
    assert compute_iou(there.select([at]).mask, ball) > 0.8
    assert max(compute_iou(one.mask, clump) for one in there.find_candidates([at])) > 0.85


@pytest.mark.parametrize("noise", [pytest.param(3.0, marks=pytest.mark.long), 40.0])
def test_further_clicks_in_a_scan_add_the_ball_clicked_or_remove_it_and_nothing_else(noise):
    shape = (72, 72, 72)
    centers = np.array([(36, 25, 36), (36, 46, 33), (36, 37, 52)], float)
    away = np.array([_lengths(shape, (1.0,) * 3, center) for center in centers]) - [[[[11.0]]], [[[10.0]]], [[[9.0]]]]
    balls = (away < 0.0) & (away == away.min(axis=0))
    skin = 34.0 - _lengths(shape, (1.0,) * 3, np.full(3, 35.5))
    values = -1000.0 + 900.0 * (skin + 0.5).clip(0.0, 1.0) + 160.0 * (0.5 - away.min(axis=0)).clip(0.0, 1.0)
    cut = cpm.partition(values + np.random.default_rng(0).normal(0.0, noise, shape))
    found, held = cut.select(centers[:1]), balls[0]
    for center, ball in zip(centers[1:], balls[1:], strict=True):
        found, held = cut.select([center], previous=found), held | ball
        assert _dice(found.mask, held) > 0.93
    less = cut.select([], [centers[2] + 1.0], previous=cut.build_selection(Region.from_mask(held), centers[:1]))
    assert _dice(less.mask, balls[0] | balls[1]) > 0.93


@pytest.mark.parametrize("level", [25.0, pytest.param(170.0, marks=pytest.mark.long)])
def test_a_further_click_in_a_hollow_of_a_body_fills_that_hollow_and_nothing_else(level):
    shape, middle = (76, 84, 76), np.array([38.0, 42.0, 38.0])
    away = _lengths(shape, (1.0, 30.0 / 33.0, 1.0), middle)
    place = middle + np.array([4.0, -9.0, 8.0])
    hollow = _lengths(shape, (1.0,) * 3, place) < 6.0
    values = np.select([hollow, away < 24.0, away < 29.0, away < 33.0], [level, 110.0, 22.0, 90.0])
    values = scipy.ndimage.gaussian_filter(values, 0.8) + np.random.default_rng(8).normal(0.0, 5.0, shape)
    cut, brain = cpm.partition(values), away < 24.0
    found = cut.select([(38.0, 60.0, 32.0)])
    assert _dice(found.mask, brain & ~hollow) > 0.97
    assert _dice(cut.select([place], previous=found).mask, brain) > 0.97


def test_a_click_on_a_branch_selects_the_whole_tree_and_another_takes_nothing_away():
    shape = (72, 96, 72)
    ends = np.array([(36, 4, 36), (36, 90, 36), (36, 30, 36), (66, 60, 60), (36, 50, 36), (8, 84, 12)], float)
    along = np.linspace(0.0, 1.0, 200)[:, None]
    line = np.concatenate([first + along * (last - first) for first, last in ends.reshape(3, 2, 3)])
    away = scipy.spatial.KDTree(line).query(np.moveaxis(np.indices(shape), 0, -1).reshape(-1, 3))[0].reshape(shape)
    cut = cpm.partition(_seen(2.5 - away, (1.0,) * 3, 8.0))
    first = cut.select([(36, 12, 36)])
    assert _dice(first.mask, away < 2.5) > 0.85
    more = cut.select([(64, 59, 58)], previous=first)
    assert np.count_nonzero(first.mask & ~more.mask) < 0.02 * np.count_nonzero(first.mask)


def test_a_click_on_an_organ_does_not_leak_out_to_the_skin():
    rng, center = np.random.default_rng(4), np.array([24.0, 36.0, 44.0])
    shape = (48, 72, 88)
    body = np.linalg.norm((np.moveaxis(np.indices(shape), 0, -1) - center) / (40.0, 30.0, 38.0), axis=-1)
    values = np.select([body < 0.85, body < 0.95, body < 1.0], [80.0, 45.0, 80.0])
    organs = []
    for place, radius, level in (((24, 30, 32), 10.0, 105.0), ((22, 44, 56), 8.0, 60.0), ((26, 26, 58), 6.0, 110.0)):
        organs.append(_lengths(shape, (1.0, 1.0, 1.2), np.array(place)) < radius)
        values[organs[-1]] = level
    values = scipy.ndimage.gaussian_filter(values, 0.7) + rng.normal(0.0, 5.0, shape)
    cut = cpm.partition(cpm.Image(values))
    for organ in organs:
        place = np.argwhere(organ).mean(axis=0) + np.array([0.0, 1.0, -2.0])
        assert _dice(cut.select([place]).mask, organ) > 0.85


@cache
def bridged(seed):
    """A partition with a ball of two tissues in a shell that it touches over a thin dark gap, and the ball."""
    rng, away = np.random.default_rng(seed), _lengths((72,) * 3, (1.0,) * 3, np.full(3, 35.5))
    folds = scipy.ndimage.gaussian_filter(rng.normal(size=away.shape), 2.5)
    tissue = 90.0 + 25.0 * (folds > 0.0)
    gap = (away >= 20.0) & (away < 25.0) & (folds < 1.2 * folds.std())
    values = scipy.ndimage.gaussian_filter(np.select([gap, away < 20.0, away < 31.0], [20.0, tissue, 130.0], 5.0), 0.7)
    return cpm.partition(rng.normal(values, 5.0)), away < 20.0


@pytest.mark.parametrize("seed", [1, *(pytest.param(each, marks=pytest.mark.long) for each in (2, 3))])
def test_a_click_deep_in_what_touches_its_surroundings_in_many_places_gives_it_without_them(seed):
    there, ball = bridged(seed)
    first = there.select([(34, 36, 40)])
    assert _dice(first.mask, ball) > 0.9
    for further in ({"inside": [(35, 35, 20)]}, {"outside": [(35, 35, 8)]}):
        assert _dice(there.select(**further, previous=first).mask, ball) > 0.9


@pytest.mark.parametrize("seed", [1103, pytest.param(1108, marks=pytest.mark.long)])
def test_a_click_deep_in_a_brain_that_the_end_of_the_volume_cuts_and_skin_touches_gives_the_brain(seed):
    rng = np.random.default_rng(seed)
    brain(rng, touching=False)
    values, inside = brain(rng, touching=True)
    depth = scipy.ndimage.distance_transform_edt(inside)
    found = cpm.partition(values).select([np.argwhere(depth == depth.max())[0]])
    assert _dice(found.mask, inside) > 0.9


def test_a_click_outside_a_part_prefers_another_body_around_the_first_click_to_a_dent():
    there = bridged(1)[0]
    bodies = there.predict_around(np.array([(34.0, 36.0, 40.0)]))
    whole = next(one for one in bodies if one.size > 60000)
    found = there.select([], [(35, 35, 8)], previous=whole)
    assert any(found.size == pytest.approx(one.size, rel=0.05) for one in bodies if one.size <= 60000)


def test_a_click_is_answered_though_another_thread_asks_around_another_place_meanwhile():
    class Forgetful(dict):
        def __setitem__(self, place, bodies):
            """Forget at once what was predicted, as when the other thread clears it."""

    cut = cpm.VolumePartition(cpm.example("ball"))
    vars(cut)["_predicted_around"] = Forgetful()
    assert cut.select([(15, 15, 15)]).contains(np.array([(15.0, 15.0, 15.0)])).all()


def test_clicks_part_two_balls_that_touch_and_join_them():
    one, other = (_lengths((40, 40, 64), (1.0,) * 3, np.array([20.0, 20.0, col])) for col in (18.0, 43.5))
    cut = cpm.partition(_seen(np.maximum(12.0 - one, 13.0 - other), (1.0,) * 3))
    first = cut.select([(20, 20, 18)], [(20, 20, 43)])
    assert _dice(first.mask, one < 12.0) > 0.9
    both = cut.select([(20, 20, 43)], previous=cut.select([(20, 20, 18)]))
    assert _dice(both.mask, (one < 12.0) | (other < 13.0)) > 0.9


def test_a_click_in_a_ball_within_a_ball_has_both_among_its_candidates_from_small_to_large():
    away = _lengths((64, 64, 64), (1.0,) * 3, np.full(3, 32.0))
    values = 40.0 + 100.0 * np.clip(22.5 - away, 0.0, 1.0) + 30.0 * np.clip(8.5 - away, 0.0, 1.0)
    noise = np.random.default_rng(3).normal(0.0, 4.0, values.shape)
    cut = cpm.partition(cpm.Image(values + noise))
    found = cut.find_candidates([(32, 32, 32)])
    assert [_dice(found[0].mask, away < 8.0), _dice(found[-1].mask, away < 22.0)] == pytest.approx([1.0, 1.0], abs=0.1)
    volumes = [one.size for one in found]
    assert volumes == sorted(volumes)
    assert any(one.has_same_region(cut.select([(32, 32, 32)])) for one in found)


def test_a_correction_keeps_all_clicks_and_the_same_arguments_give_the_same_answer():
    rng = np.random.default_rng(5)
    places = np.moveaxis(np.indices((48, 48, 48)), 0, -1) - 24.0
    ring = 6.0 - np.hypot(np.hypot(places[..., 1], places[..., 2]) - 14.0, places[..., 0])
    cut = cpm.partition(_seen(ring, (1.0,) * 3, 20.0))
    within, beyond, found = [(24, 24, 38)], [], None
    for turn in range(8):
        found = cut.select(within, beyond, previous=found)
        assert found.surface.closed
        assert all(found.mask[place] for place in within)
        assert not any(found.mask[place] for place in beyond)
        np.testing.assert_array_equal(found.contains(np.array(within)), True)
        wrong = np.argwhere(found.mask != (ring > 0.0)) if turn % 2 else np.argwhere(found.mask != found.mask[::-1])
        if len(wrong):
            place = tuple(wrong[rng.integers(len(wrong))].tolist())
            if place not in within + beyond:
                (within if ring[place] > 0.0 else beyond).append(place)
    assert _dice(found.mask, ring > 0.0) > 0.8
    again = cut.select(within, beyond)
    np.testing.assert_array_equal(cut.select(within, beyond).surface.vertices, again.surface.vertices)


def test_a_correction_is_the_same_after_a_click_elsewhere():
    shape = (64, 80, 96)
    skin = _lengths(shape, (1.0 / 44.0, 1.0 / 32.0, 1.0 / 42.0), np.array([32.0, 42.0, 48.0]))
    organ = _lengths(shape, (1.0 / 16.0, 1.0 / 14.0, 1.0 / 15.0), np.array([32.0, 42.0, 30.0]))
    centers = np.array([(24, 42, 66), (24, 42, 80), (38, 42, 73)], float)
    ball = np.min([_lengths(shape, (1.0,) * 3, center) for center in centers], axis=0)
    values = np.select([ball < 7.5, organ < 1.0, skin < 1.0], [250.0, 100.0, 40.0], -1000.0)
    noisy = scipy.ndimage.gaussian_filter(values, 0.7) + np.random.default_rng(5).normal(0.0, 12.0, shape)
    cut = cpm.partition(cpm.Image(noisy, spacing=(2.0, 1.0, 1.0)))
    first = cut.select([(32, 42, 30)])
    at_once = cut.select([], [(32, 42, 52)], previous=first)
    cut.select(centers[:1])
    assert np.array_equal(cut.select([], [(32, 42, 52)], previous=first).mask, at_once.mask)


def test_a_click_where_no_surface_is_closed_adds_what_is_likely_there_to_what_is_certain():
    cut = parted()
    alone = cpm.VolumePartition(cut.image, cut.select([WALL]).surface)
    certain = alone.select([WALL])
    assert certain.prediction is None
    both = alone.select([BALL], previous=certain)
    assert both.prediction is not None
    assert _dice(both.mask, cut.select([WALL, BALL]).mask) > 0.9


@pytest.mark.parametrize("adds", [True, False])
def test_a_click_corrects_painted_voxels_near_it_and_leaves_those_far_from_it(adds):
    shape = (48, 48, 80)
    ball = _lengths(shape, (1.0,) * 3, np.array([24.0, 24.0, 24.0])) < 14.0
    off = _lengths(shape, (1.0,) * 3, np.array([24.0, 24.0, 41.0]))
    lump = off < 7.0
    cut = cpm.partition(_seen(np.where(ball | (lump & adds), 1.0, -1.0), (1.0,) * 3))
    painted = ball if adds else ball | lump
    far = np.zeros(shape, bool)
    far[4:40:3, 8:40:2, 60:72], far[20:28, 10:14, 20:28] = True, True  # nothing that an image shows
    painted = (painted | far) & ~(np.indices(shape)[2] < 14)
    before = cut.build_selection(Region.from_mask(painted))
    np.testing.assert_array_equal(before.mask, painted)
    click = [(24, 24, 44)]
    after = cut.select(*((click, []) if adds else ([(24, 24, 24)], click)), previous=before)
    wanted = painted | lump if adds else painted & ~(lump & ~ball)
    assert _dice(after.mask ^ painted, wanted ^ painted) > 0.9
    away = off > 13.0
    np.testing.assert_array_equal(after.mask[away], painted[away])
    assert after.region.surface is None and after.region.size == after.mask.sum()


@pytest.mark.parametrize("side", [48, 120])
def test_what_a_click_gives_stays_in_the_region_of_interest(side):
    radius, center = 0.3 * side, np.full(3, 0.5 * side)
    away = _lengths((side,) * 3, (1.0,) * 3, center)
    box = tuple(center - (2.0, radius, 4.0)), tuple(center + radius)
    regions = cpm.VolumeRegions(interest=[box])
    cut = cpm.VolumePartition(_seen(radius - away, (1.0,) * 3), regions=regions)
    found, allowed = cut.select([center + 2.0]), regions.voxel_mask(away.shape)
    assert _dice(found.mask, (away < radius) & allowed) > 0.97
    assert not (found.mask & ~scipy.ndimage.binary_dilation(allowed)).any()
    assert (found.mask & ~allowed).sum() < 0.002 * found.mask.sum()
    beyond = cut.select([center - 6.0])
    assert (beyond.has_boundary, beyond.remark) == (
        False,
        "A point outside the regions of interest is ignored.",
    )


def test_a_click_deep_in_an_organ_has_it_among_its_candidates_next_to_the_whole():
    away, rng = _lengths((64,) * 3, (1.0,) * 3, np.full(3, 31.0)), np.random.default_rng(7)
    layers = np.select([away < 18.0, away < 20.5, away < 26.0], [100.0, 35.0, 150.0], 10.0)
    shade = scipy.ndimage.gaussian_filter(rng.normal(size=away.shape), 20.0)
    values = scipy.ndimage.gaussian_filter(layers, 0.8) * (1.0 + 0.08 * shade / shade.std())
    cut = cpm.partition(values + rng.normal(0.0, 6.0, away.shape))
    found = cut.find_candidates([(31, 39, 35)])
    assert max(_dice(one.mask, away < 18.0) for one in found) > 0.95
    assert _dice(found[-1].mask, away < 26.0) > 0.95
    assert len(found) < 4


@pytest.mark.parametrize("noise", [*(pytest.param(each, marks=pytest.mark.long) for each in (0.0, 10.0)), 30.0])
def test_a_click_in_the_background_finds_nothing_and_one_in_a_faint_ball_the_ball(noise) -> None:
    away = np.linalg.norm(np.moveaxis(np.indices((32, 40, 44)), 0, -1) - (16, 14, 15), axis=-1)
    values = 60.0 * np.clip(7.5 - away, 0.0, 1.0) + np.random.default_rng(3).normal(0.0, noise, away.shape)
    bodies = cpm.VolumePartition(cpm.Image(values))
    for place in ((16, 32, 34), (28, 8, 38)):
        nothing = bodies.select([place])
        assert not nothing.has_boundary
        assert nothing.remark.startswith("No body was found")
        assert not bodies.select([place], previous=nothing).has_boundary
    assert bodies.select([(16, 14, 15)]).size == pytest.approx(4.0 / 3.0 * np.pi * 7.0**3, rel=0.25)


def test_a_hollow_like_the_background_is_found_with_edges_around_it_and_the_whole_is_a_candidate() -> None:
    away = np.linalg.norm(np.moveaxis(np.indices((44, 44, 44)), 0, -1) - 22, axis=-1)
    shell = np.where((away > 7.0) & (away < 14.0), 100.0, 0.0)
    values = shell + np.random.default_rng(3).normal(0.0, 15.0, away.shape)
    bodies = cpm.VolumePartition(cpm.Image(values))
    assert _dice(bodies.select([(22, 22, 22)]).mask, away < 7.0) > 0.9
    assert _dice(bodies.find_candidates([(22, 22, 22)])[-1].mask, away < 14.0) > 0.9


@cache
def ball_alone():
    """A partition with a ball of radius 12, and the distances from its center."""
    away = _lengths((40, 40, 40), (1.0,) * 3, np.full(3, 20.0))
    return cpm.partition(_seen(12.0 - away, (1.0,) * 3)), away


@pytest.mark.parametrize("runs", [False, True])
def test_nothing_excluded_is_selected_in_a_volume_and_the_rest_is_what_it_would_be(runs):
    cut, away = ball_alone()
    if runs:
        cut = cpm.VolumePartition(cut.image, cut.select([(20, 20, 20)]).surface)
    right = np.indices(away.shape)[2] >= 24
    whole = cut.select([(20, 20, 16)])
    chosen = cut.select([(20, 20, 16)], excluded=right)
    np.testing.assert_array_equal(chosen.mask, whole.mask & ~right)
    assert chosen.surface.closed and chosen.size < whole.size
    more = cut.select([(20, 20, 12)], previous=chosen, excluded=right)
    np.testing.assert_array_equal(more.mask, chosen.mask)
    assert not any((one.mask & right).any() for one in cut.find_candidates([(20, 20, 16)], excluded=right))
    np.testing.assert_array_equal(cut.select([(20, 20, 16)], excluded=away > 15.0).mask, whole.mask)


def test_what_excluded_voxels_cut_off_from_the_click_is_left_out_and_a_click_in_them_is_ignored():
    cut, away = ball_alone()
    wall = np.abs(np.indices(away.shape)[2] - 22) < 2
    assert not cut.select([(20, 20, 14)], excluded=wall).mask[..., 21:].any()
    nothing = cut.select([(20, 20, 22)], excluded=wall)
    assert (nothing.has_boundary, nothing.remark) == (False, "A point in another object is ignored.")
    with pytest.raises(ValueError, match="the excluded voxels are"):
        cut.select([(20, 20, 14)], excluded=wall[1:])


@pytest.mark.parametrize("side", [40.0, 41.0, 55.0])
def test_the_crop_of_a_body_that_reaches_its_sides_is_widened_twice_whatever_its_size(monkeypatch, side):
    empty = np.zeros(1, np.float32)
    body = BodyPrediction(Crop3D(np.full(3, 100.0), side), empty, empty)
    predictor = body_predictor.BodyPredictor(np.zeros((200, 200, 200)), np.ones(3), network=lambda maps: None)
    monkeypatch.setattr(
        body_predictor, "correct_in_crop", lambda _, context, *__: BodyPrediction(context.crop, empty, empty)
    )
    monkeypatch.setattr(body_predictor, "_touches_crop_sides", lambda *_: True)
    at = np.full((1, 3), 100.0)
    assert predictor.correct_body(body, at[0], True, at, at[:0], lambda: None).crop.side == pytest.approx(1.4**2 * side)
