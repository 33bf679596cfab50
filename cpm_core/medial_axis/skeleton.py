"""Skeletons: the middle lines of objects, with the distance to the boundary at every place (section 5.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cpm_core.contours.contour import Contour
from cpm_core.contours.graph import Graph
from cpm_core.image.image import Image
from cpm_core.medial_axis import (
    Axis,
    Boundary,
    along,
    covered,
    find_boundary,
    half_width,
    medial_axis,
    prune,
    within_objects,
)
from cpm_core.numerics.types import Array
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.segmentation.engine import Engine

PRUNING = 1.0
"""How far the shape may reach beyond what the skeleton stands for, unless told otherwise [px]."""


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Middle lines of the objects in an image.

    Attributes
    ----------
    contours : tuple of Contour
        The branches, longest first, in px of the image. They end in tips or, where three or more meet, in junctions;
        a closed one goes round a hole. An object without a direction, such as a disk, has a branch of one vertex.
        Their `strength` is the mean edge strength of the boundary on both sides [grey levels / px].
    radii : tuple of ndarray of float64, shape (K,)
        For every branch the distance from each of its vertices to the boundary [px].
    shape : tuple of int
        Shape of the image.
    spacing : tuple of float
        Size of a pixel along each axis, in `unit`.
    unit : str or None
        Unit of `spacing`; None when the image tells none.
    source : str
        Name of the image, for people.
    """

    contours: tuple[Contour, ...]
    radii: tuple[Array, ...]
    shape: tuple[int, ...]
    spacing: tuple[float, ...]
    unit: str | None
    source: str

    @property
    def length(self) -> float:
        """Length of all branches together [px]."""
        return sum(contour.length for contour in self.contours)

    def rebuilt(self) -> NDArray[np.bool_]:
        """The shape that the skeleton stands for: the disks around its vertices, and those between two vertices.

        Returns
        -------
        ndarray of bool, shape `shape`
            True where the centre of a pixel lies in one of the disks.
        """
        disks = [np.zeros((0, 3))]
        for contour, radii in zip(self.contours, self.radii, strict=True):
            disks.append(along(contour.path, np.append(radii, radii[0]) if contour.closed else radii))
        return covered(np.concatenate(disks), self.shape)


def skeleton(
    values: ArrayLike | Image,
    params: Parameters | None = None,
    *,
    pruning: float = PRUNING,
    outside: bool = False,
) -> Skeleton:
    """Find the skeleton of the objects in a binary or grey image, from which they can be rebuilt.

    The skeleton is the medial axis: the places with more than one nearest point on the boundary, which is the crest of
    the edge map, found to a fraction of a pixel as the contours of a run are. Contours come from the Delaunay
    triangulation of points on the boundary, by the crust; the edges of its dual, the Voronoi diagram, that do not cross
    a contour are the medial axis (`cpm_core.medial_axis`). It is then cut back from its tips (`pruning`).

    Section 5.3 takes local minima of the field, or what a second field of such charges attracts. That is not done here,
    for the minima of the exact field (of 95 percent in 5 x 5 pixels) are isolated places and the rim of the object: on
    an ellipse of half axes 70 and 30 px they come within 2 px of 6 % of the medial axis. The divergence of the unit
    field is a clean ridge, but not on the medial axis where the two sides differ in length, curvature or strength: in a
    ring of radii 20 and 80 px it runs 3 px beside it, in the arms of an L up to 13 px. A disk there touches one
    side only, and no shape can be rebuilt from such disks.

    Parameters
    ----------
    values : array_like, shape (H, W), or Image
        Image. Objects are what differs from its border in grey level, brighter or darker, within edges; in a grey image
        an object may lie in another. The border of the image is no edge: an object goes on beyond it, and one whose
        middle lies out there has no skeleton in the image.
    params : Parameters, optional
        For `smoothing`, `edge_floor`, `min_strength` and `min_length`, which say what is an edge; by default the preset
        "noisy", which chooses the smoothing from the image's noise.
    pruning : float, optional
        How far a part of the shape may stick out of the disks of the rest for its branch to be left out [px]. More of
        it leaves fewer and shorter branches, and a rounder shape. What hangs together stays together. At the default
        of a pixel neither the stairs of a black and white image nor moderate noise leave twigs (at a quarter they do).
    outside : bool, optional
        Whether to give the skeleton of the background, too.

    Returns
    -------
    Skeleton
        Branches with radii; without any branch if no edge encloses anything.

    Raises
    ------
    ValueError
        For an image or a value that cannot be worked with; the message says what to do.
    """
    if not (math.isfinite(pruning) and pruning >= 0.0):
        raise ValueError(f"pruning is {pruning:g} but must be a number of pixels, 0 or more.")
    chosen = replace(params or PRESETS["noisy"], scales=1)
    engine = Engine(values, chosen)
    image, scale_field = engine.image, engine.scale_field(chosen)
    boundary = find_boundary(scale_field, chosen)
    axis = medial_axis(boundary, image.shape)
    if not outside:
        axis = axis.only(axis.edges[within_objects(axis, boundary, image.values, scale_field.smoothing)])
    low, high = np.full(2, -0.5), np.array(image.shape) - 0.5
    axis = prune(axis, pruning).within(low, high)
    branches = sorted(_branches(axis, boundary, scale_field.smoothing), key=lambda branch: -branch[0].length)
    return Skeleton(
        contours=tuple(contour for contour, _ in branches),
        radii=tuple(radii for _, radii in branches),
        shape=image.shape,
        spacing=image.spacing,
        unit=image.unit,
        source=image.source,
    )


def _branches(axis: Axis, boundary: Boundary, smoothing: float) -> list[tuple[Contour, Array]]:
    """Branches of an axis, and their radii."""
    graph = Graph(axis.points, axis.edges)
    ways = graph.ways()
    walks = [(ways.path(n), bool(ways.closed[n])) for n in range(len(ways))]
    points = [(np.array([v]), False) for v in np.flatnonzero(graph.degrees == 0)]
    found = []
    for path, closed in [*walks, *points]:
        forks = (False, False) if closed else (graph.degree(path[0]) > 2, graph.degree(path[-1]) > 2)
        strength = float(boundary.strength[axis.nearest[path]].mean())
        contour = Contour(axis.points[path], closed, strength, junctions=forks)
        found.append((contour, half_width(axis.radius[path], smoothing)))
    return found
