"""Objects chosen by clicks in scenes whose boundaries are known."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.ndimage as ndi
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core import Image, Partition, Regions, circle, example, partition, segment, select_all, uniform_grid
from cpm_core.field.start_area.drawn_area import drawn_area, is_line
from cpm_core.image.region import Region
from cpm_core.numerics import polyline
from cpm_core.objects.boundaries.necks import split_at_necks
from cpm_core.objects.partition import partition_without_run
from cpm_core.objects.prior.object_predictor import ObjectPredictor, Prediction
from cpm_core.objects.similar_objects import find_similar_objects

from ..scenes import antialiased, disk, ring

SHAPE = (96, 96)


def overlap(mask, truth):
    return np.count_nonzero(mask & truth) / np.count_nonzero(mask | truth)


def truth_of(scene):
    return scene.values > 120.0


@pytest.fixture(scope="module")
def disk_scene():
    return disk(SHAPE, (47.3, 46.6), 24.4)


@pytest.fixture(scope="module")
def disk_partition(disk_scene):
    return partition(disk_scene.values)


def test_a_click_in_a_disk_gives_the_disk(disk_scene, disk_partition):
    chosen = disk_partition.select([(47, 47)])
    assert overlap(chosen.mask, truth_of(disk_scene)) > 0.98
    assert len(chosen.contours) == 1
    assert chosen.contours[0].closed
    assert disk_scene.distance(chosen.contours[0].points).max() < 1.5
    assert chosen.gaps == ()
    assert chosen.confidence > 0.93
    assert chosen.remark == ""


def test_a_hole_that_is_said_to_be_outside_stays_one():
    scene = ring(SHAPE, (47.3, 46.6), 10.0, 30.0)
    chosen = partition(scene.values).select([(47, 67)], [(47, 47)])
    assert overlap(chosen.mask, truth_of(scene)) > 0.96
    assert len(chosen.contours) == 2


def test_a_place_outside_the_image_counts_as_the_nearest_one_in_it_and_is_told():
    values = antialiased(SHAPE, lambda row, col: row - 0.0 * col < 40.0)
    chosen = partition(values).select([(-9.0, 40.0)], [(90, 40)])
    assert overlap(chosen.mask, values > 120.0) > 0.97
    assert "outside the image" in chosen.remark


def test_nothing_outside_the_regions_of_interest_is_selected(disk_scene):
    regions = Regions(interest=(((-1, -1), (-1, 60.5), (97, 60.5), (97, -1)),))
    result = segment(disk_scene.values, circle((47, 47), 8.0), regions=regions)
    chosen = partition(result).select([(47, 47)])
    within = np.indices(SHAPE)[1] < 60.5
    assert overlap(chosen.mask, truth_of(disk_scene) & within) > 0.97


@pytest.mark.parametrize("previous", [False, True])
def test_nothing_excluded_is_selected_and_the_rest_is_what_it_would_be(disk_scene, disk_partition, previous):
    right = np.indices(SHAPE)[1] >= 50
    before = disk_partition.select([(47, 40)])
    chosen = disk_partition.select([(47, 40)], previous=before if previous else None, excluded=right)
    np.testing.assert_array_equal(chosen.mask, before.mask & ~right)
    assert all((curve.points[:, 1] < 50).all() for curve in chosen.contours)
    for one in disk_partition.find_candidates([(47, 40)], excluded=right):
        assert not (one.mask & right).any()


def test_a_point_in_an_excluded_pixel_is_ignored_and_that_is_told(disk_partition):
    right = np.indices(SHAPE)[1] >= 50
    chosen = disk_partition.select([(47, 55)], excluded=right)
    assert not chosen.mask.any()
    assert "in another object" in chosen.remark
    with pytest.raises(ValueError, match="the excluded pixels are"):
        disk_partition.select([(47, 40)], excluded=right[1:])


def test_a_negative_point_that_leaves_nearly_all_of_a_joined_pair_makes_it_no_more_likely():
    row, col = np.indices(SHAPE)
    pair = (np.hypot(row - 48, col - 38) < 15) | (np.hypot(row - 48, col - 59) < 14)
    noise = np.random.default_rng(1).normal(0.0, 9.0, SHAPE)
    found = partition(ndi.gaussian_filter(40.0 + 60.0 * pair, 1.5) + noise)
    before = found.select([(48, 38)])
    assert overlap(before.mask, pair) > 0.9
    for place in ((48, 72), (56, 70), (63, 35)):
        after = found.select([(48, 38)], [place], previous=before)
        assert 0.95 * before.region.size < after.region.size < before.region.size
        assert after.confidence <= before.confidence


def test_an_object_beside_the_one_selected_before_is_as_likely_as_without_that():
    row, col = np.indices((110, 150))
    one, other = np.hypot(row - 55, col - 38) < 17, np.hypot(row - 55, col - 108) < 16
    noise = np.random.default_rng(0).normal(0.0, 9.0, row.shape)
    found = partition(ndi.gaussian_filter(40.0 + 60.0 * (one | other), 1.5) + noise)
    before = found.select([(55, 38)])
    after = found.select([(55, 38), (55, 108)], [(55, 38)], previous=before)
    assert overlap(after.mask, other) > 0.9
    assert after.size < before.size
    alone = found.select([(55, 108)], [(55, 38)])
    assert before.confidence < after.confidence == pytest.approx(alone.confidence, abs=0.02)


@pytest.mark.parametrize("place", [(30, 44), (24, 36)])
def test_points_that_change_nothing_leave_the_confidence_as_it_was(scene_partition, place):
    before = scene_partition.select([(30, 38)], [(30, 68)])
    assert before.mask[place]
    after = scene_partition.select([(30, 38), place], [(30, 68), (5, 5)], previous=before)
    assert after.has_same_region(before)
    assert (after.confidence, after.features) == (before.confidence, before.features)
    assert (len(after.inside), len(after.outside)) == (2, 2)


def test_limits_leave_no_fragment_of_an_object(disk_partition):
    whole = disk_partition.select([(47, 40)])
    excluded = np.zeros(disk_partition.shape, bool)
    rows, cols = np.nonzero(whole.mask)
    top, col = int(rows.min()) + 4, int(cols[rows == rows.min()][0])
    excluded[: top + 1] = True
    excluded[top, col] = False  # one pixel stays, which touches the rest
    excluded[top + 1, col] = True  # but at a corner alone
    chosen = disk_partition.select([(47, 40)], excluded=excluded)
    left = disk_partition.remove_pixels(whole, excluded)
    for one in (chosen, left):
        assert one.mask.any() and not one.mask[: top + 1].any()
        assert len(one.contours) == 1


def test_an_object_that_loses_pixels_stays_as_likely():
    (found, *_) = segment(example("disks"), uniform_grid((64, 64))).objects
    bare, excluded = Partition(found.image, ()), np.zeros((64, 64), bool)
    excluded[tuple(np.argwhere(found.mask)[0])] = True
    left = bare.remove_pixels(found, excluded)
    assert np.count_nonzero(left.mask) == np.count_nonzero(found.mask) - 1
    assert left.confidence == found.confidence
    assert bare.remove_pixels(found, found.mask).confidence == 0.0


def two_disks(row, col):
    """Two disks that touch, a ring, and a half disk at the left border."""
    first, second = np.hypot(row - 30.0, col - 40.0) < 15.0, np.hypot(row - 30.0, col - 66.0) < 13.0
    around = np.hypot(row - 90.0, col - 60.0)
    return first | second | ((around < 20.0) & (around > 9.0)) | (np.hypot(row - 70.0, col + 2.0) < 15.0)


@pytest.fixture(scope="module")
def scene_partition():
    return partition(antialiased((128, 128), two_disks))


def within(row, col, radius, shape=(128, 128)):
    return np.hypot(np.indices(shape)[0] - row, np.indices(shape)[1] - col) < radius


def test_of_two_disks_that_touch_one_is_parted_at_the_neck_by_a_click_in_the_other(scene_partition):
    chosen = scene_partition.select([(30, 38)], [(30, 68)])
    assert overlap(chosen.mask, within(30.0, 40.0, 15.0)) > 0.93
    assert not chosen.mask[30, 68]
    assert sum(np.linalg.norm(np.diff(gap, axis=0), axis=1).sum() for gap in chosen.gaps) < 25.0
    assert 0.5 < chosen.confidence < 1.0


@pytest.fixture(scope="module")
def joined():
    """An image of two disks that touch, in which nothing but necks decides, and both selected by a point in each."""
    bare = Partition(Image(antialiased((128, 128), two_disks)), (), uses_network=False)
    both = within(30.0, 40.0, 15.0) | within(30.0, 66.0, 13.0)
    return bare, bare.build_selection(both, np.array([(30.0, 38.0), (30.0, 68.0)]))


@pytest.mark.parametrize("inside", [[(30, 38)], [(30, 38), (30, 68)]])
def test_a_negative_point_in_the_middle_of_a_part_takes_away_all_of_it(joined, inside):
    bare, both = joined
    left = bare.select(inside, [(31, 70)], previous=both)
    assert overlap(left.mask, within(30.0, 40.0, 15.0)) > 0.96
    again = bare.select([*inside, (30, 36)], [(31, 70)], previous=left)
    np.testing.assert_array_equal(again.mask, left.mask)


@pytest.mark.parametrize(("col", "is_larger"), [(73, True), (61, False)])
def test_a_further_point_means_the_larger_object_only_in_the_middle_of_what_is_missing(monkeypatch, col, is_larger):
    row, column = np.indices(SHAPE)
    small, large = (np.hypot(row - 48, column - 48) <= radius for radius in (12, 40))

    def predict(self, prompt, known_area=None):
        """Predict the small disk, then the large one; or what is corrected, with a bump at the last point."""
        answers, certainty = [small, large], 0.9
        if prompt.previous_mask is not None:
            answers = [prompt.previous_mask | (np.hypot(row - 48, column - prompt.positive[-1, 1]) <= 6)]
            certainty = 0.8
        return iter([Prediction(mask.copy(), 1.0, 0.9, certainty, 0.9, 0.9) for mask in answers])

    monkeypatch.setattr(ObjectPredictor, "predict_objects", predict)
    cut = partition_without_run(Image(np.random.default_rng(0).normal(100.0, 5.0, SHAPE)))
    first = cut.select([(48, 48)])
    assert overlap(first.mask, small) > 0.95
    second = cut.select([(48, 48), (48, col)], previous=first)
    assert second.contains(np.array([(48.0, col)])).all()
    assert (overlap(second.mask, large) > 0.95) == is_larger


def test_a_part_is_taken_away_whole_also_where_its_positive_point_is_outside_the_image():
    bare = Partition(Image(np.zeros((128, 128))), (), uses_network=False)
    one, other = within(10.0, 40.0, 15.0), within(10.0, 66.0, 13.0)
    points = np.array([(10.0, 38.0), (-3.0, 66.0)])
    left = bare.select(points, [(11, 68)], previous=bare.build_selection(one | other, points))
    assert overlap(left.mask, one) > 0.95


@pytest.mark.parametrize("last", [True, False])
def test_the_last_of_two_marks_of_a_pixel_counts_at_all_further_clicks(last):
    cut = Partition(Image(100.0 * within(60, 60, 40)), ())
    inside, other = [(60, 50), (60, 92)], (60, 92)
    first = cut.select(inside[:1])
    taken = cut.select(inside[:1], [other], previous=first)
    again = cut.select(inside, [other], previous=taken)
    assert again.contains(np.array([other])).all()
    after = cut.select(inside, [other, (5, 5) if last else other], previous=again)
    assert after.contains(np.array([other])).all() == last


def test_a_negative_point_on_a_small_island_takes_away_the_island():
    bare = Partition(Image(np.zeros((128, 128))), (), uses_network=False)
    large = within(60, 60, 50)
    for radius in (1, 2, 4):
        both = bare.build_selection(large | within(118, 118, radius), np.array([(60.0, 60.0)]))
        np.testing.assert_array_equal(bare.select([(60, 60)], [(118, 118)], previous=both).mask, large)


def test_a_negative_point_that_is_not_in_the_middle_or_beside_a_newer_positive_one_takes_away_no_part(joined):
    bare, both = joined
    for inside, outside in ([(30, 38)], (31, 75)), ([(30, 38), (36, 72)], (31, 70)), ([(30, 70), (30, 38)], (30, 54)):
        left = bare.select(inside, [outside], previous=both)
        assert np.count_nonzero(both.mask & ~left.mask) == 1


@pytest.mark.parametrize("size", [1, 9])
def test_necks_are_where_they_are_in_images_of_any_size(size):
    row, col = np.indices((96 * size, 128 * size)) / size
    one, other = (np.hypot(row - 48, col - at) <= 20 for at in (45, 81))
    parts = split_at_necks(one | other)
    assert parts.max() == 2
    assert ((parts > 0) == (one | other)).all()
    assert overlap(parts == parts[48 * size, 45 * size], one & (col <= 63)) > 0.98


def test_a_gap_in_a_drawn_outline_is_closed_straight_and_told():
    lines = np.full((96, 96), 200.0)
    lines[20:70, 20:22] = lines[20:70, 68:70] = lines[68:70, 20:70] = 40.0
    lines[20:22, 20:40] = lines[20:22, 50:70] = 40.0
    chosen = partition(lines).select([(45, 45)], [(5, 45)])
    row, col = np.indices(lines.shape)
    inner, outer = ((row > 21 - w) & (row < 68 + w) & (col > 21 - w) & (col < 68 + w) for w in (0, 5))
    assert chosen.mask[inner].all()
    assert not chosen.mask[~outer].any()
    lengths = [float(np.linalg.norm(np.diff(gap, axis=0), axis=1).sum()) for gap in chosen.gaps]
    assert lengths
    assert sum(lengths) < 25.0
    assert all(abs(gap[:, 1].mean() - 45.0) < 12.0 for gap in chosen.gaps)


def test_what_has_no_bearing_on_a_further_click_stays_as_it_was(scene_partition):
    before = scene_partition.select([(30, 38), (90, 75)], [(5, 5)])
    after = scene_partition.select([(30, 38), (90, 75)], [(5, 5), (30, 68)], previous=before)
    lower = np.indices((128, 128))[0] > 60
    assert np.array_equal(before.mask[lower], after.mask[lower])
    assert not after.mask[30, 68]


def test_a_click_changes_only_what_hangs_together_with_it(scene_partition):
    before = scene_partition.select([(30, 38)], [(5, 5)])
    wrong = replace(before, region=Region.from_mask(before.mask ^ within(110.0, 20.0, 4.0)))
    after = scene_partition.select([(30, 38)], [(5, 5), (30, 68)], previous=wrong)
    assert not after.mask[within(110.0, 20.0, 4.0)].any()  # not connected with the object
    assert after.mask[30, 38]


def test_the_same_place_inside_and_outside_is_what_was_marked_last_and_told(scene_partition):
    chosen = scene_partition.select([(30, 38), (90, 75)], [(30, 38)])
    assert "The same point" in chosen.remark
    assert not chosen.mask[30, 38]
    assert chosen.mask[90, 75]
    again = scene_partition.select(
        [(90, 75), (30, 38)], [(30, 38)], previous=scene_partition.select([(90, 75)], [(30, 38)])
    )
    assert again.mask[30, 38]


def test_all_like_this_finds_the_others_and_parts_those_that_touch():
    centers = [(20, 20), (20, 60), (60, 20), (60, 70), (60, 91), (100, 2), (100, 60)]

    def disks(row, col):
        alike = np.any([np.hypot(row - r, col - c) < 11.0 for r, c in centers], axis=0)
        return alike | (np.hypot(row - 110.0, col - 100.0) < 3.0)

    there = partition(antialiased((128, 128), disks))
    found = select_all(there, [there.select([(20, 20)])])
    assert len(found) == len(centers)
    for center in centers:
        true = within(*center, 11.0)
        assert max(overlap(other.mask, true) for other in found) > 0.85
    assert np.sum([other.mask for other in found], axis=0).max() == 1


def test_what_lies_mostly_in_excluded_pixels_is_not_like_this_and_the_rest_is_rated_without_them():
    pair, half = within(60, 70, 11.0) | within(60, 89, 9.0), within(60, 23, 11.0)
    single, row = within(20, 20, 11.0), np.indices((128, 128))[0]
    there = partition(30.0 + 110.0 * ndi.gaussian_filter((pair | half | single).astype(float), 1.0))
    example, thinner = there.select([(20, 20)]), ndi.binary_erosion(pair, iterations=2)
    (other,) = find_similar_objects(there, example, thinner)
    assert overlap(other.mask, half) > 0.9
    (rest,) = find_similar_objects(there, example, pair | (half & (row > 63)))
    assert overlap(rest.mask, half & (row <= 63)) > 0.9
    assert rest.confidence < other.confidence


def test_outlines_of_all_like_this_are_as_smooth_in_noise_as_that_of_a_click():
    centers = [(24, 24), (24, 70), (70, 26), (74, 72)]
    disks = np.any([within(*center, 12.0) for center in centers], axis=0)
    noise = np.random.default_rng(2).normal(0.0, 7.0, disks.shape)
    there = partition(30.0 + 110.0 * ndi.gaussian_filter(disks.astype(float), 1.3) + noise)
    found = select_all(there, [there.select([centers[0]])])
    assert len(found) == len(centers)
    for one in found:
        assert max(overlap(one.mask, within(*center, 12.0)) for center in centers) > 0.95
        assert one.contours[0].length == pytest.approx(found[0].contours[0].length, rel=0.04)


def test_where_nothing_is_found_the_places_alone_are_chosen_and_that_is_told():
    chosen = Partition(Image(np.zeros((64, 64))), (), uses_network=False).select([(32, 32)])
    assert chosen.has_only_points
    assert chosen.remark.startswith("No object was found")


def test_a_stroke_and_a_box_choose_the_object_of_a_click(disk_scene, disk_partition):
    for drawn in ({"stroke": [(40, 40), (52, 52)]}, {"box": [(21, 24), (73, 70)]}):
        assert overlap(disk_partition.select(**drawn).mask, truth_of(disk_scene)) > 0.9


@pytest.mark.parametrize("given", ["inside", "stroke"])
@pytest.mark.parametrize(("opening", "step"), [(0.0, 1.5), (0.8, 1.5), (0.4, 9.0)])
def test_a_line_around_an_object_whose_ends_nearly_meet_is_a_lasso(disk_scene, given, opening, step):
    turns = np.arange(0.3, 2.0 * np.pi + 0.3 - opening, step / 30.0)
    line = (47.0, 47.0) + 30.0 * np.column_stack([np.sin(turns), np.cos(turns)])
    bare = Partition(Image(disk_scene.values), (), uses_network=False)
    assert overlap(bare.select(**{given: line}).mask, truth_of(disk_scene)) > 0.95


@pytest.mark.parametrize("corners", [4, 5, 7])
def test_a_closed_stroke_of_few_vertices_is_a_lasso(disk_scene, corners):
    turns = np.linspace(0.3, 2.0 * np.pi + 0.2, corners + 1)
    line = (47.0, 47.0) + 38.0 * np.column_stack([np.sin(turns), np.cos(turns)])
    bare = Partition(Image(disk_scene.values), (), uses_network=False)
    assert overlap(bare.select(stroke=line).mask, truth_of(disk_scene)) > 0.95
    assert overlap(bare.select(stroke=line[:-2]).mask, truth_of(disk_scene)) < 0.5


@pytest.mark.parametrize("line", [[(20, 47), (74, 47)], [(47, 20), (20, 47), (47, 74)]])
def test_an_open_line_is_no_lasso(disk_scene, line):
    path = polyline.resample_path(np.array(line, float), 2.0)
    bare = Partition(Image(disk_scene.values), (), uses_network=False)
    assert bare.select(path).has_only_points


@pytest.mark.parametrize("step", [1.0, 2.0, 3.16, 4.1, 7.0])
@pytest.mark.parametrize("turn", [0.0, 0.02, 0.4, 0.8])
def test_what_an_open_line_covers_is_a_line_however_far_its_places_are_apart(step, turn):
    line = (48.0, 5.0) + np.arange(12)[:, None] * step * np.array([np.sin(turn), np.cos(turn)])
    assert is_line(drawn_area(line, SHAPE))
    assert not is_line(drawn_area(circle((48, 48), 4.0, spacing=min(step, 3.0)), SHAPE))


@pytest.fixture(scope="module")
def speckled():
    """A partition of an image of blobs with noise."""
    noise = np.random.default_rng(3).normal(0.0, 1.0, (96, 96))
    values = 100.0 + 60.0 * (ndi.gaussian_filter(noise, 7.0) > 0.01) + 6.0 * noise
    return partition(values)


places = st.tuples(st.integers(0, 95), st.integers(0, 95))


@settings(max_examples=10, deadline=None)
@given(st.lists(places, min_size=1, max_size=4, unique=True), st.lists(places, max_size=3, unique=True))
def test_an_object_holds_every_place_inside_and_none_outside(speckled, inside, outside):
    outside = [place for place in outside if place not in inside]
    mask = speckled.select(inside, outside).mask
    assert all(mask[place] for place in inside)
    assert not any(mask[place] for place in outside)


@settings(max_examples=10, deadline=None)
@given(st.lists(places, min_size=3, max_size=3, unique=True))
def test_a_place_inside_only_adds_and_one_outside_only_takes_away(speckled, three):
    first, second, third = three
    before = speckled.select([first])
    larger = speckled.select([first, second], previous=before)
    assert not (before.mask & ~larger.mask).any()
    smaller = speckled.select([first, second], [third], previous=larger)
    assert not (smaller.mask & ~larger.mask).any()


def test_taking_back_a_click_gives_the_object_before_it(speckled):
    one = speckled.select([(20, 20)])
    speckled.select([(20, 20), (60, 70)])
    assert np.array_equal(speckled.select([(20, 20)]).mask, one.mask)


def test_a_circle_in_a_noisy_disk_with_a_streak_gives_the_disk():
    row, col = np.indices(SHAPE)
    mask = np.hypot(row - 48, col - 44) <= 20.0
    streak = (abs(row - 48) < 3) & (col > 44) & (col < 84)
    shade = ndi.gaussian_filter(np.maximum(1.0 * mask, 0.6 * streak), 1.0)
    values = 160.0 - 100.0 * shade + np.random.default_rng(4).normal(0.0, 12.0, mask.shape)
    assert overlap(partition(values).select(circle((48, 44), 9)).mask, mask) > 0.85


@pytest.mark.parametrize("clicks", [([(30, 38)], ()), ([(30, 38)], [(30, 68)]), ([(30, 38), (90, 75)], [(5, 5)])])
def test_one_of_the_distinct_candidates_is_what_is_selected_and_each_holds_what_was_said(clicks, scene_partition):
    inside, outside = clicks
    found = scene_partition.find_candidates(inside, outside)
    assert sum(one.has_same_region(scene_partition.select(inside, outside)) for one in found) == 1
    again = scene_partition.find_candidates(inside, outside)
    assert all(one.has_same_region(other) for one, other in zip(found, again, strict=True))
    areas = [np.count_nonzero(one.mask) for one in found]
    assert areas == sorted(areas)
    for one in found:
        assert (
            one.contains(np.array(inside, float)).all()
            and not one.contains(np.array(outside, float).reshape(-1, 2)).any()
        )
        assert all(overlap(one.mask, other.mask) < 0.9 for other in found if other is not one)


def test_a_place_in_one_of_two_joined_disks_may_mean_it_alone_or_both():
    row, col = np.indices((96, 128))
    one, other = (np.hypot(row - 48, col - at) <= 20 for at in (45, 81))
    values = ndi.gaussian_filter(200.0 * (one | other), 1.0)
    masks = [chosen.mask for chosen in partition(values).find_candidates([(48, 45)])]
    assert max(overlap(mask, one) for mask in masks) > 0.9
    assert max(overlap(mask, one | other) for mask in masks) > 0.95


@pytest.mark.parametrize("place", [(47, 40), (20, 20)], ids=["in an object", "anywhere"])
def test_a_circle_counts_as_one_click_whoever_answers(place, disk_partition):
    drawn = disk_partition.select(circle(place, 6.0))
    assert drawn.features.point_count == 1
    alone = replace(disk_partition, contours=()).select(circle(place, 6.0))
    assert alone.features.point_count == 1


def test_no_candidate_ends_where_the_part_of_a_large_image_ends_in_which_basins_are_looked_for():
    row = np.indices((160, 700))[0]
    noise = np.random.default_rng(1).normal(0.0, 4.0, row.shape)
    cut = partition_without_run(Image(np.where(abs(row - 80) < 30, 160.0, 60.0) + noise))
    for one in cut.find_candidates([(80, 350)]):
        for last, beyond in ((350 - 256, 350 - 257), (350 + 256, 350 + 257)):
            assert np.count_nonzero(one.mask[:, last] & ~one.mask[:, beyond]) < 20
