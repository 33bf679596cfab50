"""A volume with the bodies that closed surfaces divide it into, and the selection of bodies by clicks.

A body is a connected part of the volume without the surface: the inside of a surface, or the space between two, such as
the wall of a shell, or the hollow in it. Its boundary consists of the components of the surface next to it; its volume
and area are measured on triangles, not on voxels. A click selects the body that it lies in, further positive points add
other bodies, and negative ones remove bodies. Where no surface encloses a click, a network answers that has learned
from outlined images (`prior.body_predictor`), and further clicks correct its answer.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field, replace
from functools import cached_property
from itertools import islice
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.contours.contour import Contour
from cpm_core.contours.packed_surface import PackedBody, PackedSurface, PackedVoxels
from cpm_core.contours.surface import Surface, voxelize_surface
from cpm_core.field.volume_field import pitch_of
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions, VolumeRegions
from cpm_core.numerics.grids import ConnectedParts, find_connected_parts
from cpm_core.numerics.real_numbers import as_positions
from cpm_core.numerics.types import Array, Arrays, Extent, Index, Mask, record
from cpm_core.objects.background import lies_in_background
from cpm_core.objects.prior.body_corrections import find_changes_near
from cpm_core.objects.prior.body_prediction import (
    BodyPrediction,
    body_from_mask,
    is_different_body,
    logits_from_mask,
)
from cpm_core.objects.prior.body_predictor import BodyPredictor
from cpm_core.objects.prior.body_surface import extract_body_surface
from cpm_core.objects.prior.crops import CROP_SIDE, resample_with_tent
from cpm_core.objects.selection import CONFLICTING_POINT_REMARK, keep_last_marks
from cpm_core.parameters.formatting import format_count, format_repr, format_size

_BODY_LOOKUP_DISTANCE = 0.75
"""Distance from a surface at which the bodies on its sides are looked up [smallest sides of a voxel]."""

_NO_POINT_REMARK = "No point is marked as inside."
_CONFLICTING_BODY_REMARK = "The same body is marked as inside and as outside; it is left out."
_OUTSIDE_INTEREST_REMARK = "A point outside the regions of interest is ignored."
_NO_BODY_REMARK = "No body was found at this place."

EMPTY_SURFACE = Surface(np.empty((0, 3)), np.empty((0, 3), np.int64))
"""The surface of a volume in which nothing has run yet."""


class FoundInImage(Protocol):
    """Contours, or a surface, with the image in which they were found: what a partition needs of a `Result`."""

    @property
    def image(self) -> Image | None:
        """The image."""

    @property
    def contours(self) -> tuple[Contour, ...]:
        """The contours."""

    @property
    def links(self) -> Arrays:
        """Pieces between contours that are too short to be contours."""

    @property
    def surface(self) -> Surface | None:
        """The surface in a volume."""

    @property
    def regions(self) -> AnyRegions | None:
        """Regions of interest and barriers."""

    @property
    def channel(self) -> str:
        """Channel of a color image."""


def require_image(result: FoundInImage) -> Image:
    """Return the image of a result; ValueError when it does not know it."""
    if result.image is None:
        raise ValueError("the result has no image: make a partition of the image itself.")
    return result.image


@record
class VolumePartition:
    """A volume, with the bodies that closed surfaces cut it into.

    Attributes
    ----------
    image : Image
        The volume.
    surface : Surface
        The surfaces along which it is cut, all in one; without any, the network answers everywhere.
    regions : VolumeRegions, optional
        Regions of interest, in which the answers of the network stay.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("ball"), cpm.sphere((15, 15, 15), 4, 60), cpm.PRESETS["volume"])
    >>> bodies = cpm.VolumePartition.from_result(result)
    >>> bodies.find_body_numbers(np.array([(15.0, 15.0, 15.0)])).tolist(), bodies.extract_boundary(np.array([1])).closed
    ([1], True)
    >>> bodies.shape, int(bodies.labels.max()), bodies.solid_bodies.tolist(), bodies.select([(15, 15, 15)]).remark
    ((31, 31, 31), 1, [1], '')
    >>> len(bodies.find_candidates([(15, 15, 15)]))
    1
    >>> bodies.build_selection(bodies.select([(15, 15, 15)]).packed_body, [(15, 15, 15)])
    <VolumeSelection ball, 1 part>
    """

    image: Image
    surface: Surface = EMPTY_SURFACE
    regions: AnyRegions | None = None

    @classmethod
    def from_result(cls, result: FoundInImage) -> VolumePartition:
        """Make the partition of the volume and the closed surface of a result; ValueError when it has no image."""
        surface = result.surface if result.surface is not None and result.surface.closed else EMPTY_SURFACE
        return cls(require_image(result), surface, result.regions)

    def __post_init__(self) -> None:
        if len(self.surface.faces) and not self.surface.closed:
            raise ValueError(
                f"{self.image.source} has no closed surface, so nothing is enclosed: run until the particles are "
                "at rest."
            )

    @property
    def shape(self) -> Extent:
        """Shape of the volume."""
        return self.image.shape

    @property
    def labels(self) -> Index:
        """Body of every voxel, shape (P, R, C), from 1 up; 0 outside all surfaces."""
        return np.asarray(sum(np.concatenate([[0], number])[parts.labels] for parts, number in self._parts))

    @cached_property
    def _parts(self) -> tuple[tuple[ConnectedParts, Index], ...]:
        """Parts of voxels inside the surface, and of those outside it, with the number of the body of each part."""
        inside = voxelize_surface(self.surface, self.shape)
        found = []
        count = 0
        for part, corners in ((inside, True), (~inside, False)):
            parts = find_connected_parts(part, corners=corners)
            enclosed = np.ones(parts.count, bool) if corners else ~parts.at_border
            found.append((parts, np.where(enclosed, count + np.cumsum(enclosed), 0)))
            count += int(enclosed.sum())
        return tuple(found)

    @property
    def solid_bodies(self) -> Index:
        """Numbers of the bodies inside the surface; the others are hollows in them."""
        return self._parts[0][1]

    def select(
        self, inside: ArrayLike, outside: ArrayLike = (), *, previous: VolumeSelection | None = None
    ) -> VolumeSelection:
        """Select the bodies that positive points lie in, without those that negative points lie in.

        Parameters
        ----------
        inside, outside : array_like, shape (M, 3) and (K, 3)
            Positive and negative points (plane, row, col) [voxels]. One outside the volume is moved to its border.
        previous : VolumeSelection, optional
            The selection before; the points are added to its own.

        Returns
        -------
        VolumeSelection
            Empty when no positive point lies in a body, or the first one in nothing but background.

        Raises
        ------
        ValueError
            When points are not planes, rows and columns.
        """
        within, beyond = (as_positions(given, "planes, rows and columns") for given in (inside, outside))
        if previous is not None:
            within, beyond = _append_new_points(previous.inside, within), _append_new_points(previous.outside, beyond)
        if not len(within):
            return VolumeSelection(self, EMPTY_SURFACE, within, beyond, _NO_POINT_REMARK)
        wanted, unwanted = self.find_body_numbers(within), self.find_body_numbers(beyond)
        chosen = np.setdiff1d(wanted, unwanted)
        voxels = None if previous is None else previous.voxels
        if wanted.all() and len(chosen) and voxels is None:
            remark = _CONFLICTING_BODY_REMARK if np.isin(wanted, unwanted).any() else ""
            found = VolumeSelection(self, self.extract_boundary(chosen), within, beyond, remark)
        else:
            found = self._select_by_network(within, beyond, previous, voxels)
            if (previous is None or not previous.has_boundary) and found.has_boundary:
                in_background = lies_in_background(self.image.values, within[0], found.surface)
                found = replace(found, surface=EMPTY_SURFACE, body=None) if in_background else found
        return found if found.has_boundary or found.remark else replace(found, remark=_NO_BODY_REMARK)

    def find_candidates(
        self, inside: ArrayLike, outside: ArrayLike = (), *, previous: VolumeSelection | None = None
    ) -> tuple[VolumeSelection, ...]:
        """Find the different bodies that points, shape (M, 3) [voxels], may mean, from the smallest to the largest.

        One of them is the result of `select`, which has the same parameters. The others are predictions in crops of
        other sizes around the first positive point.
        """
        first = self.select(inside, outside, previous=previous)
        found = [first]
        if len(first.inside):
            for body in self._predict_bodies(first.inside[:1]):
                other = self._correct_body(body, first.inside, first.outside, "")
                if other.has_boundary and all(is_different_body(other.volume, one.volume) for one in found):
                    found.append(other)
        return tuple(sorted(found, key=lambda one: one.volume))

    def _select_by_network(
        self, inside: Array, outside: Array, previous: VolumeSelection | None, voxels: PackedVoxels | None
    ) -> VolumeSelection:
        """Select a body by the network, starting from what was selected before."""
        newer = np.arange(len(inside)) >= (len(inside) if previous is None else len(previous.inside))
        within, beyond, contradicting = keep_last_marks(inside, outside, newer)
        remark = CONFLICTING_POINT_REMARK if contradicting else ""
        if self._interest is not None:
            here, there = (self._interest[tuple(self._find_nearest_voxels(given).T)] for given in (within, beyond))
            remark = remark if here.all() and there.all() else _OUTSIDE_INTEREST_REMARK
            within, beyond = within[here], beyond[there]
        if not len(within):
            return VolumeSelection(self, EMPTY_SURFACE, inside, outside, remark)
        size = self._predictor.voxel_sides
        if previous is not None and previous.body is not None:
            body = previous.body
        elif previous is not None and previous.has_boundary:
            body = body_from_mask(previous.mask, size)
        else:
            body = self._predict_bodies(within[:1], 1)[0]
        found = self._correct_body(body, within, beyond, remark, voxels)
        return replace(found, inside=inside, outside=outside)

    def _correct_body(
        self, body: BodyPrediction, inside: Array, outside: Array, remark: str, voxels: PackedVoxels | None = None
    ) -> VolumeSelection:
        """Correct a body by the points that contradict it, and find its surface, or its voxels once painted."""
        size, (within, beyond) = self._predictor.voxel_sides, map(self._clip_points, (inside, outside))
        for places, adds in ((within, True), (beyond, False)):
            for place in places:
                if (body.interpolate_logit(place * size) > 0.0) != adds:
                    before = body
                    body = self._predictor.correct_body(before, place * size, adds, within * size, beyond * size)
                    if voxels is not None:
                        voxels = self._repaint_voxels(voxels, before, body, place, adds)
        if voxels is not None:
            return replace(self.build_selection(voxels), inside=inside, outside=outside, remark=remark)
        image, shown = self.image, body
        if self._interest is not None:
            shown = replace(body, logits=np.minimum(body.logits, logits_from_mask(self._interest, size, body.crop)))
        surface = extract_body_surface(
            shown, image.values, size, within, beyond, image.spacing, image.unit, self._interest
        )
        return VolumeSelection(self, surface, inside, outside, remark, body)

    def _repaint_voxels(
        self, voxels: PackedVoxels, before: BodyPrediction, after: BodyPrediction, place: Array, adds: bool
    ) -> PackedVoxels:
        """Add to voxels what a point has added to a body near it, or remove what it has removed."""
        cube, size = after.crop, self._predictor.voxel_sides
        at = np.rint(place).astype(np.int64)
        first = np.clip(np.ceil(cube.to_positions(np.zeros(3)) / size).astype(np.int64), 0, at)
        end = np.clip(
            np.floor(cube.to_positions(np.full(3, CROP_SIDE - 1.0)) / size).astype(np.int64) + 1, at + 1, self.shape
        )
        lines = cube.axes_to_crop_steps(np.arange(a, b) * side for a, b, side in zip(first, end, size, strict=True))
        changed = resample_with_tent(find_changes_near(before, after, place), lines, tuple(size / cube.step_size)) > 0.5
        if self._interest is not None:
            changed &= self._interest[tuple(map(slice, first, end))]
        changed[tuple(at - first)] = True
        known = voxels.mask_in_box(first, changed.shape)
        return voxels.with_box_replaced(first, known | changed if adds else known & ~changed) or voxels

    def build_selection(self, body: PackedBody, inside: ArrayLike = (), outside: ArrayLike = ()) -> VolumeSelection:
        """Build the selection of the body of an object, with its points, shape (M, 3) and (K, 3) [voxels]."""
        within, beyond = (as_positions(given, "planes, rows and columns") for given in (inside, outside))
        surface = replace(body.surface, spacing=self.image.spacing, unit=self.image.unit)
        return VolumeSelection(self, surface, within, beyond, voxels=body if isinstance(body, PackedVoxels) else None)

    def _predict_bodies(self, place: Array, count: int | None = None) -> list[BodyPrediction]:
        """Predict the bodies around a point, shape (1, 3), the most plausible one first: all, or at most `count`."""
        (at,) = self._clip_points(place) * self._predictor.voxel_sides
        key = tuple(at.tolist())
        # taken out for as long as bodies are predicted, since no two threads may resume one generator
        bodies, rest = self._bodies_at_last_point.pop(key, ([], self._predictor.predict_bodies(at)))
        bodies += islice(rest, None if count is None else max(count - len(bodies), 0))
        self._bodies_at_last_point.clear()
        self._bodies_at_last_point[key] = bodies, rest
        return bodies[:count]

    @cached_property
    def _bodies_at_last_point(self) -> dict[tuple[float, ...], tuple[list[BodyPrediction], Iterator[BodyPrediction]]]:
        """The bodies predicted so far around the last point, and the iterator over the others."""
        return {}

    def _clip_points(self, places: Array) -> Array:
        """Clip points to the volume."""
        return np.clip(places, 0.0, np.array(self.shape) - 1.0)

    def _find_nearest_voxels(self, places: Array) -> Index:
        """Find the nearest voxels of points."""
        return np.rint(self._clip_points(places)).astype(np.int64)

    @cached_property
    def _interest(self) -> Mask | None:
        """Voxels in the regions of interest; None when all are."""
        return self.regions.voxel_mask(self.shape) if isinstance(self.regions, VolumeRegions) else None

    @cached_property
    def _predictor(self) -> BodyPredictor:
        return BodyPredictor(self.image.values, np.array(pitch_of(self.image.spacing)))

    def find_body_numbers(self, places: Array) -> Index:
        """Find the numbers of the bodies that points, shape (N, 3) [voxels], lie in, shape (N,); 0 outside all."""
        voxels = self._find_nearest_voxels(places)
        found = np.zeros(len(voxels), np.int64)
        if not len(self.surface.faces):
            return found
        for parts, number in self._parts:
            part = parts.part_at(voxels)
            found[part >= 0] = number[part[part >= 0]]
        return found

    def extract_boundary(self, chosen: Index) -> Surface:
        """Extract the components of the surface that bound bodies, turned outward; none between two of these bodies."""
        within, beyond = (np.isin(side, chosen) for side in self._bodies_beside_surface)
        faces = self.surface.faces
        component = self.surface.component_of_vertex[faces[:, 0]]
        outward, inward = (within & ~beyond)[component], (beyond & ~within)[component]
        kept = np.concatenate([faces[outward], faces[inward][:, ::-1]])
        used, number = np.unique(kept, return_inverse=True)
        return replace(
            self.surface,
            vertices=self.surface.vertices[used],
            faces=number.reshape(-1, 3),
            unsupported=np.nan,
            left_out=0,
        )

    @cached_property
    def _bodies_beside_surface(self) -> tuple[Index, Index]:
        """The body inside each component of the surface, and the body outside, by a majority of its vertices."""
        surface = self.surface
        step = _BODY_LOOKUP_DISTANCE * min(surface.spacing) * surface.normals / np.array(surface.spacing)
        inner, outer = self.find_body_numbers(surface.vertices - step), self.find_body_numbers(surface.vertices + step)
        return _find_most_frequent(surface.component_of_vertex, inner), _find_most_frequent(
            surface.component_of_vertex, outer
        )

    def __repr__(self) -> str:
        return format_repr("VolumePartition", self.image.source, format_size(self.shape, "voxels"))


@record
class VolumeSelection:
    """One or several bodies that clicks have selected in a volume.

    Attributes
    ----------
    partition : VolumePartition
        What it was selected from.
    surface : Surface
        Its boundary: its triangles are turned outward, away from it.
    inside, outside : ndarray, shape (M, 3) and (K, 3)
        The positive and negative points of the prompt [voxels].
    remark : str
        One sentence on what was unusual about the points, or empty.
    body : BodyPrediction or None
        The prediction of the network; None for bodies of closed surfaces.
    voxels : PackedVoxels or None
        Its voxels, if it has been painted; a correction changes only what is near its point.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("ball"), cpm.sphere((15, 15, 15), 4, 60), cpm.PRESETS["volume"])
    >>> chosen = cpm.partition(result).select([(15, 15, 15)])
    >>> chosen
    <VolumeSelection ball, 1 part>
    >>> round(chosen.volume / result.surface.volume, 3), round(chosen.area / result.surface.area, 3)
    (1.0, 1.0)
    >>> chosen.mask.shape, chosen.surface.closed, chosen.has_boundary, chosen.has_only_points
    ((31, 31, 31), True, True, False)
    >>> chosen.has_same_region(chosen)
    True
    >>> chosen.contains(np.array([(15.0, 15.0, 15.0), (2.0, 2.0, 2.0)])).tolist()
    [True, False]
    >>> chosen.packed_body.surface.closed, chosen.body is None, chosen.image.source
    (True, True, 'ball')
    """

    partition: VolumePartition = field(repr=False)
    surface: Surface
    inside: Array
    outside: Array
    remark: str = ""
    body: BodyPrediction | None = field(default=None, repr=False)
    voxels: PackedVoxels | None = field(default=None, repr=False)

    @cached_property
    def mask(self) -> Mask:
        """Voxels whose centers lie in it, shape (P, R, C), with all positive points and without negative ones."""
        found = np.zeros(self.partition.shape, bool)
        first, part = self._boxed_mask
        found[tuple(slice(at, at + side) for at, side in zip(first.tolist(), part.shape, strict=True))] = part
        return found

    @cached_property
    def _boxed_mask(self) -> tuple[Index, Mask]:
        """First voxel of a box around it, and its voxels in the box: large volumes have many selections."""
        shape = np.array(self.partition.shape)
        places = [np.rint(np.clip(given, 0, shape - 1)).astype(np.int64) for given in (self.outside, self.inside)]
        every = np.concatenate([self.surface.vertices, *places])
        first = np.maximum(np.floor(every.min(axis=0)), 0).astype(np.int64) if len(every) else np.zeros(3, np.int64)
        end = np.minimum(np.ceil(every.max(axis=0)).astype(np.int64) + 1, shape) if len(every) else first
        there = replace(self.surface, vertices=self.surface.vertices - first)
        part = (
            voxelize_surface(there, tuple((end - first).tolist())) if self.has_boundary else np.zeros(end - first, bool)
        )
        for voxels, within in zip(places, (False, True), strict=True):
            if self.body is not None and self.remark != CONFLICTING_POINT_REMARK:
                part[tuple((voxels - first).T)] = within
        return first, part

    @property
    def image(self) -> Image:
        """The volume that it was selected in."""
        return self.partition.image

    @cached_property
    def packed_body(self) -> PackedBody:
        """The body as a session holds it; ValueError when it is empty."""
        return self.voxels or PackedSurface.from_surface(self.surface)

    @property
    def has_boundary(self) -> bool:
        """Whether it has a boundary."""
        return bool(len(self.surface.faces))

    @property
    def has_only_points(self) -> bool:
        """False: a body is more than the points in it."""
        return False

    @property
    def volume(self) -> float:
        """Volume of the bodies, in the unit of the spacing, cubed."""
        return self.surface.volume

    @property
    def area(self) -> float:
        """Area of their boundary, in the unit of the spacing, squared."""
        return self.surface.area

    def __repr__(self) -> str:
        return format_repr(
            "VolumeSelection", self.partition.image.source, format_count(self.surface.components, "part")
        )

    def has_same_region(self, other: VolumeSelection) -> bool:
        """Return whether another selection has the same bodies."""
        return np.array_equal(self.surface.vertices, other.surface.vertices)

    def contains(self, places: Array) -> Mask:
        """Return which points, shape (N, 3) [voxels], lie in it; one outside is moved to the nearest voxel."""
        first, part = self._boxed_mask
        voxels = np.rint(np.clip(places, 0, np.array(self.partition.shape) - 1)).astype(np.int64) - first
        there: Mask = np.all((voxels >= 0) & (voxels < np.array(part.shape)), axis=1)
        there[there] = part[tuple(voxels[there].T)]
        return there


def _append_new_points(before: Array, places: Array) -> Array:
    """Append those of some points that are not among the points before."""
    fresh = (places[:, None] != before[None]).any(axis=2).all(axis=1) if len(places) else np.zeros(0, bool)
    return np.concatenate([before, places[fresh]])


def _find_most_frequent(group: Index, value: Index) -> Index:
    """Find the value that most members of each group have."""
    most, groups = int(value.max(initial=0)) + 1, int(group.max(initial=-1)) + 1
    counts = np.bincount(group * most + value, minlength=groups * most)
    return counts.reshape(groups, most).argmax(axis=1)
