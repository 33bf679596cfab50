"""Surfaces in space: lit triangles, optionally cut open by a plane."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cpm_app.model.space.camera import Camera
from cpm_app.model.space.picture import Picture
from cpm_core import Surface
from cpm_core.numerics import compiled
from cpm_core.numerics.types import Numbers, Pixels, Single, frozen, record

_LIGHT_DIRECTION = np.array([-0.35, -0.45, -0.82])
"""Direction to the light, (right, down, away): at the upper left behind the viewer."""


@frozen
class CutPlane:
    """A plane across an axis that cuts surfaces open: nothing before it is drawn [units of length]."""

    axis: int
    position: float

    def distance_before(self, positions: Numbers) -> Single:
        """Return how far positions (N, 3) lie before the plane, shape (N,); negative for those that are drawn."""
        return np.asarray(np.float32(self.position) - np.asarray(positions[:, self.axis], np.float32))


@record
class SurfaceMesh:
    """A surface prepared for drawing: in units of length and single precision."""

    surface: Surface

    @cached_property
    def positions(self) -> Single:
        """Vertices (N, 3) in units of length."""
        return np.asarray(self.surface.vertices * np.array(self.surface.spacing), np.float32)

    @cached_property
    def normals(self) -> Single:
        """Unit vectors outward at the vertices."""
        return np.asarray(self.surface.normals, np.float32)

    @cached_property
    def faces(self) -> NDArray[np.int32]:
        """Vertices of the triangles."""
        return np.ascontiguousarray(self.surface.faces, np.int32)


def draw_mesh(
    picture: Picture,
    mesh: SurfaceMesh,
    camera: Camera,
    outside: tuple[int, int, int],
    inside: tuple[int, int, int],
    cut: CutPlane | None = None,
) -> None:
    """Draw a surface with one color outside and another one inside, which a cut reveals."""
    seen = camera.project(mesh.positions, picture.size)
    light = np.asarray(_LIGHT_DIRECTION @ camera.axes / np.linalg.norm(_LIGHT_DIRECTION), np.float32)
    lit = mesh.normals @ light
    beyond = np.full(len(seen), -1.0, np.float32) if cut is None else cut.distance_before(mesh.positions)
    colors = np.array([outside, inside], np.float32)
    turn = np.float32(np.sign(np.linalg.det(camera.axes)))
    picture.draw_in_bands(_draw_triangles, seen, lit, beyond, mesh.faces, turn, colors)


@compiled
def _draw_triangles(
    seen: Single,
    lit: Single,
    beyond: Single,
    faces: NDArray[np.int32],
    turn: np.float32,
    colors: Single,
    shown: Pixels,
    depths: Single,
    begin: int,
    end: int,
) -> None:
    width = depths.shape[1]
    zero, one = np.float32(0.0), np.float32(1.0)
    for i in range(faces.shape[0]):
        a, b, c = faces[i, 0], faces[i, 1], faces[i, 2]
        if beyond[a] > zero and beyond[b] > zero and beyond[c] > zero:
            continue
        x, y = seen[a, 0], seen[a, 1]
        b_x, b_y, c_x, c_y = seen[b, 0] - x, seen[b, 1] - y, seen[c, 0] - x, seen[c, 1] - y
        top = max(np.ceil(y + min(zero, b_y, c_y)), np.float32(begin))
        bottom = min(np.floor(y + max(zero, b_y, c_y)), np.float32(end - 1))
        left = max(np.ceil(x + min(zero, b_x, c_x)), zero)
        right = min(np.floor(x + max(zero, b_x, c_x)), np.float32(width - 1))
        doubled = b_x * c_y - c_x * b_y
        if not (top <= bottom and left <= right) or doubled == zero:
            continue
        side, sign = (0, one) if doubled * turn < zero else (1, -one)
        scale = one / doubled
        for row in range(int(top), int(bottom) + 1):
            down = np.float32(row) - y
            for col in range(int(left), int(right) + 1):
                along = np.float32(col) - x
                to_b, to_c = (along * c_y - c_x * down) * scale, (b_x * down - along * b_y) * scale
                to_a = one - to_b - to_c
                if to_a < zero or to_b < zero or to_c < zero:
                    continue
                z = to_a * seen[a, 2] + to_b * seen[b, 2] + to_c * seen[c, 2]
                if z >= depths[row, col] or to_a * beyond[a] + to_b * beyond[b] + to_c * beyond[c] > zero:
                    continue
                depths[row, col] = z
                light = sign * (to_a * lit[a] + to_b * lit[b] + to_c * lit[c])
                _shade_pixel(shown, row, col, colors[side], max(light, zero))


@compiled
def _shade_pixel(shown: Pixels, row: int, col: int, color: Single, light: np.float32) -> None:
    """Color a pixel of a matte surface with a faint highlight, never black where no light falls."""
    gloss = light * light
    gloss *= gloss
    gloss *= gloss
    gloss *= gloss
    for channel in range(3):
        value = color[channel] * (np.float32(0.3) + np.float32(0.7) * light) + np.float32(50.0) * gloss
        shown[row, col, channel] = np.uint8(min(value, np.float32(255.0)))
