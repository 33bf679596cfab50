"""Rows of the list of objects and proposals, made from the document and the scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal

from cpm_app.model.document import objects
from cpm_app.model.text.language import tr
from cpm_app.session.features.object_measures import ObjectFigures
from cpm_app.session.scene import Proposal
from cpm_core.numerics.types import record
from cpm_core.objects.segmented import SegmentedObject, SegmentedObjects

ItemKey = tuple[Literal["object", "proposal", "contour"], int]
"""What can be selected: the number of an object, the key of a proposal, which is below 1, or the index of a contour."""

DRAFT_KEY: ItemKey = ("proposal", 0)
"""The key of the object that is being selected."""

RowKind = Literal["object", "proposal"]
"""Kind of a row."""


@record
class ObjectRow:
    """One row of the list: an object or a proposal.

    Attributes
    ----------
    key : tuple of str and int
        Its identity.
    kind : {"object", "proposal"}
        Its kind.
    title : str
        Its name, or its kind and number.
    item : SegmentedObject
        The object; for a proposal with a preliminary number until it is accepted.
    figures : ObjectFigures or None
        Figures of the object; None while unknown.
    """

    key: ItemKey
    kind: RowKind
    title: str
    item: SegmentedObject
    figures: ObjectFigures | None = None


def list_rows(
    known: SegmentedObjects,
    proposals: Sequence[Proposal],
    offered: Sequence[SegmentedObject],
    figures_of: Callable[[SegmentedObject], ObjectFigures | None],
) -> tuple[ObjectRow, ...]:
    """List all rows: objects, and then proposals.

    Parameters
    ----------
    known : SegmentedObjects
        The objects of the document.
    proposals : sequence of Proposal
        The proposals of the scene.
    offered : sequence of SegmentedObject
        The objects that they would become; see `objects_from_proposals`.
    figures_of : callable
        Returns the figures of an object; None while unknown.
    """
    keys = [each.key for each in proposals if each.selection.has_boundary]
    proposed = (
        ObjectRow(("proposal", key), "proposal", tr("proposal {number}", number=-key or 1 - min(keys)), one,
                  figures_of(one))
        for key, one in zip(keys, offered, strict=True)
    )  # fmt: skip
    accepted = (
        ObjectRow(("object", one.number), "object", objects.object_title(known, one), one, figures_of(one))
        for one in known.items
    )
    return (*accepted, *proposed)


def objects_from_proposals(offered: tuple[Proposal, ...], known: SegmentedObjects) -> tuple[SegmentedObject, ...]:
    """Make the objects that proposals would become, each with a unique number."""
    found = enumerate((each for each in offered if each.selection.has_boundary), start=known.next_number)
    return tuple(
        replace(
            each.proposed_object,
            number=each.number or fresh,
            category=each.category or (each.followed_object or known).category,
        )
        for fresh, each in found
    )
