"""Navigation along the timeline of the run."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import QTimer, Signal

from app.model.text.language import tr
from app.session.exchange.messages import CommandFailed, RunsKept, Snapshot
from app.session.features.timeline.branch_comparison import BranchComparison
from app.session.features.timeline.place import NOTHING, TimelinePlace
from app.session.session import Session
from app.session.timeline.outline import Outline
from app.session.worker.commands.run import RunCall
from app.session.worker.commands.timeline import Seek
from app.session.worker.run import Run
from cpm_core.parameters import Parameters

_PLAY_EVERY = 50
"""Time between two steps of a replay [ms]."""

_STAYING = 250
"""Time at a step after which its contours are reconstructed at once [ms]."""


class TimelineNavigation(TimelinePlace):
    """Goes along the timeline of a session's run; `comparison` shows another branch beside it."""

    changed = Signal()
    """The position or the branches have changed."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._snapshot: Snapshot | None = None
        self.comparison = BranchComparison(session)
        self.comparison.changed.connect(self.changed)
        self._play = QTimer(self)
        self._play.setInterval(_PLAY_EVERY)
        self._play.timeout.connect(self._play_on)
        self._stay = QTimer(self, singleShot=True, interval=_STAYING)
        self._stay.timeout.connect(self._reconstruct)
        session.scene_changed.connect(self._follow)
        session.status_changed.connect(self._follow_phase)
        session.image_changed.connect(lambda: self._use_outline(NOTHING))
        session.listen(CommandFailed, self._give_up_going)
        session.listen(RunsKept, self._take_kept)

    @property
    def playing(self) -> bool:
        """Whether recorded steps are replayed."""
        return self._play.isActive()

    # Going

    def go(self, branch: int, step: int) -> None:
        """Go to a step of a branch, or to its nearest one."""
        self._play.stop()
        self._go(branch, step)

    def by(self, steps: int) -> None:
        """Go forward by a number of recorded steps, or backward when it is negative."""
        branch, step = self._place_or_end()
        self.go(branch, step + steps)

    def to_first(self) -> None:
        """Go to the first step of the run."""
        self.go(self._place_or_end()[0], self.first)

    def to_last(self) -> None:
        """Go to the last step of the branch."""
        branch, _ = self._place_or_end()
        self.go(branch, self.last(branch))

    def toggle_play(self) -> None:
        """Replay the recorded steps from here on, from the first one at the end; or pause."""
        if self.playing:
            self._play.stop()
        elif self._outline.branches:
            branch, step = self._place_or_end()
            if step >= self.last(branch):
                self._go(branch, self.first)
            self._play.start()
        self.changed.emit()

    # Branches

    def rename(self, branch: int, name: str) -> None:
        """Give a branch another name."""
        self._session.post(RunCall(self._session.generation, Run.rename_branch, branch, name))

    def drop(self, branch: int) -> None:
        """Remove a branch; if the run is on it, pause."""
        if self.branch(branch) is None:
            return
        command = RunCall(self._session.generation, Run.drop_branch, branch)
        if branch == self.place[0]:
            self._target = None
            self._session.hold(command)
            self._stay.start()
        else:
            self._session.post(command)

    @property
    def other_parameters(self) -> Parameters | None:
        """Parameters of the step that is shown, as far as they act now; None where they are the current ones."""
        taken, document = self._outline.parameters, self._session.document
        if taken is None:
            return None
        taken = replace(taken, scales=document.parameters.scales)
        return None if taken == document.parameters else taken

    def use_its_parameters(self) -> None:
        """Set the parameters of the step that is shown."""
        taken = self.other_parameters
        if taken is not None:
            name = tr("use the parameters of step {step}").format(step=self._here[1])
            self._session.edit(name, lambda document: replace(document, parameters=taken))
            self.changed.emit()

    # Following

    def _go(self, branch: int, step: int) -> None:
        if self.branch(branch) is None:
            return
        if not self._session.status.started:  # until now the regions were of no use to the worker
            self._session.post(RunCall(None, Run.limit, self._session.document.regions))
        step = min(max(step, self.first), self.last(branch))
        if (branch, step) == self.place and self._session.status.phase != "running":
            return
        target = self._target = (branch, step)
        seek = Seek(self._session.generation, branch, step, wanted=lambda: self._target in (None, target))
        self._session.hold(seek)
        self._stay.start()
        self.changed.emit()

    def _play_on(self) -> None:
        branch, step = self.place
        if step >= self.last(branch) or self._session.status.phase == "running":
            self._play.stop()
            self.changed.emit()
        elif self._target is None:  # one step after the other, as fast as they are recovered
            self._go(branch, step + 1)

    def _follow(self) -> None:
        snapshot = self._session.scene.snapshot
        if snapshot is self._snapshot:
            return
        self._snapshot = snapshot
        if snapshot is None:  # the runs that there have been are still known
            self._use_outline(self._outline)
            return
        self._here = (snapshot.timeline.branch, snapshot.state.step)
        self._take_outline(snapshot.timeline)
        self._count = snapshot.state.count
        if self._here == self._target:
            self._target = None
        self.changed.emit()

    def _take_kept(self, kept: RunsKept) -> None:
        if kept.generation == self._session.generation and not self._session.status.started:
            self._use_outline(kept.timeline)

    def _use_outline(self, outline: Outline) -> None:
        """Show runs while the run is on none of them."""
        self._play.stop()
        self._here, self._target = (0, 0), None
        self._take_outline(outline)
        self.changed.emit()

    def _follow_phase(self) -> None:
        if self._session.status.phase == "running" and (self._target is not None or self.playing):
            self._target = None
            self._play.stop()
            self.changed.emit()

    def _reconstruct(self) -> None:
        if self._session.status.started and self._session.status.phase != "running":
            self._session.post(RunCall(None, Run.stay))

    def _give_up_going(self, _: CommandFailed) -> None:
        """The failed command may have been the one that goes to another step."""
        self._target = None
