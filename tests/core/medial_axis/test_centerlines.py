import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.ndimage import distance_transform_edt, label
from skimage.measure import euler_number

import cpm_core as cpm
from cpm_core.medial_axis.centerlines import centerlines
from cpm_core.numerics.voxel_graph import thin_to_lines
from tests.core.reconstruction.surface.solids import ball, grid, ring, rod, union

MIDDLE = 19.5


def inside(solid, spacing=(1.0, 1.0, 1.0)):
    return solid(grid(spacing)) > 0.0


def test_a_rod_has_one_branch_along_its_axis_with_its_radius():
    found = centerlines(inside(rod((MIDDLE, MIDDLE, 8), (MIDDLE, MIDDLE, 31), 4)))
    assert len(found.branches) == 1
    branch = found.branches[0]
    assert np.abs(branch.points[:, :2] - MIDDLE).max() < 1.0
    assert np.abs(branch.radii - 4.0).mean() < 0.5
    assert found.lengths[0] > 18.0


def test_three_vessels_meet_in_one_junction():
    middle = np.full(3, MIDDLE)
    ends = [middle + 15 * np.array(way) for way in ((0, 0, 1), (0, 0.87, -0.5), (0, -0.87, -0.5))]
    found = centerlines(inside(union(*[rod(middle, end, 3) for end in ends])))
    assert len(found.branches) == 3
    nodes = [node for branch in found.branches for node in branch.nodes]
    common = max(set(nodes), key=nodes.count)
    assert nodes.count(common) == 3
    for branch in found.branches:
        at = branch.points[0] if branch.nodes[0] == common else branch.points[-1]
        assert np.linalg.norm(at - middle) < 2.0
        assert np.abs(branch.radii[2:-2] - 3.0).mean() < 0.5


def test_a_ring_is_closed():
    found = centerlines(inside(ring(11, 3)))
    assert len(found.branches) == 1
    branch = found.branches[0]
    assert branch.nodes[0] == branch.nodes[1]
    assert branch.points[0] == pytest.approx(branch.points[-1])
    assert found.lengths[0] == pytest.approx(2.0 * np.pi * 11.0, rel=0.06)


@pytest.mark.parametrize("spacing", [(1.0, 1.0, 1.0), (2.0, 1.0, 1.0)])
@pytest.mark.parametrize("radius", [2.5, 4.0])
def test_radii_are_those_of_the_tube(radius, spacing):
    found = centerlines(inside(ring(11, radius), spacing), spacing)
    assert found.branches[0].radii.mean() == pytest.approx(radius, abs=0.4)


def test_wrinkles_are_pruned_and_vessels_are_not():
    middle = np.full(3, MIDDLE)
    vessel = rod((MIDDLE, MIDDLE, 4.5), (MIDDLE, MIDDLE, 34.5), 4)
    wrinkled = inside(union(vessel, ball(2, middle + np.array([0, 4.5, 0]))))
    assert len(centerlines(wrinkled, pruning=1.5).branches) == 1
    branched = inside(union(vessel, rod(middle, middle + np.array([0, 16, 0]), 2)))
    assert len(centerlines(branched, pruning=1.5).branches) == 3


TRUNK, LEFT, RIGHT, SIDE = (24.0, 20.0, 20.0), (33.0, 8.0, 18.0), (33.0, 31.0, 22.0), (15.0, 20.0, 20.0)
LIMBS = [
    *(((4.0, 20.0, 20.0), TRUNK, 4.0), (TRUNK, LEFT, 3.0), (TRUNK, RIGHT, 2.8)),
    *((LEFT, (44.0, 6.0, 8.0), 2.0), (LEFT, (44.0, 4.0, 28.0), 1.8), (RIGHT, (45.0, 36.0, 20.0), 2.0)),
    *((RIGHT, (44.0, 30.0, 36.0), 1.6), (SIDE, (16.0, 20.0, 34.0), 1.8)),
]
"""Vessels from place to place with their radii: a trunk, its fork, four ends, and a twig at its side."""


def test_a_tree_with_bumps_has_its_own_branches_alone():
    rng, bumps = np.random.default_rng(0), []
    for one, other, radius in LIMBS:
        axis = np.subtract(other, one) / np.linalg.norm(np.subtract(other, one))
        across = np.cross(axis, rng.normal(size=3))
        across /= np.linalg.norm(across)
        foot = np.add(one, 0.45 * np.subtract(other, one))
        bumps.append(rod(foot, foot + (radius + 1.3) * across, 1.0))
    places = grid(side=48.0)[:, :42, :42]
    tree = union(*(rod(*limb) for limb in LIMBS))
    assert len(centerlines(tree(places) > 0.0).branches) == 9
    assert len(centerlines(union(tree, *bumps)(places) > 0.0).branches) == 9
    assert len(centerlines(union(tree, *bumps)(places) > 0.0, pruning=0.0).branches) > 15


@settings(max_examples=40, deadline=None)
@given(arrays(bool, st.tuples(*[st.integers(1, 6)] * 3)))
def test_thinning_keeps_the_topology(mask):
    mask = np.pad(mask, 1)
    lines = thin_to_lines(mask, distance_transform_edt(mask))
    corners = np.ones((3, 3, 3))
    assert not (lines & ~mask).any()
    assert label(lines, corners)[1] == label(mask, corners)[1]
    assert label(~lines)[1] == label(~mask)[1]
    assert euler(lines) == euler(mask)


def euler(mask):
    return euler_number(mask, connectivity=3)


def gray(solid, noise=0.0):
    """A volume of gray levels in which a solid is light, of blurred rim."""
    return 20.0 + 100.0 * np.clip(0.5 + solid(grid()), 0.0, 1.0) + np.random.default_rng(0).normal(0, noise, (40,) * 3)


def three_vessels():
    middle = np.full(3, MIDDLE)
    return union(
        *[rod(middle, middle + 15 * np.array(way), 3) for way in ((0, 0, 1), (0, 0.87, -0.5), (0, -0.87, -0.5))]
    )


@pytest.mark.parametrize("values", [inside(ring(11, 3)), 7 * inside(ring(11, 3)), gray(ring(11, 3), 2.0)])
def test_the_skeleton_of_a_torus_is_one_closed_line(values):
    found = cpm.skeleton(values)
    (line,), (radii,) = found.contours, found.radii
    assert line.closed and line.junctions == (False, False) and line.area == 0.0
    assert line.points.shape == (len(radii), 3)
    assert not np.array_equal(line.points[0], line.points[-1])
    away = line.points - MIDDLE
    assert np.hypot(np.hypot(away[:, 1], away[:, 2]) - 11.0, away[:, 0]).max() < 1.0
    assert radii.mean() == pytest.approx(3.0, abs=0.5)
    assert line.length == pytest.approx(2.0 * np.pi * 11.0, rel=0.06)


def test_the_skeleton_of_three_vessels_has_one_junction():
    found = cpm.skeleton(gray(three_vessels(), 2.0))
    assert len(found.contours) == 3
    ends = [(line.points[k], line.junctions[k]) for line in found.contours for k in (0, -1)]
    at = [point for point, joined in ends if joined]
    assert len(at) == 3
    assert np.ptp(at, axis=0) == pytest.approx(0.0)
