"""A volume with the bodies that closed surfaces divide it into, and the selection of bodies by clicks.

A body is a connected part of the volume without the surface: the inside of a surface, or the space between two, such as
the wall of a shell, or the hollow in it. Its boundary consists of the components of the surface next to it; its volume
and area are measured on triangles, not on voxels. A click selects the body that it lies in, or where it is several that
touch, one of these; further positive points add other bodies, and negative ones remove bodies. Where no surface
encloses a click, a network answers that has learned from outlined images (`prior.body_predictor`): of the bodies that
it predicts around the click, with the one that is most probably meant (`body_evidence.find_meant_body`). Further clicks
correct this answer.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import cached_property, partial, reduce
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.contours.contour import Contour
from cpm_core.field.volume_field import pitch_of
from cpm_core.image.image import Image
from cpm_core.image.region import Region
from cpm_core.image.surface import Surface, voxelize_surface
from cpm_core.image.volume_regions import AnyRegions, VolumeRegions
from cpm_core.numerics.grids import (
    ConnectedParts,
    expand_window,
    find_connected_parts,
    first_pixel,
    lie_inside,
    measure_depth,
    nearest_pixels,
    window_at,
)
from cpm_core.numerics.real_numbers import as_positions
from cpm_core.numerics.types import Array, Arrays, Extent, Index, Mask, record
from cpm_core.objects.body_evidence import MIN_INNER_CONFIDENCE, find_meant_body, rate_body, rate_inner_part
from cpm_core.objects.boundaries.background import find_bodies_with_slits, lies_in_background
from cpm_core.objects.boundaries.inner_parts import find_inner_parts
from cpm_core.objects.boundaries.necks import split_at_clear_necks
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
from cpm_core.objects.prior.larger_models import model_title
from cpm_core.objects.prior.server import ServedVolume, split_lassos
from cpm_core.objects.selection import (
    CONFLICTING_POINT_REMARK,
    EXCLUDED_POINT_REMARK,
    Selection,
    find_newer_points,
    is_among,
    keep_last_marks,
)
from cpm_core.parameters.formatting import format_repr, format_size

_BODY_LOOKUP_DISTANCE = 0.75
"""Distance from a surface at which the bodies on its sides are looked up [smallest sides of a voxel]."""

_NO_POINT_REMARK = "No point is marked as inside."
_CONFLICTING_BODY_REMARK = "The same body is marked as inside and as outside; it is left out."
_OUTSIDE_INTEREST_REMARK = "A point outside the regions of interest is ignored."
_NO_BODY_REMARK = "No body was found at this place."

EMPTY_SURFACE = Surface(np.empty((0, 3)), np.empty((0, 3), np.int64))
"""The surface of a volume in which nothing has run yet."""

NO_VOXELS = Region.from_pixels(np.empty((0, 3), np.int64))
"""The region of a volume in which nothing is selected."""


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
    model : str
        Address of a server of nnInteractive that answers in place of the network; empty for the network.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("ball"), cpm.sphere((15, 15, 15), 4, 60), cpm.PRESETS["volume"])
    >>> bodies = cpm.VolumePartition.from_result(result)
    >>> bodies.find_body_numbers(np.array([(15.0, 15.0, 15.0)])).tolist(), bodies.extract_boundary(np.array([1])).closed
    ([1], True)
    >>> bodies.shape, int(bodies.labels.max()), bodies.solid_bodies.tolist(), bodies.select([(15, 15, 15)]).remark
    ((31, 31, 31), 1, [1], '')
    >>> bodies.values.shape, bool(bodies.interest.all()), bodies.voxel_sides.tolist()
    ((31, 31, 31), True, [1.0, 1.0, 1.0])
    >>> len(bodies.find_candidates([(15, 15, 15)])), len(bodies.split_body(1))
    (1, 1)
    >>> center = np.array([(15.0, 15.0, 15.0)])
    >>> bodies.knows_bodies(center), bodies.predict_around(center)[0].contains(center).tolist()
    (True, [True])
    >>> chosen = bodies.build_selection(bodies.select([(15, 15, 15)]).region, [(15, 15, 15)])
    >>> chosen
    <Selection ball, 1 part>
    >>> bool(bodies.rate_region(chosen.region).confidence > 0.5), list(bodies.find_parts_in(chosen.region))
    (True, [])
    >>> half = bodies.remove_pixels(chosen, np.indices((31, 31, 31))[0] > 15)
    >>> [float(row) for row, *_ in half.region.bounds]
    [6.0, 15.0]
    """

    image: Image
    surface: Surface = EMPTY_SURFACE
    regions: AnyRegions | None = None
    model: str = ""

    @classmethod
    def from_result(cls, result: FoundInImage, model: str = "") -> VolumePartition:
        """Make the partition of the volume and the closed surface of a result; ValueError when it has no image."""
        surface = result.surface if result.surface is not None and result.surface.closed else EMPTY_SURFACE
        return cls(require_image(result), surface, result.regions, model)

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
    def values(self) -> Array:
        """Gray levels of the volume, shape (P, R, C)."""
        return self.image.values

    @property
    def interest(self) -> Mask:
        """Voxels in the regions of interest, shape (P, R, C)."""
        return np.ones(self.shape, bool) if self._interest is None else self._interest

    @property
    def voxel_sides(self) -> Array:
        """Sides of a voxel, shape (3,), the smallest being 1."""
        return np.array(pitch_of(self.image.spacing))

    @property
    def labels(self) -> Index:
        """Body of every voxel, shape (P, R, C), from 1 up; 0 outside all surfaces."""
        return np.asarray(sum(np.concatenate([[0], number])[parts.labels] for parts, number in self._parts))

    @cached_property
    def _parts(self) -> tuple[tuple[ConnectedParts, Index], ...]:
        """Parts of voxels inside the surface, and of those outside it, with the number of the body of each part.

        A slit has that of the body around it.
        """
        inside = voxelize_surface(self.surface, self.shape)
        solid, rest = (find_connected_parts(part, corners=part is inside) for part in (inside, ~inside))
        is_enclosed, slit_of = ~rest.at_border, np.zeros(rest.count, np.int64)
        hollows = np.flatnonzero(is_enclosed)
        slit_of[hollows] = find_bodies_with_slits(self.values, rest.labels, hollows + 1, solid.labels)
        hollow = is_enclosed & (slit_of == 0)
        numbers = np.arange(1, solid.count + 1)
        return (solid, numbers), (rest, np.where(hollow, solid.count + np.cumsum(hollow), slit_of))

    @property
    def solid_bodies(self) -> Index:
        """Numbers of the bodies inside the surface; the others are hollows in them."""
        return self._parts[0][1]

    def select(
        self,
        inside: ArrayLike = (),
        outside: ArrayLike = (),
        *,
        box: ArrayLike = (),
        previous: Selection | None = None,
        excluded: Mask | None = None,
    ) -> Selection:
        """Select the bodies that positive points lie in, without those that negative points lie in.

        Parameters
        ----------
        inside, outside : array_like, shape (M, 3) and (K, 3)
            Positive and negative points (plane, row, col) [voxels]. One outside the volume is moved to its border.
        box : array_like, shape (2, 3)
            Two opposite corners of a box around the body, for a server to answer; it is given again with further
            points.
        previous : Selection, optional
            The selection before; the points are added to its own.
        excluded : ndarray of bool, shape (P, R, C), optional
            Voxels that are not selected, such as those of other objects. What they cut consists of voxels.

        Returns
        -------
        Selection
            Empty when no positive point lies in a body, or the first one in nothing but background.

        Raises
        ------
        ValueError
            When points are not planes, rows and columns, the excluded voxels are not those of the volume, or a box
            does not have two corners, or has no server.
        """
        within, beyond, corners = (as_positions(given, 3) for given in (inside, outside, box))
        if len(corners) not in (0, 2):
            raise ValueError(f"the box has {len(corners)} corners: give two opposite ones.")
        if len(corners) and not self.model:
            raise ValueError("A box in a volume is for a server of nnInteractive: name its address, or give points.")
        if excluded is not None:
            if excluded.shape != self.shape:
                shapes = format_size(excluded.shape), format_size(self.shape)
                raise ValueError("the excluded voxels are {} but the volume is {}.".format(*shapes))
            free = ~excluded[tuple(self._find_nearest_voxels(within).T)]
            found = self.remove_pixels(self.select(within[free], beyond, box=corners, previous=previous), excluded)
            return found if free.all() else replace(found, remark=EXCLUDED_POINT_REMARK)
        if previous is not None:
            known = (previous.inside, within), (previous.outside, beyond)
            within, beyond = (np.concatenate([old, new[~is_among(new, old)]]) for old, new in known)
        painted = None if previous is None or not self._is_painted(previous) else previous.region
        wanted, unwanted = self._find_parts(within), self._find_parts(beyond)
        chosen = set(wanted).difference(unwanted)
        if not len(within) and not len(corners):
            found = self._build_selection(NO_VOXELS, within, beyond, _NO_POINT_REMARK)
        elif None not in wanted and chosen and painted is None and not len(corners):
            remark = _CONFLICTING_BODY_REMARK if not chosen.issuperset(wanted) else ""
            found = replace(self.build_selection(self._unite_parts(chosen), within, beyond), remark=remark)
        else:
            found = self._select_by_network(within, beyond, corners, previous, painted)
            begins = previous is None or not previous.has_boundary
            surface = found.surface
            if begins and surface is not None and len(within) and lies_in_background(self.values, within[0], surface):
                found = self._build_selection(NO_VOXELS, within, beyond, found.remark)
        return found if found.has_boundary or found.remark else replace(found, remark=_NO_BODY_REMARK)

    def find_candidates(
        self,
        inside: ArrayLike,
        outside: ArrayLike = (),
        *,
        previous: Selection | None = None,
        excluded: Mask | None = None,
    ) -> tuple[Selection, ...]:
        """Find the different bodies that points, shape (M, 3) [voxels], may mean, from the smallest to the largest.

        One of them is the result of `select` with the same arguments. The others are the body that surfaces enclose
        around the first positive point, before it was split, and what the network predicts there.
        """
        first = self.select(inside, outside, previous=previous, excluded=excluded)
        found = [first]
        if len(first.inside):
            (at,) = self._clip_points(first.inside[:1]) * self._predictor.voxel_sides
            bodies = *self._predict_around(first.inside[:1])[1], *self._predictor.grow_bodies(at, clear=False)
            others = [self._correct_body(body, first.inside, first.outside, "") for body in bodies]
            number = self.find_body_numbers(first.inside[:1])
            if number.all():
                others.insert(0, self.build_selection(Region(surface=self.extract_boundary(number)), first.inside))
            for other in others:
                left = other if excluded is None else self.remove_pixels(other, excluded)
                if left.has_boundary and all(is_different_body(left.size, one.size) for one in found):
                    found.append(left)
        return tuple(sorted(found, key=lambda one: one.size))

    def _select_by_network(
        self, inside: Array, outside: Array, box: Array, previous: Selection | None, painted: Region | None
    ) -> Selection:
        """Select a body by the network, starting from what was selected before, or by a server."""
        within, beyond, contradicting = keep_last_marks(inside, outside, find_newer_points(inside, outside, previous))
        remark = CONFLICTING_POINT_REMARK if contradicting else ""
        if self._interest is not None:
            here, there = (self._interest[tuple(self._find_nearest_voxels(given).T)] for given in (within, beyond))
            remark = remark if here.all() and there.all() else _OUTSIDE_INTEREST_REMARK
            within, beyond = within[here], beyond[there]
        if not len(within) and not len(box):
            return self._build_selection(NO_VOXELS, inside, outside, remark)
        size = self._predictor.voxel_sides
        if self.model and painted is None:
            given = (split_lassos(self._find_nearest_voxels(places), self.shape) for places in (within, beyond))
            (held, around), (apart, away) = given
            lassos = [*((area, True) for area in around), *((area, False) for area in away)]
            mask = self._served_volume.answer(held, apart, lassos, self._find_nearest_voxels(box))
            if not mask.any():
                return self._build_selection(NO_VOXELS, inside, outside, remark)
            places = (
                held.astype(float) if len(held) else np.array([Region.from_mask(mask).find_innermost_pixel(self.shape)])
            )
            found = self._correct_body(body_from_mask(mask, size), places, apart.astype(float), remark)
            return replace(found, inside=inside, outside=outside, model=model_title(self.model))
        first = None
        if previous is not None and previous.prediction is not None:
            body = previous.prediction
        elif previous is not None and previous.has_boundary:
            body = body_from_mask(previous.mask, size)
        else:
            first = self._predict_around(within[:1])[0]
            assert first.prediction is not None
            body = first.prediction
        found = self._correct_body(body, within, beyond, remark, painted, first)
        return replace(found, inside=inside, outside=outside)

    def _correct_body(
        self,
        body: BodyPrediction,
        inside: Array,
        outside: Array,
        remark: str,
        painted: Region | None = None,
        first: Selection | None = None,
    ) -> Selection:
        """Correct a body by the points that contradict it, and find its surface, or its voxels once painted.

        `first` is what the first point alone selects.
        """
        given, size, (within, beyond) = body, self._predictor.voxel_sides, map(self._clip_points, (inside, outside))
        for places, adds in ((within, True), (beyond, False)):
            for place in places:
                if body.holds(place * size) != adds:
                    before = body
                    marks = within * size, beyond * size
                    find_other = partial(self._find_other_body, before, inside[:1], *marks)
                    body = self._predictor.correct_body(before, place * size, adds, *marks, find_other)
                    if painted is not None:
                        changed = self._find_change(before, body, place)
                        left = painted.united(changed) if adds else painted.without(changed)
                        painted = painted if left.is_empty else left
        if painted is not None:
            return replace(self.build_selection(painted, inside, outside), remark=remark)
        if first is not None and body is given and len(inside) == 1 and not len(outside):
            region = first.region
        else:
            region = self._extract_region(body, within, beyond)
        return self._build_selection(region, inside, outside, remark, body)

    def _find_other_body(
        self, body: BodyPrediction, place: Array, positive: Array, negative: Array
    ) -> BodyPrediction | None:
        """Find the body that all points mean instead of one of those around the first, shape (1, 3), if it is one."""
        _, known = self._predict_around(place)
        fits = [one for one in known if all(map(one.holds, positive)) and not any(map(one.holds, negative))]
        if not fits or not any(np.array_equal(body.logits, one.logits) for one in known):
            return None
        return find_meant_body(fits, positive[0], lambda one: self._show_body(one, place)).prediction

    def _extract_region(self, body: BodyPrediction, within: Array, beyond: Array) -> Region:
        """Extract what lies within the surface of a body in the regions of interest."""
        image, size, shown = self.image, self._predictor.voxel_sides, body
        if self._interest is not None:
            shown = replace(body, logits=np.minimum(body.logits, logits_from_mask(self._interest, size, body.crop)))
        surface = extract_body_surface(
            shown, image.values, size, within, beyond, image.spacing, image.unit, self._interest
        )
        return Region(surface=surface) if len(surface.faces) else NO_VOXELS

    def _find_change(self, before: BodyPrediction, after: BodyPrediction, place: Array) -> Region:
        """Find the voxels near a point in which a body differs from what it was before the point."""
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
        return Region.from_mask(changed, first)

    def remove_pixels(self, selection: Selection, excluded: Mask) -> Selection:
        """Remove voxels from a selection, a mask of the volume, and what they cut off from its positive points."""
        first, mask = selection.region.cut_to((0, 0, 0), self.shape)
        taken = excluded[window_at(first, mask.shape)]
        if not (mask & taken).any():
            return selection
        parts = find_connected_parts(mask & ~taken, corners=True)
        voxels = self._find_nearest_voxels(selection.inside) - first
        found = parts.part_at(voxels[lie_inside(voxels, mask.shape)])
        held = np.isin(parts.labels, found[found >= 0] + 1) if (found >= 0).any() else parts.labels > 0
        return replace(selection, region=Region.from_mask(held, first) if held.any() else NO_VOXELS)

    def build_selection(self, region: Region, inside: ArrayLike = (), outside: ArrayLike = ()) -> Selection:
        """Build the selection of a region, such as that of an object, with its points, shape (M, 3) and (K, 3)."""
        within, beyond = (as_positions(given, 3) for given in (inside, outside))
        return Selection(region, self.shape, within, beyond, image=self.image)

    def _build_selection(
        self,
        region: Region,
        inside: Array,
        outside: Array,
        remark: str,
        prediction: BodyPrediction | None = None,
    ) -> Selection:
        """Build the selection of a region; a prediction holds all positive points and no negative one."""
        if prediction is not None and not region.is_empty and remark != CONFLICTING_POINT_REMARK:
            beyond, within = (Region.from_pixels(self._find_nearest_voxels(given)) for given in (outside, inside))
            if beyond.count_shared(region) or within.count_shared(region) < within.size:
                region = region.without(beyond).united(within)
        return replace(self.build_selection(region, inside, outside), remark=remark, prediction=prediction)

    def predict_around(self, place: Array) -> tuple[Selection, ...]:
        """Predict the bodies around a point, shape (1, 3), one of which a click there means, each with its prediction.

        They differ in size, or one is part of another.
        """
        (at,) = self._clip_points(place) * self._predictor.voxel_sides
        return tuple(self._show_body(body, place) for body in self._predictor.predict_bodies(at))

    def _predict_around(self, place: Array) -> tuple[Selection, tuple[BodyPrediction, ...]]:
        """Predict the bodies around a point, shape (1, 3), and find the one that it means, as a run proposes it.

        That is a likely inner part of a body, or the body without these.
        """
        key = tuple(place[0].tolist())
        known = self._predicted_around.get(key)
        if known is None:
            (at,) = self._clip_points(place) * self._predictor.voxel_sides
            bodies = tuple(self._predictor.predict_bodies(at))
            meant = find_meant_body(bodies, at, lambda body: self._show_body(body, place))
            rest, inner = self._find_inner_bodies(meant.region)
            if inner:
                voxel, held = tuple(self._find_nearest_voxels(place)[0].tolist()), [one.region for one in inner]
                meant = self.build_selection(next((one for one in held if one.contains(voxel)), rest), place)
                body = body_from_mask(meant.mask, self.voxel_sides)
                meant, bodies = replace(meant, prediction=body), (*bodies, body)
            known = meant, bodies
            self._predicted_around.clear()
            self._predicted_around[key] = known
        return known  # another thread may have cleared the others since

    @cached_property
    def _predicted_around(self) -> dict[tuple[float, ...], tuple[Selection, tuple[BodyPrediction, ...]]]:
        """The bodies around the last point."""
        return {}

    def _show_body(self, body: BodyPrediction, place: Array) -> Selection:
        """Build the selection of a body around a point, shape (1, 3)."""
        region = self._extract_region(body, self._clip_points(place), np.empty((0, 3)))
        return replace(self.build_selection(region, place), prediction=body)

    def _clip_points(self, places: Array) -> Array:
        """Clip points to the volume."""
        return np.clip(places, 0.0, np.array(self.shape) - 1.0)

    def _find_nearest_voxels(self, places: Array) -> Index:
        """Find the nearest voxels of points."""
        return nearest_pixels(places, self.shape)

    @cached_property
    def _interest(self) -> Mask | None:
        """Voxels in the regions of interest; None when all are."""
        return self.regions.voxel_mask(self.shape) if isinstance(self.regions, VolumeRegions) else None

    @cached_property
    def _served_volume(self) -> ServedVolume:
        return ServedVolume(self.model, self.image.values, self.image.spacing)

    @cached_property
    def _predictor(self) -> BodyPredictor:
        return BodyPredictor(self.values, self.voxel_sides)

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

    def split_body(self, number: int) -> tuple[Selection, ...]:
        """Split a body at necks, as where nuclei touch, and into likely inner parts and the rest; see `rate_region`.

        One part within the surface where there is neither.
        """
        if number not in self._parts_of_bodies:
            boundary = self.extract_boundary(np.array([number]))
            found: list[Selection] = []
            for part in self._split_at_necks(Region(surface=boundary)) if len(boundary.faces) else ():
                rest, inner = self._find_inner_bodies(part)
                if not rest.is_empty:
                    rated = self.rate_region if number in self.solid_bodies else self._rate_hollow
                    found.append(rated(rest))
                found += inner
            self._parts_of_bodies[number] = tuple(found)
        return self._parts_of_bodies[number]

    def _find_inner_bodies(self, body: Region) -> tuple[Region, list[Selection]]:
        """Find what remains of a body without its likely inner parts, and these, split at necks."""
        inner = [part for part in self.find_parts_in(body) if part.confidence >= MIN_INNER_CONFIDENCE]
        return reduce(Region.without, (part.region for part in inner), body), inner

    def find_parts_in(self, body: Region) -> Iterator[Selection]:
        """Find what differs from most of a body in it, split at necks, each with its confidence, likely or not."""
        for one in () if body.is_empty else find_inner_parts(self.values, body, self.voxel_sides):
            for part in self._split_at_necks(one):
                yield rate_inner_part(self._build_marked(part), body)

    def rate_region(self, region: Region) -> Selection:
        """Build the selection of a body, with its deepest voxel as its positive point, and its confidence."""
        return rate_body(self._build_marked(region))

    def _rate_hollow(self, region: Region) -> Selection:
        """Build the selection of a hollow in a body, with its deepest voxel as its positive point."""
        return rate_inner_part(self._build_marked(region), self._solid)

    @cached_property
    def _solid(self) -> Region:
        """All bodies that are not hollows."""
        return Region.from_mask(self._parts[0][0].labels > 0)

    def _build_marked(self, region: Region) -> Selection:
        """Build the selection of a region with its deepest voxel as its positive point."""
        depth = measure_depth(region.mask)
        deepest = np.argwhere(depth == depth.max())[:1] + np.array(region.origin, float)
        return self.build_selection(region, deepest)

    def _split_at_necks(self, whole: Region) -> tuple[Region, ...]:
        """Split a region at its necks; the region itself where there is none."""
        window = expand_window(whole.window, 1, self.shape)
        labels = split_at_clear_necks(whole.cut_out(window), self.voxel_sides)
        numbers = range(1, int(labels.max(initial=0)) + 1)
        if len(numbers) < 2:
            return () if whole.is_empty else (whole,)
        return tuple(Region.from_mask(labels == each, first_pixel(window)) for each in numbers)

    def knows_bodies(self, places: Array) -> bool:
        """Return whether points, shape (N, 3) [voxels], all lie in bodies, and it is known how these are split."""
        return all(number in self._parts_of_bodies for number in self.find_body_numbers(places).tolist())

    @cached_property
    def _parts_of_bodies(self) -> dict[int, tuple[Selection, ...]]:
        """The parts of the bodies that have been split, by their numbers."""
        return {}

    def _is_painted(self, selection: Selection) -> bool:
        """Return whether a selection consists of voxels that neither its points have selected nor the network."""
        if not selection.has_boundary or selection.region.pixels is None or selection.prediction is not None:
            return False  # those of the network may be cut by excluded voxels
        chosen = set(self._find_parts(selection.inside)).difference(self._find_parts(selection.outside))
        return None in chosen or selection.region != self._unite_parts(chosen)

    def _find_parts(self, places: Array) -> list[tuple[int, int] | None]:
        """Find the body, and the part of it, that each point, shape (N, 3) [voxels], lies in; None outside all."""
        found: list[tuple[int, int] | None] = []
        for number, voxel in zip(
            self.find_body_numbers(places).tolist(), self._find_nearest_voxels(places), strict=True
        ):
            parts = self.split_body(number) if number else ()
            inside = [part.region.contains(tuple(voxel.tolist())) for part in parts] if len(parts) > 1 else [True]
            found.append((number, inside.index(True)) if number and any(inside) else None)
        return found

    def _unite_parts(self, chosen: Iterable[tuple[int, int] | None]) -> Region:
        """Unite parts of bodies; bodies of which all parts are chosen are bounded by the surface."""
        of_body: dict[int, list[int]] = {}
        for number, part in filter(None, chosen):
            of_body.setdefault(number, []).append(part)
        whole = [number for number, parts in of_body.items() if len(parts) == max(len(self.split_body(number)), 1)]
        boundary = self.extract_boundary(np.array(whole, np.int64))
        regions = [Region(surface=boundary)] if len(boundary.faces) else []
        for number in sorted(set(of_body).difference(whole)):
            regions += [self.split_body(number)[part].region for part in sorted(of_body[number])]
        return reduce(Region.united, regions) if regions else NO_VOXELS

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


def _find_most_frequent(group: Index, value: Index) -> Index:
    """Find the value that most members of each group have."""
    most, groups = int(value.max(initial=0)) + 1, int(group.max(initial=-1)) + 1
    counts = np.bincount(group * most + value, minlength=groups * most)
    return counts.reshape(groups, most).argmax(axis=1)
