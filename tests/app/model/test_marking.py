"""Marks as edits of the document: pure, small, and removed when they are empty."""

from __future__ import annotations

from cpm_app.model.document import contours
from cpm_app.model.document.contours import MarkTarget
from cpm_app.model.document.document import Document

from cpm_core.contours.review import Mark

HERE, THERE = (10.0, 12.0), (40.0, 41.0)


def test_a_first_word_on_a_contour_puts_a_mark_on_it_and_later_ones_change_that_mark() -> None:
    document = contours.set_verdict(Document(), [MarkTarget(None, HERE)], "rejected")
    assert document.marks == (Mark(HERE, "rejected"),)
    named = contours.rename_contours(document, [MarkTarget(document.marks[0], THERE)], " aorta ")
    assert named.marks == (Mark(HERE, "rejected", "aorta"),)
    assert contours.color_contours(named, [MarkTarget(named.marks[0], HERE)], "#e69f00").marks[0].color == "#e69f00"
    assert document.marks == (Mark(HERE, "rejected"),)


def test_an_empty_mark_is_removed() -> None:
    document = contours.set_verdict(Document(), [MarkTarget(None, HERE), MarkTarget(None, THERE)], "kept")
    assert len(document.marks) == 2
    document = contours.set_verdict(document, [MarkTarget(document.marks[0], HERE)], "")
    assert document.marks == (Mark(THERE, "kept"),)
    assert contours.rename_contours(Document(), [MarkTarget(None, HERE)], "  ") == Document()


def test_marks_change_nothing_that_a_run_starts_from() -> None:
    assert contours.set_verdict(Document(), [MarkTarget(None, HERE)], "kept").start_counts == Document().start_counts
