"""Segmented objects: the objects of an image and their classes, as a session keeps them."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import scipy

from cpm_core.contours.contour import Contour, check_color
from cpm_core.contours.packed_surface import PackedBody
from cpm_core.contours.surface import Surface
from cpm_core.image.volume_regions import Voxels
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Extent, Line, Mask, Place, Position, Sides, frozen
from cpm_core.objects.selection import Selection

CLASS_COUNT = 9
"""Number of classes, one for each digit key."""

_PIXELS_PER_TEST = 2**20
"""Pixels that are tested at once, so that a large image takes little memory."""


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
    """An object of an image with its boundary.

    Attributes
    ----------
    number : int
        Number that stays the same as long as the object exists, from 1.
    clicks : tuple of Click
        Clicks that it was selected by, in order; empty if it was found otherwise.
    boundary : tuple of tuple
        Closed curves of vertices (row, col) in px of the image, the first vertex not repeated: outer boundaries and
        holes. A place is inside when an odd number of them encloses it. Empty for an open object.
    gaps : tuple of tuple
        Stretches of the boundary that follow no contour.
    confidence : float
        Confidence in the boundary, from 0 to 1.
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
    surface : tuple of PackedSurface or PackedVoxels
        The boundary of an object in a volume, which has no closed curves, or its voxels once it has been painted; empty
        in an image.
    line : tuple of (row, col)
        The vertices of an open object in px of the image: a line that encloses nothing; empty for any other object.

    Raises
    ------
    ValueError
        When a value is out of range.
    """

    number: int
    clicks: Clicks
    boundary: tuple[Line, ...] = ()
    gaps: tuple[Line, ...] = ()
    confidence: float = 0.0
    strength: float = 0.0
    name: str = ""
    color: str = ""
    category: int = 1
    frozen: bool = False
    hidden: bool = False
    surface: tuple[PackedBody, ...] = ()
    line: Line = ()

    def __post_init__(self) -> None:
        if self.number < 1:
            raise ValueError(f"The number of an object is {self.number} but must be at least 1.")
        if len(self.surface) > 1 or bool(self.surface) + bool(self.boundary) + bool(self.line) > 1:
            raise ValueError("An object has one surface in a volume, or closed curves or a line in an image, not more.")
        if self.line and len({*self.line}) < 2:
            raise ValueError("The line of an object needs at least two different points.")
        empty = not (self.boundary or self.surface or self.line)
        if empty or any(len({*curve[:3]}) < 3 > len({*curve}) for curve in self.boundary):
            raise ValueError("The boundary of an object needs closed curves of at least three different points each.")
        if not 1 <= self.category <= CLASS_COUNT:
            raise ValueError(f"The class of an object is {self.category} but must be from 1 to {CLASS_COUNT}.")
        if not 0.0 <= self.confidence <= 1.0:
            raise ValueError(f"The confidence of an object is {self.confidence} but must be from 0 to 1.")
        check_color("an object", self.color)

    @property
    def unpacked_surface(self) -> Surface | None:
        """Its boundary in a volume [voxels]; None in an image."""
        return self.surface[0].surface if self.surface else None

    @property
    def inside(self) -> Array:
        """Positive points, shape (M, D) [px]."""
        return collect_points(self.clicks, inside=True)

    @property
    def outside(self) -> Array:
        """Negative points, shape (K, D) [px]."""
        return collect_points(self.clicks, inside=False)

    def encloses(self, places: Array) -> Mask:
        """Return which points, shape (N, 2) or (N, 3) [px], lie inside, shape (N,); in a volume the nearest voxels."""
        found = np.zeros(len(places), bool)
        for packed in self.surface:
            voxels = np.rint(places).astype(np.int64)
            found |= [bool(packed.as_packed_voxels.mask_in_box(voxel, (1, 1, 1)).all()) for voxel in voxels]
        for curve in self.boundary:
            found ^= polyline.points_inside(curve, places)
        return found

    def mask(self, shape: Extent) -> Mask:
        """Return the pixels or voxels of an image or a volume of this shape whose centers lie inside."""
        found = np.zeros(shape, bool)
        self.fill_into(found)
        return found

    def fill_into(self, mask: Mask) -> None:
        """Set the pixels or voxels of a mask whose centers lie inside."""
        for packed in self.surface:
            packed.voxels.fill_into(mask)
        if not self.surface:
            (top, left), window = self._rasterize_window(mask.shape)
            mask[top : top + window.shape[0], left : left + window.shape[1]] |= window

    @property
    def outer_curves(self) -> tuple[Line, ...]:
        """The curves of the boundary that do not bound holes."""
        if len(self.boundary) == 1:
            return self.boundary
        around = [
            sum(
                bool(polyline.points_inside(other, np.array(curve[:1]))[0])
                for other in self.boundary
                if other is not curve
            )
            for curve in self.boundary
        ]
        return tuple(curve for curve, count in zip(self.boundary, around, strict=True) if count % 2 == 0)

    @property
    def area(self) -> float:
        """Area without holes [px²]."""
        outer = self.outer_curves
        return float(sum(polyline.enclosed_area(curve) * (1.0 if curve in outer else -1.0) for curve in self.boundary))

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
        return tuple(np.array((*curve, curve[0])) for curve in self.boundary)

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

    def find_innermost_pixel(self, shape: Extent) -> Place:
        """Find the pixel (row, col) inside that is farthest from the boundary and from the border of the image.

        A vertex when no pixel lies inside; in a volume the innermost pixel of the plane with most voxels.
        """
        plane: Place = ()
        if self.surface:
            voxels = self.surface[0].voxels
            at = int(voxels.mask.sum(axis=(1, 2)).argmax())
            above, *first = voxels.first or (0, 0, 0)
            window, plane = voxels.mask[at], (float(above + at),)
        else:
            (*first,), window = self._rasterize_window(shape)
        if not window.any():
            return (self.line or self.boundary[0])[0]
        depth = scipy.ndimage.distance_transform_edt(np.pad(window, 1))[1:-1, 1:-1]
        row, col = np.unravel_index(int(np.argmax(depth)), window.shape)
        return (*plane, float(row + first[0]), float(col + first[1]))

    @cached_property
    def _windows(self) -> dict[Extent, tuple[tuple[int, int], Mask]]:
        """What `_rasterize_window` has found, by the shape of the image: each answer to a click needs all objects."""
        return {}

    def _rasterize_window(self, shape: Extent) -> tuple[tuple[int, int], Mask]:
        """Rasterize the boundary: first row and column of the part of the image around it, and its pixels inside.

        Boundaries may reach far beyond the image.
        """
        if shape in self._windows:
            return self._windows[shape]
        low, high = self.box
        top, left = np.clip(np.floor(low), 0, shape).astype(int).tolist()
        bottom, right = np.clip(np.ceil(high) + 1, (top, left), np.maximum(shape, (top, left))).tolist()
        rows, cols = np.arange(top, bottom), np.arange(left, right)
        window = np.zeros((len(rows), len(cols)), bool)
        height = max(1, _PIXELS_PER_TEST // max(1, len(cols)))
        for first in range(0, len(rows), height):
            part = window[first : first + height]
            places = np.stack(np.meshgrid(rows[first : first + height], cols, indexing="ij"), axis=-1).reshape(-1, 2)
            part[:] = self.encloses(places.astype(float)).reshape(part.shape)
        self._windows[shape] = (top, left), window
        return self._windows[shape]


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
        Rejected objects, which are not proposed again.
    taken : int
        Numbers up to this one are reserved for objects on other pages.
    may_overlap : bool
        Whether what is selected or painted may run over other objects, unless these are frozen.

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

    def __post_init__(self) -> None:
        if len(self.classes) != CLASS_COUNT:
            raise ValueError(f"There are {len(self.classes)} classes of objects but there must be {CLASS_COUNT}.")
        if not 1 <= self.category <= CLASS_COUNT:
            raise ValueError(f"The class is {self.category} but must be from 1 to {CLASS_COUNT}.")
        numbers = [item.number for item in (*self.items, *self.rejected)]
        if len(set(numbers)) < len(numbers):
            raise ValueError("Two objects have the same number; each needs one of its own.")
        if self.edited and self.edited not in numbers[: len(self.items)]:
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
        return max(self.taken, *(item.number for item in (*self.items, *self.rejected)), 0) + 1

    @property
    def barriers(self) -> tuple[Line | Voxels, ...]:
        """Boundaries of frozen objects, which particles do not cross: lines, or voxels in a volume."""
        frozen = [item for item in self.items if item.frozen]
        lines = [(*curve, curve[0]) for item in frozen for curve in item.boundary]
        lines += [item.line for item in frozen if item.line]
        return (*lines, *(packed.shell for item in frozen for packed in item.surface))

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
    """Build the selection of an object in an image of this shape."""
    return Selection(
        mask=item.mask(shape),
        contours=contours_from_object(item),
        gaps=tuple(np.array(gap) for gap in item.gaps),
        confidence=item.confidence,
        inside=item.inside,
        outside=item.outside,
    )


def contours_from_object(item: SegmentedObject) -> tuple[Contour, ...]:
    """Return the boundary of an object as closed contours, holes marked as such, or its line as an open contour."""
    if item.line:
        return (Contour(np.array(item.line), False, item.strength),)
    outer = item.outer_curves
    return tuple(Contour(np.array(curve), True, item.strength, hole=curve not in outer) for curve in item.boundary)
