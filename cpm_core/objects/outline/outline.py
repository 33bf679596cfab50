"""Outline of an object: its closed boundary, to a fraction of a pixel, and the stretches that follow no contour."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.field.interpolation import interpolate
from cpm_core.field.region_contrast import Sides
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Mask
from cpm_core.objects.faces.faces import Ground
from cpm_core.objects.outline.outline_tracing import FREE, ON_BORDER, STEPS, placed, trace

SMOOTHING = 1.0
"""Sigma of the edge map of objects [px]."""

_SHORT = 2.0
"""Length up to which a stretch off the contours is no gap [px]."""


@dataclass(frozen=True, eq=False)
class Outline:
    """A closed boundary.

    Attributes
    ----------
    contour : Contour
        The boundary.
    bridged : ndarray of bool, shape (K,)
        Whether the side from each vertex to the next one follows no contour.
    bordering : ndarray of bool, shape (K,)
        Whether it lies on the border of the image or of a region of interest.
    """

    contour: Contour
    bridged: Mask
    bordering: Mask

    @property
    def lengths(self) -> Array:
        """Length of each side, shape (K,) [px]."""
        return np.asarray(np.linalg.norm(np.diff(self.contour.path, axis=0), axis=1))

    @property
    def gaps(self) -> tuple[Array, ...]:
        """Stretches that follow no contour, each of shape (K, 2)."""
        path, bridged = self.contour.path, self.bridged
        if bridged.all():
            return (path,)
        start = int(np.argmin(bridged))
        path = np.concatenate([path[start:-1], path[: start + 1]])
        steps = np.flatnonzero(np.diff(np.roll(bridged, -start).astype(int), prepend=0, append=0))
        stretches = (path[begin : end + 1] for begin, end in steps.reshape(-1, 2).tolist())
        return tuple(stretch for stretch in stretches if polyline.length(stretch) > _SHORT)


def outlines(mask: Mask, ground: Ground) -> tuple[Outline, ...]:
    """Closed boundaries of the true pixels of a mask, shape (H, W), the longest first."""
    steps = trace(mask)
    points, kind = placed(steps, ground.lines, ground.strength, ground.strong)
    limit = np.array(mask.shape)[:, None] - 1
    found = []
    for begin, end in zip(steps.begin[:-1].tolist(), steps.begin[1:].tolist(), strict=True):
        part = slice(begin, end)
        row, col, way = steps.row[part], steps.col[part], steps.way[part]
        beyond = np.clip(np.stack([row + STEPS[0][way], col + STEPS[1][way]]), 0, limit)
        bordering = (kind[part] == ON_BORDER) | ~ground.interest[beyond[0], beyond[1]]
        free = (kind[part] == FREE) & ~ground.near[row, col] & ~bordering
        vertices = points[part]
        edge = kind[part] == ON_BORDER
        corner = edge & np.roll(edge, -1) & (way != np.roll(way, -1))
        if corner.any():  # an object in the corner of the image has a corner
            pixel = np.stack([row, col], axis=1)
            places = vertices + np.roll(vertices, -1, axis=0) - pixel
            after = np.flatnonzero(corner) + 1
            vertices = np.insert(vertices, after, places[corner], axis=0)
            free, bordering = np.insert(free, after, False), np.insert(bordering, after, True)
        found.append(_outline(vertices, free, bordering, ground))
    return tuple(sorted(found, key=lambda outline: -outline.contour.length))


def _outline(points: Array, free: Mask, bordering: Mask, ground: Ground) -> Outline:
    path = np.concatenate([points, points[:1]])
    lengths = np.linalg.norm(np.diff(path, axis=0), axis=1)
    middle = 0.5 * (path[1:] + path[:-1])
    strength = float(interpolate(ground.strength[None], middle)[:, 0] @ lengths / lengths.sum())
    along = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    sides = Sides(ground.values, points, along[:, ::-1] * (-1.0, 1.0), SMOOTHING)
    bridged = free & np.roll(free, -1)
    row, col = points.T
    hole = float(col @ np.roll(row, -1) - np.roll(col, -1) @ row) < 0.0  # the pixels are on the right hand
    contour = Contour(points, True, strength, sides=sides, hole=hole)
    found = Outline(contour, bridged, bordering & np.roll(bordering, -1))
    return replace(found, contour=replace(contour, bridged=sum(map(polyline.length, found.gaps))))
