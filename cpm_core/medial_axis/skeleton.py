"""Skeletons: the center lines of objects, with the distance to the boundary at every vertex (section 5.3).

Section 5.3 uses local minima of the field, or the particles that a second field of such charges attracts. This program
does not: the minima of the exact field (95 percent of them in 5 x 5 pixels) are isolated positions and the boundary of
the object; on an ellipse of half axes 70 and 30 px they come within 2 px of only 6 % of the medial axis. The divergence
of the unit field has a clear ridge, but it is not on the medial axis where the two sides differ in length, curvature or
strength: in a ring of radii 20 and 80 px it is off by 3 px, in the arms of an L by up to 13 px. A disk there touches
only one side, and no shape can be rebuilt from such disks.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cpm_core.contours.contour import Contour
from cpm_core.contours.graph import Graph
from cpm_core.field.image_fields import ImageFields
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.image import Image
from cpm_core.image.regions import Regions
from cpm_core.medial_axis.blur_correction import half_width
from cpm_core.medial_axis.boundary import Boundary, find_boundary
from cpm_core.medial_axis.disks import along, covered
from cpm_core.medial_axis.foreground import within_objects
from cpm_core.medial_axis.medial_axis import Axis, medial_axis
from cpm_core.medial_axis.pruning import prune
from cpm_core.numerics.types import Array
from cpm_core.parameters import PRESETS, Parameters, invalidating
from cpm_core.particles.initialization import inside_image
from cpm_core.particles.state import Particles

PRUNING = 1.0
"""Default of `pruning`: how far the shape may extend beyond the one that the skeleton represents [px]."""


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Center lines of the objects in an image.

    Attributes
    ----------
    contours : tuple of Contour
        The branches, longest first, in px of the image. They end in tips or, where three or more meet, in junctions;
        a closed one encloses a hole. An object without a direction, such as a disk, has a branch of one vertex.
        Their `strength` is the mean edge strength of the boundary on both sides [gray levels / px].
    radii : tuple of ndarray of float64, shape (K,)
        For every branch the distance from each of its vertices to the boundary [px].
    shape : tuple of int
        Shape of the image.
    spacing : tuple of float
        Size of a pixel along each axis, in `unit`.
    unit : str or None
        Unit of `spacing`; None when the image gives none.
    source : str
        Name of the image for the user.
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
        """The shape that the skeleton represents: the disks around its vertices, and those between two vertices.

        Returns
        -------
        ndarray of bool, shape `shape`
            True where the center of a pixel lies in one of the disks.
        """
        disks = [np.zeros((0, 3))]
        for contour, radii in zip(self.contours, self.radii, strict=True):
            disks.append(along(contour.path, np.append(radii, radii[0]) if contour.closed else radii))
        return covered(np.concatenate(disks), self.shape)


@dataclass(frozen=True, eq=False, slots=True)
class SkeletonState:
    """A moment of a run of the skeleton: boundary, axis and branches as far as they have been found.

    Attributes
    ----------
    step : int
        Number of steps; three of them find a skeleton.
    steering : tuple
        `SkeletonMethod.steering` of the last step; empty before the first.
    boundary : Boundary or None
        The edges, found by the first step.
    axis : Axis or None
        Their medial axis before it is pruned, found by the second step.
    points : ndarray, shape (N, 2)
        Points that the next step works on, as far as they lie in the image [px].
    contours, radii : tuple
        Branches and their radii, found by the third step; until then those of the previous parameters.
    stop_reason : str
        Why the run ended, in words; empty while it goes on.
    converged : bool
        Whether it ended with a skeleton.
    """

    step: int = 0
    steering: tuple[object, ...] = ()
    boundary: Boundary | None = None
    axis: Axis | None = None
    points: Array = field(default_factory=lambda: np.zeros((0, 2)))
    contours: tuple[Contour, ...] = ()
    radii: tuple[Array, ...] = ()
    stop_reason: str = ""
    converged: bool = False

    @property
    def scale(self) -> int:
        """Scale of the image pyramid: always the image itself."""
        return 0

    @property
    def count(self) -> int:
        """Number of points that the next step works on."""
        return len(self.position)

    @property
    def position(self) -> Array:
        """Points of the next step, shape (N, 2) [px]: of the boundary, then of the axis, none at the end."""
        return np.zeros((0, 2)) if self.stop_reason else self.points

    @property
    def particles(self) -> Particles:
        """The points as particles at rest; those of the axis have other identities than those of the boundary."""
        first = 0 if self.axis is None or self.boundary is None else len(self.boundary.points)
        return Particles.at_rest(self.position, first)

    def arrays(self) -> list[NDArray[Any]]:
        """The arrays that take up memory."""
        parts = [vars(part).values() for part in (self.boundary, self.axis) if part is not None]
        return [*itertools.chain(*parts), *(contour.points for contour in self.contours), *self.radii]

    def resumed(self) -> SkeletonState:
        """The same state as one of a running run, to continue with other parameters."""
        return replace(self, stop_reason="", converged=False)


class SkeletonMethod(ImageFields):
    """The skeleton of the objects in an image: a `Method` of three steps for boundary, medial axis and pruning.

    It needs no seeds and always uses the whole image, independent of the regions of interest.

    Parameters
    ----------
    values : array_like, shape (H, W), or Image
        Image.
    parameters : Parameters, optional
        For the fields that are prepared first; by default the preset "noisy".
    regions : Regions, optional
        Without effect.
    pruning, outside
        See `skeleton`.

    Raises
    ------
    ValueError
        For an unusable image or value.
    """

    name: ClassVar[str] = "skeleton"
    title: ClassVar[str] = "Skeleton"
    parameters: ClassVar[tuple[str, ...]] = ("d_min", *invalidating("field", "contours"))
    seeded: ClassVar[bool] = False

    def __init__(
        self,
        values: ArrayLike | Image,
        parameters: Parameters | None = None,
        regions: Regions | None = None,
        *,
        pruning: float = PRUNING,
        outside: bool = False,
    ) -> None:
        if not (math.isfinite(pruning) and pruning >= 0.0):
            raise ValueError(f"pruning is {pruning:g} but must be a number of pixels, 0 or more.")
        super().__init__(values, replace(parameters or PRESETS["noisy"], scales=1))
        self.regions = regions
        self._pruning, self._outside = pruning, outside

    @classmethod
    def steering(cls, parameters: Parameters) -> tuple[object, ...]:
        """Values that a step depends on; see `Method.steering`."""
        return tuple(getattr(parameters, name) for name in cls.parameters)

    def suits(self, parameters: Parameters) -> bool:
        """Always true: the method works on the image at full size."""
        return True

    def with_regions(self, regions: Regions | None) -> Self:
        """The same method; regions have no effect."""
        other = copy(self)
        other.regions = regions
        return other

    def start(self, seeds: ArrayLike = ()) -> SkeletonState:
        """First state of a run; seeds have no effect."""
        return SkeletonState()

    def step(self, state: SkeletonState, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> SkeletonState:
        """Find the boundary, then its medial axis, then the branches that remain after pruning.

        Parameter values that differ from those of the last step start again with the boundary; charges have no effect.
        The state of a run that has stopped is returned unchanged.
        """
        if state.stop_reason:
            return state
        steering, scale_field = self.steering(parameters), self.scale_field(parameters)
        state = replace(state, step=state.step + 1)
        if state.boundary is None or state.steering != steering:
            boundary = find_boundary(scale_field, parameters)
            return replace(state, steering=steering, boundary=boundary, axis=None, points=boundary.points)
        if state.axis is None:
            axis = self._axis(state.boundary, scale_field.smoothing)
            points = axis.points[np.unique(axis.edges)]
            return replace(state, axis=axis, points=points[inside_image(points, self.image.shape)])
        low, high = np.full(2, -0.5), np.array(self.image.shape) - 0.5
        axis = prune(state.axis, self._pruning).within(low, high)
        branches = _branches(axis, state.boundary, scale_field.smoothing)
        branches.sort(key=lambda branch: -branch[0].length)
        contours, radii = tuple(contour for contour, _ in branches), tuple(radii for _, radii in branches)
        reason = (
            "the skeleton is found" if contours else "no edge encloses anything; smooth less or lower the edge floor"
        )
        return replace(state, contours=contours, radii=radii, stop_reason=reason, converged=bool(contours))

    def result(self, state: SkeletonState, parameters: Parameters) -> Skeleton:
        """The skeleton of a state; without branches until the first is found."""
        image = self.image
        return Skeleton(state.contours, state.radii, image.shape, image.spacing, image.unit, image.source)

    def measures(self, state: SkeletonState, parameters: Parameters, thorough: bool = False) -> Mapping[str, float]:
        """Metrics of a state by name; see `Method.measures`."""
        length = sum(contour.length for contour in state.contours)
        return {"count": state.count, "scale": 0.0, "branches": len(state.contours), "length": length}

    def positions(self, state: SkeletonState) -> Array:
        """Points of the next step, shape (N, 2) [px]."""
        return state.position

    def _axis(self, boundary: Boundary, smoothing: float) -> Axis:
        """Medial axis of a boundary, only in objects unless the background is included."""
        axis = medial_axis(boundary, self.image.shape)
        if self._outside:
            return axis
        return axis.only(axis.edges[within_objects(axis, boundary, self.image.values, smoothing)])


def skeleton(
    values: ArrayLike | Image,
    params: Parameters | None = None,
    *,
    pruning: float = PRUNING,
    outside: bool = False,
) -> Skeleton:
    """Find the skeleton of the objects in a binary or gray image, from which they can be rebuilt.

    The skeleton is the medial axis: the positions with more than one nearest point on the boundary. The boundary is the
    ridge of the edge map, found with the subpixel accuracy of the contours of a run. Contours come from the Delaunay
    triangulation of points on the boundary, by the crust; the edges of its dual, the Voronoi diagram, that do not cross
    a contour are the medial axis (`cpm_core.medial_axis`). It is then shortened from its tips (`pruning`).

    Parameters
    ----------
    values : array_like, shape (H, W), or Image
        Image. Objects are regions within edges that differ from the image border in gray level, brighter or darker; in
        a gray image an object may lie in another. The image border is no edge: an object continues beyond it, and
        one whose center line lies outside has no skeleton in the image.
    params : Parameters, optional
        For `smoothing`, `edge_floor`, `min_strength` and `min_length`, which define the edges; by default the preset
        "noisy", which chooses the smoothing from the image's noise.
    pruning : float, optional
        How far a part of the shape may extend beyond the disks of the rest for its branch to be left out [px]. A larger
        value leaves fewer and shorter branches, and a rounder shape; connected parts stay connected. At the default of
        one pixel neither the steps of a binary image nor moderate noise cause short branches (at 0.25 they do).
    outside : bool, optional
        Whether to include the skeleton of the background.

    Returns
    -------
    Skeleton
        Branches with radii; without any branch if no edge encloses anything.

    Raises
    ------
    ValueError
        For an unusable image or value; the message says what to do.
    """
    chosen = params or PRESETS["noisy"]
    method = SkeletonMethod(values, chosen, pruning=pruning, outside=outside)
    state = method.start()
    while not state.stop_reason:
        state = method.step(state, chosen)
    return method.result(state, chosen)


def _branches(axis: Axis, boundary: Boundary, smoothing: float) -> list[tuple[Contour, Array]]:
    """Branches of an axis, and their radii."""
    graph = Graph(axis.points, axis.edges)
    ways = graph.ways()
    paths = [(ways.path(n), bool(ways.closed[n])) for n in range(len(ways))]
    points = [(np.array([v]), False) for v in np.flatnonzero(graph.degrees == 0)]
    found = []
    for path, closed in [*paths, *points]:
        forks = (False, False) if closed else (graph.degree(path[0]) > 2, graph.degree(path[-1]) > 2)
        strength = float(boundary.strength[axis.nearest[path]].mean())
        contour = Contour(axis.points[path], closed, strength, junctions=forks)
        found.append((contour, half_width(axis.radius[path], smoothing)))
    return found
