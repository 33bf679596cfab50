"""Comparison of another branch of the timeline with the branch of the run."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import QObject, QTimer, Signal

from app.session.exchange.messages import Snapshot
from app.session.session import Session
from app.session.worker.commands.timeline import Compare, Compared
from cpm_core.contours.result import Result

_EVERY, _SELDOM, _QUIET = 100, 500, 200
"""Time between two comparisons while the timeline is scrubbed and during a run, and time without one after which
contours are compared [ms]."""


class BranchComparison(QObject):
    """Requests the state of a branch at the step that is shown; the answer is `Scene.compared`."""

    changed = Signal()
    """Another branch is compared, or none."""
    found_changed = Signal()
    """`found` has been replaced."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._branch: int | None = None
        self._snapshot: Snapshot | None = None
        self._contours: Result | None = None
        self._compared: Compared | None = None
        self._look = QTimer(self, singleShot=True)
        self._look.timeout.connect(lambda: self._compare(None))
        self._quiet = QTimer(self, singleShot=True, interval=_QUIET)
        self._quiet.timeout.connect(self._compare_contours)
        session.scene_changed.connect(self._follow)

    @property
    def branch(self) -> int | None:
        """The branch that is compared."""
        return self._branch

    @property
    def found(self) -> Compared | None:
        """The branch at the step that is shown; None while that is not known."""
        return self._compared if self._compared is not None and self._compared.branch is not None else None

    def compare(self, branch: int | None) -> None:
        """Show another branch beside that of the run; None for none."""
        self._branch = branch
        self._compare(None)
        self._quiet.start()
        self.changed.emit()

    def _follow(self) -> None:
        scene = self._session.scene
        if scene.contours.result is not self._contours:
            self._contours = scene.contours.result
            if self._branch is not None:
                self._quiet.start()
        if scene.snapshot is not self._snapshot:
            self._snapshot = scene.snapshot
            self._follow_run(scene.snapshot)
        if scene.compared is not self._compared:
            self._compared = scene.compared
            self.found_changed.emit()

    def _follow_run(self, snapshot: Snapshot | None) -> None:
        if self._branch is None:
            return
        known = {branch.identity for branch in snapshot.timeline.branches} if snapshot is not None else set()
        if snapshot is None or self._branch not in known or self._branch == snapshot.timeline.branch:
            self._end()
        elif not self._look.isActive():
            running = self._session.status.phase == "running"
            self._look.start(_SELDOM if running else _EVERY)
            self._quiet.start()

    def _end(self) -> None:
        self._look.stop()
        self._quiet.stop()
        self._branch = None
        self._session.show(replace(self._session.scene, compared=None))
        self._compare(None)
        self.changed.emit()

    def _compare(self, against: Result | None) -> None:
        step = self._snapshot.state.step if self._snapshot is not None else 0
        self._session.post(Compare(self._session.generation, self._branch, step, against))

    def _compare_contours(self) -> None:
        if self._branch is not None and self._contours is not None and self._session.status.phase != "running":
            self._compare(self._contours)
