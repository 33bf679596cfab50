import itertools

import numpy as np
import pytest
import scipy
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cpm_core.contours.surface import Surface
from cpm_core.numerics.grids import zero_surface
from tests.core.reconstruction.surface.solids import MIDDLE, ball, brick, grid, ring, union

LINKED = union(ring(9, 3.5, 0, MIDDLE - np.array([0, 5, 0])), ring(9, 3.5, 2, MIDDLE + np.array([0, 5, 0])))


def sampled(solid, spacing=(1.0, 1.0, 1.0)):
    return Surface(*zero_surface(solid(grid(spacing)).astype(np.float32)), spacing, "mm")


def noisy_tree():
    """A branched body of voxels with noise: handles, hollows and specks."""
    rng, places = np.random.default_rng(0), np.moveaxis(np.indices((44, 44, 44)), 0, -1).astype(float)
    off = np.full(places.shape[:3], 9.0)
    ends = [(np.array([5.0, 22.0, 22.0]), np.array([1.0, 0.0, 0.0]), 13.0, 3.0)]
    while ends:
        begin, way, length, radius = ends.pop()
        end = np.clip(begin + way * length, 5, 38)
        along = np.clip((places - begin) @ (end - begin) / max((end - begin) @ (end - begin), 1e-9), 0, 1)
        off = np.minimum(off, np.linalg.norm(places - begin - along[..., None] * (end - begin), axis=-1) - radius)
        ways = way + rng.normal(0.0, 0.8, (2 if radius > 1.5 else 0, 3))
        ends += [(end, one / np.linalg.norm(one), 0.75 * length, 0.75 * radius) for one in ways]
    values = np.full(np.add(off.shape, 2), -3.0)
    values[1:-1, 1:-1, 1:-1] = np.clip(rng.normal(-off, 0.5), -3.0, 3.0)
    return Surface(*zero_surface(values.astype(np.float32)))


def topology(surface):
    return surface.euler, surface.free_edges, surface.nonmanifold_edges, surface.components


def whole_fans(surface):
    """Whether no two triangles have the same corners, and those at each vertex follow each other in one fan."""
    corners = np.arange(3 * len(surface.faces)).reshape(-1, 3)
    sides = [(surface.faces[:, [i, j]], corners[:, i]) for i, j in itertools.permutations(range(3), 2)]
    ends, corner = (np.concatenate(parts) for parts in zip(*sides, strict=True))
    order = np.lexsort(ends.T)
    same = (np.diff(ends[order], axis=0) == 0).all(axis=1)
    joined = scipy.sparse.coo_array(
        (np.ones(same.sum()), (corner[order[:-1]][same], corner[order[1:]][same])), shape=(corners.size,) * 2
    )
    fans = scipy.sparse.csgraph.connected_components(joined, directed=False)[0]
    apart = len(np.unique(np.sort(surface.faces, axis=1), axis=0)) == len(surface.faces)
    return apart and fans == len(np.unique(surface.faces))


@pytest.mark.parametrize("spacing", [(1.0, 1.0, 1.0), (2.0, 1.0, 1.0)])
@pytest.mark.parametrize(
    "solid", [ball(14), ring(11, 5), LINKED, brick(8, 10, 12)], ids=["ball", "ring", "linked", "brick"]
)
def test_fewer_triangles_keep_the_topology_and_the_place(solid, spacing):
    whole = sampled(solid, spacing)
    wanted = len(whole.faces) // 4
    few = whole.decimated(wanted)
    assert wanted - 1 <= len(few.faces) <= wanted
    assert topology(few) == topology(whole)
    assert few.closed
    assert few.volume == pytest.approx(whole.volume, rel=0.01)
    assert (few.spacing, few.unit) == (spacing, "mm")
    off = [np.abs(solid((surface.vertices * spacing)[surface.faces].mean(1))).max() for surface in (whole, few)]
    assert off[1] < off[0] + 0.2


@settings(max_examples=30, deadline=None)
@given(arrays(np.int8, st.tuples(*[st.integers(2, 5)] * 3), elements=st.sampled_from([-1, 1])), st.integers(4, 60))
def test_any_surface_stays_closed_and_manifold_with_its_topology(signs, wanted):
    whole = Surface(*zero_surface(np.pad(signs, 1, constant_values=-1).astype(np.float32)))
    few = whole.decimated(wanted)
    assert topology(few) == topology(whole)
    assert whole_fans(few) == whole_fans(whole)
    assert len(few.faces) <= len(whole.faces)


def test_a_noisy_tree_becomes_half_as_many_triangles_and_stays_manifold_with_its_handles():
    whole = noisy_tree()
    assert whole.closed and whole.euler < 2 * whole.components and whole_fans(whole)
    few = whole.decimated(len(whole.faces) // 4)
    assert topology(few) == topology(whole)
    assert few.closed and whole_fans(few)
    assert len(few.faces) < 0.6 * len(whole.faces)
    assert few.volume == pytest.approx(whole.volume, rel=0.1)


@pytest.mark.parametrize(("solid", "least"), [(ball(14), 4), (ring(11, 5), 14), (LINKED, 28)])
def test_so_few_triangles_that_the_topology_would_change_are_not_reached(solid, least):
    few = sampled(solid).decimated(4)
    assert topology(few) == topology(sampled(solid))
    assert whole_fans(few) and few.volume > 0
    assert least <= len(few.faces) <= 100


def test_a_surface_that_ends_at_the_border_keeps_its_rim():
    values = ball(12, np.array([-2.0, 19.5, 19.5]))(grid()).astype(np.float32)
    whole = Surface(*zero_surface(values, ((0, 40), (0, 40), (0, 40))))
    few = whole.decimated(len(whole.faces) // 4)
    assert len(few.faces) <= len(whole.faces) // 4
    assert topology(few) == topology(whole)
    assert few.free_edges > 0
    rims = [surface.vertices[surface.vertices[:, 0] == 0.0] for surface in (whole, few)]
    assert np.array_equal(*(rim[np.lexsort(rim.T)] for rim in rims))


def test_a_surface_with_no_more_triangles_than_wanted_is_returned_as_it_is():
    whole = sampled(ball(6))
    assert whole.decimated(len(whole.faces)) is whole


def test_what_cannot_be_decimated_is_refused_in_a_sentence():
    whole = sampled(ball(6))
    with pytest.raises(ValueError, match=r"faces is .* but must be a whole number of at least 4\."):
        whole.decimated(10.5)
    corners = np.array([[0, 0, 0], [0, 0, 1], [0, 1, 0], [1, 0, 0], [5, 5, 5]], float)
    fin = Surface(corners, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2], [0, 1, 4]])
    with pytest.raises(ValueError, match="more than two triangles, 1 in number"):
        fin.decimated(4)
