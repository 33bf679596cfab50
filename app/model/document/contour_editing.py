"""Editing of contours by hand: pure edits of the document, and their names."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from app.model.document.document import Document
from app.model.text.language import tr
from cpm_core.contours.hand_edits import HandEdit, Kind

NAMES: Mapping[Kind, str] = MappingProxyType(
    {
        "cut": tr("cut contour"),
        "deletion": tr("delete stretch of contour"),
        "redrawing": tr("redraw stretch of contour"),
        "join": tr("join contours"),
        "extension": tr("extend contour"),
        "line": tr("draw contour"),
        "outline": tr("draw outline"),
    }
)
"""What each kind of edit is called after "Undo"."""


def add_hand_edits(document: Document, edits: Sequence[HandEdit]) -> Document:
    """The document with further edits of contours by hand, made last."""
    return replace(document, hand_edits=(*document.hand_edits, *edits))


def drop_hand_edits(document: Document, indices: Collection[int]) -> Document:
    """The document without some edits of contours by hand."""
    left = tuple(edit for index, edit in enumerate(document.hand_edits) if index not in indices)
    return replace(document, hand_edits=left)
