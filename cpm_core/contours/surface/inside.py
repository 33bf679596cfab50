"""The voxels inside a closed surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cpm_core.contours.surface import Surface
from cpm_core.numerics.grids import parts_of
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask

_BESIDE = (1.3e-6, 2.9e-6)
"""How far beside the voxel centers lines run, so that they pass through no vertex of a surface on the grid [voxels]."""


def inside_of(surface: Surface, shape: tuple[int, ...]) -> Mask:
    """Voxels of a volume of that shape whose center lies inside a closed surface; hollows are outside."""
    found = np.zeros(shape, np.bool_)
    _fill(surface.vertices, surface.faces, np.array(_BESIDE), found)
    return found


def numbered(surface: Surface, shape: tuple[int, ...]) -> Index:
    """Number of the object that each voxel of a volume lies in: its own, or the largest first from 1 up; 0 outside."""
    if surface.numbers is not None:
        return _by_their_numbers(surface, surface.numbers, shape)
    inside = inside_of(surface, shape)
    parts = parts_of(inside, corners=True)
    order = np.argsort(-parts.sizes, kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(1, len(order) + 1)
    found = np.zeros(shape, np.int64)
    places = np.argwhere(inside)
    found[tuple(places.T)] = rank[parts.part_at(places)]
    return found


def _by_their_numbers(surface: Surface, numbers: Index, shape: tuple[int, ...]) -> Index:
    """The number of each object in its voxels; where objects share voxels, that of the last one."""
    found = np.zeros(shape, np.int64)
    for number in np.unique(numbers):
        found[inside_of(replace(surface, faces=surface.faces[numbers == number], numbers=None), shape)] = number
    return found


@compiled
def _fill(vertices: Array, faces: Index, beside: Array, found: Mask) -> None:
    """Turn all voxels beyond each crossing of a line with the surface over, so that an even number changes nothing."""
    planes, rows, cols = found.shape
    for k in range(len(faces)):
        a, b, c = vertices[faces[k, 0]], vertices[faces[k, 1]], vertices[faces[k, 2]]
        twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if twice == 0.0:
            continue
        first = max(int(np.ceil(min(a[0], b[0], c[0]) - beside[0])), 0)
        last = min(int(np.floor(max(a[0], b[0], c[0]) - beside[0])), planes - 1)
        top = max(int(np.ceil(min(a[1], b[1], c[1]) - beside[1])), 0)
        bottom = min(int(np.floor(max(a[1], b[1], c[1]) - beside[1])), rows - 1)
        for p in range(first, last + 1):
            for r in range(top, bottom + 1):
                x, y = p + beside[0], r + beside[1]
                u = ((b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x)) / twice
                v = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / twice
                if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
                    crossing = u * a[2] + v * b[2] + (1.0 - u - v) * c[2]
                    for col in range(max(int(np.ceil(crossing)), 0), cols):
                        found[p, r, col] = not found[p, r, col]
