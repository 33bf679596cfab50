"""Segmented objects: the objects of an image and their classes, as a session keeps them."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.image.colors import check_color
from cpm_core.image.region import Region
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Extent, Line, Place, Position, Sides, frozen
from cpm_core.objects.selection import Selection

CLASS_COUNT = 9
"""Number of classes, one for each digit key."""


@frozen
class Click:
    """Positive or negative points of an object that were given in one gesture.

    Attributes
    ----------
    places : tuple of tuple of float
        Positions (row, col) in px of the image, or (plane, row, col) in voxels, at least one.
    inside : bool
        Whether they are positive: inside the object.
    step : int
        How many candidates larger (above 0) or smaller (below 0) than the first one the selected candidate is.

    Raises
    ------
    ValueError
        When there is no point.
    """

    places: tuple[Place, ...]
    inside: bool = True
    step: int = 0

    def __post_init__(self) -> None:
        if not self.places:
            raise ValueError("A click has no position: give at least one, (row, col).")


Clicks = tuple[Click, ...]
"""Clicks, one after the other."""


@frozen
class ObjectClass:
    """A class of objects: its name, which may be empty, and its color, ``"#rrggbb"``."""

    name: str
    color: str

    def __post_init__(self) -> None:
        if not self.color:
            raise ValueError("A class has no color: give it one.")
        check_color("a class", self.color)


@frozen
class SegmentedObject:
    """An object of an image or a volume.

    Attributes
    ----------
    number : int
        Number that stays the same as long as the object exists, from 1.
    clicks : tuple of Click
        Clicks that it was selected by, in order; empty if it was found otherwise.
    region : Region
        Its pixels with their boundary; in a volume its surface, its voxels, or both once it has been painted. Empty
        for an open object.
    gaps : tuple of tuple
        Stretches of the boundary that follow no contour.
    confidence : float
        Confidence in the boundary, from 0 to 1; 0 where it is unknown, as once it has been edited by hand.
    strength : float
        Mean edge strength along the boundary [gray levels / px].
    name, color : str
        Given by the user, or empty; the color as ``"#rrggbb"``.
    category : int
        Number of its class, 1 to 9.
    frozen : bool
        Whether it keeps its boundary and is a barrier for particles.
    hidden : bool
        Whether it is not shown.
    opacity : float
        How opaque it is shown, from 0 to 1.
    line : tuple of (row, col)
        The vertices of an open object in px of the image: a line that encloses nothing; empty for any other object.
    model : str
        The larger model that found it; see `Selection.model`.

    Raises
    ------
    ValueError
        When a value is out of range.
    """

    number: int
    clicks: Clicks
    region: Region = Region()
    gaps: tuple[Line, ...] = ()
    confidence: float = 0.0
    strength: float = 0.0
    name: str = ""
    color: str = ""
    category: int = 1
    frozen: bool = False
    hidden: bool = False
    opacity: float = 1.0
    line: Line = ()
    model: str = ""

    def __post_init__(self) -> None:
        if self.number < 1:
            raise ValueError(f"The number of an object is {self.number} but must be at least 1.")
        if self.line and not self.region.is_empty:
            raise ValueError("An object has a region or a line, not both.")
        if self.line and len({*self.line}) < 2:
            raise ValueError("The line of an object needs at least two different points.")
        if self.region.ndim == 3 and self.region.is_empty:
            raise ValueError("An object in a volume needs at least one voxel.")
        empty = self.region.is_empty and not self.line
        if empty or any(len({*curve[:3]}) < 3 > len({*curve}) for curve in self.region.boundary):
            raise ValueError("The boundary of an object needs closed curves of at least three different points each.")
        if not 1 <= self.category <= CLASS_COUNT:
            raise ValueError(f"The class of an object is {self.category} but must be from 1 to {CLASS_COUNT}.")
        if not 0.0 <= self.confidence <= 1.0:
            raise ValueError(f"The confidence of an object is {self.confidence} but must be from 0 to 1.")
        if not 0.0 <= self.opacity <= 1.0:
            raise ValueError(f"The opacity of an object is {self.opacity} but must be from 0 to 1.")
        check_color("an object", self.color)

    @property
    def inside(self) -> Array:
        """Positive points, shape (M, D) [px]."""
        return collect_points(self.clicks, inside=True)

    @property
    def outside(self) -> Array:
        """Negative points, shape (K, D) [px]."""
        return collect_points(self.clicks, inside=False)

    def redrawn(self, region: Region, gaps: tuple[Line, ...] = ()) -> SegmentedObject:
        """Return the object with a region that the user has made: no clicks explain it, and no confidence is known."""
        return replace(self, clicks=(), region=region, gaps=gaps, confidence=0.0)

    def measure_perimeter(self, spacing: Sides = (1.0, 1.0)) -> float:
        """Measure the length of the boundary, holes included, or of the line, in the unit of the size of a pixel."""
        return sum(polyline.path_length(path * spacing) for path in self.paths)

    def measure_gap_length(self, spacing: Sides = (1.0, 1.0)) -> float:
        """Measure the length of the gaps: stretches of the boundary off the contours, in the unit of a pixel's size."""
        return sum(polyline.path_length(np.array(gap) * spacing) for gap in self.gaps)

    @cached_property
    def paths(self) -> tuple[Array, ...]:
        """The curves of the boundary with their first vertex repeated, or the line, each of shape (K, 2) [px]."""
        if self.line:
            return (np.array(self.line),)
        return tuple(np.array((*curve, curve[0])) for curve in self.region.boundary)

    @cached_property
    def box(self) -> tuple[Array, Array]:
        """Lowest and highest row and column of the boundary or the line, each of shape (2,) [px]."""
        corners = np.concatenate(self.paths)
        return corners.min(axis=0), corners.max(axis=0)

    @property
    def center(self) -> Position:
        """Center (row, col) of the box around the boundary [px]."""
        low, high = self.box
        row, col = (0.5 * (low + high)).tolist()
        return row, col


DEFAULT_CLASSES: tuple[ObjectClass, ...] = tuple(
    ObjectClass("", color)
    for color in (
        "#e69f00",
        "#009e73",
        "#cc79a7",
        "#f0e442",
        "#d55e00",
        "#b48cff",
        "#56b4e9",
        "#0072b2",
        "#b08968",
    )
)
"""The default classes: hues after Okabe and Ito, which color-blind people can distinguish, and two more."""


@frozen
class SegmentedObjects:
    """The objects of an image, their classes, and the selection that is being made.

    Attributes
    ----------
    items : tuple of SegmentedObject
        The objects, in the order in which they were accepted.
    classes : tuple of ObjectClass
        Classes 1 to 9.
    category : int
        Number of the class that the next object gets.
    clicks : tuple of Click
        Clicks of the selection that is being made.
    edited : int
        Number of the object that the selection changes; 0 for a new one.
    rejected : tuple of SegmentedObject
        Rejected objects, which are not proposed again, and whose numbers others may get.
    taken : int
        Numbers up to this one are reserved for objects on other pages.
    may_overlap : bool
        Whether what is selected or painted may run over other objects, unless these are frozen.
    deleted : tuple of SegmentedObject
        Objects deleted since the last run began, which are not proposed again until the next one begins.

    Raises
    ------
    ValueError
        When there are not nine classes, a number is out of range, or two objects have the same one.
    """

    items: tuple[SegmentedObject, ...] = ()
    classes: tuple[ObjectClass, ...] = DEFAULT_CLASSES
    category: int = 1
    clicks: Clicks = ()
    edited: int = 0
    rejected: tuple[SegmentedObject, ...] = ()
    taken: int = 0
    may_overlap: bool = False
    deleted: tuple[SegmentedObject, ...] = ()

    def __post_init__(self) -> None:
        if len(self.classes) != CLASS_COUNT:
            raise ValueError(f"There are {len(self.classes)} classes of objects but there must be {CLASS_COUNT}.")
        if not 1 <= self.category <= CLASS_COUNT:
            raise ValueError(f"The class is {self.category} but must be from 1 to {CLASS_COUNT}.")
        numbers = [item.number for item in self.items]
        if len(set(numbers)) < len(numbers):
            raise ValueError("Two objects have the same number; each needs one of its own.")
        if self.edited and self.edited not in numbers:
            raise ValueError(f"The object being changed is number {self.edited}, but there is none with this number.")

    def __getitem__(self, number: int) -> SegmentedObject:
        """Return the object of a number; KeyError when there is none."""
        for item in self.items:
            if item.number == number:
                return item
        raise KeyError(number)

    @property
    def next_number(self) -> int:
        """A number that no object has."""
        return max((self.taken, *(item.number for item in self.items))) + 1

    @property
    def dismissed(self) -> tuple[SegmentedObject, ...]:
        """The objects that are not proposed again."""
        return self.rejected + self.deleted

    @property
    def barriers(self) -> tuple[Line | Region, ...]:
        """Boundaries of frozen objects, which particles do not cross: lines, or voxels in a volume."""
        frozen = [item for item in self.items if item.frozen]
        lines = [(*curve, curve[0]) for item in frozen for curve in item.region.boundary]
        lines += [item.line for item in frozen if item.line]
        return (*lines, *(item.region.shell for item in frozen if item.region.ndim == 3))

    def color_of(self, item: SegmentedObject) -> str:
        """Return the color of an object: its own, or that of its class."""
        return item.color or self.classes[item.category - 1].color


def class_label(category: int, name: str = "") -> str:
    """Return what files call a class: its name, else "object" for the first one and "class" with its number."""
    return name or ("object" if category == 1 else f"class {category}")


def object_label(number: int, name: str = "", class_name: str = "") -> str:
    """Return what files call an object: its name, else that of its class, or "object", with its number."""
    return name or f"{class_name or 'object'} {number}"


def collect_points(clicks: Clicks, *, inside: bool) -> Array:
    """Collect the positive points of clicks, or the negative ones, shape (N, D) [px]."""
    found = [place for click in clicks if click.inside == inside for place in click.places]
    return np.array(found, dtype=float).reshape(-1, len(clicks[0].places[0]) if clicks else 2)


def selection_from_object(item: SegmentedObject, shape: Extent) -> Selection:
    """Build the selection of an object in an image or a volume of this shape."""
    return Selection(
        region=item.region,
        shape=shape,
        inside=item.inside.reshape(-1, len(shape)),
        outside=item.outside.reshape(-1, len(shape)),
        contours=contours_from_object(item),
        gaps=tuple(np.array(gap) for gap in item.gaps),
        confidence=item.confidence if len(shape) == 2 else item.confidence or np.nan,
        model=item.model,
    )


def contours_from_object(item: SegmentedObject) -> tuple[Contour, ...]:
    """Return the boundary of an object as closed contours, holes marked as such, or its line as an open contour."""
    if item.line:
        return (Contour(np.array(item.line), False, item.strength),)
    outer = item.region.outer_curves
    curves = item.region.boundary
    return tuple(Contour(np.array(curve), True, item.strength, hole=curve not in outer) for curve in curves)
