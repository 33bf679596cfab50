"""The partition of an image into faces, and the choice of an object among them by clicks.

Contours, closed and open, and the ridges of the edge map between them cut the image into faces (`faces`). An object is
a set of faces. Its boundary is the cheapest closed one (`boundary`, `minimum_cut`) between what has been said to be
inside and what to be outside, and what the gray levels say (`evidence`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import ArrayLike

from cpm_core.contours.contour import Contour
from cpm_core.contours.result import Result
from cpm_core.field.edge_map import background_strength, edge_map
from cpm_core.image.image import Image, as_plane
from cpm_core.image.regions import Regions
from cpm_core.numerics.segments import SegmentTree
from cpm_core.numerics.types import Array, Mask
from cpm_core.objects.boundary import STRONG_PERCENTILE, prices
from cpm_core.objects.evidence import evidence
from cpm_core.objects.face_graph import FaceGraph, face_graph
from cpm_core.objects.faces import Labels, barrier_walls, basins, walls
from cpm_core.objects.minimum_cut import minimum_cut
from cpm_core.objects.outline import gaps_of, outlines
from cpm_core.objects.selection import Selection
from cpm_core.parameters import Parameters
from cpm_core.particles.initialization import uniform_grid
from cpm_core.segmentation.segment import segment

SMOOTHING = 1.5
"""Sigma of the run from everywhere that a partition of an image makes [px]."""

_FINE = 1.0
"""Sigma of the edge map whose basins are the faces [px]."""

_RADIUS = 3.0
"""Distance from a click up to which faces are clicked [px]."""


def partition(values: ArrayLike | Image | Result, params: Parameters | None = None) -> Partition:
    """Cut an image into faces along its contours.

    Parameters
    ----------
    values : array_like, shape (H, W), or Image, or Result
        An image, in which a run from everywhere finds the contours, or the result of a run.
    params : Parameters, optional
        Of the run on an image.

    Returns
    -------
    Partition
        To select objects from.

    Raises
    ------
    ValueError
        For an unusable image, or a result that does not know its image.
    """
    if not isinstance(values, Result):
        image = as_plane(values)
        grid = uniform_grid(image.shape)
        return partition(segment(image, grid, params or Parameters(smoothing=SMOOTHING)))
    if values.image is None:
        raise ValueError("the result does not know its image: make a partition of the image itself.")
    return Partition(values.image, values.contours, values.regions)


@dataclass(frozen=True, eq=False)
class Partition:
    """An image that contours cut into faces.

    Attributes
    ----------
    image : Image
        The image.
    contours : tuple of Contour
        The contours along which it is cut.
    regions : Regions or None
        Outside the regions of interest nothing is selected; barriers are boundaries.
    """

    image: Image
    contours: tuple[Contour, ...]
    regions: Regions | None = None

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the image."""
        return self.image.shape

    @cached_property
    def labels(self) -> Labels:
        """Face of every pixel, shape (H, W); -1 outside the regions of interest."""
        least = 0.1 * background_strength(self._strength)
        found = basins(self._strength, self._wall | self._barrier, least)
        if self.regions is not None and self.regions.interest:
            within = self.regions.pixels(self.shape)
            found = np.where(within, found, -1).astype(np.int32)
            found[within] = np.unique(found[within], return_inverse=True)[1]
        return found

    def select(self, inside: ArrayLike, outside: ArrayLike = (), *, previous: Selection | None = None) -> Selection:
        """Choose the object that some places lie in, and others do not.

        Parameters
        ----------
        inside, outside : array_like, shape (M, 2) and (K, 2)
            Places (row, col) [px].
        previous : Selection, optional
            What was chosen before the last place was added.

        Returns
        -------
        Selection
            The object; empty when no place is inside.
        """
        graph, shape = self._graph, self.shape
        within, beyond = _places(inside), _places(outside)
        remark = self._remark(within, beyond)
        tied, barred = self._touched(within), self._touched(beyond)
        tied &= ~barred
        chosen = np.zeros(graph.count, np.bool_)
        if tied.any():
            leaving, entering = evidence(graph, tied, barred)
            chosen = minimum_cut(graph.first, graph.second, self._prices, leaving, entering, tied, barred)
            chosen = self._filled(self._reached(chosen, tied), barred)
        mask = np.append(chosen, False)[self.labels]
        found = outlines(mask, self._strength)
        gaps = tuple(gap for outline in found for gap in gaps_of(outline, self._tree, shape))
        whole = sum(outline.length for outline in found)
        off = sum(float(np.linalg.norm(np.diff(gap, axis=0), axis=1).sum()) for gap in gaps)
        confidence = max(0.0, 1.0 - off / whole) if whole else 0.0
        return Selection(mask, found, gaps, confidence, within, beyond, remark)

    def _remark(self, inside: Array, outside: Array) -> str:
        if not len(inside):
            return "No place has been said to be inside."
        every = np.concatenate([inside, outside])
        if ((every < -0.5) | (every > np.array(self.shape) - 0.5)).any():
            return "A place outside the image counts as the nearest one in it."
        return ""

    def _touched(self, places: Array) -> Mask:
        """Faces within `_RADIUS` of places, shape (F,)."""
        touched = np.zeros(self._graph.count + 1, np.bool_)
        reach = np.arange(-int(_RADIUS), int(_RADIUS) + 1)
        disk = np.stack(np.meshgrid(reach, reach, indexing="ij"), axis=-1).reshape(-1, 2)
        disk = disk[np.linalg.norm(disk, axis=1) <= _RADIUS]
        limit = np.array(self.shape) - 1
        pixel = np.clip(np.rint(np.clip(places, 0, limit)).astype(int)[:, None] + disk, 0, limit)
        touched[self.labels[pixel[..., 0], pixel[..., 1]]] = True
        return touched[:-1]

    def _reached(self, chosen: Mask, tied: Mask) -> Mask:
        """Chosen faces that hang together with clicked ones."""
        return self._groups(chosen, tied)

    def _filled(self, chosen: Mask, barred: Mask) -> Mask:
        """Chosen faces with the holes that nobody has said to be outside."""
        return ~self._groups(~chosen, barred | (self._graph.rim > 0.0))

    def _groups(self, chosen: Mask, wanted: Mask) -> Mask:
        """Those of the chosen faces that hang together with wanted ones."""
        graph = self._graph
        both = chosen[graph.first] & chosen[graph.second]
        links = scipy.sparse.coo_array(
            (np.ones(both.sum(), np.bool_), (graph.first[both], graph.second[both])), shape=(graph.count,) * 2
        )
        _, group = scipy.sparse.csgraph.connected_components(links, directed=False)
        kept = np.zeros(graph.count, np.bool_)
        kept[group[chosen & wanted]] = True
        return np.asarray(chosen & kept[group])

    @cached_property
    def _strength(self) -> Array:
        return edge_map(self.image.values, _FINE)

    @cached_property
    def _wall(self) -> Mask:
        return walls(self.contours, self.shape)

    @cached_property
    def _barrier(self) -> Mask:
        return barrier_walls(self.regions, self.shape)

    @cached_property
    def _graph(self) -> FaceGraph:
        return face_graph(self.labels, self.image.values, self._strength, self._wall, self._barrier)

    @cached_property
    def _prices(self) -> Array:
        return prices(self._graph, float(np.percentile(self._strength, STRONG_PERCENTILE)))

    @cached_property
    def _tree(self) -> SegmentTree:
        paths = [contour.path for contour in self.contours]
        begin = np.concatenate([np.empty((0, 2)), *(path[:-1] for path in paths)])
        end = np.concatenate([np.empty((0, 2)), *(path[1:] for path in paths)])
        return SegmentTree(begin, end)


def _places(given: ArrayLike) -> Array:
    """Places, shape (N, 2); `ValueError` when they are none."""
    places = np.asarray(given, dtype=float)
    if places.size == 0:
        return np.empty((0, 2))
    places = np.atleast_2d(places)
    if places.ndim != 2 or places.shape[1] != 2 or not np.isfinite(places).all():
        raise ValueError(f"the places have the shape {places.shape} but must be (N, 2), finite rows and columns.")
    return places
