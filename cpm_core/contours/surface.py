"""Surfaces of several objects in a volume: joined, told apart, labeled, and cut by slices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour
from cpm_core.contours.graph import Graph
from cpm_core.image.surface import Surface, voxelize_surface
from cpm_core.numerics.grids import find_connected_parts, find_label_boxes, zero_surface
from cpm_core.numerics.types import Extent, Index, Sides


def extract_object_surface(surface: Surface, number: int) -> Surface:
    """Extract the surface of the object with a number, without the other vertices."""
    used, corners = np.unique(surface.faces[surface.numbers == number], return_inverse=True)
    return replace(surface, vertices=surface.vertices[used], faces=corners.reshape(-1, 3), numbers=None)


def label_voxels(surface: Surface, shape: Extent) -> Index:
    """Label each voxel of a volume of shape `shape` with the object it lies in, 0 outside.

    Labels are the objects' own numbers, or else count from 1, the largest first.
    """
    found = np.zeros(shape, np.int64)
    if surface.numbers is not None:
        for number in np.unique(surface.numbers):  # where objects share voxels, the last one gets them
            one = extract_object_surface(surface, number)
            first = np.clip(np.floor(one.vertices.min(axis=0)), 0, shape).astype(np.int64)
            end = np.clip(np.floor(one.vertices.max(axis=0)) + 2, 0, shape).astype(np.int64)
            around = found[tuple(map(slice, first, end))]
            shifted = replace(one, vertices=one.vertices - first)
            around[voxelize_surface(shifted, around.shape)] = number
        return found
    inside = voxelize_surface(surface, shape)
    parts = find_connected_parts(inside, corners=True)
    order = np.argsort(-parts.sizes, kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(1, len(order) + 1)
    places = np.argwhere(inside)
    found[tuple(places.T)] = rank[parts.part_at(places)]
    return found


_LABEL_MARGIN = 1
"""Margin around an object in which its surface lies [voxels]."""


def surface_from_labels(
    labels: NDArray[np.int32], spacing: Sides, unit: str | None, *, open_border: bool = False
) -> Surface:
    """Build the surfaces halfway between the voxels of labels, shape (P, R, C), and their neighbors.

    At the border of the volume they are closed, or with `open_border` open, as the objects may continue beyond it. With
    a single label the connected parts are the objects, and none has a number.
    """
    places, corners, numbers, count = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], [np.empty(0, np.int64)], 0
    for number, part in find_label_boxes(labels):
        inside = np.pad(labels[part] == number, _LABEL_MARGIN)
        begin = np.array([side.start - _LABEL_MARGIN for side in part])
        within = np.clip([begin, begin + inside.shape], 0, labels.shape) - begin
        vertices, faces = zero_surface(
            inside.astype(np.float32) - np.float32(0.5), tuple(map(tuple, within.T.tolist())) if open_border else None
        )
        places.append(vertices + begin)
        corners.append(faces + count)
        numbers.append(np.full(len(faces), number))
        count += len(vertices)
    of = np.concatenate(numbers) if len(numbers) > 2 else None
    return Surface(np.concatenate(places), np.concatenate(corners), spacing, unit, numbers=of)


def join_surfaces(bodies: Sequence[tuple[int, Surface]], spacing: Sides, unit: str | None) -> Surface:
    """Join the surfaces of objects, each with its number, into one."""
    firsts = np.cumsum([0, *(len(body.vertices) for _, body in bodies)])
    return Surface(
        np.concatenate([body.vertices for _, body in bodies]),
        np.concatenate([body.faces + first for (_, body), first in zip(bodies, firsts, strict=False)]),
        spacing,
        unit,
        numbers=np.concatenate([np.full(len(body.faces), number) for number, body in bodies]),
    )


def slice_surface(surface: Surface, axis: int, index: int) -> tuple[Contour, ...]:
    """Cut a surface by a slice of the volume: closed contours, and open ones where the surface has a rim."""
    heights = surface.vertices[:, axis] - index
    above = heights >= 0.0  # a vertex in the slice lies on one side, so that each triangle is cut once or never
    corners = above[surface.faces]
    faces = surface.faces[corners.any(axis=1) & ~corners.all(axis=1)]
    if not len(faces):
        return ()
    sides = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    ends = sides[above[sides[:, 0]] != above[sides[:, 1]]]  # two of each triangle, one after the other
    edges, numbers = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    first, last = heights[edges].T
    share = (first / (first - last))[:, None]
    places = surface.vertices[edges[:, 0]] * (1.0 - share) + surface.vertices[edges[:, 1]] * share
    return Graph(np.delete(places, axis, axis=1), numbers.reshape(-1, 2)).extract_contours()
