"""Rasterization of contours: the label mask, and the pixels inside contours."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.contour import Contour
from cpm_core.contours.measurements import assign_labels, containment
from cpm_core.numerics.polyline import repeat_indices
from cpm_core.numerics.types import Array, Extent, Mask
from cpm_core.parameters.formatting import quote_value

Labels = NDArray[np.unsignedinteger]

MAX_UINT16_LABELS = 65535
"""Largest number of labels that 16 bits can hold."""

_ON_EDGE_DISTANCE = 1e-9
"""Distance from an edge up to which a pixel lies on it [px]."""


def rasterize_labels(contours: Sequence[Contour], shape: Extent) -> Labels:
    """Fill the inside of each closed contour with its label.

    A pixel is inside when its center is. Contours are filled from the largest to the smallest, so one inside another
    keeps its own label: an object in an object, and likewise a hole, which a measurement can then leave out or
    subtract. The holes of selected objects have the label 0, unless another object lies in them. Open contours
    enclose nothing.

    Parameters
    ----------
    contours : sequence of Contour
        Contours in px of the image.
    shape : tuple of int
        Shape of the image, (rows, columns).

    Returns
    -------
    ndarray of uint16 or uint32, shape `shape`
        Labels, 0 outside every contour; 32 bits above 65535.
    """
    check_plane_shape(shape)
    labels = assign_labels(contours)
    mask = np.zeros(shape, label_type(max(labels, default=0)))
    of_group = {contour.group: label for contour, label in zip(contours, labels, strict=True) if label}
    closed = [(contour, label) for contour, label in zip(contours, labels, strict=True) if contour.closed]
    closed.sort(key=lambda pair: -pair[0].area)
    for index, row, first, end in _scan_rows([contour.points for contour, _ in closed], shape):
        contour, label = closed[index]
        pixels = mask[row, first:end]
        if contour.hole:  # other objects may be there already
            pixels[pixels == of_group.get(contour.group, 0)] = 0
        else:
            pixels[:] = label
    return mask


def fill_polygon(points: Array, shape: Extent) -> Mask:
    """Find the pixels, shape `shape`, whose centers lie inside a polygon, shape (K, 2), or on its edges."""
    mask = np.zeros(shape, bool)
    for _, row, first, end in _scan_rows([points], shape):
        mask[row, first:end] = True
    return mask


def _scan_rows(polygons: Sequence[Array], shape: Extent) -> Iterable[list[int]]:
    """Find the pixels inside polygons or on their edges, as runs: the polygon, in order, row, first column and end."""
    if not polygons:
        return []
    index = repeat_indices([len(points) for points in polygons])
    row, col = np.concatenate(polygons).T
    below, right = np.concatenate([np.roll(points, -1, axis=0) for points in polygons]).T
    low, high = np.clip([np.minimum(row, below), np.maximum(row, below)], -1, shape[0])
    places = []
    # first pass: an edge crosses its first row but not its last one; second pass: vice versa; pixels off edges agree
    for side, (begin, end) in enumerate(((np.ceil(low), np.ceil(high)), (np.floor(low) + 1, np.floor(high) + 1))):
        count = (end - begin).astype(int)
        edge = repeat_indices(count)
        line = begin[edge] + np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count)
        slope = (right[edge] - col[edge]) / (below[edge] - row[edge])
        places.append([index[edge], np.full(len(edge), side), line, col[edge] + slope * (line - row[edge])])
    crossed = np.concatenate(places, axis=1)
    crossed = crossed[:, (crossed[2] >= 0) & (crossed[2] < shape[0])]
    crossed = crossed[:, np.lexsort(crossed[::-1])]
    ends = np.clip(
        [np.ceil(crossed[3, ::2] - _ON_EDGE_DISTANCE), np.floor(crossed[3, 1::2] + _ON_EDGE_DISTANCE) + 1], 0, shape[1]
    )
    return np.stack([crossed[0, ::2], crossed[2, ::2], *ends], axis=1).astype(int).tolist()


def check_plane_shape(shape: Sequence[int]) -> None:
    """Raise ValueError unless a shape has rows and columns: filling polygons would read memory beyond any other."""
    if len(shape) != 2:
        raise ValueError(f"shape of image is {quote_value(shape)} but must be rows and columns.")


def label_type(count: int) -> type[np.unsignedinteger]:
    """Return the smallest type for this number of labels."""
    return np.uint16 if count <= MAX_UINT16_LABELS else np.uint32


def rasterize_mask(contours: Sequence[Contour], shape: Extent, *, holes: bool = True) -> Mask:
    """Find the pixels inside closed contours.

    Parameters
    ----------
    contours : sequence of Contour
        Contours in px of the image.
    shape : tuple of int
        Shape of the image.
    holes : bool
        Whether a contour inside another is a hole, and a contour inside a hole another object.

    Returns
    -------
    ndarray of bool, shape `shape`
        True where the center of a pixel is inside.
    """
    alone = [replace(contour, group=0, hole=False) for contour in contours]
    labels = rasterize_labels(alone, shape)
    if not holes:
        return labels > 0
    around = containment(contours)
    solid = [False]
    for index, contour in enumerate(contours):
        if contour.closed:
            depth, outer = 0, around[index]
            while outer is not None:
                depth, outer = depth + 1, around[outer]
            solid.append(depth % 2 == 0)
    return np.array(solid)[labels]
