"""Outlines of masks: closed lines that contain exactly the pixels of the mask."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from cpm_core import edge_map
from cpm_core.contours.contour import Contour
from cpm_core.contours.rasterize import rasterize_mask
from cpm_core.numerics.segments import first_crossing, path_segments
from cpm_core.objects.boundaries.boundary_guides import build_boundary_guides
from cpm_core.objects.outline import compute_outlines

from ..scenes import disk, square

seeds = st.integers(0, 2**32 - 1)


def crosses_itself(contour):
    segments = path_segments(contour.path)
    for k in range(len(segments) - 2):
        others = segments[k + 2 : len(segments) - (k == 0)]
        if len(others) and first_crossing(segments[k].reshape(2, 2), others)[0] >= 0:
            return True
    return False


@settings(deadline=None, max_examples=12)
@given(seeds)
def test_the_outlines_of_any_mask_contain_exactly_its_pixels_and_never_cross(seed):
    random = np.random.default_rng(seed)
    shape = (14, 17)
    mask = ndimage.gaussian_filter(random.random(shape), random.choice([0.0, 1.0])) > 0.5
    values = random.random(shape)
    lines = [random.uniform(-2.0, 18.0, (5, 2))]
    contours = tuple(
        outline.contour for outline in compute_outlines(mask, build_boundary_guides(values, values, lines))
    )
    assert np.array_equal(rasterize_mask(contours, shape), mask)
    for contour in contours:
        assert contour.closed
        assert not crosses_itself(contour)


@pytest.mark.parametrize(
    "make", [lambda: disk((64, 64), (31.3, 30.6), 20.2), lambda: square((64, 64), (15.375, 14.625), 31.25)]
)
def test_without_contours_the_outline_lies_on_the_ridge_of_the_edge_map(make):
    scene = make()
    there = build_boundary_guides(scene.values, edge_map(scene.values, 1.0))
    (found,) = compute_outlines(scene.values > 120.0, there)
    away = scene.distance(found.contour.points)
    assert np.median(away) < 0.06
    assert np.percentile(away, 90) < 0.15
    assert found.gaps[0].shape[1] == 2  # all of it follows no contour


def test_where_a_contour_passes_the_outline_lies_on_it_exactly():
    scene = disk((64, 64), (31.3, 30.6), 20.2)
    ring = Contour(scene.boundary, True)
    flat = np.zeros((64, 64))
    (found,) = compute_outlines(scene.values > 120.0, build_boundary_guides(flat, flat, [ring.path]))
    assert scene.distance(found.contour.points).max() < 0.03
    assert found.gaps == ()
    assert found.contour.area == pytest.approx(np.pi * 20.2**2, rel=0.005)


def test_along_the_border_of_the_image_the_outline_is_the_border():
    mask = np.zeros((20, 30), bool)
    mask[:8, :11] = True
    flat = np.zeros(mask.shape)
    (found,) = compute_outlines(mask, build_boundary_guides(flat, flat))
    assert found.contour.points.min(axis=0).tolist() == [-0.5, -0.5]
    assert [-0.5, -0.5] in found.contour.points.tolist()
    path = found.contour.path
    bordering = ((path[1:] == -0.5) & (path[:-1] == -0.5)).any(axis=1)
    assert np.linalg.norm(np.diff(path, axis=0), axis=1)[bordering].sum() == pytest.approx(8.0 + 11.0 - 1.0)


def test_of_an_outline_with_a_gap_the_stretch_across_it_is_told():
    scene = disk((64, 64), (31.3, 30.6), 20.2)
    part = scene.boundary[20:]  # 20 of 161 points are missing
    flat = np.zeros((64, 64))
    (found,) = compute_outlines(scene.values > 120.0, build_boundary_guides(flat, flat, [part]))
    (gap,) = found.gaps
    missing = 20.0 / len(scene.boundary) * 2.0 * np.pi * 20.2
    assert np.linalg.norm(np.diff(gap, axis=0), axis=1).sum() == pytest.approx(missing, abs=4.0)
    assert np.linalg.norm(gap[:, None] - scene.boundary[None, :20], axis=2).min(axis=1).max() < 1.5
