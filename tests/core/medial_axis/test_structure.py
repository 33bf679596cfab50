"""What a skeleton is of: dark or light structures, up to a width, in uneven images, and given outlines."""

import numpy as np
import pytest
from scipy import ndimage
from scipy.spatial import cKDTree

import cpm_core as cpm
from cpm_core.contours.contour import Contour
from cpm_core.medial_axis.skeleton_method import SkeletonMethod

from .. import scenes

SHAPE = (160, 160)
FORK = np.array([80.2, 79.7])
ARMS = {0.0: 60.0, 2.3: 55.0, 4.2: 50.0}
"""Direction of each arm of a Y, and its length [px]."""


def direction(angle):
    return np.array([np.sin(angle), np.cos(angle)])


def distance_to_y(row, col):
    """Distance to the center lines of a Y."""
    places = np.stack(np.broadcast_arrays(row, col), axis=-1) - FORK
    off = []
    for angle, length in ARMS.items():
        along = np.clip(places @ direction(angle), 0.0, length)
        off.append(np.linalg.norm(places - along[..., None] * direction(angle), axis=-1))
    return np.min(off, axis=0)


def y_shape(width, level=-100.0):
    """A Y whose arms are as wide as `width`, this many gray levels beside the background."""
    share = scenes.antialiased(SHAPE, lambda row, col: distance_to_y(row, col) <= 0.5 * width)
    share = (share - share.min()) / (share.max() - share.min())
    return 150.0 + level * share


def vertices(skeleton):
    return np.concatenate([contour.points for contour in skeleton.contours])


def radii(skeleton):
    return np.concatenate(skeleton.radii)


def bright_lines(count=60):
    """Points along the center lines of the Y."""
    return np.concatenate([FORK + np.linspace(0, length, count)[:, None] * direction(a) for a, length in ARMS.items()])


def shadow():
    """An uneven background: a slope, and a wide dark region with a soft edge over one side."""
    row, col = np.indices(SHAPE)
    return 0.3 * row - 60.0 / (1.0 + np.exp(-(col - 118.0 - 0.2 * row) / 3.0))


@pytest.mark.parametrize(("width", "level"), [(6.0, -100.0), (10.0, 100.0)])
def test_a_y_has_three_branches_of_its_own_thickness_dark_or_light(width, level):
    skeleton = cpm.skeleton(y_shape(width, level), of="dark" if level < 0 else "light", max_width=16.0)
    assert len(skeleton.contours) == 3
    assert skeleton.polarity == np.sign(level)
    assert distance_to_y(*vertices(skeleton).T).max() < 0.6
    assert cKDTree(vertices(skeleton)).query(bright_lines())[0].max() < 0.5 * width + 1.0
    assert np.median(radii(skeleton)) == pytest.approx(0.5 * width, abs=0.15)
    assert skeleton.thickness == pytest.approx(width, abs=1.0)


def test_dark_on_light_and_light_on_dark_have_the_same_skeleton():
    dark, light = (cpm.skeleton(y_shape(8.0, level)) for level in (-100.0, 100.0))
    assert (dark.polarity, light.polarity) == (-1, 1)  # found out without being told
    for one, other in ((dark, light), (light, dark)):
        away, near = cKDTree(vertices(one)).query(vertices(other))
        assert away.max() < 0.3
        assert np.abs(radii(one)[near] - radii(other)).max() < 0.2


def test_what_is_wider_has_no_skeleton():
    values = y_shape(8.0) - 100.0 * (scenes.disk(SHAPE, (25.0, 125.0), 20.0).values > 127.0)
    thin, wide = (cpm.skeleton(values, of="dark", max_width=width) for width in (16.0, 60.0))
    assert np.hypot(*(vertices(thin) - (25.0, 125.0)).T).min() > 20.0
    assert 2.0 * radii(thin).max() <= 16.0
    assert len(thin.contours) == 3
    assert cpm.skeleton(scenes.square(SHAPE, (40.0, 40.0), 70.0).values, max_width=30.0).contours == ()
    assert wide.length >= thin.length


def test_the_side_of_a_wide_dark_region_has_nothing_and_does_not_hide_thin_structures():
    values = y_shape(7.0, -40.0) + shadow() + np.random.default_rng(4).normal(0.0, 3.0, SHAPE)
    skeleton = cpm.skeleton(values, max_width=14.0)
    assert skeleton.polarity == -1
    assert np.median(distance_to_y(*vertices(skeleton).T)) < 0.5
    assert np.mean(distance_to_y(*vertices(skeleton).T) < 2.0) > 0.95
    assert np.mean(cKDTree(vertices(skeleton)).query(bright_lines())[0] < 2.5) > 0.85


def test_loose_outlines_make_strips_with_a_width_of_their_own():
    """An image like an angiogram: no outline is closed, so that regions cannot tell objects from background."""
    rng, row, col = np.random.default_rng(7), *np.indices((200, 200))
    values = 120.0 + 0.25 * row + 25.0 * ndimage.gaussian_filter(rng.normal(size=(200, 200)), 12.0) * 20.0
    for middle, half in ((60.0, 3.0), (100.0, 4.0), (140.0, 2.5)):
        depth = 60.0 * np.clip((190.0 - col) / 150.0, 0.0, 1.0)  # fades out, so that its outline stays open
        values -= depth / (1.0 + np.exp(2.0 * (np.abs(row - middle - 0.1 * col) - half)))
    values += rng.normal(0.0, 3.0, values.shape)
    skeleton = cpm.skeleton(values)
    assert skeleton.polarity == -1
    assert 8.0 < skeleton.width < 25.0
    line = (vertices(skeleton)[:, 0] - 0.1 * vertices(skeleton)[:, 1])[:, None] - (60.0, 100.0, 140.0)
    assert np.mean(np.abs(line).min(axis=1) < 2.0) > 0.9


def ring_contours(middle, inner, outer):
    angle = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    around = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    return [Contour(np.array(middle) + radius * around, closed=True) for radius in (outer, inner)]


NOISE = np.random.default_rng(0).normal(size=(120, 130))


def test_outlines_with_a_hole_have_the_line_halfway_between_them_exactly():
    skeleton = cpm.skeleton(NOISE, within=ring_contours((60.4, 64.7), 20.0, 50.0))
    (contour,) = skeleton.contours
    assert contour.closed
    assert np.abs(np.hypot(*(contour.points - (60.4, 64.7)).T) - 35.0).max() < 0.01
    assert np.abs(skeleton.radii[0] - 15.0).max() < 0.01


def test_a_mask_has_the_skeleton_of_its_objects():
    mask = np.zeros((120, 130), bool)
    mask[40:50, 20:110] = True
    mask[80:100, 20:110] = True
    skeleton = cpm.skeleton(NOISE, within=mask, pruning=3.0)
    off = np.abs(vertices(skeleton)[:, 0, None] - (44.5, 89.5)).min(axis=1)
    straight = (vertices(skeleton)[:, 1] > 32.0) & (vertices(skeleton)[:, 1] < 98.0)
    assert off[straight].max() < 0.1
    assert np.unique(np.round(radii(skeleton)[straight], 1)).tolist() == [5.0, 10.0]
    assert (skeleton.rebuild_shape() & ~mask).sum() < 20
    thin = cpm.skeleton(NOISE, within=mask, pruning=3.0, max_width=12.0)
    assert radii(thin).max() < 6.0
    assert np.abs(vertices(thin)[:, 0] - 44.5).max() < 6.0


def test_a_region_of_interest_limits_the_skeleton():
    values, square = y_shape(8.0), ((70.0, 85.0), (70.0, 150.0), (92.0, 150.0), (92.0, 85.0))
    parameters = cpm.Parameters(max_width=16.0)
    method = SkeletonMethod(values, parameters, cpm.Regions(interest=(square,)))
    state = method.start()
    while not state.stop_reason:
        state = method.step(state, parameters)
    found = method.result(state, parameters)
    assert (vertices(found) > (70.0, 85.0)).all()
    assert np.abs(vertices(found)[:, 0] - FORK[0]).max() < 0.5  # one arm of the Y, along a row
    assert found.length == pytest.approx(ARMS[0.0] + FORK[1] - 85.0, abs=6.0)
