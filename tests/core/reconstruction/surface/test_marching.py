import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.ndimage import generate_binary_structure, label

from cpm_core.image.surface import Surface
from cpm_core.numerics.grids import zero_surface

SIGNS = arrays(np.int8, st.tuples(*[st.integers(2, 5)] * 3), elements=st.sampled_from([-1, 1]))


@settings(max_examples=60, deadline=None)
@given(SIGNS)
def test_every_surface_is_closed_and_manifold(signs):
    values = np.pad(signs, 1, constant_values=-1).astype(np.float32)
    surface = Surface(*zero_surface(values))
    if (signs > 0).any():
        assert surface.closed
    assert links_are_rings(surface.faces)
    assert surface.volume >= 0.0


@settings(max_examples=60, deadline=None)
@given(SIGNS)
def test_its_parts_are_those_of_the_inside_with_edges_and_of_the_outside_without(signs):
    values = np.pad(signs, 1, constant_values=-1).astype(np.float32)
    inside = label(values > 0, generate_binary_structure(3, 2))[1]
    outside = label(values <= 0)[1]
    assert Surface(*zero_surface(values)).components == inside + outside - 1


def links_are_rings(faces):
    """Whether the triangles around each vertex form one ring, all of them with the same orientation."""
    for vertex in np.unique(faces):
        around = faces[(faces == vertex).any(1)].tolist()
        following = {t[(t.index(vertex) + 1) % 3]: t[(t.index(vertex) + 2) % 3] for t in around}
        ring = [next(iter(following))]
        while following.get(ring[-1], ring[0]) != ring[0]:
            ring.append(following[ring[-1]])
        if len(ring) != len(around) or ring[-1] not in following:
            return False
    return True


def test_vertices_lie_where_the_values_pass_through_zero():
    places = np.stack(np.meshgrid(*[np.arange(12.0)] * 3, indexing="ij"), -1)
    plane = np.array([0.36, 0.48, 0.8])
    vertices, faces = zero_surface((places @ plane - 7.1).astype(np.float32))
    assert vertices @ plane == pytest.approx(7.1, abs=1e-5)
    normals = Surface(vertices, faces).normals
    assert normals == pytest.approx(np.broadcast_to(-plane, normals.shape), abs=1e-4)  # away from what is positive


def test_a_range_within_a_volume_gives_the_surface_there():
    places = np.stack(np.meshgrid(*[np.arange(20.0)] * 3, indexing="ij"), -1) - 9.5
    values = (7.0 - np.linalg.norm(places, axis=-1)).astype(np.float32)
    whole = zero_surface(values)[0]
    part, faces = zero_surface(values, ((0, 20), (3, 20), (8, 20)))
    assert Surface(part, faces).free_edges > 0
    wanted = whole[(whole[:, 1] >= 3) & (whole[:, 2] >= 8)]
    assert sorted(map(tuple, part.round(4))) == sorted(map(tuple, wanted.round(4)))
