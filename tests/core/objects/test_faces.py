"""Faces: crossings of lines, basins, and the graph of neighbors, against their definitions."""

import numpy as np
import pytest
import scipy.ndimage
from hypothesis import given, settings
from hypothesis import strategies as st

from cpm_core.numerics import polyline
from cpm_core.objects.faces.basins import basins
from cpm_core.objects.faces.crossings import Crossings, crossings
from cpm_core.objects.faces.face_graph import face_graph
from cpm_core.objects.faces.faces import find_faces, ground, split

seeds = st.integers(0, 2**32 - 1)


def none(shape):
    return crossings([], shape)


def links(shape):
    """Pairs of neighboring pixels, and whether one is below or right of the other."""
    for r in range(shape[0]):
        for c in range(shape[1]):
            for down, right in ((0, 1), (1, 0)):
                if r + down < shape[0] and c + right < shape[1]:
                    yield (r, c), (r + down, c + right), down


@settings(deadline=None, max_examples=24)
@given(seeds)
def test_a_closed_line_parts_the_pixels_inside_from_those_outside(seed):
    random = np.random.default_rng(seed)
    shape = (12, 14)
    angle = np.sort(random.random(9)) * 2.0 * np.pi
    radius = random.uniform(1.0, 8.0, 9)
    corners = np.stack([5.5 + radius * np.sin(angle), 6.5 + radius * np.cos(angle)], axis=1)
    if random.random() < 0.5:
        corners = np.rint(corners)  # through the centers of pixels
    found = crossings([np.concatenate([corners, corners[:1]])], shape)
    pixels = np.indices(shape).reshape(2, -1).T.astype(float)
    inside = polyline.inside(corners - [1.37e-7, -2.61e-7] + [2.74e-7, 0.0], pixels).reshape(shape)
    for p, q, down in links(shape):
        if inside[p] != inside[q]:
            assert (found.down if down else found.right)[p] >= 0.0


@settings(deadline=None, max_examples=24)
@given(seeds)
def test_without_merging_there_is_a_basin_for_each_minimum_and_water_runs_down_in_it(seed):
    random = np.random.default_rng(seed)
    height = random.integers(0, 6, (9, 11)) / 5.0  # with level ground
    found = basins(height, none(height.shape), 0.0, 0)
    lowest = 0
    for level in np.unique(height):
        regions, count = scipy.ndimage.label(height == level)
        for number in range(1, count + 1):
            around = scipy.ndimage.binary_dilation(regions == number) & (regions != number)
            lowest += not (height[around] < level).any()
    assert found.max() + 1 == lowest
    for number in range(found.max() + 1):
        assert scipy.ndimage.label(found == number)[1] == 1


@settings(deadline=None, max_examples=24)
@given(seeds)
def test_no_basin_reaches_across_a_closed_line(seed):
    random = np.random.default_rng(seed)
    shape = (20, 20)
    angle = np.linspace(0.0, 2.0 * np.pi, 40)
    radius = random.uniform(3.0, 8.0)
    circle = np.stack([9.7 + radius * np.sin(angle), 9.2 + radius * np.cos(angle)], axis=1)
    found = basins(random.random(shape), crossings([circle], shape), 2.0, 400)
    inside = polyline.inside(circle, np.indices(shape).reshape(2, -1).T.astype(float)).reshape(shape)
    assert found.max() == 1
    assert np.array_equal(found == found[9, 9], inside)


def brute_force(labels, strength, lines, barriers):
    """Sides, sums of strength, sides on lines and barriers, and corners of each pair."""
    pairs = {}
    for p, q, down in links(labels.shape):
        key = tuple(sorted((int(labels[p]), int(labels[q]))))
        if key[0] != key[1]:
            entry = pairs.setdefault(key, np.zeros(5))
            crossed = ((on.down if down else on.right)[p] >= 0.0 for on in (lines, barriers))
            entry[:4] += 1.0, max(strength[p], strength[q]), *crossed
    for r in range(labels.shape[0] - 1):
        for c in range(labels.shape[1]):
            for right in (-1, 1):
                if 0 <= c + right < labels.shape[1]:
                    key = tuple(sorted((int(labels[r, c]), int(labels[r + 1, c + right]))))
                    if key in pairs:
                        pairs[key][4] += 1.0
    return pairs


def scattered(random, shape):
    return Crossings(*(np.where(random.random(shape) < 0.3, 0.5, -1.0).astype(np.float32) for _ in range(2)))


@settings(deadline=None, max_examples=24)
@given(seeds)
def test_the_graph_has_the_measures_of_its_definition(seed):
    random = np.random.default_rng(seed)
    shape = tuple(random.integers(3, 10, 2))
    labels = random.integers(0, 5, shape)
    labels = np.unique(labels, return_inverse=True)[1].reshape(shape).astype(np.int32)
    if labels.max() > 0 and random.random() < 0.4:
        labels -= 1  # some pixels are outside the regions of interest
    values, strength = random.random(shape), random.random(shape)
    lines, barriers = scattered(random, shape), scattered(random, shape)
    graph = face_graph(labels, values, strength, lines, barriers)
    expected = brute_force(labels, strength, lines, barriers)
    inner = {pair: entry for pair, entry in expected.items() if pair[0] >= 0}
    assert sorted(inner) == sorted(zip(graph.first.tolist(), graph.second.tolist(), strict=True))
    for k, pair in enumerate(zip(graph.first.tolist(), graph.second.tolist(), strict=True)):
        sides, sums, on_line, on_barrier, corners = inner[pair]
        assert graph.length[k] == pytest.approx(np.pi / 8.0 * (sides + corners / np.sqrt(2.0)))
        measured = graph.strength[k], graph.along[k], graph.barred[k]
        assert measured == pytest.approx((sums / sides, on_line / sides, on_barrier / sides))
    for k in range(graph.count):
        own = labels == k
        assert graph.area[k] == own.sum()
        assert graph.mean[k] == pytest.approx(values[own].mean())
        assert graph.center[k] == pytest.approx(np.argwhere(own).mean(axis=0))
        on_border = own[0].sum() + own[-1].sum() + own[:, 0].sum() + own[:, -1].sum()
        outer = expected.get((-1, k), np.zeros(5))
        assert graph.rim[k] == pytest.approx(on_border + np.pi / 8.0 * (outer[0] + outer[4] / np.sqrt(2.0)))


@settings(deadline=None, max_examples=24)
@given(seeds)
def test_a_face_that_is_cut_is_measured_as_if_it_had_always_been_two(seed):
    random = np.random.default_rng(seed)
    values = random.random((24, 30))
    there = ground(values, values, [np.array([(5.0, -3.0), (20.0, 40.0)])], None)
    faces = find_faces(there)
    inside, outside = random.integers(0, 24, (5, 2)), random.integers(0, 24, (5, 2))
    inside = inside[~(inside[:, None] == outside[None]).all(axis=2).any(axis=1)]
    found = split(faces, there, inside, outside)
    again = face_graph(found.labels, there.values, there.strength, there.contours, there.barriers)
    assert not set(found.labels[tuple(inside.T)]) & set(found.labels[tuple(outside.T)])
    order, other = (np.lexsort((graph.second, graph.first)) for graph in (found.graph, again))
    for name in ("first", "second", "length", "strength", "along", "barred"):
        assert np.allclose(getattr(found.graph, name)[order], getattr(again, name)[other])
    for name in ("area", "mean", "rim", "center"):
        assert np.allclose(getattr(found.graph, name), getattr(again, name))


def test_a_gap_in_an_outline_parts_the_faces_on_both_sides_of_it():
    flat = np.zeros((60, 60))
    outline = 0.3 + np.array([(15, 27), (15, 15), (45, 15), (45, 45), (15, 45), (15, 33)])
    faces = find_faces(ground(flat, flat, [outline], None))
    inside = polyline.inside(outline, np.indices(flat.shape).reshape(2, -1).T.astype(float)).reshape(flat.shape)
    away = np.hypot(*(np.indices(flat.shape) - np.array([15.0, 30.0])[:, None, None])) > 6.0
    assert not set(faces.labels[inside & away]) & set(faces.labels[~inside & away])
