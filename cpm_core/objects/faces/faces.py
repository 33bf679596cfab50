"""Faces: the small regions that contours, barriers and the ridges of the edge map cut an image into."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
import skimage

from cpm_core.image.regions import Regions
from cpm_core.numerics.grids import running_maximum
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.objects.faces.basins import Labels, basins
from cpm_core.objects.faces.crossings import Crossings, crossings
from cpm_core.objects.faces.face_graph import FaceGraph, face_graph

STRONG_PERCENTILE = 95.0
"""Percentile of the edge map above which an edge is strong."""

_DEPTH, _AREA = 0.02, 24
"""Basins that are less deep or have fewer pixels are parts of a neighbor; see `basins`."""

_NECK, _FAR = 0.04, 24.0
"""How much higher the ground is next to a line than `_FAR` pixels from all of them, where there is no edge: the square
root of an edge strength, as a fraction of that of the largest. It parts two wide places at the neck between them, as at
a gap in an outline."""


@dataclass(frozen=True, eq=False)
class Ground:
    """What an image is cut along.

    Attributes
    ----------
    values, strength : ndarray, shape (H, W)
        Image, and its edge map.
    strong : float
        Edge strength that counts as strong.
    contours, barriers, rims : Crossings
        Where contours, barriers, and the boundary of the regions of interest pass between pixels.
    interest : ndarray of bool, shape (H, W)
        Pixels in the regions of interest.
    """

    values: Array
    strength: Array
    strong: float
    contours: Crossings
    barriers: Crossings
    rims: Crossings
    interest: Mask

    @cached_property
    def lines(self) -> Crossings:
        """Where any of these lines passes."""
        return self.contours.with_others(self.barriers).with_others(self.rims)

    @cached_property
    def beside(self) -> Mask:
        """Pixels that a contour passes next to, shape (H, W)."""
        return self.contours.pixels

    @cached_property
    def near(self) -> Mask:
        """Pixels within about 1.5 px of a line, shape (H, W)."""
        return running_maximum(self.lines.pixels, 1)


@dataclass(frozen=True, eq=False)
class Faces:
    """Faces and their graph.

    Attributes
    ----------
    labels : ndarray of int32, shape (H, W)
        Face of every pixel; -1 outside the regions of interest.
    graph : FaceGraph
        Their measures and common borders.
    """

    labels: Labels
    graph: FaceGraph

    @cached_property
    def boxes(self) -> Index:
        """First row, row behind the last, first column and column behind the last of each face, shape (F, 4)."""
        parts = scipy.ndimage.find_objects(self.labels + 1, self.graph.count)
        nowhere = slice(0, 0), slice(0, 0)
        found = [(rows.start, rows.stop, cols.start, cols.stop) for rows, cols in (part or nowhere for part in parts)]
        return np.array(found).reshape(-1, 4)


def ground(values: Array, strength: Array, contours: Sequence[Array], regions: Regions | None) -> Ground:
    """Prepare to cut an image along the paths of contours, each of shape (K, 2)."""
    regions = regions or Regions()
    shape = values.shape
    return Ground(
        values,
        strength,
        max(float(np.percentile(strength[regions.pixels(shape)], STRONG_PERCENTILE)), 1e-300),
        crossings(contours, shape),
        crossings([np.array(line) for line in regions.barriers], shape),
        crossings(list(regions.rims().reshape(-1, 2, 2)), shape),
        regions.pixels(shape),
    )


def find_faces(ground: Ground) -> Faces:
    """Cut the image into faces; see `basins`."""
    edges = ground.lines.pixels | (ground.strength > ground.strong)
    away = np.full(edges.shape, _FAR)
    if edges.any():
        away = np.minimum(scipy.ndimage.distance_transform_cdt(~edges, "chessboard"), _FAR)
    slope = _NECK * (1.0 - away / _FAR)
    largest = max(float(ground.strength.max()), 1e-300)
    level = (np.sqrt(ground.strength / largest) + slope) / (1.0 + _NECK)
    labels = basins(level, ground.lines, _DEPTH, _AREA)
    if not ground.interest.all():
        labels[~ground.interest] = -1
        labels[ground.interest] = np.unique(labels[ground.interest], return_inverse=True)[1]
    return _measured(labels, ground)


def split(faces: Faces, ground: Ground, inside: Index, outside: Index) -> Faces:
    """Cut faces that hold both kinds of places, which are whole pixels, shape (M, 2) and (K, 2).

    The border runs along the edge map, and half way between the places where that is flat. Each part with places
    `outside` is a new face.
    """
    own, other = faces.labels[tuple(inside.T)], faces.labels[tuple(outside.T)]
    both = np.intersect1d(own, other)
    both = both[both >= 0]
    if not len(both):
        return faces
    labels = faces.labels.copy()
    for new, number in enumerate(both.tolist(), start=faces.graph.count):
        top, bottom, left, right = faces.boxes[number]
        window = slice(top, bottom), slice(left, right)
        markers = np.zeros(labels.shape, np.int32)
        markers[tuple(inside[own == number].T)] = 1
        markers[tuple(outside[other == number].T)] = 2
        parts = skimage.segmentation.watershed(  # type: ignore[no-untyped-call]
            ground.strength[window], markers[window], mask=faces.labels[window] == number
        )
        labels[window][parts == 2] = new
    return _measured(labels, ground)


def _measured(labels: Labels, ground: Ground) -> Faces:
    return Faces(labels, face_graph(labels, ground.values, ground.strength, ground.contours, ground.barriers))
