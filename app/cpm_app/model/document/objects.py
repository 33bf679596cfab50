"""Objects of a document: pure edits, the object that a selection gives, and painting with a brush."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Sequence
from dataclasses import replace
from functools import reduce
from typing import Any

import numpy as np

from cpm_app.model.document import edits
from cpm_app.model.document.document import Document
from cpm_app.model.text.language import tr
from cpm_core import Bridge, Result, Selection, Surface, VolumeSelection
from cpm_core.contours import Label, PackedBody, surfaces_joined
from cpm_core.contours.contour import Contours
from cpm_core.numerics import Array, Place, Position, length, polyline, thinned
from cpm_core.numerics.polyline import as_line
from cpm_core.numerics.types import Extent, Integers, Line, Sides
from cpm_core.objects import boundaries_result
from cpm_core.objects.segmented import (
    Click,
    Halves,
    ObjectClass,
    SegmentedObject,
    SegmentedObjects,
    contours_of,
    lies_on,
    line_of,
    painted_in,
    union,
)
from cpm_core.objects.segmented.in_volumes import Part
from cpm_core.objects.segmented.segmented_object import Clicks
from cpm_core.parameters import Provenance
from cpm_core.shapes import Barrier, EnclosedRegion, EnclosingWall, Points, Polygon, Region

AnySelection = Selection | VolumeSelection
"""What has been selected, in an image or in a volume."""

_APART, _MOST_POINTS = 2.0, 4000
"""Side of the blocks of voxels that get a point on a surface, and how many points there are at most."""

_DECIMALS = 3
"""Decimals of what a session keeps of a selection, such as vertices [px], which are accurate to about a tenth."""


# Selecting


def first_clicks(item: SegmentedObject, shape: Extent) -> Clicks:
    """The clicks by which an object of an image of this shape is selected anew: its own, or one where it is widest."""
    return item.clicks or (Click((item.innermost(shape),)),)


def select(document: Document, clicks: Clicks, number: int = 0) -> Document:
    """The document in which the object of some clicks is being selected; with a number, in place of that object."""
    known = document.objects
    category = known[number].category if number and number != known.edited else known.category
    return _with(document, clicks=clicks, edited=number if clicks else 0, category=category)


Found = tuple[AnySelection, Clicks, int]
"""A selection with its clicks and the number of the object that it replaces, 0 for a new one."""


def accept(document: Document, given: Iterable[SegmentedObject], *, ends: bool = False) -> Document:
    """The document with further objects, or with other boundaries of those that it has.

    New ones get the next numbers; rejected ones, and those of other pages, keep theirs. The selection in progress is
    over where it `ends`.
    """
    objects = document.objects
    known, rejected = {item.number: item for item in objects.items}, {item.number for item in objects.rejected}
    items = dict(known)
    for one in given:
        old = known.get(one.number)
        if old is not None:
            items[old.number] = replace(
                one, name=old.name, color=old.color, category=old.category, frozen=old.frozen, hidden=old.hidden
            )
        else:
            own = one.number in rejected or one.number <= objects.taken
            number = one.number if own else max((*items, *rejected, objects.taken)) + 1
            items[number] = replace(one, number=number)
    left = tuple(item for item in objects.rejected if item.number not in items)
    over = {"clicks": (), "edited": 0} if ends else {}
    return _with(document, items=tuple(items.values()), rejected=left, **over)


def reject(document: Document, numbers: Iterable[int], offered: Iterable[SegmentedObject] = ()) -> Document:
    """The document without some objects, which are not to be proposed again, nor are others that have been."""
    gone = frozenset(numbers)
    removed = [item for item in document.objects.items if item.number in gone]
    fresh = enumerate(offered, start=document.objects.next_number)
    left = delete(document, gone)
    kept = (*left.objects.rejected, *removed, *(replace(one, number=number) for number, one in fresh))
    return _with(left, rejected=kept)


def add(document: Document, selections: Iterable[Selection], category: int) -> Document:
    """The document with one more object of a class for each selection; the selection in progress stays."""
    found = ((each, (Click(as_line(each.inside)),)) for each in selections if each.found)
    return accept(document, (made(each, clicks, document.objects.next_number, category) for each, clicks in found))


def bounded(number: int, category: int, contours: Contours, gaps: Iterable[Array] = ()) -> SegmentedObject:
    """An object that closed contours bound, with gaps where they follow nothing."""
    strength = float(np.average([one.strength for one in contours], weights=[one.length for one in contours]))
    return SegmentedObject(
        number,
        (),
        tuple(line_of(contour.points) for contour in contours),
        tuple(map(line_of, gaps)),
        strength=round(strength, _DECIMALS),
        category=category,
    )


def replace_boundaries(document: Document, found: Iterable[Found]) -> Document:
    """The document in which objects that there are have the boundaries of selections."""
    known = {item.number for item in document.objects.items}
    return accept(document, (made(*each, 1) for each in found if each[2] in known and each[0].found))


def made(selection: AnySelection, clicks: Clicks, number: int, category: int) -> SegmentedObject:
    """The object of a selection that is not empty."""
    if isinstance(selection, VolumeSelection):
        clicks = clicks if selection.voxels is None else ()  # of which what has been painted is not the answer
        return SegmentedObject(number, clicks, category=category, surface=(selection.packed,))
    confidence = round(min(max(float(selection.confidence), 0.0), 1.0), _DECIMALS)
    item = bounded(number, category, selection.contours, selection.gaps)
    return replace(item, clicks=clicks, confidence=confidence)


# The objects


def delete(document: Document, numbers: Iterable[int]) -> Document:
    """The document without some objects, rejected ones among them."""
    gone, objects = frozenset(numbers), document.objects
    left, rejected = (
        tuple(item for item in items if item.number not in gone) for items in (objects.items, objects.rejected)
    )
    over = {"clicks": (), "edited": 0} if objects.edited in gone else {}
    return _with(document, items=left, rejected=rejected, **over)


def rename(document: Document, numbers: Iterable[int], name: str) -> Document:
    """The document in which objects have a name; none when it is empty."""
    return amend(document, numbers, name=name.strip())


def classify(document: Document, numbers: Iterable[int], category: int) -> Document:
    """The document in which objects have a class, as the next ones will; own colors are removed."""
    return _with(amend(document, numbers, category=category, color=""), category=category)


def amend(document: Document, numbers: Iterable[int], **parts: Any) -> Document:
    """The document in which objects have another color (empty: that of their class), or are frozen or hidden or not."""
    chosen = frozenset(numbers)
    items = tuple(replace(item, **parts) if item.number in chosen else item for item in document.objects.items)
    return _with(document, items=items)


def merge(document: Document, numbers: Iterable[int]) -> Document:
    """The document in which several objects of its image are one: the first of them, with all their places inside."""
    chosen = frozenset(numbers)
    merged = [item for item in document.objects.items if item.number in chosen]
    return merge_into(document, merged, reduce(union, merged))


def merge_into(document: Document, merged: Iterable[SegmentedObject], whole: SegmentedObject) -> Document:
    """The document in which one object replaces several, of which it has the number of one."""
    return accept(delete(document, [item.number for item in merged if item.number != whole.number]), (whole,))


def split(document: Document, whole: SegmentedObject, halves: Halves) -> Document:
    """The document with the halves of an object, or of what may become one; the first keeps its number and name."""
    objects = document.objects
    ends = whole.number == objects.edited or whole.clicks == objects.clicks
    second = replace(halves.second, number=objects.next_number, name="")
    return accept(document, (halves.first, second), ends=ends)


def name_class(document: Document, category: int, name: str, color: str = "") -> Document:
    """The document in which a class has a name, and another color unless that is empty."""
    classes = list(document.objects.classes)
    before = classes[category - 1]
    classes[category - 1] = ObjectClass(name.strip(), color or before.color)
    return _with(document, classes=tuple(classes))


# Objects as shapes of the next run


def as_starts(document: Document, numbers: Iterable[int]) -> Document:
    """The document in which the outlines of objects are starts too; in a volume, points all over their surfaces."""
    return _with_shapes(document, numbers, Polygon, lambda surface: Points(_spread(surface.surface)))


def as_regions(document: Document, numbers: Iterable[int]) -> Document:
    """The document in which objects are regions of interest too; their holes count as inside."""
    return _with_shapes(document, numbers, Region, EnclosedRegion)


def as_barriers(document: Document, numbers: Iterable[int]) -> Document:
    """The document in which the boundaries of objects are barriers too."""
    return _with_shapes(document, numbers, lambda curve: Barrier((*curve, curve[0])), EnclosingWall, holes=True)


def _with_shapes(
    document: Document,
    numbers: Iterable[int],
    shape: Callable[[Line], Polygon | Region | Barrier],
    in_volume: Callable[[PackedBody], Points | EnclosedRegion | EnclosingWall],
    holes: bool = False,
) -> Document:
    for number in numbers:
        item = document.objects[number]
        for surface in item.surface:
            document = edits.add_shape(document, in_volume(surface))
        for curve in item.boundary if holes else item.outer:
            few = thinned(curve)
            document = edits.add_shape(document, shape(few if len(set(few)) > 2 else curve))
    return document


def _spread(surface: Surface) -> tuple[Place, ...]:
    """Corners of the triangles of a surface, one of each block of some voxels, so that there are not too many."""
    side, vertices = _APART, surface.vertices
    while len(first := np.unique(np.floor(vertices / side).astype(int), axis=0, return_index=True)[1]) > _MOST_POINTS:
        side *= 1.5
    return as_line(np.round(vertices[np.sort(first)], _DECIMALS))


# Exports


def objects_result(document: Document, only: Container[int] | None = None) -> Result | None:
    """The objects, or those with some numbers, as a result for writers: each with class, name and color.

    The contours of an object have its number as their group, and holes are marked, so that a label mask has one label
    for it and none in its holes. Gaps are bridges, whose strength is not known and 0. Hidden objects are left out; None
    when there is no other. Nothing is computed from the image, so that it can be asked for at any time.
    """
    objects, image = document.objects, document.image
    shown = [item for item in objects.items if not item.hidden and (only is None or item.number in only)]
    if image is None or not shown:
        return None
    surface = surface_of(shown, image.spacing, image.unit)
    if surface is not None:
        labels = tuple(Label(item.number, title(objects, item), objects.color(item)) for item in shown)
        surface = replace(surface, labels=labels)
    contours = [
        replace(
            contour,
            name=title(objects, item),
            color=objects.color(item),
            group=item.number,
            category=class_title(objects, item.category),
        )
        for item in shown
        for contour in contours_of(item)
    ]
    bridges = [Bridge(np.array(gap), length(gap), 0.0) for item in shown for gap in item.gaps]
    found = boundaries_result(contours, bridges, image.shape, image.spacing, image.unit, image.name)
    return replace(found, surface=surface, provenance=Provenance("objects", sha256=image.sha256))


def surface_of(items: Iterable[SegmentedObject], spacing: Sides, unit: str | None) -> Surface | None:
    """The surfaces of objects in a volume as one, with the number of its object for each triangle."""
    bodies = [(item.number, item.body) for item in items if item.body is not None]
    return surfaces_joined(bodies, spacing, unit) if bodies else None


# Texts


def title(objects: SegmentedObjects, item: SegmentedObject) -> str:
    """Name of an object, or the name of its class, if it has one, and its number."""
    return item.name or f"{objects.classes[item.category - 1].name or tr('object')} {item.number}"


def class_title(objects: SegmentedObjects, category: int) -> str:
    """Name of a class, or "object" for the first one and "class" with its number for others."""
    name = objects.classes[category - 1].name
    if name:
        return name
    return tr("object") if category == 1 else tr("class {number}", number=category)


def listed_classes(objects: SegmentedObjects) -> Integers:
    """Numbers of the classes that are in use or have a name, and the next one."""
    used = {objects.category, *(item.category for item in objects.items)}
    listed = [number for number, known in enumerate(objects.classes, start=1) if number in used or known.name]
    free = [number for number in range(1, len(objects.classes) + 1) if number not in listed][:1]
    return tuple(sorted((*listed, *(free if objects.items else ()))))


def _with(document: Document, **parts: Any) -> Document:
    return replace(document, objects=replace(document.objects, **parts))


def paint_in_volume(
    document: Document, number: int, part: Part, adds: bool = True, over_others: bool = True
) -> Document:
    """The document in which an object of a volume, or a new one, has some voxels more, or less; see `painted_in`."""
    return replace(document, objects=painted_in(document.objects, number, part, adds, over_others))


_ON_BRUSH = 0.1
"""Difference between the distance from the path of the brush and its radius up to which a vertex is painted [px]."""


def brushed(
    document: Document,
    before: SegmentedObject | None,
    number: int,
    boundary: tuple[Line, ...],
    path: Sequence[Position],
    radius: float,
) -> Document:
    """The document in which an object has the boundary that a brush has given it.

    Parameters
    ----------
    document : Document
        What is edited.
    before : SegmentedObject or None
        The object as it was before the stroke of the brush; None for a new one.
    number : int
        The number of the object.
    boundary : tuple of tuple
        Closed curves (row, col) [px]; where there is none, the object is gone.
    path : sequence of (row, col)
        The way of the brush [px]. What its edge has made of the boundary follows no contour.
    radius : float
        Radius of the brush [px].

    Returns
    -------
    Document
        The object without clicks, of which the boundary is no longer the answer.
    """
    if not boundary:
        return delete(document, (number,))
    made = before or SegmentedObject(number, (), boundary, category=document.objects.category)
    kept = tuple(gap for gap in made.gaps if lies_on(gap, boundary))
    painted = []
    for points in map(np.array, boundary):
        on = np.abs(polyline.distances(path, points) - radius) <= _ON_BRUSH
        runs = (points[run].tolist() for run in polyline.stretches(on, closed=True) if len(run) > 1)
        painted += [tuple(map(tuple, run)) for run in runs]
    new = replace(made, clicks=(), boundary=boundary, gaps=(*kept, *painted))
    return accept(document, (new,), ends=document.objects.edited == number)
