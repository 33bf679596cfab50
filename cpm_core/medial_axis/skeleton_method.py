"""The method that finds skeletons, in three steps that a run can show: edges, medial axis, pruning.

In a volume the first step finds the inside, the second its center lines, and the third prunes them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from typing import Any, ClassVar, Self, cast

import numpy as np
import scipy
from numpy.typing import ArrayLike

from cpm_core.contours.contour import Contour, Contours
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.field.volume_field import VolumeField
from cpm_core.image.image import Image, as_image
from cpm_core.image.region import Region
from cpm_core.image.regions import Regions
from cpm_core.image.surface import voxelize_surface
from cpm_core.image.volume_regions import AnyRegions, VolumeRegions
from cpm_core.medial_axis.boundary import boundary_from_outlines
from cpm_core.medial_axis.centerlines import Centerlines, centerlines
from cpm_core.medial_axis.medial_axis import MedialAxis, compute_medial_axis
from cpm_core.medial_axis.outlines import check_mask, closed_outlines, is_inside_outlines
from cpm_core.medial_axis.skeleton import Skeleton, extract_branches
from cpm_core.medial_axis.structure import DARK_POLARITY, Structure, find_axis, find_structure
from cpm_core.model.image_fields import ImageFields
from cpm_core.model.starts import is_inside_image
from cpm_core.model.state import Particles
from cpm_core.numerics.types import NO_POINTS, Array, Arrays, Mask, Numbers, Texts, copy_with, record
from cpm_core.parameters import (
    CHARGE_PARAMETERS,
    PRESETS,
    START_PARAMETERS,
    Parameters,
    choose_parameters,
    find_invalidating,
)
from cpm_core.parameters.formatting import format_repr, format_size, quote_value
from cpm_core.parameters.provenance import Provenance, select_parameters
from cpm_core.reconstruction.surface.pipeline import find_surface

Within = Contours | ArrayLike
"""Objects that have a skeleton: closed outlines, or a mask of the shape of the image."""

OF_CENTERLINES = ("smoothing", "gamma", "edge_floor", "polarity", "pruning")
"""Parameters that the center lines of gray levels in a volume depend on."""

_MAX_SHOWN_VOXELS = 20_000
"""Largest number of voxels of the boundary that are shown."""

_POLARITY_CHOICES = {"dark": -1.0, "light": 1.0, "auto": 0.0}
"""Values of the argument `of` -> values of `Parameters.polarity`."""


@record
class SkeletonState:
    """Moment of a run of the skeleton: its input, and axis and branches as far as they have been found.

    Attributes
    ----------
    step : int
        Number of steps; three of them find a skeleton.
    steering : tuple
        `SkeletonMethod.steering` of the last step; empty before the first.
    structure : Structure, ndarray of bool or None
        The edges that count, found by the first step; in a volume the voxels inside.
    made_of : tuple
        Everything that `structure` depends on, except for the image.
    axis : MedialAxis, Centerlines or None
        The medial axis, found by the second step; in a volume all center lines.
    points : ndarray, shape (N, D)
        Points in the image that the next step works on [px].
    first : int
        Identity of the first point: points of the axis and of the boundary have different ones.
    contours, radii : tuple
        Branches and their radii, found by the third step; until then found with the previous parameters.
    lines : Centerlines or None
        The branches in a volume.
    stop_reason : str
        Why the run ended, in words; empty while it continues.
    converged : bool
        Whether it ended with a skeleton.
    """

    step: int = 0
    steering: tuple[object, ...] = ()
    structure: Structure | Mask | None = None
    made_of: tuple[object, ...] = ()
    axis: MedialAxis | Centerlines | None = None
    points: Array = field(default_factory=lambda: NO_POINTS)
    first: int = 0
    contours: tuple[Contour, ...] = ()
    radii: Arrays = ()
    lines: Centerlines | None = None
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
        """Points of the next step, shape (N, D) [px]: of the boundary, then of the axis, none at the end."""
        return self.points[:0] if self.stop_reason else self.points

    @property
    def particles(self) -> Particles:
        """The points as particles at rest."""
        return Particles.at_rest(self.position, self.first)

    def list_arrays(self) -> list[Numbers]:
        """List the arrays that take up memory."""
        found: list[Numbers] = [self.points, *(contour.points for contour in self.contours), *self.radii]
        if isinstance(self.structure, np.ndarray):
            found.append(self.structure)
        for part in (getattr(self.structure, "boundary", None), self.axis):
            if part is not None:
                found += [value for value in vars(part).values() if isinstance(value, np.ndarray)]
        return found

    def resume(self) -> SkeletonState:
        """Return the state as one of a running run, to continue with other parameters."""
        return replace(self, stop_reason="", converged=False)


class SkeletonMethod(ImageFields):
    """Skeletons as a `Method` of three steps; in a volume the center lines of objects lighter than their surroundings.

    It needs no seeds. In regions of interest only edges and branches inside them count; barriers have no effect.

    Parameters
    ----------
    values : array_like, shape (H, W) or (P, H, W), or Image
        Image or volume.
    parameters : Parameters or str, optional
        For the fields that are prepared first; by default the preset "noisy", or "volume".
    regions : Regions or VolumeRegions, optional
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
    parameters: ClassVar[Texts] = tuple(
        name for name in find_invalidating("field", "contours") if name not in (*START_PARAMETERS, *CHARGE_PARAMETERS)
    )
    seeded: ClassVar[bool] = False

    def __init__(
        self,
        values: ArrayLike | Image,
        parameters: Parameters | str | None = None,
        regions: AnyRegions | None = None,
        *,
        within: Within | None = None,
        outside: bool = False,
    ) -> None:
        image = as_image(values)
        plane = image.ndim == 2
        chosen = replace(choose_parameters(parameters, PRESETS["noisy" if plane else "volume"]), scales=1)
        super().__init__(image, chosen, _plane_regions(regions))
        self.regions = regions
        self._outside = outside
        self._within: tuple[Contour | Region, ...] = ()
        if within is not None:
            self._within = (
                closed_outlines(within, image.shape) if plane else (Region.from_mask(check_mask(within, image.shape)),)
            )

    @classmethod
    def steering(cls, parameters: Parameters) -> tuple[object, ...]:
        """Return the values that a step depends on; see `Method.steering`."""
        return tuple(getattr(parameters, name) for name in cls.parameters)

    def can_start(self, parameters: Parameters) -> bool:
        """Return True: the method works on the image at full size."""
        return True

    def with_regions(self, regions: AnyRegions | None) -> Self:
        """Return the method with other regions of interest."""
        other = super().with_regions(_plane_regions(regions))
        other.regions = regions
        return other

    def for_objects(self, objects: Contours | Sequence[Region]) -> Self:
        """Return the method for closed outlines, or bodies in a volume; without any for what it finds itself."""
        return copy_with(self, _within=tuple(objects))

    def __reduce__(self) -> tuple[Any, ...]:
        return _make_method, (self.image, self._latest, self.regions, self._within, self._outside)

    def start(self, seeds: ArrayLike = ()) -> SkeletonState:
        """Return the first state of a run; seeds, of any shape, have no effect."""
        return SkeletonState(points=np.zeros((0, self.image.ndim)))

    def step(self, state: SkeletonState, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> SkeletonState:
        """Find the enclosing edges, then the medial axis, then the branches that remain after pruning.

        If a value differs from the last step, the run starts with the first step again, or, if only the pruning
        differs, with the third. Charges have no effect. The state of a run that has stopped is returned unchanged.
        """
        if state.stop_reason:
            return state
        interest = self.regions and self.regions.interest
        made_of = (*self.steering(replace(parameters, pruning=0.0)), interest, self._within)
        state = replace(state, step=state.step + 1, steering=self.steering(parameters))
        if state.structure is None or state.made_of != made_of:
            structure: Structure | Mask
            if self.image.ndim == 3:
                structure = self._find_inside(parameters)
                points = _boundary_voxels(structure)
            else:
                if self._within:
                    boundary = boundary_from_outlines(self._outlines, self.scale_field(parameters))
                    structure = Structure(boundary, 0.0, 0, parameters.max_width)
                else:
                    structure = find_structure(self.scale_field, parameters)
                points = self._points_in_image(structure.boundary.points)
            return replace(state, made_of=made_of, structure=structure, axis=None, points=points, first=0)
        found, image = state.structure, self.image
        if isinstance(found, Structure):
            if not isinstance(state.axis, MedialAxis):
                found, axis = self._find_axis(found, parameters)
                points = self._points_in_image(axis.points[np.unique(axis.edges)])
                return replace(state, structure=found, axis=axis, points=points, first=len(state.points))
            rest = found.prune_and_clip(state.axis, parameters.pruning, image.shape)
            drawn = extract_branches(rest, found.boundary, found.smoothing)
            drawn.sort(key=lambda branch: -branch[0].length)
            contours, radii = tuple(contour for contour, _ in drawn), tuple(radii for _, radii in drawn)
            reason = "the skeleton is found" if contours else _explain_no_skeleton(found)
            return replace(state, contours=contours, radii=radii, stop_reason=reason, converged=bool(contours))
        lines = centerlines(found, image.spacing, image.unit, 0.0 if state.axis is None else parameters.pruning)
        if state.axis is None:
            points = np.concatenate([np.empty((0, 3)), *(branch.points for branch in lines.branches)])
            return replace(state, axis=lines, points=points, first=len(state.points))
        return replace(
            state,
            lines=lines,
            contours=lines.contours,
            radii=tuple(radii / min(image.spacing) for radii in lines.radii),
            stop_reason="the skeleton is found" if lines.branches else "no edge encloses anything; smooth less",
            converged=bool(lines.branches),
        )

    def result(self, state: SkeletonState, parameters: Parameters) -> Skeleton:
        """Return the skeleton of a state; without branches until the first is found."""
        image, found, lines, names = self.image, state.structure, None, self.parameters
        polarity, width, channel = 0, 0.0, image.resolve_channel(parameters.channel)
        if image.ndim == 3:
            names = ("pruning",) if self._within else OF_CENTERLINES
            polarity = 0 if self._within else -1 if parameters.polarity < 0.0 else 1
            channel, lines = "luminance", state.lines or Centerlines((), image.spacing, image.unit)
        elif isinstance(found, Structure):
            polarity, width = found.polarity, found.width
        made = Provenance(
            self.name, select_parameters(parameters, names), sha256=image.sha256, of_file=bool(image.file_sha256)
        )
        if lines is not None:
            lines = replace(lines, source=image.source, geometry=image.geometry, provenance=made)
        place = image.shape, image.spacing, image.unit, image.source
        return Skeleton(
            state.contours, state.radii, *place, polarity, width, channel, made, image.geometry, image, lines
        )  # fmt: skip

    def measure_state(self, state: SkeletonState, parameters: Parameters) -> Mapping[str, float]:
        """Measure a state by name; see `Method.measure_state`."""
        length = self.result(state, parameters).length
        return {"count": state.count, "scale": 0.0, "branches": len(state.contours), "length": length}

    def _points_in_image(self, points: Array) -> Array:
        """Return the points that lie in the image; boundary and axis continue beyond it."""
        return points[is_inside_image(points, self.image.shape)]

    @property
    def _outlines(self) -> list[Contour]:
        return [one for one in self._within if isinstance(one, Contour)]

    def _find_axis(self, found: Structure, parameters: Parameters) -> tuple[Structure, MedialAxis]:
        """Find the structure in an image and its medial axis."""
        if self._within or self._outside:
            axis = compute_medial_axis(found.boundary, self.image.shape)
            if self._within:
                continued = axis.middles.clip(
                    0.0, np.array(self.image.shape) - 1.0
                )  # objects continue beyond the border
                axis = axis.select_edges(is_inside_outlines(self._outlines, continued))
        else:
            found, axis = find_axis(found, self.image.gray_levels(parameters.channel), parameters)
        if isinstance(self.regions, Regions):
            axis = axis.select_edges(np.all(self.regions.contains(axis.points)[axis.edges], axis=1))
        return found, axis

    def _find_inside(self, parameters: Parameters) -> Mask:
        """Find the voxels of a volume that have center lines."""
        image, dark = self.image, parameters.polarity < 0.0
        low, high = image.gray_range
        if self._within:
            inside = np.zeros(image.shape, bool)
            for one in self._within:
                if isinstance(one, Region):
                    one.fill_into(inside)
        elif ((image.values == low) | (image.values == high)).all():  # a mask
            inside = image.values == (low if dark else high)
        else:
            field = cast("VolumeField", self.scale_field(parameters))
            smoothed = -field.smoothed if dark else field.smoothed  # the inside is lighter
            places = field.ridges.place / field.pitch
            surface = find_surface(
                smoothed, field.edge_map, places, image.spacing, image.unit, smoothing=field.smoothing
            )
            inside = voxelize_surface(surface, image.shape)
        within = self.regions.voxel_mask(image.shape) if isinstance(self.regions, VolumeRegions) else None
        return inside if within is None else inside & within

    def __repr__(self) -> str:
        return format_repr("SkeletonMethod", self.image.source, format_size(self.image.shape, ""))


def _make_method(
    image: Image, parameters: Parameters, regions: AnyRegions | None, objects: tuple[Any, ...], outside: bool
) -> SkeletonMethod:
    """Make the method of an image for some objects, or for what it finds itself."""
    return SkeletonMethod(image, parameters, regions, outside=outside).for_objects(objects)


def _plane_regions(regions: AnyRegions | None) -> Regions | None:
    """Return the regions of interest in an image, without barriers."""
    return Regions(regions.interest) if isinstance(regions, Regions) and regions.interest else None


def _boundary_voxels(inside: Mask) -> Array:
    """Return the voxels at the boundary of the inside, shape (N, 3), thinned evenly where there are very many."""
    places = np.argwhere(inside & ~scipy.ndimage.binary_erosion(inside)).astype(float)
    return places[:: -(-max(len(places), 1) // _MAX_SHOWN_VOXELS)]


def _explain_no_skeleton(found: Structure) -> str:
    """Explain why there is no skeleton in an image."""
    if found.width:
        kind = "" if not found.polarity else "dark " if found.polarity == DARK_POLARITY else "light "
        return f"nothing {kind}up to {found.width:g} px wide is found; raise the width or lower the edge floor"
    return "no edge encloses anything; smooth less or lower the edge floor"


def skeleton(
    values: ArrayLike | Image,
    parameters: Parameters | str | None = None,
    *,
    of: str | None = None,
    max_width: float | None = None,
    pruning: float | None = None,
    within: Within | None = None,
    outside: bool = False,
) -> Skeleton | Centerlines:
    """Find the skeleton of the objects in a binary or gray image, or the center lines of those in a volume.

    They run midway between the edges, in a volume inside the surface through these, and are shortened from their tips.

    Parameters
    ----------
    values : array_like, shape (H, W) or (P, H, W), or Image
        Image, whose border is no edge: an object continues beyond it. Or volume; one of two gray levels is a mask.
    parameters : Parameters or str, optional
        For the edges, and where the following arguments are not given; by default the preset "noisy", or "volume".
    of : {"dark", "light", "auto"}, optional
        Objects darker, or lighter, than their surroundings on both sides; "auto" takes what most objects are, or, if
        outlines are closed and objects differ, regions unlike the image border; in a volume lighter ones.
    max_width : float, optional
        Width above which a part has no skeleton [px]; the rest are strips between two edges, three widths long or more.
        At 0 any width counts if outlines are closed, else it is estimated from the strips themselves. Images only.
    pruning : float, optional
        How far a part of the shape may extend beyond the disks of the rest for its branch to be left out [px]. At one
        pixel neither the steps of a binary image nor moderate noise cause short branches (at 0.25 they do). In a
        volume the length of branches that are left out, in radii at their junction, by default 1; see `centerlines`.
    within : sequence of Contour, or array_like of bool, shape of the image, optional
        Closed outlines of objects and holes, or a mask: the skeleton is theirs, and `of` has no effect.
    outside : bool, optional
        Whether to include the skeleton of the background, for any `of`. Images only.

    Returns
    -------
    Skeleton or Centerlines
        Branches in `contours` with `radii`; without any branch if no edge encloses anything.

    Raises
    ------
    ValueError
        For an unusable image or value.

    Examples
    --------
    >>> bones = cpm.skeleton(cpm.example("ring"))
    >>> len(bones.contours), bones.contours[0].closed, round(float(np.median(bones.radii[0])))
    (1, True, 7)
    """
    image = as_image(values)
    if of is not None and not (isinstance(of, str) and of in _POLARITY_CHOICES):
        raise ValueError(f"of is {quote_value(of)} but must be one of {', '.join(_POLARITY_CHOICES)}.")
    given = choose_parameters(parameters, PRESETS["noisy" if image.ndim == 2 else "volume"])
    chosen = replace(
        given,
        polarity=given.polarity if of is None else _POLARITY_CHOICES[of],
        max_width=given.max_width if max_width is None else max_width,
        pruning=given.pruning if pruning is None else pruning,
    )
    for name, value in (("outside", outside), ("max_width", chosen.max_width)) if image.ndim == 3 else ():
        if value:
            raise ValueError(f"{name} is {quote_value(value)} but has no meaning in a volume: leave it out.")
    method = SkeletonMethod(image, chosen, within=within, outside=outside)
    state = method.start()
    while not state.stop_reason:
        state = method.step(state, chosen)
    found = method.result(state, chosen)
    return found.lines or found
