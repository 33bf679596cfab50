"""Surfaces of which voxels were painted: exact where nobody painted, and around exactly the painted voxels there."""

import gc
import weakref

import numpy as np
import pytest
import scipy

from cpm_core.image.region import Region
from cpm_core.image.surface import Surface, voxelize_surface
from cpm_core.numerics.grids import zero_surface
from cpm_core.numerics.packed_mask import PackedMask
from cpm_core.objects.segmented import SegmentedObject, SegmentedObjects, paint_voxels, voxelize_brush

SHAPE = (48, 52, 50)
CENTER = np.array([23.7, 25.2, 24.6])
RADIUS = 15.3


def ball() -> Region:
    away = np.linalg.norm(np.moveaxis(np.indices(SHAPE), 0, -1) - CENTER, axis=-1)
    return Region.from_surface(Surface(*zero_surface((RADIUS - away).astype(np.float32))))


def strokes(seed: int) -> list[tuple[Region, bool]]:
    """Strokes across the surface of the ball, some in one slice."""
    rng = np.random.default_rng(seed)
    found = []
    for axis in (None, 0, 1, 2, None):
        way = rng.normal(size=3)
        begin = CENTER + RADIUS * rng.uniform(0.8, 1.1) * way / np.linalg.norm(way)
        end = begin + rng.normal(size=3) * 6.0
        if axis is not None:
            begin[axis] = end[axis] = round(begin[axis])
        part = voxelize_brush(SHAPE, (tuple(begin), tuple(end)), rng.uniform(1.0, 6.0), (1.0, 1.0, 1.0), axis)
        found.append((part, bool(rng.random() < 0.6)))
    return found


@pytest.mark.parametrize("seed", range(4))
def test_paint_changes_the_voxels_it_covers_and_the_surface_only_near_them(seed: int) -> None:
    body = ball()
    before, known = body.paste(SHAPE), {*map(tuple, body.surface.vertices)}
    objects = SegmentedObjects((SegmentedObject(1, (), body),))
    expected = before.copy()
    for part, adds in strokes(seed):
        objects = paint_voxels(objects, 1, part, adds)
        covered = part.paste(SHAPE)
        expected = expected | covered if adds else expected & ~covered
        region = objects[1].region
        assert np.array_equal(region.paste(SHAPE), expected)
        surface = region.find_surface()
        assert surface.closed
        assert np.count_nonzero(voxelize_surface(surface, SHAPE) != expected) <= 1
        lost = np.array([*(known - {*map(tuple, surface.vertices)})]).reshape(-1, 3)
        changed = scipy.spatial.cKDTree(np.argwhere(expected != before))
        assert changed.query(lost)[0].max(initial=0.0) < 4.0
    assert objects[1].region.surface is body.surface


def test_taking_back_by_hand_what_was_painted_gives_the_same_surface() -> None:
    body, part = ball(), voxelize_brush(SHAPE, ((23.0, 25.0, 44.0),), 3.0, (1.0, 1.0, 1.0))
    assert body.united(part).without(part.without(body)).find_surface() is body.surface


def test_an_object_painted_over_loses_only_what_is_taken() -> None:
    objects = SegmentedObjects((SegmentedObject(1, (), ball()),), may_overlap=True)
    part = voxelize_brush(SHAPE, ((23.0, 25.0, 38.0),), 4.0, (1.0, 1.0, 1.0))
    after = paint_voxels(objects, 2, part)
    taken = objects[1].region.count_shared(part)
    assert after[1].region.count == objects[1].region.count - taken
    lost = len({*map(tuple, ball().surface.vertices)} - {*map(tuple, after[1].region.find_surface().vertices)})
    assert 0 < lost < 0.1 * len(ball().surface.vertices)


def test_versions_of_a_painted_body_share_the_planes_that_are_the_same() -> None:
    region = Region.from_mask(np.ones((40, 30, 30), bool))
    painted = region.without(voxelize_brush((40, 30, 30), ((20.0, 15.0, 15.0),), 3.0, (1.0, 1.0, 1.0)))
    own = [one for one, other in zip(painted.pixels.planes, region.pixels.planes, strict=True) if one is not other]
    assert len(own) == 7
    assert sum(map(len, own)) < 7 * 30 * 30 / 8 + 7


def test_no_cache_keeps_a_region_alive() -> None:
    region = Region.from_mask(np.ones((3, 3, 3), bool))
    region.find_surface()
    watched = weakref.ref(region)
    del region
    gc.collect()
    assert watched() is None


@pytest.mark.parametrize("shape", [(7, 9), (5, 6, 7)])
def test_a_packed_mask_gives_and_changes_any_window(shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(1)
    mask = rng.random(shape) > 0.5
    packed = PackedMask.pack(mask)
    for _ in range(20):
        window = tuple(slice(*sorted(rng.integers(0, side + 1, 2).tolist())) for side in shape)
        assert np.array_equal(packed.cut(window), mask[window])
        part, adds = rng.random(mask[window].shape) > 0.5, bool(rng.random() > 0.5)
        packed = packed.changed(window, part, adds)
        mask[window] = mask[window] | part if adds else mask[window] & ~part
        assert packed == PackedMask.pack(mask)
        assert packed.count == mask.sum()
