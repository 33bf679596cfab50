"""Objects split in two, next to touching bodies whose areas are known."""

import math

import numpy as np
import pytest
import scipy
import shapely.affinity
import shapely.ops
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.field.scale_field import build_scale_field
from cpm_core.image.region import Region
from cpm_core.numerics import polyline
from cpm_core.objects.segmented import SegmentedObject, split_object, split_object_along
from cpm_core.objects.segmented.areas import boundary_from_polygon, lies_on, polygon_from_boundary

SHAPE = (96, 96)
PIXELS = np.indices(SHAPE)


def disk(center, radius):
    return shapely.Point(center).buffer(radius, 64)


def item_of(area):
    return SegmentedObject(3, (), Region(boundary_from_polygon(area)), name="both", category=2)


def overlap(item, area):
    own = polygon_from_boundary(item.region.boundary)
    return own.intersection(area).area / own.union(area).area


def field_of(values):
    return build_scale_field(scipy.ndimage.gaussian_filter(values, 1.0), 1.0, 0.0)


def gaps(item):
    return sum(polyline.path_length(np.array(gap)) for gap in item.gaps)


TURNS = st.floats(0.0, 2.0 * math.pi)


@given(TURNS, st.floats(10.0, 16.0), st.floats(10.0, 16.0), st.floats(0.85, 0.96), TURNS, TURNS, st.booleans())
@settings(max_examples=25, deadline=None)
def test_disks_that_overlap_are_parted_at_their_neck_wherever_the_clicks_lie(turn, r, s, apart, a, b, seen) -> None:
    way = np.array([math.sin(turn), math.cos(turn)])
    one, other = 47.5 - 0.5 * apart * (r + s) * way, 47.5 + 0.5 * apart * (r + s) * way
    both = disk(one, r).union(disk(other, s))
    neck = shapely.LineString(disk(one, r).boundary.intersection(disk(other, s).boundary).geoms)
    true = shapely.ops.split(both, shapely.affinity.scale(neck, 1.1, 1.1)).geoms
    true = sorted(true, key=lambda part: part.distance(shapely.Point(one)))
    inside = shapely.contains_xy(both, *PIXELS.reshape(2, -1)).reshape(SHAPE)
    item, field = item_of(both), field_of(100.0 * inside) if seen else None
    clicks = [tuple(c + 0.5 * q * np.array([math.sin(t), math.cos(t)])) for c, q, t in ((one, r, a), (other, s, b))]
    found = split_object(item, *clicks, field)
    halves = found.first, found.second
    assert [half.region.encloses(np.array(clicks)).tolist() for half in halves] == [[True, False], [False, True]]
    assert sum(half.region.size for half in halves) == pytest.approx(item.region.size, abs=1.0)
    assert [gaps(half) for half in halves] == pytest.approx(2 * [neck.length], abs=4.0)
    assert min(map(overlap, halves, true)) > 0.93
    assert [(half.name, half.category) for half in halves] == 2 * [("both", 2)]


@pytest.mark.parametrize("by_line", [False, True])
def test_the_cut_follows_an_edge_inside_where_the_outline_has_no_neck(by_line) -> None:
    inside = (PIXELS[0] >= 20) & (PIXELS[0] <= 75) & (PIXELS[1] >= 30) & (PIXELS[1] <= 65)
    wave = 42.0 + 2.0 * np.sin(PIXELS[1] / 6.0)
    field = field_of(np.where(inside, np.where(PIXELS[0] < wave, 60.0, 120.0), 0.0))
    item = item_of(shapely.box(19.5, 29.5, 75.5, 65.5))
    if by_line:
        halves = split_object_along(item, ((42.0, 20.0), (42.0, 70.0)), field)
        second, first = halves.first, halves.second
    else:
        halves = split_object(item, (28.0, 50.0), (60.0, 40.0), field)
        first, second = halves.first, halves.second
    true = (PIXELS[0] < wave) & inside
    differs = (first.region.paste(SHAPE) != true).sum() / 36.0
    assert differs < 1.0, "on the average within a pixel"
    assert gaps(first) < 8.0
    assert second.region.size > first.region.size


@given(st.floats(-0.9, 0.9), TURNS)
@settings(max_examples=20, deadline=None)
def test_a_line_across_cuts_off_the_very_part_beyond_it(off, turn) -> None:
    item = item_of(disk((48, 48), 20.0))
    way, aside = np.array([math.sin(turn), math.cos(turn)]), np.array([math.cos(turn), -math.sin(turn)])
    middle = 48 + 20.0 * off * aside
    half = math.sqrt(1.0 - off**2)
    line = tuple(middle - 10.0 * half * way), tuple(middle + 25.0 * way)  # it begins inside and is continued
    halves = split_object_along(item, line)
    first, second = halves.first, halves.second
    angle = 2.0 * math.acos(abs(off))
    assert second.region.size == pytest.approx(200.0 * (angle - math.sin(angle)), abs=3.0)
    assert first.region.size + second.region.size == pytest.approx(item.region.size, abs=1.0)
    assert gaps(first) == pytest.approx(40.0 * half, abs=1.5)
    assert all(lies_on(gap, second.region.boundary) for gap in first.gaps)


def test_a_ring_is_cut_twice_and_parts_that_are_apart_not_at_all() -> None:
    ring = item_of(disk((48, 48), 30.0).difference(disk((48, 48), 15.0)))
    halves = split_object(ring, (48.0, 25.0), (48.0, 71.0))
    assert halves.first.region.size == pytest.approx(halves.second.region.size, rel=0.1) and len(halves.cuts) == 2
    two = item_of(disk((30, 30), 10.0).union(disk((70, 70), 12.0)))
    halves = split_object(two, (30.0, 30.0), (70.0, 72.0))
    sizes = halves.first.region.size, halves.second.region.size
    assert sizes == pytest.approx((math.pi * 100, math.pi * 144), rel=0.01)
    assert halves.cuts == ()


def test_what_cannot_be_split_is_reported() -> None:
    item = item_of(disk((48, 48), 20.0))
    with pytest.raises(ValueError, match="outside of the object"):
        split_object(item, (48.0, 48.0), (10.0, 10.0))
    with pytest.raises(ValueError, match="not split"):
        split_object_along(item, ((5.0, 5.0), (5.0, 90.0)))
    with pytest.raises(ValueError, match="too short"):
        split_object_along(item, ((48.0, 48.0), (48.0, 48.0)))
