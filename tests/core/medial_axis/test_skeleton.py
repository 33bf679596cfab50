"""Skeletons: on the medial axis of shapes whose medial axis is known, with radii that rebuild the shape."""

import numpy as np
import pytest
from scipy import ndimage
from scipy.optimize import brentq
from scipy.spatial import cKDTree

import cpm_core as cpm
from cpm_core.formats.masks.labels import paint_labels
from cpm_core.medial_axis.skeleton_method import SkeletonMethod

from .. import scenes

TOUCHING = np.ones((3, 3))


def vertices(skeleton):
    return np.concatenate([contour.points for contour in skeleton.contours])


def radii(skeleton):
    return np.concatenate(skeleton.radii)


def densely(skeleton):
    """Points every quarter of a pixel along all branches."""
    out = [vertices(skeleton)]
    for contour in skeleton.contours:
        for a, b in zip(contour.path[:-1], contour.path[1:], strict=True):
            out.append(a + (b - a) * np.linspace(0.0, 1.0, 2 + int(4 * np.linalg.norm(b - a)))[:, None])
    return np.concatenate(out)


def farthest(points, others):
    """Largest distance from one of the points to the nearest of the others."""
    return cKDTree(others).query(points)[0].max()


def overlap(mask, other):
    return (mask & other).sum() / (mask | other).sum()


def inside(values):
    return values > 0.5 * (scenes.DARK + scenes.BRIGHT)


MIDDLE, LONG, SHORT, ANGLE = np.array([80.3, 79.6]), 60.0, 30.0, 0.4
ALONG = np.array([np.cos(ANGLE), np.sin(ANGLE)])


@pytest.fixture(scope="module")
def ellipse():
    def within(row, col):
        y, x = row - MIDDLE[0], col - MIDDLE[1]
        u, v = ALONG[0] * y + ALONG[1] * x, ALONG[0] * x - ALONG[1] * y
        return np.hypot(u / LONG, v / SHORT) < 1.0

    return scenes.antialiased((160, 160), within)


def focal_radius(at):
    """Distance of a position on the medial axis of the ellipse to its boundary."""
    return SHORT * np.sqrt(1.0 - at**2 / (LONG**2 - SHORT**2))


END = (LONG**2 - SHORT**2) / LONG


@pytest.mark.parametrize("pruning", [0.2, 3.0])
def test_an_ellipse_has_its_focal_segment_shortened_by_exactly_the_pruning(ellipse, pruning):
    skeleton = cpm.skeleton(ellipse, pruning=pruning)
    (contour,) = skeleton.contours
    offset = contour.points - MIDDLE
    at = offset @ ALONG
    assert np.abs(offset - at[:, None] * ALONG).max() < 0.2
    assert np.abs(skeleton.radii[0] - focal_radius(at)).max() < 0.1
    # the disk at the end of the segment may stick out of the one at the tip by as much as the pruning
    tip = brentq(lambda t: END - t + focal_radius(END) - focal_radius(t) - pruning, 0.0, END)
    assert np.abs([at.min() + tip, at.max() - tip]).max() < 1.5


def rectangle(middle, half, angle):
    turn = np.array([(np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))])
    return np.array(middle) + np.array([(-1, -1), (-1, 1), (1, 1), (1, -1)]) * half @ turn.T, turn


@pytest.mark.parametrize("angle", [0.0, 0.3])
def test_a_rectangle_has_its_center_line_and_a_branch_toward_each_corner(angle):
    corners, turn = rectangle((64.3, 70.2), (25.0, 45.0), angle)
    scene = scenes.polygon((130, 140), corners)
    skeleton = cpm.skeleton(scene.values)
    assert len(skeleton.contours) == 5
    forks = np.array((64.3, 70.2)) + np.array([(0.0, -20.0), (0.0, 20.0)]) @ turn.T
    lines = [forks, *(np.array([forks[side], corners[k]]) for k, side in enumerate((0, 1, 1, 0)))]
    assert scenes.outline_distance(vertices(skeleton), lines).max() < 0.3
    assert np.abs(radii(skeleton) - scene.distance(vertices(skeleton))).max() < 0.3
    # smoothing rounds a corner by some 2 px, and the disk there may stick out by a pixel of one (1 - sqrt(1/2)) nearer
    reached = densely(skeleton)
    assert farthest(forks, reached) < 0.5
    assert farthest(corners, reached) < 2.0 * np.sqrt(2.0) + 1.0 / (1.0 - np.sqrt(0.5)) + 0.5
    assert sum(contour.junctions == (True, True) for contour in skeleton.contours) == 1


def test_a_ring_has_the_circle_halfway_between_its_edges():
    scene = scenes.ring((120, 130), (60.4, 64.7), 20.0, 50.0)
    skeleton = cpm.skeleton(scene.values)
    (contour,) = skeleton.contours
    assert contour.closed
    assert np.abs(np.hypot(*(contour.points - (60.4, 64.7)).T) - 35.0).max() < 0.2
    assert np.abs(skeleton.radii[0] - 15.0).max() < 0.1
    assert contour.length == pytest.approx(2.0 * np.pi * 35.0, rel=0.01)


def test_a_disk_is_one_vertex_at_its_center():
    skeleton = cpm.skeleton(scenes.disk((90, 90), (44.4, 45.3), 30.0).values)
    (contour,), (radius,) = skeleton.contours, skeleton.radii
    assert contour.points.shape == (1, 2)
    assert np.hypot(*(contour.points[0] - (44.4, 45.3))) < 0.5
    assert radius[0] == pytest.approx(30.0, abs=0.2)
    assert contour.length == 0.0


TURN = 0.3 + 0.2 * np.pi * np.arange(10)
STAR = 70.3 + np.array([60.0, 25.0] * 5)[:, None] * np.stack([np.sin(TURN), np.cos(TURN)], axis=1)
SHAPES = {
    "u": scenes.u_shape(),
    "star": scenes.polygon((140, 140), STAR),
    "disk": scenes.disk((90, 90), (44.4, 45.3), 30.0),
    "ring": scenes.ring((120, 130), (60.4, 64.7), 20.0, 50.0),
    "bar": scenes.polygon((100, 100), rectangle((50.2, 49.6), (7.3, 35.0), 0.5)[0]),
}
CORNERS = {
    "u": scenes.U_CORNERS,
    "star": STAR,
    "bar": rectangle((50.2, 49.6), (7.3, 35.0), 0.5)[0],
}


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("u", "antialiased"),
        ("disk", "antialiased"),
        ("bar", "black and white"),
        ("ring", "soft and noisy"),
        ("star", "soft and noisy"),
    ],
)
def test_the_shape_is_rebuilt_from_its_skeleton(name, kind):
    values, mask = SHAPES[name].values, inside(SHAPES[name].values)
    if kind == "black and white":
        values = mask.astype(float)
    elif kind == "soft and noisy":
        values = ndimage.gaussian_filter(values, 1.5) + np.random.default_rng(3).normal(0.0, 8.0, values.shape)
    rebuilt = cpm.skeleton(values).rebuild_shape()
    assert rebuilt.shape == values.shape
    assert rebuilt.dtype == bool
    assert overlap(rebuilt, mask) >= (0.96 if kind == "soft and noisy" else 0.98)


@pytest.mark.parametrize("name", SHAPES)
def test_a_radius_is_the_distance_to_the_boundary(name):
    scene, skeleton = SHAPES[name], cpm.skeleton(SHAPES[name].values)
    assert len(skeleton.radii) == len(skeleton.contours)
    error = np.abs(radii(skeleton) - scene.distance(vertices(skeleton)))
    touched = scene.boundary[cKDTree(scene.boundary).query(vertices(skeleton))[1]]
    rounded = cKDTree(CORNERS.get(name, [(-99.0, -99.0)])).query(touched)[0] < 2.0  # smoothing moves corners by a pixel
    assert error[~rounded].max() < 0.1
    assert error[rounded].max(initial=0.0) < 1.0


@pytest.mark.parametrize(
    ("name", "branches", "noise"), [("ring", 1, 20.0), ("disk", 1, 20.0), ("bar", 5, 20.0), ("bar", 5, 0.0)]
)
def test_neither_pixel_steps_nor_noise_on_the_boundary_make_short_branches(name, branches, noise):
    values = inside(SHAPES[name].values) * 160.0
    values = values + np.random.default_rng(1).normal(0.0, noise, values.shape) if noise else values
    assert len(cpm.skeleton(values).contours) == branches


def test_more_pruning_only_removes_and_within_its_bound_and_keeps_connections():
    values = inside(SHAPES["ring"].values).astype(float)  # with pixel steps that could make short branches
    skeletons = [cpm.skeleton(values, pruning=pruning) for pruning in (0.3, 1.0, 8.0)]
    everything = skeletons[0].rebuild_shape()
    for pruning, more, less in zip((1.0, 8.0), skeletons[:-1], skeletons[1:], strict=True):
        assert farthest(vertices(less), densely(more)) < 1.0
        rebuilt = less.rebuild_shape()
        assert ndimage.distance_transform_edt(~rebuilt)[everything & ~rebuilt].max(initial=0.0) < pruning + 1.5
        lines = paint_labels(less) > 0
        assert ndimage.label(lines, TOUCHING)[1] == 1
        assert ndimage.label(~lines)[1] == 2  # a round stays a round


def test_a_rotated_image_has_the_rotated_skeleton():
    values = scenes.blob((70, 80), (33.6, 41.2))
    expected = scenes.turned(densely(cpm.skeleton(values)), values.shape)
    found = densely(cpm.skeleton(np.rot90(values)))
    assert max(farthest(found, expected), farthest(expected, found)) < 0.5


def test_each_object_has_a_skeleton_of_its_own_and_a_hole_has_none():
    values = np.maximum(
        scenes.ring((100, 200), (50.0, 50.0), 18.0, 40.0).values, scenes.disk((100, 200), (50.0, 150.0), 30.0).values
    )
    skeleton = cpm.skeleton(values)
    assert sorted(len(contour.points) == 1 for contour in skeleton.contours) == [False, True]
    assert skeleton.rebuild_shape()[50, 50] == False  # noqa: E712
    both = cpm.skeleton(values, outside=True)
    assert both.rebuild_shape()[50, 50]
    assert farthest(vertices(skeleton), densely(both)) < 1e-9
    assert both.length > skeleton.length + 50.0


def test_an_object_continues_beyond_the_image_border():
    values = scenes.polygon((90, 80), np.array([(-20.0, 30.3), (-20.0, 50.3), (60.0, 50.3), (60.0, 30.3)])).values
    skeleton = cpm.skeleton(values)
    assert len(skeleton.contours) == 3
    points = skeleton.contours[0].points
    assert np.abs(points[:, 1] - 40.3).max() < 0.3
    assert points[:, 0].min() == -0.5
    assert np.abs(skeleton.radii[0][points[:, 0] < 45] - 10.0).max() < 0.1
    assert overlap(skeleton.rebuild_shape(), inside(values)) > 0.98


def test_the_points_of_a_step_lie_in_the_image():
    """The Voronoi diagram of a boundary has vertices far beyond the image, which a canvas could not clear again."""
    image, parameters = scenes.disk((64, 64), (30.0, 34.0), 18.0).values, cpm.PRESETS["noisy"]
    method = SkeletonMethod(image, parameters, outside=True)
    state = method.start()
    while not state.stop_reason:
        state = method.step(state, parameters)
        assert np.all((state.position > -0.5) & (state.position < np.array(method.image.shape) - 0.5))
    assert state.count == 0
