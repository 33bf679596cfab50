"""Commands and reports of the timeline: going to other steps, branches, and what they are compared by."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from app.session.exchange.messages import Report
from app.session.worker.commands.run import Command, CommandContext
from cpm_core.contours.agreement import Agreement, agreement
from cpm_core.contours.result import Result
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.numerics.types import Array
from cpm_core.segmentation.method import MethodState


def _always() -> bool:
    return True


@dataclass(frozen=True, slots=True)
class Seek(Command):
    """Hold the run and go to a step of a branch, unless by then another step is wanted."""

    generation: int
    branch: int
    step: int
    wanted: Callable[[], bool] = _always

    latest_only = True
    activity = "going to another step"

    def execute(self, context: CommandContext) -> None:
        """Go there."""
        if self.generation == context.run.generation:
            context.run.go_to(self.branch, self.step, lambda: self.wanted() and not context.closing())


@dataclass(frozen=True, slots=True)
class Compare(Command):
    """Find what a branch is at a step, for showing it beside another one.

    Attributes
    ----------
    generation : int
        The run.
    branch : int or None
        The branch; None for nothing to compare with any more.
    step : int
        The step, or the last one of a branch that is shorter.
    against : Result or None
        Contours of what is shown, to tell the difference from; None to leave contours alone, which take longer.
    """

    generation: int
    branch: int | None
    step: int
    against: Result | None = None

    latest_only = True
    activity = "comparing branches"

    def execute(self, context: CommandContext) -> None:
        """Find it."""
        run = context.run
        if self.branch is None or self.generation != run.generation:
            context.report(Compared(self.generation))
            return
        state = run.recorded.timeline.state(self.branch, self.step, lambda: not context.closing())
        if state is None:
            return
        result = run.result_of(state) if self.against is not None and state.step > 0 else None
        apart = None
        if self.against is not None and isinstance(result, Result):
            apart = agreement(self.against.contours, result.contours)
        context.report(Compared(self.generation, self.branch, state, state.position, result, apart))


@dataclass(frozen=True, eq=False, slots=True)
class Compared(Report):
    """Another branch at the step that is shown, or nothing.

    Attributes
    ----------
    generation : int
        The run.
    branch : int or None
        The branch; None for nothing.
    state : MethodState or None
        Its state.
    position : ndarray, shape (N, 2), or None
        Its particles (row, col) [px of the image].
    result : Result or Skeleton or None
        Its contours, where they were asked for.
    apart : Agreement or None
        How far they lie from those that are shown.
    """

    generation: int
    branch: int | None = None
    state: MethodState | None = None
    position: Array | None = None
    result: Result | Skeleton | None = None
    apart: Agreement | None = None
