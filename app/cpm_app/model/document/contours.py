"""Contours of a document: the result of a run, and pure edits of their review and of edits by hand."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import replace

from cpm_app.model.document.document import Document
from cpm_app.model.text.language import tr
from cpm_core import Contour, Engine, Evolution, Result, State
from cpm_core.contours import HandEdit, KeptOutline, Mark, Verdict, capture_outline
from cpm_core.numerics import Position
from cpm_core.numerics.types import record
from cpm_core.results import apply_marks, restore_kept_contours
from cpm_core.shapes import ImageSeeds

HAND_EDIT_NAMES = {
    "cut": tr("cut contour"),
    "deletion": tr("delete segment of contour"),
    "redrawing": tr("redraw segment of contour"),
    "join": tr("join contours"),
    "extension": tr("extend contour"),
    "line": tr("draw contour"),
    "outline": tr("draw outline"),
}
"""Names of the kinds of edits, as they follow "Undo"."""


def apply_document_review(document: Document, result: Result) -> Result:
    """Add the contours that the user has kept to a result, and leave out the rejected ones."""
    return apply_marks(restore_kept_contours(result, document.marks), document.marks)


def run_document(engine: Engine, document: Document, seeds: ImageSeeds, progress: Callable[[State], object]) -> Result:
    """Run a document to its reviewed result; `progress` is called with each state, first the start.

    `seeds` are the seeds of the starts that depend on the image.
    """
    run = Evolution(engine, engine.start(document.collect_seeds(seeds)), document.parameters, charges=document.charges)
    for moment in run:
        progress(moment.state)
    return apply_document_review(document, run.result)


def add_hand_edits(document: Document, edits: Sequence[HandEdit]) -> Document:
    """Append edits of contours by hand."""
    return replace(document, hand_edits=(*document.hand_edits, *edits))


def drop_hand_edits(document: Document, indices: Collection[int]) -> Document:
    """Remove some edits of contours by hand."""
    left = tuple(edit for index, edit in enumerate(document.hand_edits) if index not in indices)
    return replace(document, hand_edits=left)


@record
class MarkTarget:
    """A contour to mark, with its mark so far, and the place (row, col) [px] of its first mark."""

    mark: Mark | None
    anchor: Position
    contour: Contour | None = None


def set_verdict(document: Document, targets: Iterable[MarkTarget], verdict: Verdict) -> Document:
    """Mark contours as kept as they are now, as rejected, or as undecided."""

    def set_mark_verdict(mark: Mark, target: MarkTarget) -> Mark:
        kept = target.contour if verdict == "kept" else None
        return replace(mark, verdict=verdict, outline=KeptOutline() if kept is None else capture_outline(kept))

    return _update_marks(document, targets, set_mark_verdict)


def rename_contours(document: Document, targets: Iterable[MarkTarget], name: str) -> Document:
    """Name contours; an empty name removes theirs."""
    return _update_marks(document, targets, lambda mark, _: replace(mark, name=name.strip()))


def color_contours(document: Document, targets: Iterable[MarkTarget], color: str) -> Document:
    """Color contours; an empty color restores the default."""
    return _update_marks(document, targets, lambda mark, _: replace(mark, color=color))


def _update_marks(
    document: Document, targets: Iterable[MarkTarget], update: Callable[[Mark, MarkTarget], Mark]
) -> Document:
    """Change some marks, with new ones last, and drop empty ones."""
    marks = list(document.marks)
    for target in targets:
        if target.mark is not None and target.mark in marks:
            marks[marks.index(target.mark)] = update(target.mark, target)
        else:
            marks.append(update(Mark(target.anchor), target))
    return replace(document, marks=tuple(mark for mark in marks if mark.verdict or mark.name or mark.color))
