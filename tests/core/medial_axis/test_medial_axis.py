"""Parts of the skeleton: pruning, clipping, disks, and the width of thin lines."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.medial_axis.medial_axis import MedialAxis, label_axis_parts, prune_axis
from cpm_core.medial_axis.skeleton import disks_along, paint_disks
from cpm_core.medial_axis.structure import correct_half_width


def axis_of(points, edges, radius):
    count = len(points)
    return MedialAxis(np.array(points, float), np.array(edges, np.int64), np.array(radius, float), np.arange(count))


def random_tree(seed, shortest, count=40):
    """Tree whose disks do not contain each other."""
    rng = np.random.default_rng(seed)
    points, edges, radius = [np.zeros(2)], [], [5.0]
    for k in range(1, count):
        parent = int(rng.integers(max(0, k - 4), k))
        step = rng.uniform(shortest, 3.0)
        angle = rng.uniform(0.0, 2.0 * np.pi)
        points.append(points[parent] + step * np.array([np.sin(angle), np.cos(angle)]))
        radius.append(max(0.5, radius[parent] + rng.uniform(-1.0, 1.0) * step))
        edges.append((parent, k))
    return axis_of(points, edges, radius)


def test_a_branch_is_pruned_if_its_disks_extend_little_beyond_the_others():
    # a straight axis of disks of radius 5, and a side branch whose tip sticks out by 8 + 1 - 5 = 4
    line = [(0.0, float(x)) for x in range(0, 41, 4)]
    branch = [(4.0, 20.0), (8.0, 20.0)]
    edges = [*pairwise(range(11)), (5, 11), (11, 12)]
    axis = axis_of([*line, *branch], edges, [*[5.0] * 5, 5.5, *[5.0] * 5, 3.0, 1.0])
    assert len(prune_axis(axis, 1.9).edges) == 12
    assert {tuple(p) for p in prune_axis(axis, 2.1).points} == {*line, branch[0]}  # of the tip alone: 4 + 1 - 3
    assert {tuple(p) for p in prune_axis(axis, 3.6).points} == set(line)
    assert {tuple(p) for p in prune_axis(axis, 30.0).points} == {line[5]}


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.0, 6.0))
def test_the_pruned_axis_is_connected_and_its_disks_enlarged_by_the_pruning_cover_every_disk(seed, pruning):
    axis = random_tree(seed, 0.2)
    rest = prune_axis(axis, pruning)
    assert label_axis_parts(rest)[0] == 1
    away = np.linalg.norm(axis.points[:, None] - rest.points, axis=2)
    sticking = (away + axis.radius[:, None] - rest.radius).min(axis=1)
    assert sticking.max() <= pruning + 2.0 + 1e-9  # and a branch of less than a pixel


def test_edges_are_clipped_by_a_rectangle():
    axis = axis_of([(5, 5), (5, 15), (-4, 5), (12, -8), (-8, 12), (30, 30)], [(0, 1), (0, 2), (3, 4), (1, 5)], range(6))
    cut = axis.clip_to_rectangle(np.zeros(2), np.full(2, 10.0))
    ends = {tuple(sorted(map(tuple, np.round(cut.points[edge], 9).tolist()))) for edge in cut.edges}
    assert ends == {((5.0, 5.0), (5.0, 10.0)), ((0.0, 5.0), (5.0, 5.0)), ((0.0, 4.0), (4.0, 0.0))}
    radius = {tuple(p): r for p, r in zip(np.round(cut.points, 9).tolist(), cut.radius, strict=True)}
    assert radius[5.0, 10.0] == pytest.approx(0.5)
    assert radius[0.0, 5.0] == pytest.approx(2.0 * 5.0 / 9.0)
    assert radius[0.0, 4.0] == pytest.approx(3.6)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(0, 12))
def test_covered_pixels_are_those_whose_centers_lie_in_a_disk(seed, count):
    rng = np.random.default_rng(seed)
    disks = np.column_stack(
        [rng.uniform(-8.0, 28.0, count), rng.uniform(-8.0, 38.0, count), rng.uniform(0.0, 9.0, count)]
    )
    row, col = np.indices((20, 30))
    expected = np.zeros((20, 30), bool)
    unclear = np.zeros((20, 30), bool)
    for r, c, radius in disks:
        away = np.hypot(row - r, col - c)
        expected |= away <= radius
        unclear |= np.abs(away - radius) < 0.01
    assert (paint_disks(disks, (20, 30)) == expected)[~unclear].all()


def test_disks_between_two_vertices_lie_on_the_cone_through_theirs():
    disks = disks_along(np.array([(0.0, 0.0), (6.0, 8.0), (6.0, 20.0)]), np.array([1.0, 6.0, 0.0]))
    assert disks[0].tolist() == [0.0, 0.0, 1.0]
    assert disks[-1].tolist() == [6.0, 20.0, 0.0]
    assert np.linalg.norm(np.diff(disks[:, :2], axis=0), axis=1).max() <= 0.2501
    first = disks[:, 1] <= 8.0
    np.testing.assert_allclose(disks[first, 2], 1.0 + 0.5 * np.hypot(*disks[first, :2].T), atol=1e-12)
    np.testing.assert_allclose(disks[~first, 2], 0.5 * (20.0 - disks[~first, 1]), atol=1e-12)


@pytest.mark.parametrize("smoothing", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("half", [0.75, 1.5, 2.0, 4.0, 30.0])
def test_the_width_of_a_line_is_what_it_was_before_smoothing(half, smoothing):
    # central differences of a line that has been averaged over pixels and smoothed, on a fine grid
    fine = 0.002
    spread = np.sqrt(smoothing**2 + 1.0 / 3.0 + 1.0 / 12.0)
    x = np.arange(0.0, half + 4.0 * spread, fine)
    slope = np.exp(-0.5 * ((x - half) / spread) ** 2) - np.exp(-0.5 * ((x + half) / spread) ** 2)
    ridge = x[np.argmax(slope)]
    # the ridges of a line thinner than its smoothing hardly depend on its width
    tolerance = 0.005 if half > spread else 0.2 * spread
    assert correct_half_width(np.array([ridge]), smoothing)[0] == pytest.approx(half, abs=tolerance)
