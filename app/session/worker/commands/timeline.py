"""Commands and reports of the timeline: moves to other steps, and comparison of branches."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from app.model.text.language import tr
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
    """Pause the run and go to a step of a branch, unless by then another step is wanted."""

    generation: int
    branch: int
    step: int
    wanted: Callable[[], bool] = _always

    latest_only = True
    activity = tr("going to another step")

    def execute(self, context: CommandContext) -> None:
        """Go to the step."""
        if self.generation == context.run.generation:
            context.run.go_to(self.branch, self.step, lambda: self.wanted() and not context.closing())


@dataclass(frozen=True, slots=True)
class Compare(Command):
    """Report the state of a branch at a step, or at its last one; `branch` is None to end the comparison.

    Contours, which take longer, are compared only where `against` gives those that are shown.
    """

    generation: int
    branch: int | None
    step: int
    against: Result | None = None

    latest_only = True
    activity = tr("comparing branches")
    topic = "comparing"

    def execute(self, context: CommandContext) -> None:
        """Recover the state and compare it."""
        run = context.run
        if self.branch is None or self.generation != run.generation:
            context.report(Compared(self.generation))
            return
        state = run.recorded.timeline.state(self.branch, self.step, lambda: not context.closing())
        if state is None:
            return
        result = run.result_of(self.branch, state) if self.against is not None and state.step > 0 else None
        apart = None
        if self.against is not None and isinstance(result, Result):
            apart = agreement(self.against.contours, result.contours)
        context.report(Compared(self.generation, self.branch, state, state.position, result, apart))


@dataclass(frozen=True, eq=False, slots=True)
class Compared(Report):
    """Another branch at the step that is shown; `branch` is None for no comparison.

    `position`, shape (N, 2), holds its particles (row, col) [px of the image]; `apart` is the distance of its contours
    from those that are shown.
    """

    generation: int
    branch: int | None = None
    state: MethodState | None = None
    position: Array | None = None
    result: Result | Skeleton | None = None
    apart: Agreement | None = None
