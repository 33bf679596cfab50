"""Navigation along the timeline of the run."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import QObject, QTimer, Signal

from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import CommandFailed, Snapshot
from cpm_app.session.session import Session
from cpm_app.session.timeline.branches import TimelineBranch
from cpm_app.session.timeline.timeline import EMPTY_TIMELINE, TimelineState
from cpm_app.session.worker.commands import call_run
from cpm_app.session.worker.run import Run
from cpm_core import Parameters


class TimelineNavigation(QObject):
    """Navigates the timeline of a session's runs."""

    changed = Signal()
    """The position or the branches have changed."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._here = (0, 0)
        self._target: tuple[int, int] | None = None
        self._shown: tuple[Snapshot | None, TimelineState] = (None, EMPTY_TIMELINE)
        self._stay = QTimer(self, singleShot=True, interval=_CONTOURS_DELAY)
        self._stay.timeout.connect(self._on_stayed)
        session.store.scene_changed.connect(self._on_scene_changed)

        def on_status_changed() -> None:
            if session.status.phase == "running" and self._target is not None:
                self._target = None
                self.changed.emit()

        session.store.status_changed.connect(on_status_changed)
        session.store.add_listener(
            CommandFailed, lambda _: setattr(self, "_target", None)
        )  # which may have failed to go there

    @property
    def timeline_state(self) -> TimelineState:
        """The state of the timeline."""
        return self._session.scene.timeline

    @property
    def branches(self) -> tuple[TimelineBranch, ...]:
        """The branches, the oldest first."""
        return self.timeline_state.branches

    @property
    def current_step(self) -> tuple[int, int]:
        """Branch and step of the run, or the ones that it is going to."""
        return self._target or self._here

    def find_branch(self, identity: int) -> TimelineBranch | None:
        """Return a branch by its number; None if it does not exist."""
        return next((branch for branch in self.branches if branch.identity == identity), None)

    def last_step(self, identity: int) -> int:
        """Return the last step of a branch; 0 if it does not exist."""
        branch = self.find_branch(identity)
        if branch is None:
            return 0
        return max(branch.last, self._here[1]) if identity == self._here[0] else branch.last

    def matching_step(self, identity: int) -> int:
        """Return the step of a branch that matches the current one: the same step in the same run, else its end."""
        here, there = self.find_branch(self.current_step[0]), self.find_branch(identity)
        if here is None or there is None or here.run != there.run:
            return self.last_step(identity)
        return self.current_step[1]

    # Going

    def go_to(self, branch: int, step: int) -> None:
        """Go to a step of a branch, or to its nearest one."""
        if self.find_branch(branch) is None:
            return
        if not self._session.status.started:  # without a run, the worker has not been sent the regions
            self._session.post_command(call_run(None, Run.set_regions, self._session.document.regions))
        step = min(max(step, 0), self.last_step(branch))
        if (branch, step) == self.current_step and self._session.status.phase != "running":
            return
        target = self._target = (branch, step)
        session = self._session
        session.pause_and_post(
            call_run(session.store.generation, Run.go_to, branch, step, lambda: self._target in (None, target))
        )
        self._stay.start()
        self.changed.emit()

    def go_by(self, steps: int) -> None:
        """Go forward by a number of recorded steps, or backward when it is negative."""
        branch, step = self._current_or_last_step()
        self.go_to(branch, step + steps)

    def go_to_first(self) -> None:
        """Go to the first step of the run."""
        self.go_to(self._current_or_last_step()[0], 0)

    def go_to_last(self) -> None:
        """Go to the last step of the branch."""
        branch, _ = self._current_or_last_step()
        self.go_to(branch, self.last_step(branch))

    # Branches

    def rename_branch(self, branch: int, name: str) -> None:
        """Rename a branch."""
        self._session.post_command(call_run(self._session.store.generation, Run.rename_branch, branch, name))

    def remove_branch(self, branch: int) -> None:
        """Remove a branch; if the run is on it, pause."""
        if self.find_branch(branch) is None:
            return
        command = call_run(self._session.store.generation, Run.remove_branch, branch)
        if branch == self.current_step[0]:
            self._target = None
            self._session.pause_and_post(command)
            self._stay.start()
        else:
            self._session.post_command(command)

    @property
    def differing_parameters(self) -> Parameters | None:
        """Parameters of the shown step, if they differ from the current ones; else None."""
        taken, document = self.timeline_state.parameters, self._session.document
        if taken is None:
            return None
        taken = replace(taken, scales=document.parameters.scales)
        return None if taken == document.parameters else taken

    def use_step_parameters(self) -> None:
        """Set the parameters to those of the shown step."""
        taken = self.differing_parameters
        if taken is not None:
            name = tr("use the parameters of step {step}", step=self._here[1])
            self._session.edit(name, lambda document: replace(document, parameters=taken))
            self.changed.emit()

    # Following

    def _on_scene_changed(self) -> None:
        scene, (snapshot, known) = self._session.scene, self._shown
        if scene.snapshot is snapshot and scene.timeline is known:
            return
        self._shown = scene.snapshot, scene.timeline
        # without a snapshot, earlier runs stay on the timeline
        self._here = (0, 0) if scene.snapshot is None else (scene.timeline.branch, scene.snapshot.state.step)
        if scene.snapshot is None or self._here == self._target:
            self._target = None
        fallen = scene.timeline.dropped_runs[len(known.dropped_runs) :]
        if fallen:
            self._session.messages.show(
                tr(
                    "{runs} had to be removed from the timeline to make room; renamed runs are kept longer.",
                    runs=", ".join(fallen),
                )
            )
        self.changed.emit()

    def _on_stayed(self) -> None:
        if self._session.status.started and self._session.status.phase != "running":
            self._session.post_command(call_run(None, Run.reconstruct_if_halted))

    def _current_or_last_step(self) -> tuple[int, int]:
        """Return the current branch and step, or the end of the last branch while the run is on none."""
        if self.current_step[0] or not self.branches:
            return self.current_step
        newest = self.branches[-1].identity
        return newest, self.last_step(newest) + 1


_CONTOURS_DELAY = 250
"""Time at a step after which its contours are reconstructed at once [ms]."""
