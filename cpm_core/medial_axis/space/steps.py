"""Center lines in a volume as a run of three steps that can be shown: what is inside, its center lines, pruning."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from cpm_core.contours.contour import Contour
from cpm_core.contours.surface.packing import PackedSurface
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.field.volume_field import check_parameters
from cpm_core.image.image import Image, as_image
from cpm_core.image.volume_regions import AnyRegions, VolumeRegions
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.medial_axis.skeleton_method import SkeletonMethod, SkeletonState
from cpm_core.medial_axis.space.centerlines import Centerlines, centerlines
from cpm_core.medial_axis.space.volume_skeleton import OF_CENTERLINES, inside_edges
from cpm_core.model.image_fields import ImageFields
from cpm_core.model.state import Particles
from cpm_core.numerics.types import Array, Mask
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.parameters.provenance import Provenance, taken

_MOST_SHOWN = 20_000
"""Points of the boundary that are shown at most."""


@dataclass(frozen=True, eq=False)
class VolumeSkeleton(Skeleton):
    """Center lines in a volume as a run finds them; lengths and radii in smallest sides of a voxel.

    Attributes
    ----------
    lines : Centerlines
        The center lines, as files hold them.
    """

    lines: Centerlines = field(default_factory=lambda: Centerlines(()))

    @property
    def length(self) -> float:
        """Length of all branches together."""
        return float(self.lines.lengths.sum()) / min(self.spacing)


@dataclass(frozen=True, eq=False, slots=True)
class VolumeSkeletonState(SkeletonState):
    """A moment of a run: what is inside and its center lines, as far as they have been found.

    Attributes
    ----------
    inside : ndarray of bool or None
        The voxels that have center lines, found by the first step.
    unpruned, lines : Centerlines or None
        What the second step finds, and the third.
    """

    points: Array = field(default_factory=lambda: np.zeros((0, 3)))
    inside: Mask | None = None
    unpruned: Centerlines | None = None
    lines: Centerlines | None = None

    @property
    def position(self) -> Array:
        """Points of the next step, shape (N, 3) [voxels]: of the boundary, then of center lines, none at the end."""
        return np.zeros((0, 3)) if self.stop_reason else self.points

    @property
    def particles(self) -> Particles:
        """The points as particles at rest; those of center lines have other identities than those of the boundary."""
        return Particles.at_rest(self.position, 0 if self.unpruned is None else _MOST_SHOWN)

    def arrays(self) -> list[NDArray[Any]]:
        """The arrays that take up memory."""
        found = [lines for lines in (self.unpruned, self.lines) if lines is not None]
        held = [array for lines in found for branch in lines.branches for array in (branch.points, branch.radii)]
        return [*held, self.points, *([] if self.inside is None else [self.inside])]


class VolumeSkeletonMethod(SkeletonMethod):
    """Center lines in a volume as a `Method` of three steps; `SkeletonMethod` makes one for a volume.

    They are those of what is lighter than its surroundings, or darker, or of the insides of some surfaces. In regions
    of interest only what lies inside them counts; barriers have no effect.
    """

    def __init__(
        self, values: ArrayLike | Image, parameters: Parameters | None = None, regions: AnyRegions | None = None
    ) -> None:
        chosen = replace(parameters or PRESETS["volume"], scales=1)
        check_parameters(chosen)
        ImageFields.__init__(self, as_image(values), chosen, None)
        self.regions = regions
        self._surfaces: tuple[PackedSurface, ...] = ()

    def with_regions(self, regions: AnyRegions | None) -> Self:
        """The same method with other regions of interest."""
        other = copy(self)
        other.regions = regions
        return other

    def of_surfaces(self, surfaces: Sequence[PackedSurface]) -> Self:
        """The same method for what some surfaces enclose, or for what it finds in the volume if there are none."""
        other = copy(self)
        other._surfaces = tuple(surfaces)
        return other

    def of_outlines(self, outlines: Sequence[Contour] | None) -> Self:
        """The same method: lines in a plane enclose nothing in a volume."""
        return self

    def start(self, seeds: ArrayLike = ()) -> VolumeSkeletonState:
        """First state of a run; seeds have no effect."""
        return VolumeSkeletonState()

    def step(
        self, state: SkeletonState, parameters: Parameters, charges: Sequence[PlacedCharge] = ()
    ) -> VolumeSkeletonState:
        """Find what is inside, then all its center lines, then those that remain after pruning.

        Values that differ from those of the last step start again with the inside, but for the pruning, which starts
        with the third step. Charges have no effect. The state of a run that has stopped is returned unchanged.
        """
        assert isinstance(state, VolumeSkeletonState)
        if state.stop_reason:
            return state
        regions = self.regions.interest if self.regions is not None else ()
        made_of = (*self.steering(replace(parameters, pruning=0.0)), regions, self._surfaces)
        state = replace(state, step=state.step + 1, steering=self.steering(parameters))
        size = self.image.spacing, self.image.unit
        if state.inside is None or state.made_of != made_of:
            inside = self._enclosed(parameters)
            return replace(state, made_of=made_of, inside=inside, unpruned=None, points=_boundary(inside))
        if state.unpruned is None:
            lines = centerlines(state.inside, *size, 0.0)
            places = np.concatenate([np.empty((0, 3)), *(branch.points for branch in lines.branches)])
            return replace(state, unpruned=lines, points=places)
        lines = centerlines(state.inside, *size, parameters.pruning)
        reason = "the skeleton is found" if lines.branches else "no edge encloses anything; smooth less"
        return replace(
            state,
            lines=lines,
            contours=lines.contours,
            radii=tuple(radii / min(self.image.spacing) for radii in lines.radii),
            stop_reason=reason,
            converged=bool(lines.branches),
        )

    def result(self, state: SkeletonState, parameters: Parameters) -> VolumeSkeleton:
        """The skeleton of a state; without branches until the first is found."""
        assert isinstance(state, VolumeSkeletonState)
        image = self.image
        given = ("pruning",) if self._surfaces else OF_CENTERLINES
        made = Provenance(self.name, taken(parameters, given), sha256=image.sha256, of_file=bool(image.file_sha256))
        lines = Centerlines((), image.spacing, image.unit) if state.lines is None else state.lines
        polarity = 0 if self._surfaces else -1 if parameters.polarity < 0.0 else 1
        return VolumeSkeleton(
            state.contours, state.radii, image.shape, image.spacing, image.unit, image.source, polarity, 0.0,
            "luminance", made, image.geometry,
            image=image, lines=replace(lines, source=image.source, geometry=image.geometry, provenance=made),
        )  # fmt: skip

    def measures(self, state: SkeletonState, parameters: Parameters, thorough: bool = False) -> Mapping[str, float]:
        """Metrics of a state by name; see `Method.measures`."""
        length = self.result(state, parameters).length
        return {"count": state.count, "scale": 0.0, "branches": len(state.contours), "length": length}

    def _enclosed(self, parameters: Parameters) -> Mask:
        """The voxels that have center lines."""
        if self._surfaces:
            inside = np.zeros(self.image.shape, np.bool_)
            for surface in self._surfaces:
                surface.voxels.fill(inside)
        else:
            inside = inside_edges(self.image, parameters, parameters.polarity < 0.0)
        within = self.regions.voxels(self.image.shape) if isinstance(self.regions, VolumeRegions) else None
        return inside if within is None else inside & within


def _boundary(inside: Mask) -> Array:
    """Voxels at the boundary of what is inside, shape (N, 3), evenly fewer of them where there are very many."""
    places = np.argwhere(inside & ~scipy.ndimage.binary_erosion(inside)).astype(float)
    return np.asarray(places[:: -(-max(len(places), 1) // _MOST_SHOWN)])
