"""The bodies into which closed surfaces part a volume, and the choice of an object among them by clicks.

A body is a connected part of the volume without the surface: what a surface encloses, or what lies between two of them,
such as the wall of a shell and the hollow in it. Its boundary are the components of the surface next to it, and its
volume and area are those of the triangles, not of voxels. Nothing is closed across gaps here, nor chosen by gray
levels: a click selects the body that it lies in, a further one adds another body, and one outside takes a body away.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.contours.packed_surface import PackedSurface
from cpm_core.contours.surface import Surface, inside_of
from cpm_core.image.image import Image
from cpm_core.numerics.grids import Parts, parts_of
from cpm_core.numerics.real_numbers import as_places
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.parameters.quotation import counted, described, sized

_BESIDE = 0.75
"""Distance from a surface at which the bodies on both sides are looked up [smallest sides of a voxel]."""

_OUTSIDE = "A place that no surface encloses counts for nothing: click inside an object."
_NOWHERE = "No place has been said to be inside."
_SAME = "The same body has been said to be inside and outside; it is left out."
_THIN = "The object at this place is thinner than a voxel, and has no boundary of its own."


@dataclass(frozen=True, eq=False)
class VolumePartition:
    """A volume that closed surfaces cut into bodies.

    Attributes
    ----------
    image : Image
        The volume.
    surface : Surface
        The surfaces along which it is cut, all in one.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("ball"), cpm.sphere((15, 15, 15), 4, 60), cpm.PRESETS["volume"])
    >>> bodies = cpm.partition(result)
    >>> bodies.bodies_at(np.array([(15.0, 15.0, 15.0)])).tolist(), bodies.boundary_of(np.array([1])).closed
    ([1], True)
    >>> bodies.shape, int(bodies.labels.max()), bodies.solid.tolist(), bodies.select([(15, 15, 15)]).remark
    ((31, 31, 31), 1, [1], '')
    """

    image: Image
    surface: Surface

    def __post_init__(self) -> None:
        if not self.surface.closed:
            raise ValueError(
                f"{self.image.source} has no closed surface, so nothing is enclosed: run until the particles are "
                "at rest."
            )

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the volume."""
        return self.image.shape

    @property
    def labels(self) -> Index:
        """Body of every voxel, shape (P, R, C), from 1 up; 0 outside all surfaces."""
        return np.asarray(sum(parts.labels_of(number) for parts, number in self._parts))

    @cached_property
    def _parts(self) -> tuple[tuple[Parts, Index], ...]:
        """Parts of voxels inside the surface, and of those outside it, with the number of the body of each part."""
        inside = inside_of(self.surface, self.shape)
        found = []
        count = 0
        for part, corners in ((inside, True), (~inside, False)):
            parts = parts_of(part, corners=corners)
            enclosed = np.ones(parts.count, np.bool_) if corners else ~parts.at_border
            found.append((parts, np.where(enclosed, count + np.cumsum(enclosed), 0)))
            count += int(enclosed.sum())
        return tuple(found)

    @property
    def solid(self) -> Index:
        """Numbers of the bodies inside the surface; the others are hollows in them."""
        return self._parts[0][1]

    def select(
        self, inside: ArrayLike, outside: ArrayLike = (), *, previous: VolumeSelection | None = None
    ) -> VolumeSelection:
        """Choose the bodies that some places lie in, and leave out those that others lie in.

        Parameters
        ----------
        inside, outside : array_like, shape (M, 3) and (K, 3)
            Places (plane, row, col) [voxels]. A place outside the volume counts as the nearest one in it.
        previous : VolumeSelection, optional
            What was chosen before; the places are added to its own.

        Returns
        -------
        VolumeSelection
            Empty when no place lies in a body.

        Raises
        ------
        ValueError
            When the places are not planes, rows and columns.
        """
        within, beyond = (as_places(given, "planes, rows and columns") for given in (inside, outside))
        if previous is not None:
            within = np.concatenate([previous.inside, within])
            beyond = np.concatenate([previous.outside, beyond])
        wanted, unwanted = self.bodies_at(within), self.bodies_at(beyond)
        chosen = np.setdiff1d(wanted[wanted > 0], unwanted)
        found = VolumeSelection(self, chosen, within, beyond)
        if not len(within):
            return replace(found, remark=_NOWHERE)
        if np.isin(wanted[wanted > 0], unwanted).any():
            return replace(found, remark=_SAME)
        if not wanted.all():
            return replace(found, remark=_OUTSIDE)
        return found if found.found else replace(found, remark=_THIN)

    def bodies_at(self, places: Array) -> Index:
        """Numbers of the bodies that places, shape (N, 3) [voxels], lie in, 0 outside all."""
        voxels = np.clip(np.rint(places), 0, np.array(self.shape) - 1).astype(np.int64)
        found = np.zeros(len(voxels), np.int64)
        for parts, number in self._parts:
            part = parts.part_at(voxels)
            found[part >= 0] = number[part[part >= 0]]
        return found

    def boundary_of(self, chosen: Index) -> Surface:
        """The components of the surface that bound bodies, turned outward; none between two of them."""
        within, beyond = (np.isin(side, chosen) for side in self._sides)
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
    def _sides(self) -> tuple[Index, Index]:
        """The body inside each component of the surface, and the one outside it: those most of its vertices tell."""
        surface = self.surface
        step = _BESIDE * min(surface.spacing) * surface.normals / np.array(surface.spacing)
        inner, outer = self.bodies_at(surface.vertices - step), self.bodies_at(surface.vertices + step)
        return _most_frequent(surface.component_of_vertex, inner), _most_frequent(surface.component_of_vertex, outer)

    def __repr__(self) -> str:
        return described("VolumePartition", self.image.source, sized(self.shape, "voxels"))


@dataclass(frozen=True, eq=False)
class VolumeSelection:
    """Bodies that have been chosen by clicks in a volume.

    Attributes
    ----------
    partition : VolumePartition
        What they are parts of.
    bodies : ndarray of int, shape (B,)
        Their numbers in `VolumePartition.labels`, ascending.
    inside, outside : ndarray, shape (M, 3) and (K, 3)
        The places that have been said to be inside and outside [voxels].
    remark : str
        One sentence on what was unusual about the places, or empty.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("ball"), cpm.sphere((15, 15, 15), 4, 60), cpm.PRESETS["volume"])
    >>> chosen = cpm.partition(result).select([(15, 15, 15)])
    >>> chosen
    <VolumeSelection ball, 1 body>
    >>> round(chosen.volume / result.surface.volume, 3), round(chosen.area / result.surface.area, 3)
    (1.0, 1.0)
    >>> chosen.mask.shape, chosen.surface.closed, chosen.found, chosen.only_places, chosen.same(chosen)
    ((31, 31, 31), True, True, False, True)
    >>> chosen.holds(np.array([(15.0, 15.0, 15.0), (2.0, 2.0, 2.0)])).tolist()
    [True, False]
    >>> chosen.packed.surface.closed
    True
    """

    partition: VolumePartition = field(repr=False)
    bodies: Index
    inside: Array
    outside: Array
    remark: str = ""

    @cached_property
    def mask(self) -> Mask:
        """Voxels whose centers lie in them, shape (P, R, C)."""
        return np.isin(self.partition.labels, self.bodies)

    @cached_property
    def surface(self) -> Surface:
        """Their boundary: its triangles are turned outward, away from the bodies."""
        return self.partition.boundary_of(self.bodies)

    @cached_property
    def packed(self) -> PackedSurface:
        """Their boundary as a session holds it; ValueError when it is empty."""
        return PackedSurface.of(self.surface)

    @property
    def found(self) -> bool:
        """Whether they have a boundary."""
        return bool(len(self.surface.faces))

    @property
    def only_places(self) -> bool:
        """Never: a body is more than the places in it."""
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
        return described("VolumeSelection", self.partition.image.source, counted(len(self.bodies), "body", "bodies"))

    def same(self, other: VolumeSelection) -> bool:
        """Whether the same bodies have been chosen."""
        return np.array_equal(self.bodies, other.bodies)

    def holds(self, places: Array) -> Mask:
        """Which of places, shape (N, 3) [voxels], lie in it; one outside the volume counts as the nearest one in it."""
        return np.isin(self.partition.bodies_at(places), self.bodies)


def _most_frequent(group: Index, value: Index) -> Index:
    """The value that most members of each group have."""
    most, groups = int(value.max(initial=0)) + 1, int(group.max(initial=-1)) + 1
    counts = np.bincount(group * most + value, minlength=groups * most)
    return counts.reshape(groups, most).argmax(axis=1)
