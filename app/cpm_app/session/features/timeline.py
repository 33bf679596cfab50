"""Navigation along the timeline of the run."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import QObject, QTimer, Signal

from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import CommandFailed, RunsKept, Snapshot
from cpm_app.session.session import Session
from cpm_app.session.timeline.stored_runs import Branch
from cpm_app.session.timeline.timeline import Outline
from cpm_app.session.worker.commands import run_call
from cpm_app.session.worker.requests import seek
from cpm_app.session.worker.run import Run
from cpm_core import Parameters

NOTHING = Outline()
"""The timeline before there is a run."""


class TimelineNavigation(QObject):
    """Navigates the timeline of a session's runs."""

    changed = Signal()
    """The position or the branches have changed."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self.outline = NOTHING
        """The state of the timeline."""
        self._here = (0, 0)
        self._target: tuple[int, int] | None = None
        self._snapshot: Snapshot | None = None
        self._stay = QTimer(self, singleShot=True, interval=_STAYING)
        self._stay.timeout.connect(self._reconstruct)
        session.scene_changed.connect(self._follow)

        def on_status_changed() -> None:
            if session.status.phase == "running" and self._target is not None:
                self._target = None
                self.changed.emit()

        session.status_changed.connect(on_status_changed)
        session.image_changed.connect(lambda: self._use_outline(NOTHING))
        session.listen(CommandFailed, lambda _: setattr(self, "_target", None))  # which may have failed to go there
        session.listen(
            RunsKept,
            lambda kept: None if kept.generation != session.generation or session.status.started
            else self._use_outline(kept.timeline),
        )  # fmt: skip

    @property
    def branches(self) -> tuple[Branch, ...]:
        """The branches, the oldest first."""
        return self.outline.branches

    @property
    def place(self) -> tuple[int, int]:
        """Branch and step of the run, or the ones that it is going to."""
        return self._target or self._here

    def branch(self, identity: int) -> Branch | None:
        """Return a branch by its number; None if it does not exist."""
        return next((branch for branch in self.branches if branch.identity == identity), None)

    def last(self, identity: int) -> int:
        """Return the last step of a branch; 0 if it does not exist."""
        branch = self.branch(identity)
        if branch is None:
            return 0
        return max(branch.last, self._here[1]) if identity == self._here[0] else branch.last

    def beside(self, identity: int) -> int:
        """Return the step of a branch that matches the current one: the same step in the same run, else its end."""
        here, there = self.branch(self.place[0]), self.branch(identity)
        if here is None or there is None or here.run != there.run:
            return self.last(identity)
        return self.place[1]

    # Going

    def go(self, branch: int, step: int) -> None:
        """Go to a step of a branch, or to its nearest one."""
        if self.branch(branch) is None:
            return
        if not self._session.status.started:  # without a run, the worker has not been sent the regions
            self._session.post(run_call(None, Run.limit, self._session.document.regions))
        step = min(max(step, 0), self.last(branch))
        if (branch, step) == self.place and self._session.status.phase != "running":
            return
        target = self._target = (branch, step)
        session = self._session
        session.hold(seek(session.generation, branch, step, lambda: self._target in (None, target)))
        self._stay.start()
        self.changed.emit()

    def by(self, steps: int) -> None:
        """Go forward by a number of recorded steps, or backward when it is negative."""
        branch, step = self._place_or_end()
        self.go(branch, step + steps)

    def to_first(self) -> None:
        """Go to the first step of the run."""
        self.go(self._place_or_end()[0], 0)

    def to_last(self) -> None:
        """Go to the last step of the branch."""
        branch, _ = self._place_or_end()
        self.go(branch, self.last(branch))

    # Branches

    def rename(self, branch: int, name: str) -> None:
        """Rename a branch."""
        self._session.post(run_call(self._session.generation, Run.rename_branch, branch, name))

    def drop(self, branch: int) -> None:
        """Remove a branch; if the run is on it, pause."""
        if self.branch(branch) is None:
            return
        command = run_call(self._session.generation, Run.drop_branch, branch)
        if branch == self.place[0]:
            self._target = None
            self._session.hold(command)
            self._stay.start()
        else:
            self._session.post(command)

    @property
    def other_parameters(self) -> Parameters | None:
        """Parameters of the shown step, if they differ from the current ones; else None."""
        taken, document = self.outline.parameters, self._session.document
        if taken is None:
            return None
        taken = replace(taken, scales=document.parameters.scales)
        return None if taken == document.parameters else taken

    def use_its_parameters(self) -> None:
        """Set the parameters to those of the shown step."""
        taken = self.other_parameters
        if taken is not None:
            name = tr("use the parameters of step {step}", step=self._here[1])
            self._session.edit(name, lambda document: replace(document, parameters=taken))
            self.changed.emit()

    # Following

    def _follow(self) -> None:
        snapshot = self._session.scene.snapshot
        if snapshot is self._snapshot:
            return
        self._snapshot = snapshot
        if snapshot is None:  # earlier runs stay on the timeline
            self._use_outline(self.outline)
            return
        self._here = (snapshot.timeline.branch, snapshot.state.step)
        self._take_outline(snapshot.timeline)
        if self._here == self._target:
            self._target = None
        self.changed.emit()

    def _use_outline(self, outline: Outline) -> None:
        """Show runs while the run is on none of them."""
        self._here, self._target = (0, 0), None
        self._take_outline(outline)
        self.changed.emit()

    def _take_outline(self, outline: Outline) -> None:
        fallen = outline.fallen[len(self.outline.fallen) :]
        self.outline = outline
        if fallen:
            self._session.say(
                tr(
                    "{runs} had to be removed from the timeline to make room; renamed runs are kept longer.",
                    runs=", ".join(fallen),
                )
            )

    def _reconstruct(self) -> None:
        if self._session.status.started and self._session.status.phase != "running":
            self._session.post(run_call(None, Run.stay))

    def _place_or_end(self) -> tuple[int, int]:
        """Return the current branch and step, or the end of the last branch while the run is on none."""
        if self.place[0] or not self.branches:
            return self.place
        newest = self.branches[-1].identity
        return newest, self.last(newest) + 1


_STAYING = 250
"""Time at a step after which its contours are reconstructed at once [ms]."""
