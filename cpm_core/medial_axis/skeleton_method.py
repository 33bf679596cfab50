"""The method that finds skeletons, in three steps that a run can show: boundary, medial axis, pruning."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cpm_core.contours.contour import Contour
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.image import Image, as_image, as_plane
from cpm_core.image.regions import Regions
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.medial_axis.boundary import outlined_boundary
from cpm_core.medial_axis.medial_axis import Axis, medial_axis
from cpm_core.medial_axis.outlines import inside_outlines, outlines_of
from cpm_core.medial_axis.polarity import DARK
from cpm_core.medial_axis.skeleton import Skeleton, branches
from cpm_core.medial_axis.structure import Structure, find_structure, with_axis
from cpm_core.model.image_fields import ImageFields
from cpm_core.model.starts import inside_image
from cpm_core.model.state import Particles
from cpm_core.numerics.types import Array
from cpm_core.parameters import OF_CHARGES, OF_STARTS, PRESETS, Parameters, invalidating
from cpm_core.parameters.provenance import Provenance, taken
from cpm_core.parameters.quotation import described, sized

Within = Sequence[Contour] | ArrayLike
"""What a skeleton can be of: closed outlines, or a mask, shape (H, W)."""


@dataclass(frozen=True, eq=False, slots=True)
class SkeletonState:
    """A moment of a run of the skeleton: what it is of, axis and branches as far as they have been found.

    Attributes
    ----------
    step : int
        Number of steps; three of them find a skeleton.
    steering : tuple
        `SkeletonMethod.steering` of the last step; empty before the first.
    structure : Structure or None
        The edges that count, found by the first step; with their medial axis from the second step on.
    made_of : tuple
        All that `structure` depends on, besides the image.
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
    structure: Structure | None = None
    made_of: tuple[object, ...] = ()
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
        found = self.structure
        first = len(found.boundary.points) if found is not None and found.axis is not None else 0
        return Particles.at_rest(self.position, first)

    def arrays(self) -> list[NDArray[Any]]:
        """The arrays that take up memory."""
        found = self.structure
        parts = [part for part in (found and found.boundary, found and found.axis) if part is not None]
        held = itertools.chain(*(vars(part).values() for part in parts))
        kept = [value for value in held if isinstance(value, np.ndarray)]
        return [*kept, *(contour.points for contour in self.contours), *self.radii]

    def resumed(self) -> SkeletonState:
        """The same state as one of a running run, to continue with other parameters."""
        return replace(self, stop_reason="", converged=False)


class SkeletonMethod(ImageFields):
    """Skeletons as a `Method` of three steps: the edges that count, their medial axis, and pruning.

    It needs no seeds. In regions of interest only edges and branches inside them count; barriers have no effect.

    Parameters
    ----------
    values : array_like, shape (H, W), or Image
        Image.
    parameters : Parameters, optional
        For the fields that are prepared first; by default the preset "noisy".
    regions : Regions, optional
        Regions of interest.
    within, outside
        See `cpm_core.skeleton`.

    Raises
    ------
    ValueError
        For an unusable image or value.
    """

    name: ClassVar[str] = "skeleton"
    title: ClassVar[str] = "Skeleton"
    parameters: ClassVar[tuple[str, ...]] = tuple(
        name for name in invalidating("field", "contours") if name not in (*OF_STARTS, *OF_CHARGES)
    )
    seeded: ClassVar[bool] = False
    _in_volumes: ClassVar[type[SkeletonMethod] | None] = None
    """The kind of method for volumes, once its module has been imported."""

    def __init_subclass__(cls) -> None:
        SkeletonMethod._in_volumes = cls

    def __new__(cls, values: ArrayLike | Image | None = None, *_: Any, **__: Any) -> Self:
        """A method for the image; for a volume one of another kind, with the same name and table entry."""
        kind = SkeletonMethod._in_volumes
        if cls is SkeletonMethod and kind is not None and values is not None and as_image(values).ndim == 3:
            return super().__new__(kind)  # type: ignore[return-value]
        return super().__new__(cls)

    def __init__(
        self,
        values: ArrayLike | Image,
        parameters: Parameters | None = None,
        regions: Regions | None = None,
        *,
        within: Within | None = None,
        outside: bool = False,
    ) -> None:
        interest = Regions(regions.interest) if isinstance(regions, Regions) and regions.interest else None
        super().__init__(as_plane(values), replace(parameters or PRESETS["noisy"], scales=1), interest)
        self.regions = regions
        self._outlines = None if within is None else outlines_of(within, self.image.shape)
        self._outside = outside

    @classmethod
    def steering(cls, parameters: Parameters) -> tuple[object, ...]:
        """Values that a step depends on; see `Method.steering`."""
        return tuple(getattr(parameters, name) for name in cls.parameters)

    def suits(self, parameters: Parameters) -> bool:
        """Always true: the method works on the image at full size."""
        return True

    def with_regions(self, regions: AnyRegions | None) -> Self:
        """The same method with other regions of interest."""
        interest = Regions(regions.interest) if isinstance(regions, Regions) and regions.interest else None
        other = super().with_regions(interest)
        other.regions = regions
        return other

    def of_outlines(self, outlines: Sequence[Contour] | None) -> Self:
        """The same method for the skeletons of some outlines, or of what it finds in the image if there are none."""
        other = copy(self)
        other._outlines = None if outlines is None else outlines_of(outlines, self.image.shape)
        return other

    def start(self, seeds: ArrayLike = ()) -> SkeletonState:
        """First state of a run; seeds have no effect."""
        return SkeletonState()

    def step(self, state: SkeletonState, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> SkeletonState:
        """Find the boundary, then its medial axis, then the branches that remain after pruning.

        Values that differ from those of the last step start again with the boundary, but for the pruning, which starts
        with the third step. Charges have no effect. The state of a run that has stopped is returned unchanged.
        """
        if state.stop_reason:
            return state
        made_of = (*self.steering(replace(parameters, pruning=0.0)), self.regions and self.regions.interest,
                   self._outlines)  # fmt: skip
        state = replace(state, step=state.step + 1, steering=self.steering(parameters))
        if state.structure is None or state.made_of != made_of:
            found = self._structure(parameters)
            return replace(state, made_of=made_of, structure=found, points=self._inside(found.boundary.points))
        if state.structure.axis is None:
            found, axis = self._with_axis(state.structure, parameters)
            return replace(state, structure=found, points=self._inside(axis.points[np.unique(axis.edges)]))
        return self._with_branches(state, state.structure, state.structure.axis, parameters.pruning)

    def result(self, state: SkeletonState, parameters: Parameters) -> Skeleton:
        """The skeleton of a state; without branches until the first is found."""
        image, found = self.image, state.structure
        polarity, width = (found.polarity, found.width) if found is not None else (0, 0.0)
        place = image.shape, image.spacing, image.unit, image.source
        made = Provenance(
            self.name, taken(parameters, self.parameters), sha256=image.sha256, of_file=bool(image.file_sha256)
        )
        channel = image.channel(parameters.channel)
        return Skeleton(state.contours, state.radii, *place, polarity, width, channel, made, image.geometry, image)

    def measures(self, state: SkeletonState, parameters: Parameters, thorough: bool = False) -> Mapping[str, float]:
        """Metrics of a state by name; see `Method.measures`."""
        length = sum(contour.length for contour in state.contours)
        return {"count": state.count, "scale": 0.0, "branches": len(state.contours), "length": length}

    def positions(self, state: SkeletonState) -> Array:
        """Points of the next step, shape (N, 2) [px]."""
        return state.position

    def _inside(self, points: Array) -> Array:
        """Those of points that lie in the image; boundary and axis continue beyond it."""
        return points[inside_image(points, self.image.shape)]

    def _structure(self, parameters: Parameters) -> Structure:
        """The edges that count."""
        if self._outlines is None:
            return find_structure(self.scale_field, parameters)
        boundary = outlined_boundary(self._outlines, self.scale_field(parameters))
        return Structure(boundary, 0.0, 0, parameters.max_width)

    def _with_axis(self, found: Structure, parameters: Parameters) -> tuple[Structure, Axis]:
        """What the skeleton is of with its medial axis, and this axis."""
        if self._outlines is not None or self._outside:
            axis = medial_axis(found.boundary, self.image.shape)
            if self._outlines is not None:
                middle = axis.points[axis.edges].mean(axis=1)
                continued = middle.clip(0.0, np.array(self.image.shape) - 1.0)  # objects continue beyond the border
                axis = axis.chosen(inside_outlines(self._outlines, continued))
        else:
            found = with_axis(found, self.image.gray(parameters.channel), parameters)
            axis = found.axis or medial_axis(found.boundary, self.image.shape)
        if self.regions is not None:
            axis = axis.chosen(np.asarray(self.regions.contains(axis.points)[axis.edges].all(axis=1)))
        return replace(found, axis=axis), axis

    def _with_branches(self, state: SkeletonState, found: Structure, axis: Axis, pruning: float) -> SkeletonState:
        """The last state, with the branches."""
        rest = found.pruned(axis, pruning, self.image.shape)
        drawn = branches(rest, found.boundary, found.smoothing)
        drawn.sort(key=lambda branch: -branch[0].length)
        contours, radii = tuple(contour for contour, _ in drawn), tuple(radii for _, radii in drawn)
        reason = "the skeleton is found" if contours else _nothing(found)
        return replace(state, contours=contours, radii=radii, stop_reason=reason, converged=bool(contours))

    def __repr__(self) -> str:
        return described("SkeletonMethod", self.image.source, sized(self.image.shape, ""))


def _nothing(found: Structure) -> str:
    """Why there is no skeleton."""
    if found.width:
        kind = "" if not found.polarity else "dark " if found.polarity == DARK else "light "
        return f"nothing {kind}up to {found.width:g} px wide is found; raise the width or lower the edge floor"
    return "no edge encloses anything; smooth less or lower the edge floor"


def plane_skeleton(
    values: ArrayLike | Image,
    parameters: Parameters | None = None,
    *,
    within: Within | None = None,
    outside: bool = False,
) -> Skeleton:
    """The skeleton of the objects in an image, shape (H, W): all three steps; see `cpm_core.skeleton`."""
    chosen = parameters or PRESETS["noisy"]
    method = SkeletonMethod(values, chosen, within=within, outside=outside)
    state = method.start()
    while not state.stop_reason:
        state = method.step(state, chosen)
    return method.result(state, chosen)
