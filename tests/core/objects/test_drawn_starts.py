"""What a drawn start means: smooth lines against true outlines, descriptions against scipy, trees against recursion."""

from types import SimpleNamespace

import numpy as np
import pytest
import scipy.ndimage as ndi
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial import ConvexHull

from cpm_core import circle, partition
from cpm_core.field.edge_map import edge_map
from cpm_core.objects.candidates.appearance import appearance
from cpm_core.objects.candidates.choice import START, scored
from cpm_core.objects.candidates.description import DESCRIPTION, description
from cpm_core.objects.candidates.grids import box_of, grid_over
from cpm_core.objects.candidates.stars import stars
from cpm_core.objects.candidates.trees import trees, trees_of

SIDE = 96
ROW, COL = np.indices((SIDE, SIDE))


def ellipse(middle, axes):
    return ((ROW - middle[0]) / axes[0]) ** 2 + ((COL - middle[1]) / axes[1]) ** 2 <= 1.0


def look_at(values):
    return appearance(values, edge_map(values, 1.0))


def overlap(one, other):
    return np.count_nonzero(one & other) / np.count_nonzero(one | other)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("axes", [(12.0, 12.0), (20.0, 14.0), (30.0, 25.0)])
def test_a_star_is_the_outline_of_an_ellipse_around_any_place_deep_in_it(axes, sign):
    mask = ellipse((48.0, 45.0), axes)
    values = 100.0 + sign * 60.0 * mask + np.random.default_rng(0).normal(0.0, 3.0, mask.shape)
    for place in ((48.0, 45.0), (48.0 + axes[0] / 4, 45.0 - axes[1] / 4)):
        found = stars(look_at(values), place, (2.0, 60.0), 3)
        best = max(found, key=lambda star: star.support)
        assert overlap(best.within(np.arange(SIDE), np.arange(SIDE)), mask) > 0.9


def test_a_star_does_not_follow_a_streak_that_hangs_together_with_the_object():
    mask = ellipse((48.0, 40.0), (18.0, 18.0))
    streak = (abs(ROW - 48) < 3) & (COL > 40) & (COL < 90)
    values = 200.0 - 120.0 * ndi.gaussian_filter((mask | streak).astype(float), 1.0)
    best = max(stars(look_at(values), (48.0, 40.0), (4.0, 60.0), 3), key=lambda star: star.support)
    found = best.within(np.arange(SIDE), np.arange(SIDE))
    assert overlap(found, mask) > 0.9 > overlap(mask | streak, mask)


def test_a_star_lies_in_its_box():
    values = 100.0 + 60.0 * ellipse((30.0, 60.0), (12.0, 17.0))
    for star in stars(look_at(values), (30.0, 60.0), (2.0, 60.0), 3):
        top, bottom, left, right = star.box
        rows, cols = np.nonzero(star.within(np.arange(-SIDE, 2 * SIDE), np.arange(-SIDE, 2 * SIDE)))
        assert top <= rows.min() - SIDE < rows.max() - SIDE < bottom
        assert left <= cols.min() - SIDE < cols.max() - SIDE < right


def described(values, mask):
    grid = grid_over(box_of(mask), mask.shape)
    middle = np.rint(np.argwhere(mask).mean(axis=0)).astype(np.int64)
    found = description(look_at(values), grid, grid.of(mask), middle, 1.0, 4.0)
    return dict(zip(DESCRIPTION, found, strict=True))


@settings(deadline=None, max_examples=20)
@given(hnp.arrays(np.bool_, st.tuples(st.integers(3, 14), st.integers(3, 14))).filter(lambda mask: mask.any()))
def test_the_solidity_is_the_share_of_the_convex_hull(mask):
    whole = np.zeros((24, 24), np.bool_)
    whole[4 : 4 + mask.shape[0], 5 : 5 + mask.shape[1]] = mask
    place = np.argwhere(whole)
    hull = ConvexHull(np.concatenate([place + np.array([a, b]) for a in (0, 1) for b in (0, 1)])).volume
    values = np.random.default_rng(1).normal(0.0, 1.0, whole.shape)
    assert described(values, whole)["solidity"] == pytest.approx(np.log(len(place) / hull + 0.01))


def test_the_elongation_is_the_ratio_of_the_axes_however_it_lies():
    for axes in ((9.0, 18.0), (18.0, 9.0)):
        mask = ellipse((48.0, 48.0), axes)
        assert described(100.0 * mask, mask)["elongation"] == pytest.approx(np.log(2.0), abs=0.03)


def test_a_light_object_and_a_dark_one_differ_in_the_sign_alone():
    mask = ellipse((40.0, 50.0), (11.0, 16.0))
    noise = np.random.default_rng(2).normal(0.0, 5.0, mask.shape)
    light, dark = described(100.0 + 60.0 * mask + noise, mask), described(100.0 - 60.0 * mask - noise, mask)
    assert (light.pop("sign"), dark.pop("sign")) == (1.0, -1.0)
    assert light.pop("overlap") == pytest.approx(dark.pop("overlap"), abs=0.05)
    assert light == pytest.approx(dark, rel=1e-4)


def answer(stored, root, features):
    """What a tree says, by recursion."""
    asked = stored["feature"][root]
    if asked < 0:
        return stored["value"][root]
    side = "left" if features[asked] <= stored["value"][root] else "right"
    return answer(stored, stored[side][root], features)


def test_the_score_is_the_sum_of_what_the_trees_say():
    stored = {
        "features": ["a", "b"],
        "roots": [0, 3],
        "feature": [0, -1, -1, 1, -1, 0, -1, -1],
        "value": [0.5, 1.0, -1.0, 0.0, 0.25, 1.5, 4.0, 8.0],
        "left": [1, 0, 0, 4, 0, 6, 0, 0],
        "right": [2, 0, 0, 5, 0, 7, 0, 0],
    }
    features = np.random.default_rng(0).normal(0.0, 1.5, (40, 2))
    wanted = [sum(answer(stored, root, row) for root in stored["roots"]) for row in features]
    assert trees_of(stored).scores(features).tolist() == pytest.approx(wanted)


def test_the_trees_ask_for_the_features_that_are_described():
    found = trees("start")
    assert found.features == START
    inner = found.feature >= 0
    assert found.feature.max() < len(START)
    assert (found.left[inner] > np.flatnonzero(inner)).all()
    assert (found.right[inner] > np.flatnonzero(inner)).all()


def test_a_circle_in_a_noisy_disk_with_a_streak_gives_the_disk():
    mask = ellipse((48.0, 44.0), (20.0, 20.0))
    streak = (abs(ROW - 48) < 3) & (COL > 44) & (COL < 84)
    shade = ndi.gaussian_filter(np.maximum(1.0 * mask, 0.6 * streak), 1.0)
    values = 160.0 - 100.0 * shade + np.random.default_rng(4).normal(0.0, 12.0, mask.shape)
    assert overlap(partition(values).select(circle((48, 44), 9)).mask, mask) > 0.85


def test_among_objects_far_larger_than_the_start_the_smaller_one_is_meant():
    drawn = SimpleNamespace(chosen=None, inside=circle((32, 32), 8))
    features = np.zeros((3, len(START)))
    features[:, -1] = 10.0, 11.0, 13.0  # beyond all that trees tell apart
    first, second, third = scored(drawn, features)
    assert first - second > 1.0
    assert second - third == pytest.approx(2.0 * (first - second))
