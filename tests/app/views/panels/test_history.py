"""Undo and redo restore every document, in any order."""

from __future__ import annotations

import pytest
from cpm_app.model.document import edits
from cpm_app.model.document.document import Document
from cpm_app.session.session import Session
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from cpm_core.shapes import Circle

pytestmark = pytest.mark.shared_window


class EditingMachine(RuleBasedStateMachine):
    """Edits, undo and redo against two plain lists of documents."""

    def __init__(self) -> None:
        super().__init__()
        self.editor = Session()
        self.past: list[Document] = []
        self.future: list[Document] = []
        self.now = Document()

    def _edited(self, after: Document) -> None:
        if after != self.now:
            self.past.append(self.now)
            self.future = []
            self.now = after

    @rule(row=st.integers(0, 9), radius=st.integers(1, 9))
    def draw(self, row: int, radius: int) -> None:
        circle = Circle((float(row), 0.0), float(radius))
        self.editor.edit("draw", lambda document: edits.add_shape(document, circle), "")
        self._edited(edits.add_shape(self.now, circle))

    @precondition(lambda self: self.now.shapes)
    @rule()
    def delete(self) -> None:
        self.editor.select_shape(0)
        self.editor.edit("delete", lambda document: edits.delete_shape(document, 0), "")
        self._edited(edits.delete_shape(self.now, 0))

    @rule(values=st.lists(st.sampled_from([0.5, 0.8, 1.0, 1.5]), min_size=1, max_size=4))
    def drag_slider(self, values: list[float]) -> None:
        self.editor.end_gesture()
        for value in values:
            self.editor.edit("beta", lambda document, value=value: edits.set_parameter(document, "beta", value), "beta")
        self.editor.end_gesture()
        before = self.now.parameters.beta
        if any(value != before for value in values):
            self.future = []
        self._edited(edits.set_parameter(self.now, "beta", values[-1]))

    @rule()
    def undo(self) -> None:
        self.editor.undo()
        if self.past:
            self.future.append(self.now)
            self.now = self.past.pop()

    @rule()
    def redo(self) -> None:
        self.editor.redo()
        if self.future:
            self.past.append(self.now)
            self.now = self.future.pop()

    def teardown(self) -> None:
        self.editor.close()

    @invariant()
    def same_document(self) -> None:
        assert self.editor.document == self.now
        assert bool(self.editor.history.undo_name) == bool(self.past)
        assert self.editor.selected_shape is None or self.editor.selected_shape < len(self.now.shapes)


EditingMachine.TestCase.settings = settings(max_examples=40, stateful_step_count=25, deadline=None)
TestEditing = EditingMachine.TestCase
