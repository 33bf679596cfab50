"""The picture of a volume in space agrees with geometry, pixel by pixel."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from cpm_app.model.display.display_image import IntensityWindow
from cpm_app.model.space.camera import Camera
from cpm_app.model.space.picture import EMPTY_DEPTH, Picture, draw_balls, draw_lines
from cpm_app.model.space.triangles import CutPlane, SurfaceMesh, draw_mesh
from cpm_app.model.space.view_in_space import ColoredMesh, ShownParticles, ShownParts, ViewInSpace
from cpm_app.model.space.voxels import ShadedVolume, draw_projection, draw_slice
from cpm_app.model.volume.slices import Slice, Slices
from cpm_app.views.canvas.flow import start_positions
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cpm_core.image.image import Image
from cpm_core.image.surface import Surface

SIZE = 40, 60
MIDDLE = np.array([29.5, 19.5, 0.0])
WHOLE = IntensityWindow(0.0, 255.0)
RED, GREEN = (200, 0, 0), (0, 200, 0)
GRAY = np.repeat(np.arange(256, dtype=np.uint8)[:, None], 3, axis=1)

angles = st.floats(-3.0, 3.0)
cameras = st.builds(
    lambda one, other, roll, scale: (
        Camera.facing_box((20.0, 30.0, 40.0), SIZE).rotated(one, other).rolled(roll).zoomed(scale)
    ),
    angles,
    angles,
    angles,
    st.floats(0.3, 3.0),
)


def blank() -> Picture:
    return Picture.blank(SIZE, (0, 0, 0))


def of_shape(shape: tuple[int, ...], spacing: tuple[float, ...] = (1.0, 1.0, 1.0), **more: object) -> ViewInSpace:
    """A view of a volume of this shape."""
    image = Image(np.arange(float(np.prod(shape))).reshape(shape), spacing)
    return ViewInSpace(image, ShadedVolume(image.values, WHOLE), Slices.through_middle(image), **more)


def front(scale: float = 1.0) -> Camera:
    """Look along the planes of a volume, at its first voxel."""
    return Camera(np.zeros(3), np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]), scale)


def ball(radius: float, center: float, rings: int = 24) -> Surface:
    """A closed surface whose normals point outward."""
    polar, around = np.linspace(0.0, np.pi, rings + 1), np.linspace(0.0, 2.0 * np.pi, 2 * rings, endpoint=False)
    grid = np.array([[[np.cos(a), np.sin(a) * np.cos(b), np.sin(a) * np.sin(b)] for b in around] for a in polar])
    number = np.arange(grid[..., 0].size).reshape(grid.shape[:2])
    one, right = number[:-1], np.roll(number, -1, axis=1)[:-1]
    below, corner = number[1:], np.roll(number, -1, axis=1)[1:]
    faces = np.concatenate([np.stack([one, below, corner], -1), np.stack([one, corner, right], -1)]).reshape(-1, 3)
    surface = Surface(center + radius * grid.reshape(-1, 3), faces)
    return surface if surface.volume > 0 else Surface(surface.vertices, surface.faces[:, ::-1])


@given(camera=cameras, place=st.tuples(*[st.floats(-50.0, 50.0)] * 3))
def test_a_pixel_and_its_depth_lead_back_to_the_position(camera, place) -> None:
    x, y, depth = camera.project(np.array([place]), SIZE)[0].astype(float)
    back = camera.first_pixel_position(SIZE) + np.array([x, y, depth]) @ camera.axes / camera.scale
    assert back == pytest.approx(place, abs=1e-2)


@given(camera=cameras, right=st.floats(-20, 20), down=st.floats(-20, 20), factor=st.floats(0.2, 5.0))
def test_enlarging_keeps_the_place_under_the_pointer(camera, right, down, factor) -> None:
    under = camera.center + (right * camera.axes[0] + down * camera.axes[1]) / camera.scale
    seen = camera.zoomed(factor, right, down).project(under[None], SIZE)[0]
    assert seen[:2] == pytest.approx((MIDDLE[0] + right, MIDDLE[1] + down), abs=1e-2)


@settings(max_examples=10)
@given(seed=st.integers(0, 10_000), camera=cameras)
def test_each_pixel_shows_the_nearest_triangle_on_its_line_of_sight(seed, camera) -> None:
    """Beside the intersection of each line with each plane, by a linear system for each."""
    rng = np.random.default_rng(seed)
    vertices = np.array(camera.center) + rng.normal(0.0, 12.0 / camera.scale, (9, 3))
    picture = blank()
    draw_mesh(picture, SurfaceMesh(Surface(vertices, np.arange(9).reshape(3, 3))), camera, RED, GREEN)
    seen = camera.project(vertices, SIZE).astype(float).reshape(3, 3, 3)
    sides = [np.array([b[:2] - a[:2], c[:2] - a[:2]]).T for a, b, c in seen]
    assume(all(abs(np.linalg.det(edges)) >= 1e-2 for edges in sides))
    compared = 0
    for row in range(0, SIZE[0], 3):
        for col in range(0, SIZE[1], 3):
            found, sure = np.inf, True
            for (a, b, c), edges in zip(seen, sides, strict=True):
                to_b, to_c = np.linalg.solve(edges, np.array([col, row]) - a[:2])
                least = min(to_b, to_c, 1.0 - to_b - to_c)
                sure &= abs(least) > 1e-4
                if least >= 0:
                    found = min(found, (a + to_b * (b - a) + to_c * (c - a))[2])
            depth = picture.depths[row, col]
            if sure:
                assert (depth == EMPTY_DEPTH) == np.isinf(found)
                assert np.isinf(found) or depth == pytest.approx(found, abs=0.05)
                compared += 1
    assert compared > 100


def test_a_cut_lays_the_inside_open() -> None:
    mesh, camera = SurfaceMesh(ball(8.0, 0.0, 48)), front()
    picture = blank()
    draw_mesh(picture, mesh, camera, RED, GREEN, CutPlane(0, 0.0))
    assert picture.depths[19, 29] == pytest.approx(8.0, abs=0.1)
    assert picture.colors[19, 29, 1] > picture.colors[19, 29, 0]
    assert picture.depths.min() >= -0.01


@given(camera=cameras, seed=st.integers(0, 1000), radius=st.floats(0.5, 6.0))
@settings(max_examples=10)
def test_balls_hide_what_is_behind_them(camera, seed, radius) -> None:
    rng = np.random.default_rng(seed)
    places = camera.project(camera.center + rng.normal(0.0, 10.0 / camera.scale, (6, 3)), SIZE)
    colors = rng.integers(100, 255, (6, 3)).astype(np.uint8)
    picture = blank()
    draw_balls(picture, places, colors, radius)
    rows, cols = np.indices(SIZE)
    off = radius**2 - (cols[..., None] - places[:, 0]) ** 2 - (rows[..., None] - places[:, 1]) ** 2
    depths = np.where(off >= 0, places[:, 2] - np.sqrt(np.maximum(off, 0)), np.inf)
    sure = (np.abs(off) > 1e-3).all(-1)
    nearest = depths.min(-1)
    assert ((picture.depths < EMPTY_DEPTH) == np.isfinite(nearest))[sure].all()
    both = sure & np.isfinite(nearest)
    assert picture.depths[both] == pytest.approx(nearest[both], abs=1e-2)


def straight(center: np.ndarray, axis: int) -> Camera:
    """A camera that looks along an axis, with the two others down and to the right."""
    down, right = (one for one in range(3) if one != axis)
    return Camera(center, np.eye(3)[[right, down, axis]], 1.0)


@settings(max_examples=15)
@given(camera=cameras, axis=st.integers(0, 2), index=st.integers(0, 9))
def test_a_slice_lies_where_its_voxels_are(camera, axis, index) -> None:
    shape, spacing = (10, 15, 20), np.array([2.0, 2.0, 2.0])
    colors = np.full((*[shape[k] for k in range(3) if k != axis], 3), 255, np.uint8)
    picture = blank()
    draw_slice(picture, Slice(axis, index), colors, camera, tuple(spacing))
    rows, cols = np.nonzero(picture.depths < EMPTY_DEPTH)
    seen = np.stack([cols, rows, picture.depths[rows, cols]], -1)
    voxels = (camera.first_pixel_position(SIZE) + seen @ camera.axes / camera.scale) / spacing
    assert np.abs(voxels[:, axis] - index).max(initial=0.0) < 1e-2
    assert (voxels > -0.51).all()
    assert (voxels < np.array(shape) - 0.49).all()


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("spread", [0.02, 0.9])
def test_the_projection_seen_straight_is_the_maximum_along_the_axis(axis, spread) -> None:
    rng = np.random.default_rng(1)
    voxels = (255 * rng.random((19, 23, 31)) ** (1.0 / spread)).astype(np.uint8)
    shape = tuple(voxels.shape[k] for k in range(3) if k != axis)
    picture = Picture.blank(shape, (0, 0, 0))
    center = (np.array(voxels.shape) - 1) / 2
    camera = straight(center, axis)
    draw_projection(picture, ShadedVolume(voxels, WHOLE), camera, (1.0, 1.0, 1.0), GRAY)
    assert (picture.colors[..., 0] == voxels.max(axis)).all()
    assert (picture.depths == EMPTY_DEPTH).all()


@given(ends=st.lists(st.tuples(st.floats(-90, 150), st.floats(-90, 150)), min_size=2, max_size=2))
def test_a_line_has_a_pixel_at_every_step_and_none_beside_it(ends) -> None:
    seen = np.array([[*ends[0], 0.0], [*ends[1], 0.0]], np.float32)
    picture = blank()
    draw_lines(picture, seen, np.array([RED], np.uint8))
    rows, cols = np.nonzero(picture.depths < EMPTY_DEPTH)
    (x, y), (d_x, d_y) = seen[0, :2].astype(float), (seen[1] - seen[0])[:2].astype(float)
    steps = max(abs(d_x), abs(d_y), 1e-6)
    part = np.clip((((cols - x) * d_x) + ((rows - y) * d_y)) / max(d_x**2 + d_y**2, 1e-9), 0, 1)
    assert np.hypot(cols - x - part * d_x, rows - y - part * d_y).max(initial=0.0) < 0.75
    for step in range(int(steps) + 1):
        at_x, at_y = x + step / steps * d_x, y + step / steps * d_y
        if 0.5 < at_x < SIZE[1] - 1.5 and 0.5 < at_y < SIZE[0] - 1.5:
            assert ((np.abs(cols - at_x) < 0.501) & (np.abs(rows - at_y) < 0.501)).any()


def test_a_surface_that_is_not_opaque_lets_the_particles_behind_it_be_seen() -> None:
    mesh = SurfaceMesh(ball(8.0, 10.0, 48))
    inside = ShownParticles(np.array([[10.0, 10.0, 10.0]]), np.array([[0, 0, 250]], np.uint8))
    camera = Camera(np.full(3, 10.0), front().axes, 1.0)
    blue = {}
    for opacity in (0.0, 0.5, 1.0):
        shown = ShownParts(opacity=opacity, box=False)
        view = of_shape((21, 21, 21), particles=inside, mesh=mesh, shown=shown)
        blue[opacity] = view.render_picture(camera, (41, 41)).colors[20, 20].astype(float)
    assert blue[0.0] == pytest.approx([0.0, 0.0, 250.0], abs=2.0)
    assert blue[0.5] == pytest.approx(0.5 * (blue[0.0] + blue[1.0]), abs=1.5)


@pytest.mark.parametrize("order", [1, -1])
def test_an_inner_object_is_seen_through_an_outer_one_that_is_not_opaque(order: int) -> None:
    camera = replace(front(2.0), center=np.array([10.0, 10.0, 10.0]))

    def red_inside(outer: float, inner: float) -> int:
        meshes = [
            ColoredMesh(SurfaceMesh(ball(radius, 10.0)), color, color, opacity)
            for radius, color, opacity in ((8.0, GREEN, outer), (3.0, RED, inner))
        ]
        view = of_shape((21, 21, 21), objects=tuple(meshes[::order]), shown=ShownParts(box=False))
        assert view.is_translucent == (outer < 1.0 or inner < 1.0)
        return int(view.render_picture(camera, SIZE).colors[SIZE[0] // 2, SIZE[1] // 2, 0])

    hidden, faint, clear = red_inside(1.0, 1.0), red_inside(0.5, 0.5), red_inside(0.2, 1.0)
    assert hidden < faint < clear


def test_particles_come_from_where_those_of_the_same_number_were_and_new_ones_from_nowhere() -> None:
    rng = np.random.default_rng(0)
    numbers = rng.permutation(40)

    def snapshot(step: int, count: int, identity: np.ndarray) -> SimpleNamespace:
        state = SimpleNamespace(step=step, particles=SimpleNamespace(identity=identity))
        return SimpleNamespace(generation=1, position=rng.normal(size=(count, 3)), state=state)

    before, after = snapshot(4, 30, numbers[:30]), snapshot(5, 25, rng.permutation(numbers[15:]))
    for begin, place, number in zip(
        start_positions(before, after), after.position, after.state.particles.identity, strict=True
    ):
        known = np.flatnonzero(numbers[:30] == number)
        assert begin.tolist() == (before.position[known[0]] if len(known) else place).tolist()
    assert start_positions(after, before) is start_positions(before, before) is None, "only from one step to the next"
