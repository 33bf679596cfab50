"""Whatever is done in whatever order, document, run and files stay consistent with each other."""

from __future__ import annotations

import shutil
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from cpm_app.model.document import edits
from cpm_app.model.document.document import Document
from cpm_app.session.features.timeline_navigation import TimelineNavigation
from cpm_app.session.session import Session
from cpm_app.session.storage.preferences import Preferences
from cpm_app.session.storage.recovery import Journal, find_leftovers
from cpm_app.session.storage.session_file import DocumentFile
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)
from PySide6.QtCore import QCoreApplication

from cpm_core.formats.sessions.session_file import load_session
from cpm_core.parameters import Parameters
from cpm_core.shapes import Barrier, Circle, Everywhere, Points, Shape

PATIENCE = 20.0
SIDE = 32

places = st.tuples(st.integers(2, SIDE - 3), st.integers(2, SIDE - 3)).map(
    lambda place: (float(place[0]), float(place[1]))
)
shapes = st.one_of(
    st.builds(Circle, places, st.sampled_from([3.0, 5.0, 8.0])),
    st.builds(Points, st.lists(places, min_size=1, max_size=3).map(tuple)),
    st.builds(Barrier, st.lists(places, min_size=2, max_size=4, unique=True).map(tuple)),
    st.just(Everywhere("grid")),
)


class SessionMachine(RuleBasedStateMachine):
    """A session without a window, against a model of two lists of documents.

    To go through time changes where the run stands, and never document or files.
    """

    def __init__(self) -> None:
        super().__init__()
        self.folder = Path(tempfile.mkdtemp())
        row, col = np.indices((SIDE, SIDE))
        np.save(self.folder / "disc.npy", np.where(np.hypot(row - 16, col - 16) < 9, 200.0, 20.0))
        self.said: list[str] = []
        self.session = Session()
        self.session.set_pace(None)
        self.session.messages.shown.connect(lambda sentence, trouble: self.said.append(sentence) if trouble else None)
        self.document_file = DocumentFile(self.session, lambda: {"place": {}})
        self.journal = Journal(self.document_file, self.folder / "journals", Preferences(self.session))
        self.navigation = TimelineNavigation(self.session)
        self.past: list[Document] = []
        self.future: list[Document] = []
        self.saved: dict[Path, Document] = {}
        self.steps: dict[Path, int | None] = {}
        self.generation = 0
        self.now = Document()

    @initialize()
    def open(self) -> None:
        self.session.open_file(self.folder / "disc.npy")
        self.wait(lambda: self.session.document.image is not None)
        self.settle()
        self.begin()
        self.edit(edits.set_parameters(self.now, Parameters(scales=1)))

    # The model

    def begin(self) -> None:
        """There is no way back from here."""
        self.past, self.future, self.now = [], [], self.session.document

    def edit(self, after: Document) -> None:
        """Let the session become a document, and expect so."""
        self.session.edit("change", lambda document: after)
        if after != self.now:
            self.past.append(self.now)
            self.future, self.now = [], after

    def wait(self, condition) -> None:
        end = time.monotonic() + PATIENCE
        while not condition():
            QCoreApplication.processEvents()
            assert time.monotonic() < end
            time.sleep(0.001)

    def settle(self) -> None:
        """Wait until all work has ended."""
        self.wait(lambda: self.session.idle)

    # Edit, undo, redo

    @precondition(lambda self: len(self.now.shapes) < 6)
    @rule(shape=shapes)
    def add(self, shape: Shape) -> None:
        self.edit(edits.add_shape(self.now, shape))

    @precondition(lambda self: self.now.shapes)
    @rule(data=st.data(), by=places)
    def move(self, data: st.DataObject, by: tuple[float, float]) -> None:
        index = data.draw(st.integers(0, len(self.now.shapes) - 1))
        self.edit(edits.move_shape(self.now, index, (by[0] - SIDE / 2, by[1] - SIDE / 2)))

    @precondition(lambda self: self.now.shapes)
    @rule(data=st.data())
    def delete(self, data: st.DataObject) -> None:
        self.edit(edits.delete_shape(self.now, data.draw(st.integers(0, len(self.now.shapes) - 1))))

    @rule(name=st.sampled_from(["beta", "annealing", "min_length"]), share=st.sampled_from([0.2, 0.5, 0.9]))
    def set_parameter(self, name: str, share: float) -> None:
        self.edit(edits.set_parameter(self.now, name, share))

    @rule()
    def refuse(self) -> None:
        self.session.edit("nonsense", lambda document: edits.set_parameter(document, "beta", -1.0))
        assert "beta" in self.said[-1]

    @rule()
    def undo(self) -> None:
        self.session.undo()
        if self.past:
            self.future.append(self.now)
            self.now = self.past.pop()

    @rule()
    def redo(self) -> None:
        self.session.redo()
        if self.future:
            self.past.append(self.now)
            self.now = self.future.pop()

    @precondition(lambda self: self.past)
    @rule()
    def undo_then_redo_changes_nothing(self) -> None:
        before = self.session.document
        self.session.undo()
        assert self.session.document != before
        self.session.redo()
        assert self.session.document == before

    # Run, pause, step, reset

    @rule()
    def run(self) -> None:
        self.session.run()

    @rule()
    def pause(self) -> None:
        self.session.pause()
        assert self.session.status.phase != "running"

    @rule()
    def step(self) -> None:
        self.session.step()

    @rule()
    def reset(self) -> None:
        self.session.reset()
        assert self.session.status.step == 0

    @rule(seconds=st.sampled_from([0.0, 0.01, 0.05]))
    def let_go_on(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() <= end:
            QCoreApplication.processEvents()

    @rule()
    def come_to_rest(self) -> None:
        self.session.pause()
        self.settle()
        status = self.session.status
        assert status.phase in ("ready", "paused", "finished")
        assert (status.phase == "finished") == bool(status.stop_reason)
        assert not status.busy
        if status.phase == "ready":
            assert status.step == 0

    # Seek, branch

    def stands(self) -> bool:
        """Whether the run has come to rest by the user's hand, so that it can be gone through."""
        self.session.pause()
        self.settle()
        return self.session.status.step > 0 and self.navigation.last_step(self.navigation.current_step[0]) > 0

    @rule(share=st.floats(0.0, 1.0))
    def seek(self, share: float) -> None:
        if not self.stands():
            return
        branch, first, last = (
            self.navigation.current_step[0],
            0,
            self.navigation.last_step(self.navigation.current_step[0]),
        )
        step = round(first + share * (last - first))
        self.navigation.go_to(branch, step)
        self.settle()
        assert self.navigation.current_step == (branch, step)
        assert self.session.status.step == step
        assert self.navigation.last_step(branch) == last

    @rule(share=st.floats(0.0, 0.9), beta=st.floats(0.1, 3.0))
    def branch(self, share: float, beta: float) -> None:
        if not self.stands() or self.session.status.stale:
            return
        before = {
            branch.identity: self.navigation.last_step(branch.identity)
            for branch in self.navigation.timeline_state.branches
        }
        branch, last = self.navigation.current_step[0], self.navigation.last_step(self.navigation.current_step[0])
        step = min(round(share * last), last - 1)
        self.navigation.go_to(branch, step)
        self.settle()
        self.edit(edits.set_parameter(self.now, "beta", beta))
        self.session.step()
        self.settle()
        if self.session.status.step == step:  # it was the end of the run, or no particle was left
            return
        assert self.navigation.current_step == (self.navigation.current_step[0], step + 1)
        for identity, end in before.items():
            assert self.navigation.last_step(identity) >= end

    # Save, load, recover

    @rule(name=st.sampled_from(["a.cpm", "b.cpm"]))
    def save(self, name: str) -> None:
        path = self.folder / name
        self.session.pause()
        self.settle()
        self.document_file.save(path)
        self.saved[path] = self.now
        self.steps[path] = self.session.status.step if self.session.status.started else None
        self.wait(
            lambda: self.session.tasks.idle and self.document_file.path == path and not self.document_file.unsaved
        )
        file = load_session(path)
        assert (file.shapes, file.parameters) == (self.now.shapes, self.now.parameters)

    @precondition(lambda self: self.saved)
    @rule(data=st.data())
    def load(self, data: st.DataObject) -> None:
        path = data.draw(st.sampled_from(sorted(self.saved)))
        before = self.session.store.image_generation
        self.session.open_file(path)
        self.wait(lambda: self.session.store.image_generation != before)
        self.settle()
        assert self.session.document == self.saved[path]
        assert not self.document_file.unsaved
        assert self.session.status.started == (self.steps[path] is not None)
        assert self.session.status.step == (self.steps[path] or 0)
        self.begin()

    @rule()
    def what_is_unsaved_is_in_the_journal(self) -> None:
        self.journal.write()
        self.journal.flush()
        assert self.journal.path.exists() == self.document_file.unsaved
        if self.document_file.unsaved:
            file = load_session(self.journal.path)
            assert (file.shapes, file.parameters) == (self.now.shapes, self.now.parameters)
        assert find_leftovers(self.folder / "journals")[0] == []

    # Invariants

    @invariant()
    def the_document_is_the_one_expected(self) -> None:
        assert self.session.document == self.now
        assert bool(self.session.situation.undo_name) == bool(self.past)
        assert bool(self.session.situation.redo_name) == bool(self.future)
        assert self.session.selected_shape is None or self.session.selected_shape < len(self.now.shapes)

    @invariant()
    def generations_never_go_back(self) -> None:
        assert self.session.store.generation >= self.generation
        self.generation = self.session.store.generation
        assert self.session.store.image_generation <= self.generation

    @invariant()
    def nobody_has_died(self) -> None:
        alive = {thread.name for thread in threading.enumerate()}
        assert {"cpm-engine", "cpm-reconstruction"} <= alive
        assert not [said for said in self.said if "unexpected" in said]

    @invariant()
    def particles_stay_few(self) -> None:
        assert self.session.status.count <= 4 * SIDE * SIDE
        assert len(self.session.tasks.current) <= 1

    def teardown(self) -> None:
        self.journal.close()
        self.session.close()
        journals = self.folder / "journals"
        assert not journals.exists() or list(journals.iterdir()) == []
        shutil.rmtree(self.folder)


@pytest.mark.usefixtures("qapp", "compiled_loops")
def test_whatever_is_done_in_whatever_order_everything_stays_consistent() -> None:
    run_state_machine_as_test(
        SessionMachine,
        settings=settings(
            max_examples=8, stateful_step_count=20, deadline=None, suppress_health_check=list(HealthCheck)
        ),
    )
