"""Contours and surfaces from files in a document: as starts, or as objects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from cpm_app.model.document.document import Document
from cpm_app.model.document.objects import initial_clicks, name_class
from cpm_app.model.text.language import tr
from cpm_core import Centerlines, Contour, Image, Surface, VolumePartition
from cpm_core.contours import extract_object_surface
from cpm_core.contours.contour import Contours
from cpm_core.formats import ContourFile
from cpm_core.image.region import Region
from cpm_core.image.surface import Label
from cpm_core.numerics.types import Texts, record
from cpm_core.objects.segmented import SegmentedObject, round_line
from cpm_core.shapes import Points, Polygon, Stroke, start_from_surface, starts_from_centerlines, starts_from_contours

MAX_IMPORTED = 1000
"""Largest number of contours: each becomes a shape or an object that can be moved and named by itself."""

ImportedKind = Literal["contours", "surface", "center lines"]


@record
class ImportedContent:
    """Content of a file, ready to be taken into a document.

    Attributes
    ----------
    name : str
        Name of the file for the user.
    count : int
        Number of contours, of center lines, or of surfaces, which is one.
    starts : tuple of Polygon, Stroke or Points
        Starts along them.
    objects : tuple of SegmentedObject
        Objects from the closed contours, or from the bodies.
    classes : tuple of str
        Names of their classes, empty where a file has none.
    open_count : int
        Number of open ones, which enclose no object.
    notes : tuple of str
        What was left out or assumed, one sentence each.
    kind : {"contours", "surface", "center lines"}
        Kind of the content; surfaces and center lines lie in a volume.
    """

    name: str
    count: int
    starts: tuple[Polygon | Stroke | Points, ...]
    objects: tuple[SegmentedObject, ...]
    open_count: int
    notes: Texts
    kind: ImportedKind = "contours"
    classes: Texts = ()

    @classmethod
    def from_surface(cls, surface: Surface, volume: Image, name: str, notes: Texts = ()) -> ImportedContent:
        """Import a surface in a volume, with an object for each body inside; ValueError if there are too many."""
        objects = objects_from_surface(surface, volume) if surface.closed else ()
        _check_import_count(tr("{name} has {count} objects, but at most {most} can be imported."), name, len(objects))
        return cls(name, 1, (start_from_surface(surface),), objects, int(not surface.closed), notes, "surface")

    @classmethod
    def from_centerlines(cls, lines: Centerlines, notes: Texts) -> ImportedContent:
        """Import center lines in a volume."""
        count = len(lines.branches)
        return cls(lines.source, count, starts_from_centerlines(lines), (), count, notes, "center lines")

    @classmethod
    def from_contour_file(cls, found: ContourFile, name: str) -> ImportedContent:
        """Import the contours of a file; ValueError if there are too many."""
        count = len(found.contours)
        _check_import_count(tr("{name} has {count} contours, but at most {most} can be imported."), name, count)
        closed = [contour for contour in found.contours if contour.closed]
        starts = starts_from_contours(found.contours, found.points)
        classes = tuple(parts[0].category for parts in _group_boundaries(closed))
        return cls(
            name, count, starts, objects_from_contours(closed), count - len(closed), found.notes, classes=classes
        )


def _check_import_count(message: str, name: str, count: int) -> None:
    if count > MAX_IMPORTED:
        raise ValueError(message.format(name=name, count=count, most=MAX_IMPORTED))


def objects_from_contours(contours: Contours) -> tuple[SegmentedObject, ...]:
    """Make objects of closed contours; those of one group are the boundaries of one object.

    A name that only repeats the class is left out.
    """
    return tuple(
        SegmentedObject(
            number,
            (),
            Region(tuple(round_line(part.points) for part in parts)),
            name=parts[0].name if parts[0].name != parts[0].category else "",
            color=parts[0].color,
            confidence=1.0,
        )
        for number, parts in enumerate(_group_boundaries(contours), start=1)
    )


def _group_boundaries(contours: Contours) -> list[list[Contour]]:
    """Return the boundaries of each object that encloses anything, holes last."""
    groups: dict[tuple[int, int], list[Contour]] = {}
    for index, contour in enumerate(contours):
        if len(set(round_line(contour.points))) > 2:
            groups.setdefault((contour.group, 0 if contour.group else index), []).append(contour)
    return [sorted(parts, key=lambda part: part.hole) for parts in groups.values()]


def objects_from_surface(surface: Surface, volume: Image) -> tuple[SegmentedObject, ...]:
    """Make an object of each numbered part of a closed surface or, without numbers, of each body, with a click inside.

    Parts with numbers keep their names and colors.
    """
    if surface.numbers is not None:
        numbers = np.unique(surface.numbers).tolist()
        bodies = [extract_object_surface(surface, number) for number in numbers]
    else:
        partition = VolumePartition(volume, surface)
        bodies = [partition.extract_boundary(np.array([number])) for number in partition.solid_bodies.tolist()]
        bodies = [body for body in bodies if len(body.faces)]
        numbers = range(1, len(bodies) + 1)
    known = {label.number: label for label in surface.labels}
    labels = [known.get(number, Label(number)) for number in numbers]
    items = (
        SegmentedObject(
            label.number,
            (),
            Region.from_surface(body),
            name=label.name,
            color=label.color,
            confidence=1.0,
        )
        for label, body in zip(labels, bodies, strict=True)
    )
    return tuple(replace(item, clicks=initial_clicks(item, volume.shape)) for item in items)


def add_objects(document: Document, imported: Sequence[SegmentedObject], classes: Sequence[str] = ()) -> Document:
    """Add objects, each of the class that is named for it, else of the current class.

    They keep their numbers if none of these is in use.
    """
    taken = {item.number for item in document.objects.items}
    first = document.objects.next_number - 1 if taken.intersection(item.number for item in imported) else 0
    for index, item in enumerate(imported):
        objects, name = document.objects, classes[index] if classes else ""
        used = {item.category for item in objects.items}
        numbered = list(enumerate(objects.classes, start=1))
        known = [number for number, one in numbered if name and one.name == name]
        # the first class without name and objects gets a name that none has
        free = [number for number, one in numbered if name and not one.name and number not in used]
        category = next(iter([*known, *free]), 0)
        if category:
            document = name_class(document, category, name)
        added = replace(item, number=first + item.number, category=category or objects.category)
        document = replace(document, objects=replace(document.objects, items=(*objects.items, added)))
    return document
