import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from cpm_core.reconstruction.surface.joints import SaddleSurroundings, contrast_around_path
from tests.core.reconstruction.surface import solids
from tests.core.reconstruction.surface.solids import ball, brick, ring, rod, scene, surface_of, union, without

ALONG = np.array([0.0, 0.0, 1.0])
LINKED = union(ring(9, 3.5, 0, solids.MIDDLE - 5 * ALONG), ring(9, 3.5, 1, solids.MIDDLE + 5 * ALONG))
DOUBLE = union(ring(7, 3, 0, solids.MIDDLE - 7.5 * ALONG), ring(7, 3, 0, solids.MIDDLE + 7.5 * ALONG))


@pytest.mark.parametrize(
    ("solid", "euler", "parts", "bias"),
    [
        (ball(13), 2, 1, 0.05),
        (ring(11, 5), 0, 1, 0.05),
        (brick(8, 12, 10), 2, 1, None),
        (DOUBLE, -2, 1, None),
        (LINKED, 0, 2, None),
        (without(ball(16), ball(8)), 4, 2, 0.05),
        (brick(2, 14, 14), 2, 1, None),
    ],
    ids=["ball", "torus", "brick", "double torus", "linked tori", "shell", "thin plate"],
)
def test_surfaces_have_the_topology_and_the_place_of_the_solid(solid, euler, parts, bias):
    seen = scene(solid, noise=20.0)
    surface = surface_of(seen)
    assert (surface.euler, surface.components) == (euler, parts)
    assert surface.closed and surface.volume > 0.0
    off = np.abs(solid(surface.vertices))
    assert (off < 1.0).mean() > 0.98
    assert surface.unsupported < 0.01
    if bias is not None:
        assert off.mean() <= bias


@pytest.mark.parametrize("solid", [ball(13), ring(11, 5)], ids=["ball", "torus"])
def test_voxels_need_not_be_cubes(solid):
    surface = surface_of(scene(solid, spacing=(2.0, 1.0, 1.0), noise=2.0))
    off = np.abs(solid(surface.vertices * surface.spacing))
    assert off.mean() <= 0.1
    assert surface.closed and surface.components == 1
    cubes = surface_of(scene(solid, noise=2.0))
    assert surface.euler == cubes.euler
    assert surface.volume == pytest.approx(cubes.volume, rel=0.02)
    assert surface.area == pytest.approx(cubes.area, rel=0.02)


@pytest.mark.parametrize("path", [[5, 6, 5, 6], [5, 6, 7, 6, 5]])
def test_the_contrast_around_a_path_that_turns_back_on_the_spot_is_a_number(path) -> None:
    there = np.column_stack([np.full((len(path), 2), 5), path]).astype(float)
    volume, nowhere = np.ones((12, 12, 12), np.float32), np.empty((0, 3))
    volume[5, 5] = 3.0
    around = SaddleSurroundings(volume, 1.0, nowhere, nowhere, np.empty(0), np.ones(3))
    with np.errstate(all="raise"):
        contrast = contrast_around_path(there, around, 1.0)
    assert (contrast > 0.5).all()


@pytest.mark.parametrize("shape", ["balls", "rod ends", "crossing rods", "bricks"])
def test_what_is_two_voxels_apart_stays_apart(shape):
    middle, half = solids.MIDDLE, 1.0
    solid = {
        "balls": union(ball(6, middle - (6 + half) * ALONG), ball(6, middle + (6 + half) * ALONG)),
        "rod ends": union(
            rod(middle - 15 * ALONG, middle - (3 + half) * ALONG, 3),
            rod(middle + (3 + half) * ALONG, middle + 15 * ALONG, 3),
        ),
        "crossing rods": union(
            rod((middle[0] - 2 - half, 4, middle[2]), (middle[0] - 2 - half, 35, middle[2]), 2),
            rod((middle[0] + 2 + half, middle[1], 4), (middle[0] + 2 + half, middle[1], 35), 2),
        ),
        "bricks": union(
            brick(8, 8, 6, center=middle - (6 + half) * ALONG), brick(8, 8, 6, center=middle + (6 + half) * ALONG)
        ),
    }[shape]
    assert surface_of(scene(solid, noise=20.0)).components == 2


@pytest.mark.parametrize("noise", [0.0, 20.0])
def test_a_vessel_that_thins_out_stays_one_surface(noise):
    """Two vessels that meet at the corners of voxels: nowhere between them is the volume as bright as at the edges."""
    middle = solids.MIDDLE.astype(int)
    label = np.zeros((40, 40, 40))
    label[middle[0] - 2 : middle[0] + 1, middle[1] - 2 : middle[1] + 1, 6 : middle[2]] = 1.0
    label[middle[0] + 1 : middle[0] + 4, middle[1] + 1 : middle[1] + 4, middle[2] : 34] = 1.0
    solid = as_solid(label)
    surface = surface_of(scene(solid, noise=noise, apart=1.5))
    assert surface.components == 1
    assert surface.closed


@pytest.mark.parametrize("dark", [False, True])
def test_a_thread_too_faint_for_particles_joins_what_it_leads_to(dark):
    middle = solids.MIDDLE
    ends = [middle - 7 * ALONG, middle + 7 * ALONG]
    stumps = union(rod(middle - 15 * ALONG, ends[0], 2.5), rod(ends[1], middle + 15 * ALONG, 2.5))
    seen = scene(union(stumps, rod(*ends, 0.9)), noise=40.0, dark=dark, found=stumps)
    surface = surface_of(seen)
    assert (surface.components, surface.euler, surface.closed) == (1, 2, True)
    assert surface_of(scene(stumps, noise=40.0, dark=dark)).components == 2


def as_solid(label):
    """A solid of voxels: half inside where they are 1, half outside where they are 0."""
    return lambda p: map_coordinates(label - 0.5, np.moveaxis(p, -1, 0), order=1, mode="nearest")


def test_a_surface_gets_a_flat_end_at_the_border():
    cut = surface_of(scene(ball(13, np.array([-2.0, 19.5, 19.5]))))
    assert (cut.euler, cut.free_edges) == (2, 0)


def test_components_with_few_particles_are_left_out_and_counted():
    solid = union(ball(9, solids.MIDDLE - 6 * ALONG), ball(3, solids.MIDDLE + 15 * ALONG))
    everything = surface_of(scene(solid))
    assert (everything.components, everything.left_out) == (2, 0)
    larger = surface_of(scene(solid, apart=3.2))
    assert (larger.components, larger.left_out) == (1, 1)
    assert len(larger.vertices) == len(np.unique(larger.faces))


def ridge_test(volume):
    """Whether a way along the middle row of a volume, over its middle, follows a ridge between edges of slope 20."""
    middle = np.array([12, 12, 12])
    beside = np.array([[12.0, 12.0, 14.0]])
    surroundings = SaddleSurroundings(
        volume.astype(np.float32), 1.0, beside, np.array([ALONG]), np.array([20.0]), np.ones(3)
    )
    return surroundings.lies_on_ridge(middle + np.arange(-2, 4)[:, None] * np.array([0, 1, 0]), middle)


def test_one_dark_voxel_does_not_part_a_thin_vessel_and_blur_does_not_join_two_objects():
    plane, row, col = np.indices((25, 25, 25)) - 12.0
    vessel = 40.0 * np.exp(-(plane**2 + col**2) / (2 * 1.2**2))
    assert ridge_test(vessel)
    vessel[12, 12, 12] -= 20.0
    assert ridge_test(vessel)
    plates = 40.0 * (np.exp(-((row - 3) ** 2) / 4.0) + np.exp(-((row + 3) ** 2) / 4.0))
    assert not ridge_test(plates)
    balls = sum(40.0 * np.exp(-(plane**2 + (row - 4 * s) ** 2 + col**2) / 8.0) for s in (1, -1))
    assert not ridge_test(balls)
