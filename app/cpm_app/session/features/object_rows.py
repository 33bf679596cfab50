"""Rows of the list of objects, proposals and contours, made from the document and the scene."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Literal, get_args

import numpy as np

from cpm_app.model.document import objects
from cpm_app.model.text.language import tr
from cpm_app.model.volume.surface_section import object_contains, object_size
from cpm_app.session.features.object_measures import ObjectFigures
from cpm_app.session.scene import ContourItem, Proposal
from cpm_core.numerics import Place, polyline
from cpm_core.numerics.types import Line, record
from cpm_core.objects.segmented import SegmentedObject, SegmentedObjects

RowKey = tuple[Literal["object", "proposal", "contour"], int]
"""Identity of a row: the number of an object, the key of a proposal, which is below 1, or the key of a contour."""

DRAFT_KEY: RowKey = ("proposal", 0)
"""The key of the object that is being selected."""

RowKind = Literal["object", "proposal", "closed", "open", "rejected"]
"""Kind of a row; rejected are objects and contours."""

ROW_KINDS: tuple[RowKind, ...] = get_args(RowKind)
"""Kinds of rows, in the order shown."""


@record
class ObjectRow:
    """One row of the list: an object, a proposal or a contour.

    Attributes
    ----------
    key : tuple of str and int
        Its identity.
    kind : {"object", "proposal", "closed", "open", "rejected"}
        Its kind; rejected are objects and contours.
    title : str
        Its name, or its kind and number.
    item : SegmentedObject or None
        The object; for a proposal with a preliminary number until it is accepted.
    contour : ContourItem or None
        The contour; None for objects and proposals.
    figures : ObjectFigures or None
        Figures of the object; None while unknown.
    """

    key: RowKey
    kind: RowKind
    title: str
    item: SegmentedObject | None = None
    contour: ContourItem | None = None
    figures: ObjectFigures | None = None

    @property
    def name(self) -> str:
        """The name given by the user, or ""."""
        return self.item.name if self.item is not None else self.contour.contour.name if self.contour else ""

    @property
    def drawn(self) -> SegmentedObject | None:
        """The object if it is shown; None for hidden and rejected ones, and for a contour."""
        return None if self.item is None or self.item.hidden or self.kind == "rejected" else self.item


def list_rows(
    known: SegmentedObjects,
    proposals: Sequence[Proposal],
    offered: Sequence[SegmentedObject],
    separate: Iterable[ContourItem],
    figures_of: Callable[[SegmentedObject], ObjectFigures | None],
) -> tuple[ObjectRow, ...]:
    """List all rows by their kind: objects, proposals, contours, closed ones first, and what has been rejected.

    Parameters
    ----------
    known : SegmentedObjects
        The objects of the document.
    proposals : sequence of Proposal
        The proposals of the scene.
    offered : sequence of SegmentedObject
        The objects that they would become; see `objects_from_proposals`.
    separate : iterable of ContourItem
        The contours that bound none of all these objects.
    figures_of : callable
        Returns the figures of an object; None while unknown.
    """
    keys = [each.key for each in proposals if each.selection.has_boundary]

    def make_row(kind: RowKind, one: SegmentedObject, key: RowKey | None = None, title: str = "") -> ObjectRow:
        title = title or objects.object_title(known, one)
        return ObjectRow(key or ("object", one.number), kind, title, one, figures=figures_of(one))

    rows = [
        *(make_row("object", one) for one in known.items),
        *(make_row("proposal", one, ("proposal", key), tr("proposal {number}", number=-key or 1 - min(keys)))
          for key, one in zip(keys, offered, strict=True)),
        *(make_row("rejected", one) for one in known.rejected),
        *(ObjectRow(("contour", one.key), "rejected" if one.reviewed.rejected else
              "closed" if one.contour.closed else "open", one.title, contour=one) for one in separate),
    ]  # fmt: skip
    return tuple(sorted(rows, key=lambda row: ROW_KINDS.index(row.kind)))


def objects_from_proposals(offered: tuple[Proposal, ...], known: SegmentedObjects) -> tuple[SegmentedObject, ...]:
    """Make the objects that proposals would become, each with a unique number."""
    found = enumerate((each for each in offered if each.selection.has_boundary), start=known.next_number)
    return tuple(
        replace(each.proposed_object, number=each.number or fresh, category=(each.followed_object or known).category)
        for fresh, each in found
    )


def boundary_lines(items: Iterable[SegmentedObject]) -> list[Line]:
    """Return the closed lines of places (row, col) [px] that bound objects."""
    return [line for item in items for line in item.boundary]


def row_contains(row: ObjectRow, place: Place) -> bool:
    """Return whether a place (row, col) [px], or (plane, row, col), lies inside the object or contour of a row."""
    if row.drawn is None:
        line = row.contour.contour if row.kind == "closed" and row.contour is not None else None
        return line is not None and len(place) == 2 and bool(polyline.points_inside(line.points, np.array([place]))[0])
    return object_contains(row.drawn, place)


def row_size(row: ObjectRow) -> float:
    """Return the size of the object or contour of a row: its area, or its volume in a volume [px, voxels]."""
    return object_size(row.item) if row.item is not None else row.contour.contour.area if row.contour else 0.0
