"""Marking: pure edits of the review of contours."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from app.model.document.document import Document
from cpm_core.contours.contour import Contour
from cpm_core.contours.kept import outline_of
from cpm_core.contours.review import Mark, Outline, Verdict
from cpm_core.numerics.types import Position


@dataclass(frozen=True, eq=False, slots=True)
class Target:
    """A contour to mark: its mark so far, the place (row, col) [px] of its first mark, where it runs."""

    mark: Mark | None
    anchor: Position
    contour: Contour | None = None

    @property
    def outline(self) -> Outline:
        """Where it runs."""
        return Outline() if self.contour is None else outline_of(self.contour)


def judge(document: Document, targets: Iterable[Target], verdict: Verdict) -> Document:
    """The document in which contours are kept as they are now, rejected, or undecided again."""

    def amend(mark: Mark, target: Target) -> Mark:
        return replace(mark, verdict=verdict, outline=target.outline if verdict == "kept" else Outline())

    return _amended(document, targets, amend)


def rename(document: Document, targets: Iterable[Target], name: str) -> Document:
    """The document in which contours have a name; none when it is empty."""
    return _amended(document, targets, lambda mark, _: replace(mark, name=name.strip()))


def paint(document: Document, targets: Iterable[Target], color: str) -> Document:
    """The document in which contours have a color; the default one when it is empty."""
    return _amended(document, targets, lambda mark, _: replace(mark, color=color))


def clear_marks(document: Document) -> Document:
    """The document without marks."""
    return replace(document, marks=())


def _amended(document: Document, targets: Iterable[Target], amend: Callable[[Mark, Target], Mark]) -> Document:
    """The document with some marks changed, new ones last, and without empty ones."""
    marks = list(document.marks)
    for target in targets:
        if target.mark is not None and target.mark in marks:
            marks[marks.index(target.mark)] = amend(target.mark, target)
        else:
            marks.append(amend(Mark(target.anchor), target))
    return replace(document, marks=tuple(mark for mark in marks if not mark.says_nothing))
