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
from cpm_core import Result, Selection, Surface, containment
from cpm_core.contours import select_bridges_on
from cpm_core.contours.contour import Contours
from cpm_core.image.region import Region
from cpm_core.numerics import Array, Place, Position, polyline, simplify_path
from cpm_core.numerics.polyline import as_line
from cpm_core.numerics.types import Extent, Integers, Line
from cpm_core.objects.segmented import (
    Click,
    Halves,
    ObjectClass,
    SegmentedObject,
    SegmentedObjects,
    lies_on,
    paint_voxels,
    round_line,
    unite_objects,
)
from cpm_core.objects.segmented.segmented_object import Clicks
from cpm_core.parameters import Provenance
from cpm_core.results import add_segmented_objects, boundaries_result
from cpm_core.shapes import Barrier, EnclosedRegion, EnclosingWall, Points, Polygon, PolygonRegion, Stroke

_SURFACE_BLOCK_SIDE = 2.0
"""Side of the blocks of voxels that get at most one point on a surface."""

_MAX_SURFACE_POINTS = 4000
"""Largest number of points on a surface."""

_SESSION_DECIMALS = 3
"""Decimals of selections in session files, such as of vertices [px], which are accurate to about a tenth."""


# Selecting


def initial_clicks(item: SegmentedObject, shape: Extent) -> Clicks:
    """Return the clicks that select an object in an image of this shape: its own, or one where it is widest."""
    return item.clicks or (Click((item.line[0] if item.line else item.region.find_innermost_pixel(shape),)),)


def set_selection_clicks(document: Document, clicks: Clicks, number: int = 0) -> Document:
    """Set the clicks of the selection in progress; with a number, it is to replace that object."""
    known = document.objects
    category = known[number].category if number and number != known.edited else known.category
    return _replace_objects(document, clicks=clicks, edited=number if clicks else 0, category=category)


SelectionUpdate = tuple[Selection, Clicks, int]
"""A selection with its clicks and the number of the object that it replaces, 0 for a new one."""


_KEPT_PROPERTIES = ("name", "color", "category", "frozen", "hidden", "opacity")
"""What an object keeps when its boundary is replaced."""


def accept_objects(document: Document, accepted: Iterable[SegmentedObject], *, ends: bool = False) -> Document:
    """Add objects, or replace the boundaries of existing ones with the same numbers.

    New objects get the next numbers; those of other pages keep theirs. The selection in progress is cleared if it
    `ends`.
    """
    objects = document.objects
    known = {item.number: item for item in objects.items}
    items = dict(known)
    for one in accepted:
        old = known.get(one.number)
        if old is not None:
            kept = {name: getattr(old, name) for name in _KEPT_PROPERTIES}
            if one.region.pixels is not None and not old.clicks:
                kept["clicks"] = ()  # clicks on what has been painted in a volume do not explain it
            items[old.number] = replace(one, **kept)
        else:
            number = one.number if one.number <= objects.taken else max((*items, objects.taken)) + 1
            items[number] = replace(one, number=number)
    over = {"clicks": (), "edited": 0} if ends else {}
    return _replace_objects(document, items=tuple(items.values()), **over)


def with_taken_numbers(document: Document, taken: int) -> Document:
    """Let new objects get numbers above the taken ones, which are those of objects on other pages."""
    return _replace_objects(document, taken=max(document.objects.taken, taken))


def reject_objects(document: Document, numbers: Iterable[int], offered: Iterable[SegmentedObject]) -> Document:
    """Reject objects, and proposals in `offered`, none of which will be proposed again."""
    gone = frozenset(numbers)
    removed = (item for item in document.objects.items if item.number in gone)
    kept = (*document.objects.rejected, *removed, *offered)
    return _replace_objects(delete_objects(document, gone), rejected=kept, deleted=document.objects.deleted)


def object_from_contours(number: int, category: int, contours: Contours, gaps: Iterable[Array] = ()) -> SegmentedObject:
    """Make an object of closed contours, or of an open one.

    Parameters
    ----------
    number, category : int
        Number and class of the object.
    contours : sequence of Contour
        Its boundaries, at least one, or a single open contour.
    gaps : iterable of ndarray, shape (K, 2)
        Stretches of the boundary that follow no edge [px].
    """
    strength = float(np.average([one.strength for one in contours], weights=[one.length for one in contours]))
    curves = tuple(round_line(contour.points) for contour in contours)
    closed = contours[0].closed
    return SegmentedObject(
        number,
        (),
        Region(curves) if closed else Region(),
        tuple(map(round_line, gaps)),
        strength=round(strength, _SESSION_DECIMALS),
        category=category,
        line=() if closed else curves[0],
    )


def copy_contours_to_objects(known: SegmentedObjects, result: Result, indices: Iterable[int]) -> list[SegmentedObject]:
    """Make objects of contours of a run, not accepted yet: closed ones with their direct holes, and open ones.

    A contour in a hole of a selected one bounds an object of its own again.
    """
    contours, around, selected = result.contours, containment(result.contours), frozenset(indices)

    def find_enclosing(index: int) -> list[int]:
        found: list[int] = []
        outer = around[index]
        while outer is not None:
            found.append(outer)
            outer = around[outer]
        return found

    made = []
    for index in sorted(selected):
        bounds, outer = [contours[index]], find_enclosing(index) if contours[index].closed else []
        highest = next((depth for depth in reversed(range(len(outer))) if outer[depth] in selected), -1)
        if highest % 2 == 0:  # enclosed by an odd number of contours: a hole
            continue
        if contours[index].closed:
            bounds += [one for one, inside in zip(contours, around, strict=True) if inside == index and one.closed]
        gaps = (bridge.points for bridge in select_bridges_on(result.bridges, bounds) if contours[index].closed)
        made.append(object_from_contours(known.next_number, known.category, bounds, gaps))
    return made


def replace_boundaries(document: Document, found: Iterable[SelectionUpdate]) -> Document:
    """Replace the boundaries of existing objects by those of selections."""
    known = {item.number for item in document.objects.items}
    return accept_objects(
        document, (object_from_selection(*each, 1) for each in found if each[2] in known and each[0].has_boundary)
    )


def object_from_selection(selection: Selection, clicks: Clicks, number: int, category: int) -> SegmentedObject:
    """Make an object of a selection that is not empty."""
    confidence = float(np.nan_to_num(selection.confidence))  # unknown where a body was clicked
    if selection.region.ndim == 3:
        region = selection.region
        if region.surface is not None:
            region = replace(region, surface=Region.from_surface(region.surface).surface)
        return SegmentedObject(number, clicks, region, category=category, confidence=confidence, model=selection.model)
    item = object_from_contours(number, category, selection.contours, selection.gaps)
    return replace(item, clicks=clicks, confidence=confidence, model=selection.model)


# The objects


def delete_objects(document: Document, numbers: Iterable[int]) -> Document:
    """Delete objects."""
    gone, objects = frozenset(numbers), document.objects
    left = tuple(item for item in objects.items if item.number not in gone)
    deleted = (*objects.deleted, *(item for item in objects.items if item.number in gone))
    over = {"clicks": (), "edited": 0} if objects.edited in gone else {}
    return _replace_objects(document, items=left, deleted=deleted, **over)


def rename_objects(document: Document, numbers: Iterable[int], name: str) -> Document:
    """Name objects; an empty name removes theirs."""
    return update_objects(document, numbers, name=name.strip())


def classify_objects(document: Document, numbers: Iterable[int], category: int) -> Document:
    """Set the class of objects, and of the next ones; their own colors are removed."""
    return _replace_objects(update_objects(document, numbers, category=category, color=""), category=category)


def update_objects(document: Document, numbers: Iterable[int], **parts: Any) -> Document:
    """Set the color of objects (empty: that of their class), their opacity, or whether they are frozen or hidden."""
    chosen = frozenset(numbers)
    items = tuple(replace(item, **parts) if item.number in chosen else item for item in document.objects.items)
    return _replace_objects(document, items=items)


def merge_objects(document: Document, numbers: Iterable[int]) -> Document:
    """Merge several objects of the image into the first of them, with the clicks of all."""
    chosen = frozenset(numbers)
    merged = [item for item in document.objects.items if item.number in chosen]
    return merge_into(document, merged, reduce(unite_objects, merged))


def merge_into(document: Document, merged: Iterable[SegmentedObject], whole: SegmentedObject) -> Document:
    """Replace several objects by their union, which has the number of one of them."""
    return accept_objects(
        delete_objects(document, [item.number for item in merged if item.number != whole.number]), (whole,)
    )


def replace_by_halves(document: Document, whole: SegmentedObject, halves: Halves) -> Document:
    """Replace an object or a candidate by its halves; the first keeps its number and name."""
    objects = document.objects
    ends = whole.number == objects.edited or whole.clicks == objects.clicks
    second = replace(halves.second, number=objects.next_number, name="")
    return accept_objects(document, (halves.first, second), ends=ends)


def name_class(document: Document, category: int, name: str, color: str = "") -> Document:
    """Name a class, and change its color unless that is empty."""
    classes = list(document.objects.classes)
    before = classes[category - 1]
    classes[category - 1] = ObjectClass(name.strip(), color or before.color)
    return _replace_objects(document, classes=tuple(classes))


# Objects as shapes of the next run


def add_objects_as_starts(document: Document, numbers: Iterable[int]) -> Document:
    """Add the outlines and lines of objects as starts; in a volume, points all over their surfaces."""
    return _add_objects_as_shapes(
        document, numbers, Polygon, lambda body: Points(_sample_surface_points(body.find_surface())), Stroke
    )


def add_objects_as_regions(document: Document, numbers: Iterable[int]) -> Document:
    """Add objects as regions of interest; their holes count as inside, and open objects enclose none."""
    return _add_objects_as_shapes(document, numbers, PolygonRegion, EnclosedRegion)


def add_objects_as_barriers(document: Document, numbers: Iterable[int]) -> Document:
    """Add the boundaries and lines of objects as barriers."""
    return _add_objects_as_shapes(
        document, numbers, lambda curve: Barrier((*curve, curve[0])), EnclosingWall, Barrier, holes=True
    )


def _add_objects_as_shapes(
    document: Document,
    numbers: Iterable[int],
    shape: Callable[[Line], Polygon | PolygonRegion | Barrier],
    in_volume: Callable[[Region], Points | EnclosedRegion | EnclosingWall],
    from_line: Callable[[Line], Stroke | Barrier] | None = None,
    holes: bool = False,
) -> Document:
    for number in numbers:
        item = document.objects[number]
        if item.region.ndim == 3:
            document = edits.add_shape(document, in_volume(item.region))
        if item.line and from_line is not None:
            document = edits.add_shape(document, from_line(simplify_path(item.line)))
        for curve in item.region.boundary if holes else item.region.outer_curves:
            few = simplify_path(curve)
            document = edits.add_shape(document, shape(few if len(set(few)) > 2 else curve))
    return document


def _sample_surface_points(surface: Surface) -> tuple[Place, ...]:
    """Return vertices of a surface, at most one in each block of voxels, so that there are not too many."""
    side, vertices = _SURFACE_BLOCK_SIDE, surface.vertices
    while (
        len(first := np.unique(np.floor(vertices / side).astype(int), axis=0, return_index=True)[1])
        > _MAX_SURFACE_POINTS
    ):
        side *= 1.5
    return as_line(np.round(vertices[np.sort(first)], _SESSION_DECIMALS))


# Exports


def build_objects_result(document: Document, only: Container[int] | None = None) -> Result | None:
    """Return the objects, or those with some numbers, as a result for writers, with class, name and color.

    Hidden objects are left out; None when no other remains. The image itself is not needed, so this can be called at
    any time.
    """
    image = document.image
    if image is None:
        return None
    made = Provenance("objects", sha256=image.sha256)
    nothing = boundaries_result(image.shape, image.name, image.spacing, image.unit, provenance=made)
    return add_segmented_objects(nothing, document.objects, only)


# Texts


def object_title(objects: SegmentedObjects, item: SegmentedObject) -> str:
    """Return the name of an object, or else the name of its class and its number."""
    return item.name or f"{objects.classes[item.category - 1].name or tr('object')} {item.number}"


def class_title(objects: SegmentedObjects, category: int) -> str:
    """Return the name of a class, or "object" for the first one and "class" with its number for others."""
    name = objects.classes[category - 1].name
    if name:
        return name
    return tr("object") if category == 1 else tr("class {number}", number=category)


def list_classes(objects: SegmentedObjects) -> Integers:
    """Return the numbers of the classes that are in use or have a name, and of one unused class."""
    used = {objects.category, *(item.category for item in objects.items)}
    listed = [number for number, known in enumerate(objects.classes, start=1) if number in used or known.name]
    free = [number for number in range(1, len(objects.classes) + 1) if number not in listed][:1]
    return tuple(sorted((*listed, *(free if objects.items else ()))))


def _replace_objects(document: Document, **parts: Any) -> Document:
    return replace(document, objects=replace(document.objects, **parts))


def set_overlap(document: Document, may_overlap: bool) -> Document:
    """Set whether what is selected or painted may run over other objects."""
    return _replace_objects(document, may_overlap=may_overlap)


def paint_volume_object(document: Document, number: int, part: Region, adds: bool = True) -> Document:
    """Add voxels to an object of a volume, or to a new one, or remove them; see `paint_voxels`."""
    return replace(document, objects=paint_voxels(document.objects, number, part, adds))


_BRUSH_EDGE_TOLERANCE = 0.1
"""Largest difference of a painted vertex's distance from the brush's path and the brush's radius [px]."""


def apply_brush(
    document: Document,
    before: SegmentedObject | None,
    number: int,
    boundary: tuple[Line, ...],
    path: Sequence[Position],
    radius: float,
) -> Document:
    """Give an object the boundary that a brush has left.

    Parameters
    ----------
    document : Document
        Document to edit.
    before : SegmentedObject or None
        The object as it was before the stroke of the brush; None for a new one.
    number : int
        The number of the object.
    boundary : tuple of tuple
        Closed curves (row, col) [px]; the object is deleted if there is none.
    path : sequence of (row, col)
        Path of the brush [px]. Boundary that its rim has made follows no contour and becomes gaps.
    radius : float
        Radius of the brush [px].

    Returns
    -------
    Document
        The object without clicks, since they no longer explain its boundary, and without confidence.
    """
    if not boundary:
        return delete_objects(document, (number,))
    made = before or SegmentedObject(number, (), Region(boundary), category=document.objects.category)
    kept = tuple(gap for gap in made.gaps if lies_on(gap, boundary))
    painted = []
    for points in map(np.array, boundary):
        on = np.abs(polyline.distances_to_path(path, points) - radius) <= _BRUSH_EDGE_TOLERANCE
        runs = (points[run].tolist() for run in polyline.find_marked_runs(on, closed=True) if len(run) > 1)
        painted += [tuple(map(tuple, run)) for run in runs]
    new = made.redrawn(Region(boundary), (*kept, *painted))
    return accept_objects(document, (new,), ends=document.objects.edited == number)
