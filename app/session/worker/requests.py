"""Requests of views: another step or branch, forces on a particle, frames, intensity windows and edges."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from app.model.display.display_image import DisplayImage, IntensityWindow, apply_window
from app.model.text.language import tr
from app.session.exchange.contour_tracking import ContourTracker
from app.session.exchange.messages import Reconstruction, Report, Snapshot, sentence
from app.session.tasks.tasks import Task
from app.session.worker.commands import Command, CommandContext
from cpm_core import Image, Parameters, Result, Skeleton
from cpm_core.contours import Agreement, agreement
from cpm_core.field import ScaleField
from cpm_core.model import ImageFields
from cpm_core.numerics import Array, Place
from cpm_core.segmentation import MethodState, Steerable


@dataclass(frozen=True, slots=True)
class Seek(Command):
    """Pause the run and go to a step of a branch, unless by then another step is wanted."""

    generation: int
    branch: int
    step: int
    wanted: Callable[[], bool] = lambda: True

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
        state = run.timeline.state(self.branch, self.step, lambda: not context.closing())
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


NAMES = ("coulomb", "lorentz", "placed", "friction", "damping", "total")
"""Forces that are reported: attributes of the core's `Forces`."""


@dataclass(frozen=True, eq=False, slots=True)
class Probed(Report):
    """The forces on a particle.

    Attributes
    ----------
    generation, step : int
        Run and step.
    identity : int
        The particle, -1 where there is none near the position.
    position : tuple of float
        Its position [px of the image].
    forces : mapping
        By name, (row, col) [px of the image / unit of time^2]; in a volume, (plane, row, col) in smallest sides of a
        voxel.
    sizes : mapping
        Size of each, in a volume.
    trouble : str
        What working them out failed with.
    """

    generation: int
    step: int
    identity: int = -1
    position: Place = (0.0, 0.0)
    forces: Mapping[str, Array] = field(default_factory=dict)
    trouble: str = ""
    sizes: Mapping[str, float] = field(default_factory=dict)

    def size(self, name: str) -> float:
        """Size of a force, also of one of which a slice shows a part."""
        return self.sizes[name] if name in self.sizes else math.hypot(*self.forces[name])


@dataclass(frozen=True, slots=True)
class Probe(Command):
    """Report the forces on the particle nearest to a place (row, col), within `reach` [px of the image]."""

    generation: int
    place: Place
    reach: float

    latest_only = True
    activity = tr("working out the forces on a particle")

    def execute(self, context: CommandContext) -> None:
        """Find the particle and report its forces."""
        method, state = context.run.method, context.run.state
        if not isinstance(method, Steerable) or state is None or self.generation != context.run.generation:
            context.report(Probed(self.generation, -1))
            return
        position = state.position
        distance = np.linalg.norm(position - self.place, axis=1)
        nearest = int(distance.argmin()) if len(distance) else -1
        if nearest < 0 or distance[nearest] > self.reach:
            context.report(Probed(self.generation, state.step))
            return
        found = method.forces(state, context.run.parameters, context.run.charges, [nearest])
        if np.isnan(found.total).any():  # new regions delete it at the next step
            context.report(Probed(self.generation, state.step))
            return
        size = 2.0**state.scale
        at = tuple(position[nearest].tolist())
        forces = {name: size * getattr(found, name)[0] for name in NAMES}
        sizes = {name: float(np.linalg.norm(force)) for name, force in forces.items()}
        identity = int(state.particles.identity[nearest])
        context.report(Probed(self.generation, state.step, identity, at, forces, sizes=sizes))

    def failure_report(self, error: Exception) -> Report:
        """There is none."""
        return Probed(self.generation, -1, trouble=sentence(error, self.activity))


@dataclass(frozen=True, eq=False, slots=True)
class TakeFrame(Command):
    """Report all that is shown of one step of a branch; the run itself continues.

    Nothing is done once the task is over.
    """

    task: Task
    generation: int
    branch: int
    step: int
    contours: bool

    def execute(self, context: CommandContext) -> None:
        """Recover the step and report it."""
        run = context.run
        if self.generation != run.generation:
            context.report(FrameTaken(self.task))
            return
        moment = run.moment(self.branch, self.step, lambda: not (self.task.over or context.closing()))
        if moment is None or self.task.over:
            return
        contours = None
        if self.contours and moment.state.step > 0:
            result = run.result_of(self.branch, moment.state)
            contours = Reconstruction.of(self.generation, result, ContourTracker(), thorough=False)
        context.report(FrameTaken(self.task, moment, contours))

    def failure_report(self, error: Exception) -> Report:
        """The animation cannot be made."""
        return FrameTaken(self.task, sentence=sentence(error, tr("taking a picture of a step")))


@dataclass(frozen=True, eq=False, slots=True)
class FrameTaken(Report):
    """All that is shown in one frame, or an error message; `moment` is None when the run has been replaced."""

    task: Task
    moment: Snapshot | None = None
    contours: Reconstruction | None = None
    sentence: str = ""


@dataclass(frozen=True, eq=False, slots=True)
class Shaded(Report):
    """An image in an intensity window."""

    image: Image
    window: IntensityWindow
    display: DisplayImage
    channel: str = "luminance"


@dataclass(frozen=True, eq=False, slots=True)
class Shade(Command):
    """Make the display image of a channel for an intensity window."""

    image: Image
    window: IntensityWindow
    channel: str = "luminance"

    latest_only = True
    activity = tr("changing the levels")

    def execute(self, context: CommandContext) -> None:
        """Make the display image."""
        display = DisplayImage.of(apply_window(self.image.gray(self.channel), self.window))
        context.report(Shaded(self.image, self.window, display, self.channel))


EDGES = "edges"
"""Topic of the messages on trouble with the edges."""


@dataclass(frozen=True, eq=False, slots=True)
class EdgesFound(Report):
    """Fields of the image opened as `image_generation`, at its full size."""

    image_generation: int
    scale_field: ScaleField


@dataclass(frozen=True, slots=True)
class FindEdges(Command):
    """Report the fields of the image, if it is still the current one."""

    image_generation: int
    parameters: Parameters

    latest_only = True
    activity = tr("looking for edges")
    topic = EDGES

    def execute(self, context: CommandContext) -> None:
        """Find them, unless the method has none."""
        fields: object = context.run.method
        if self.image_generation == context.run.image_generation and isinstance(fields, ImageFields):
            context.report(EdgesFound(self.image_generation, fields.scale_field(self.parameters)))
