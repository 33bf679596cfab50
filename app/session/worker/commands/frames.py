"""Moments of the run for a film, one after the other."""

from __future__ import annotations

from dataclasses import dataclass

from app.session.exchange.contour_tracking import ContourTracker
from app.session.exchange.error_messages import sentence
from app.session.exchange.messages import Reconstruction, Report, Snapshot
from app.session.tasks.tasks import Task
from app.session.worker.commands.run import Command, CommandContext
from app.session.worker.commands.timeline import Compared


@dataclass(frozen=True, eq=False, slots=True)
class TakeFrame(Command):
    """Find all that is to be seen of one step of a branch; the run itself goes on.

    Attributes
    ----------
    task : Task
        The film that it is for; nothing is done once that is over.
    generation : int
        The run.
    branch, step : int
        Which step.
    contours : bool
        Whether contours are to be seen.
    compared : int or None
        A branch to be seen beside it.
    """

    task: Task
    generation: int
    branch: int
    step: int
    contours: bool
    compared: int | None = None

    def execute(self, context: CommandContext) -> None:
        """Find it."""
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
            result = run.result_of(moment.state)
            contours = Reconstruction.of(self.generation, result, ContourTracker(), thorough=False)
        if other is not None:
            found = run.result_of(other) if self.contours and other.step > 0 else None
            beside = Compared(self.generation, self.compared, other, other.position, found)
        context.report(FrameTaken(self.task, moment, contours, beside))

    def failure_report(self, error: Exception) -> Report:
        """The film cannot be made."""
        return FrameTaken(self.task, sentence=sentence(error, "taking a picture of a step"))


@dataclass(frozen=True, eq=False, slots=True)
class FrameTaken(Report):
    """What is to be seen in one frame, or why nothing is.

    Attributes
    ----------
    task : Task
        The film that it is for.
    moment : Snapshot or None
        The particles; None when the run is another one by now, or when there has been trouble.
    contours : Reconstruction or None
        The contours.
    compared : Compared or None
        The branch beside it.
    sentence : str
        The trouble.
    """

    task: Task
    moment: Snapshot | None = None
    contours: Reconstruction | None = None
    compared: Compared | None = None
    sentence: str = ""
