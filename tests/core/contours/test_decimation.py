import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cpm_core.contours.surface import Surface
from cpm_core.numerics.grids import zero_surface
from tests.core.reconstruction.surface.solids import MIDDLE, ball, brick, grid, ring, union

LINKED = union(ring(9, 3.5, 0, MIDDLE - np.array([0, 5, 0])), ring(9, 3.5, 2, MIDDLE + np.array([0, 5, 0])))


def sampled(solid, spacing=(1.0, 1.0, 1.0)):
    return Surface(*zero_surface(solid(grid(spacing)).astype(np.float32)), spacing, "mm")


def topology(surface):
    return surface.euler, surface.free_edges, surface.nonmanifold_edges, surface.components


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
    assert len(few.faces) <= len(whole.faces)


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
