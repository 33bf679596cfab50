"""Steps of the run as animation frames."""

from __future__ import annotations

from dataclasses import dataclass

from app.model.text.language import tr
from app.session.exchange.contour_tracking import ContourTracker
from app.session.exchange.error_messages import sentence
from app.session.exchange.messages import Reconstruction, Report, Snapshot
from app.session.tasks.tasks import Task
from app.session.worker.commands.run import Command, CommandContext
from app.session.worker.commands.timeline import Compared


@dataclass(frozen=True, eq=False, slots=True)
class TakeFrame(Command):
    """Report all that is shown of one step of a branch, and of a `compared` one; the run itself goes on.

    Nothing is done once the task is over.
    """

    task: Task
    generation: int
    branch: int
    step: int
    contours: bool
    compared: int | None = None

    def execute(self, context: CommandContext) -> None:
        """Recover the step and report it."""
        run = context.run
        if self.task.over:
            return
        if self.generation != run.generation:
            context.report(FrameTaken(self.task))
            return

        def wanted() -> bool:
            return not (self.task.over or context.closing())

        moment = run.moment(self.branch, self.step, wanted)
        other = run.recorded.timeline.state(self.compared, self.step, wanted) if self.compared is not None else None
        if moment is None or not wanted():
            return
        contours, beside = None, Compared(self.generation)
        if self.contours and moment.state.step > 0:
            result = run.result_of(self.branch, moment.state)
            contours = Reconstruction.of(self.generation, result, ContourTracker(), thorough=False)
        if other is not None:
            assert self.compared is not None
            found = run.result_of(self.compared, other) if self.contours and other.step > 0 else None
            beside = Compared(self.generation, self.compared, other, other.position, found)
        context.report(FrameTaken(self.task, moment, contours, beside))

    def failure_report(self, error: Exception) -> Report:
        """The animation cannot be made."""
        return FrameTaken(self.task, sentence=sentence(error, tr("taking a picture of a step")))


@dataclass(frozen=True, eq=False, slots=True)
class FrameTaken(Report):
    """All that is shown in one frame, or an error message; `moment` is None when the run has been replaced."""

    task: Task
    moment: Snapshot | None = None
    contours: Reconstruction | None = None
    compared: Compared | None = None
    sentence: str = ""
