"""Contours of other programs in a document: as starts, or as objects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from app.model.document.document import Document
from app.model.text.language import tr
from cpm_core.contours.contour import Contour
from cpm_core.formats.contours.reading.contour_file import ContourFile
from cpm_core.numerics.types import Array
from cpm_core.objects.segmented.segmented_object import Line, SegmentedObject
from cpm_core.shapes import Points, Polygon, Stroke
from cpm_core.shapes.outlines import starts_along

MOST = 1000
"""Most contours that are taken over: each is a shape or an object that can be moved and named by itself."""

_DECIMALS = 3


@dataclass(frozen=True, eq=False, slots=True)
class Imported:
    """What was read, ready to be taken into a document.

    Attributes
    ----------
    name : str
        Name of the file for the user.
    count : int
        Number of contours.
    starts : tuple of Polygon, Stroke or Points
        Starts along the contours.
    objects : tuple of SegmentedObject
        Objects of the closed contours.
    open : int
        Number of open contours, which enclose no object.
    notes : tuple of str
        What was left out, one sentence each.
    """

    name: str
    count: int
    starts: tuple[Polygon | Stroke | Points, ...]
    objects: tuple[SegmentedObject, ...]
    open: int
    notes: tuple[str, ...]

    @classmethod
    def of(cls, found: ContourFile, name: str) -> Imported:
        """What a file of contours holds; ValueError when that is too much."""
        if len(found.contours) > MOST:
            message = tr("{name} has {count} contours, but no more than {most} can be taken over.")
            raise ValueError(message.format(name=name, count=len(found.contours), most=MOST))
        closed = [contour for contour in found.contours if contour.closed]
        starts = starts_along(found.contours, found.places)
        return cls(
            name, len(found.contours), starts, objects_of(closed), len(found.contours) - len(closed), found.notes
        )


def objects_of(contours: Sequence[Contour]) -> tuple[SegmentedObject, ...]:
    """Objects with closed contours as their boundaries; those of one group are one object."""
    groups: dict[tuple[int, int], list[Contour]] = {}
    for index, contour in enumerate(contours):
        groups.setdefault((contour.group, 0 if contour.group else index), []).append(contour)
    made: list[SegmentedObject] = []
    for parts in groups.values():
        lines = [line for line in (_line(part.points) for part in parts) if len(set(line)) > 2]
        first = next((part for part in parts if not part.hole), parts[0])
        if lines:
            number = len(made) + 1
            made.append(SegmentedObject(number, (), tuple(lines), name=first.name, color=first.color, confidence=1.0))
    return tuple(made)


def add_starts(document: Document, imported: Imported) -> Document:
    """The document with starts along the contours."""
    return replace(document, shapes=(*document.shapes, *imported.starts))


def add_objects(document: Document, imported: Imported) -> Document:
    """The document with the objects, of the class that is chosen."""
    objects = document.objects
    first = objects.next_number - 1
    added = (replace(item, number=first + item.number, category=objects.category) for item in imported.objects)
    return replace(document, objects=replace(objects, items=(*objects.items, *added)))


def _line(points: Array) -> Line:
    return tuple((row, col) for row, col in np.round(points, _DECIMALS).tolist())
