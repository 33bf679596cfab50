"""Marking: pure edits of the review of contours."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from app.model.document.document import Document
from cpm_core.contours.review import Mark, Verdict
from cpm_core.numerics.types import Position


@dataclass(frozen=True, slots=True)
class Target:
    """A contour to mark: its mark so far, and the place (row, col) [px] of its first mark."""

    mark: Mark | None
    anchor: Position


def judge(document: Document, targets: Iterable[Target], verdict: Verdict) -> Document:
    """The document in which contours are kept, rejected, or undecided again."""
    return _amended(document, targets, lambda mark: replace(mark, verdict=verdict))


def rename(document: Document, targets: Iterable[Target], name: str) -> Document:
    """The document in which contours have a name; none when it is empty."""
    return _amended(document, targets, lambda mark: replace(mark, name=name.strip()))


def paint(document: Document, targets: Iterable[Target], color: str) -> Document:
    """The document in which contours have a color; the default one when it is empty."""
    return _amended(document, targets, lambda mark: replace(mark, color=color))


def clear_marks(document: Document) -> Document:
    """The document without marks."""
    return replace(document, marks=())


def _amended(document: Document, targets: Iterable[Target], amend: Callable[[Mark], Mark]) -> Document:
    """The document with some marks changed, new ones last, and without empty ones."""
    marks = list(document.marks)
    for target in targets:
        if target.mark is not None and target.mark in marks:
            marks[marks.index(target.mark)] = amend(target.mark)
        else:
            marks.append(amend(Mark(target.anchor)))
    return replace(document, marks=tuple(mark for mark in marks if not mark.says_nothing))
