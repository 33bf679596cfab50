"""The undo history: what a run leaves of deletions in it."""

from __future__ import annotations

from collections import Counter

import pytest
from cpm_app.model.document.document import Document
from cpm_app.model.document.objects import delete_objects, rename_objects
from cpm_app.session.undo_history import Change, TimelinePlace, UndoHistory

from cpm_core.image.region import Region
from cpm_core.objects.segmented import SegmentedObject, SegmentedObjects

FIRST, SECOND = (
    SegmentedObject(number, (), Region((((0.0, at), (4.0, at), (4.0, at + 4.0)),)))
    for number, at in ((1, 0.0), (2, 9.0))
)


@pytest.fixture
def documents():
    """Documents with two objects, with one of them deleted, and with the other renamed after that."""
    both = Document(objects=SegmentedObjects((FIRST, SECOND)))
    one = delete_objects(both, (1,))
    return both, one, rename_objects(one, (2,), "dot")


@pytest.fixture
def history(documents, place):
    both, one, renamed = documents
    known = UndoHistory()
    known.push(Change("delete", both, one))
    known.push(Change("rename", one, renamed, place_before=place))
    return known


@pytest.fixture
def place():
    """Where a run was at rest before the last change: nowhere."""


def test_a_run_forgets_what_was_deleted_before_it_and_redo_does_not_bring_it_back(history, documents) -> None:
    _, one, _ = documents
    history.undo(None)
    begun = history.forget_deleted(one)
    assert (begun.objects.items, begun.objects.dismissed) == ((SECOND,), ())
    for name in ("dot", ""):
        again = history.redo(None) if name else history.undo(None)
        shown = again.after if name else again.before
        assert (shown.objects.items[0].name, shown.objects.dismissed) == (name, ())


@pytest.mark.parametrize("place", [None, TimelinePlace(1, 1, 1, 9, Counter(), True)], ids=["no run", "another run"])
def test_undo_restores_what_was_deleted_before_a_run_only_where_it_goes_back_to_another(
    history, documents, place
) -> None:
    _, _, renamed = documents
    assert history.forget_deleted(renamed).objects.dismissed == ()
    left = (FIRST,) if place else ()
    assert history.undo(None).before.objects.dismissed == left
    assert history.undo(None).after.objects.dismissed == left
    history.redo(None)
    assert history.redo(None).after.objects.dismissed == ()


def test_a_deletion_that_is_repeated_after_a_run_has_begun_is_not_forgotten(history, documents) -> None:
    both, one, _ = documents
    history.undo(None)
    history.undo(None)
    assert history.forget_deleted(both) == both
    assert history.redo(None).after == one
    assert one.objects.dismissed == (FIRST,)
