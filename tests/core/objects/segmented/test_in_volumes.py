"""Painting in volumes: voxels in bytes, what a brush covers, whom it takes from, and the slices between."""

import json
from dataclasses import replace

import numpy as np
import pytest

from cpm_core.formats.common.json_values import from_json, to_json
from cpm_core.image.region import Region
from cpm_core.objects.segmented import (
    SegmentedObject,
    SegmentedObjects,
    fill_between_slices,
    paint_voxels,
    split_object_along,
    split_painted_object,
    unite_objects,
    voxelize_brush,
)

SHAPE = (20, 30, 41)
SIDES = (2.5, 1.0, 1.0)


def whole(body, shape=SHAPE):
    found = np.zeros(shape, bool)
    if body is not None:
        body.fill_into(found)
    return found


def body(mask):
    return Region.from_mask(mask)


def window(first, shape):
    return tuple(slice(a, a + n) for a, n in zip(first, shape, strict=True))


def random_box(rng, largest=12):
    shape = rng.integers(1, largest, 3)
    return [int(rng.integers(0, side - n + 1)) for side, n in zip(SHAPE, shape, strict=True)], shape


@pytest.mark.parametrize("seed", range(20))
def test_a_region_holds_what_was_added_to_it_and_not_what_was_removed(seed):
    rng = np.random.default_rng(seed)
    expected = np.zeros(SHAPE, bool)
    first, shape = random_box(rng)
    expected[window(first, shape)] = True
    found = Region.from_mask(np.ones(shape, bool), first)
    for share, adds in ((0.5, False), (0.5, True), (1.0, False), (0.2, True), (1.0, False)):
        first, shape = random_box(rng)
        assert np.array_equal(found.cut_out(window(first, shape)), expected[window(first, shape)])
        part = Region.from_mask(rng.random(shape) < share, first)
        both, either = whole(part) & expected, whole(part) | expected
        assert np.array_equal(whole(found.shared_with(part)), both)
        assert found.compute_iou(part) == pytest.approx(both.sum() / max(either.sum(), 1))
        found, expected = (found.united(part), either) if adds else (found.without(part), expected & ~both)
        assert np.array_equal(whole(found), expected)
        assert (found.size, found.is_empty) == (expected.sum(), not expected.any())
        if found.is_empty:
            return
        inside = np.argwhere(expected)
        assert np.array_equal(found.bounds, [inside.min(axis=0), inside.max(axis=0)])
        assert found == Region.from_mask(expected)
    kept = json.loads(json.dumps(to_json(SegmentedObject(1, (), found))))
    assert from_json(SegmentedObject, kept, "it").region == found


def test_the_smooth_surface_around_voxels_encloses_the_very_same_ones():
    rng = np.random.default_rng(1)
    for share in (0.02, 0.5, 0.9):
        mask = rng.random((9, 10, 11)) < share
        exact = Region.from_surface(body(mask).find_surface())
        assert np.array_equal(whole(exact, mask.shape), mask)


def test_no_voxel_at_all_is_no_object():
    with pytest.raises(ValueError, match="at least one voxel"):
        SegmentedObject(1, (), body(np.zeros((3, 3, 3), bool)))


def away_from(path, axis=None):
    """Distance of each voxel from a way, by many places on it; infinite out of the slice."""
    places = np.moveaxis(np.indices(SHAPE), 0, -1)
    ends = np.array(path, float)
    ways = (ends[0] + share * (ends[-1] - ends[0]) for share in np.linspace(0.0, 1.0, 200))
    away = np.min([np.linalg.norm((places - at) * SIDES, axis=-1) for at in ways], axis=0)
    if axis is not None:
        away[np.indices(SHAPE)[axis] != ends[0][axis]] = np.inf
    return away


@pytest.mark.parametrize("axis", [None, 0, 1, 2])
@pytest.mark.parametrize("path", [((9.0, 14.0, 20.0),), ((3.0, 5.0, 4.5), (12.0, 22.0, 38.0)), ((0.0, 0.0, 0.0),)])
def test_the_brush_covers_what_is_nearer_to_its_way_than_its_radius(path, axis):
    if axis is not None:
        path = tuple(tuple(7.0 if at == axis else x for at, x in enumerate(place)) for place in path)
    found = voxelize_brush(SHAPE, path, 5.0, SIDES, axis).paste(SHAPE)
    away = away_from(path, axis)
    sure = np.abs(away - 5.0) > 0.05
    assert np.array_equal(found[sure], (away < 5.0)[sure])


def test_the_smallest_brush_covers_the_voxel_that_it_is_in():
    found = voxelize_brush(SHAPE, ((4.4, 7.4, 8.6),), 0.1, SIDES)
    assert (found.origin, found.mask.tolist()) == ((4, 7, 9), [[[True]]])


def painted(*masks):
    """Objects with these voxels, of which the last one is painted over the others."""
    objects = SegmentedObjects(may_overlap=True)
    for number, mask in enumerate(masks, start=1):
        objects = paint_voxels(objects, number, body(mask))
    return objects


def apart(objects):
    """The same objects, which may not overlap."""
    return replace(objects, may_overlap=False)


def test_painting_and_erasing_the_same_way_leaves_what_was_there():
    rng = np.random.default_rng(3)
    there = rng.random(SHAPE) < 0.3
    part = voxelize_brush(SHAPE, ((5.0, 9.0, 9.0), (11.0, 20.0, 30.0)), 6.0, SIDES)
    before = painted(there)
    after = paint_voxels(paint_voxels(before, 1, part), 1, part, adds=False)
    covered = whole(part)
    assert np.array_equal(whole(after[1].region), there & ~covered)
    new = paint_voxels(paint_voxels(apart(before), 2, part), 2, part, adds=False)
    assert np.array_equal(whole(new[1].region), there)
    assert [item.number for item in new.items] == [1]


def test_paint_takes_from_others_where_they_may_overlap_but_never_from_frozen_or_hidden_ones():
    rng = np.random.default_rng(4)
    masks = rng.random((4, *SHAPE)) < 0.3
    alone = [masks[0] & ~masks[1] & ~masks[2], masks[1] & ~masks[2], masks[2]]
    objects = painted(*masks[:3])
    assert [np.array_equal(whole(item.region), mask) for item, mask in zip(objects.items, alone, strict=True)] == [
        True
    ] * 3
    items = tuple(
        SegmentedObject(item.number, (), region=item.region, frozen=item.number == 1, hidden=item.number == 2)
        for item in objects.items
    )
    after = paint_voxels(replace(objects, items=items), 4, body(masks[3]))
    bodies = [whole(item.region) for item in after.items]
    assert np.array_equal(bodies[0], alone[0])
    assert np.array_equal(bodies[1], alone[1])
    assert np.array_equal(bodies[2], alone[2] & ~masks[3])
    assert np.array_equal(bodies[3], masks[3] & ~alone[0] & ~alone[1])
    clear = paint_voxels(apart(objects), 4, body(masks[3]))
    assert clear.items[:3] == objects.items
    assert np.array_equal(whole(clear[4].region), masks[3] & ~np.any(alone, axis=0))


def test_no_confidence_is_known_of_what_a_user_has_painted_split_or_united_in_image_and_volume():
    there, part = np.zeros((2, *SHAPE), bool)
    there[2:6, 2:7, 2:8], part[3:5, 3:5, 7:9] = True, True
    sure = replace(painted(there), items=(replace(painted(there)[1], confidence=0.9),))
    other = replace(SegmentedObject(2, (), body(part)), confidence=0.8)
    after = paint_voxels(sure, 1, body(part), adds=False)[1]
    halves = split_painted_object(sure[1], (3, 4, 3), (3, 4, 7), (1.0,) * 3)
    flat = SegmentedObject(1, (), Region((((2.0, 2.0), (2.0, 9.0), (9.0, 9.0), (9.0, 2.0)),)), confidence=0.9)
    line = [(0.0, 5.5), (11.0, 5.5)]
    parts = split_object_along(flat, line, None)
    made = after, halves.first, halves.second, unite_objects(sure[1], other), parts.first, unite_objects(flat, flat)
    assert [item.confidence for item in made] == [0.0] * 6
    assert paint_voxels(apart(sure), 3, body(part))[1].confidence == 0.9


def test_an_object_that_is_painted_over_whole_is_gone():
    small, large = np.zeros((2, *SHAPE), bool)
    small[5:7, 5:7, 5:7] = large[4:9, 4:9, 4:9] = True
    assert [item.number for item in painted(small, large).items] == [2]


def test_the_union_with_painted_voxels_has_the_voxels_of_both():
    rng = np.random.default_rng(5)
    one, other = rng.random((2, 9, 10, 11)) < 0.4
    exact = Region.from_surface(body(one).find_surface())
    items = [SegmentedObject(n, (), region=made) for n, made in ((1, exact), (2, body(other)))]
    for first, second in (items, items[::-1]):
        assert np.array_equal(unite_objects(first, second).region.paste(one.shape), one | other)


def disk(center, radius, shape=(64, 72), pixel=(1.0, 1.0)):
    row, col = np.indices(shape)
    return np.hypot((row - center[0]) * pixel[0], (col - center[1]) * pixel[1]) <= radius


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("ends", [((30, 30), (30, 30)), ((20, 20), (40, 50))])
def test_between_two_disks_lie_those_of_the_cone(axis, ends):
    planes = np.zeros((11, 64, 72), bool)
    planes[0], planes[10] = disk(ends[0], 6.0), disk(ends[1], 16.0)
    between, count = fill_between_slices(body(np.moveaxis(planes, 0, axis)), axis, (1.0, 1.0, 1.0))
    assert count == 9
    found = np.moveaxis(between.paste(np.moveaxis(planes, 0, axis).shape), axis, 0)
    assert not found[[0, 10]].any()
    for at in range(1, 10):
        share = at / 10
        center = np.add(np.multiply(1 - share, ends[0]), np.multiply(share, ends[1]))
        radius = 6.0 + share * 10.0
        assert not (found[at] & ~disk(center, radius + 1.0)).any()
        assert not (disk(center, radius - 1.0) & ~found[at]).any()


def test_a_branch_continues_from_its_trunk_and_slices_that_are_painted_stay():
    planes = np.zeros((9, 64, 72), bool)
    planes[0] = disk((30, 36), 15.0)
    planes[4] = disk((30, 25), 6.0) | disk((30, 48), 6.0)
    planes[5] = planes[4]
    planes[8] = disk((30, 10), 4.0) | disk((30, 60), 4.0)  # touches none of those before it
    between, count = fill_between_slices(body(planes), 0, (1.0, 1.0, 1.0))
    assert count == 5
    filled = between.paste(planes.shape)
    assert not filled[[0, 4, 5, 8]].any()
    whole_planes = planes | filled
    from scipy.ndimage import label  # noqa: PLC0415

    assert label(whole_planes)[1] == 1
    assert label(whole_planes[6])[1] == 2


@pytest.mark.parametrize("sides", [(1.0, 1.0, 1.0), (2.0, 1.0, 1.0)])
def test_two_balls_that_touch_are_split_at_their_neck(sides):
    places = np.moveaxis(np.indices((30, 40, 64)), 0, -1) * sides
    one, other = (np.linalg.norm(places - (15 * sides[0], 20, col), axis=-1) for col in (18, 41))
    balls = (one < 12.5) | (other < 12.5)
    balls[0, 0, :3] = True  # a piece apart from both
    whole = SegmentedObject(3, (), name="both", region=Region.from_mask(balls))
    halves = split_painted_object(whole, (15, 22, 12), (15, 18, 47), sides)
    first, second = (half.region.paste(balls.shape) for half in (halves.first, halves.second))
    np.testing.assert_array_equal(first ^ second, balls)
    sure = np.abs(one - other) > 1.5
    np.testing.assert_array_equal((first & balls)[sure], (balls & (one < other))[sure])
    assert halves.first.name == "both"
    with pytest.raises(ValueError, match="outside"):
        split_painted_object(whole, (15, 20, 12), (1, 1, 60), sides)


def test_what_has_no_neck_is_split_halfway():
    box = np.zeros((12, 12, 41), bool)
    box[2:10, 2:10, 2:39] = True
    halves = split_painted_object(
        SegmentedObject(1, (), region=Region.from_mask(box)), (5, 5, 10), (5, 5, 30), (1,) * 3
    )
    assert (np.flatnonzero(halves.first.region.paste(box.shape).any(axis=(0, 1)))[[0, -1]] - (2, 20)).tolist() in (
        [0, 0],
        [0, -1],
    )


def test_versions_of_an_object_that_the_brush_has_hollowed_out_differ_in_their_hash():
    solid = body(np.ones(SHAPE, bool))
    hollowed = [solid.without(Region.from_mask(np.ones((1, 1, n), bool), (9, 9, 9))) for n in range(1, 20)]
    assert len({hash(one) for one in (solid, *hollowed)}) == 20  # else caches compare each with all others
    again = body(hollowed[3].paste(SHAPE))
    assert (again, hash(again)) == (hollowed[3], hash(hollowed[3]))
