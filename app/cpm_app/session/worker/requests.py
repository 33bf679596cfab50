"""Commands that views send: another step or branch, forces on a particle, frames, intensity windows and edges."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field
from functools import partial

import numpy as np

from cpm_app.model.display.display_image import DisplayImage, IntensityWindow
from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import CommandFailed, Reconstruction, Report, Snapshot, WorkFinished
from cpm_app.session.tasks.tasks import BackgroundTask
from cpm_app.session.worker.commands import CommandContext, WorkerCommand
from cpm_core import Image, Parameters
from cpm_core.field import ScaleField
from cpm_core.model import ImageFields
from cpm_core.numerics import Array, Place
from cpm_core.numerics.types import record
from cpm_core.segmentation import Steerable

FORCE_NAMES = ("coulomb", "lorentz", "placed", "friction", "damping", "total")
"""Names of the reported forces: attributes of the core's `Forces`."""


@record
class ForcesProbed(Report):
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
        Forces by name, (row, col) [px of the image / unit of time^2]; in a volume, (plane, row, col) in smallest sides
        of a voxel.
    sizes : mapping
        Magnitude of each force, also where a slice shows only a component of it.
    error : str
        Error of their computation.
    """

    generation: int
    step: int
    identity: int = -1
    position: Place = (0.0, 0.0)
    forces: Mapping[str, Array] = field(default_factory=dict)
    error: str = ""
    sizes: Mapping[str, float] = field(default_factory=dict)


def probe_forces(generation: int, place: Place, max_distance: float) -> WorkerCommand:
    """Report the forces on the particle nearest to a place (row, col), within `max_distance` [px of the image]."""

    def report_forces(context: CommandContext) -> None:
        method, state = context.run.method, context.run.state
        if not isinstance(method, Steerable) or state is None or generation != context.run.generation:
            context.report(ForcesProbed(generation, -1))
            return
        position = state.position
        distance = np.linalg.norm(position - place, axis=1)
        nearest = int(distance.argmin()) if len(distance) else -1
        if nearest < 0 or distance[nearest] > max_distance:
            context.report(ForcesProbed(generation, state.step))
            return
        found = method.forces(state, context.run.parameters, context.run.charges, [nearest])
        if np.isnan(found.total).any():  # new regions delete it at the next step
            context.report(ForcesProbed(generation, state.step))
            return
        size = 2.0**state.scale
        at = tuple(position[nearest].tolist())
        forces = {name: size * getattr(found, name)[0] for name in FORCE_NAMES}
        sizes = {name: float(np.linalg.norm(force)) for name, force in forces.items()}
        identity = int(state.particles.identity[nearest])
        context.report(ForcesProbed(generation, state.step, identity, at, forces, sizes=sizes))

    activity = tr("computing the forces on a particle")
    return WorkerCommand(report_forces, activity, "probe", lambda trouble: ForcesProbed(generation, -1, error=trouble))


@record
class FrameTaken:
    """Everything shown in one frame, or an error message; `snapshot` is None if the run has been replaced."""

    snapshot: Snapshot | None = None
    contours: Reconstruction | None = None
    message: str = ""


def take_frame(
    task: BackgroundTask,
    generation: int,
    branch: int,
    step: int,
    contours: bool,
    on_taken: Callable[[FrameTaken], object],
) -> WorkerCommand:
    """Pass everything shown of one step of a branch to `on_taken`; the run itself continues.

    Nothing is done once the task is over.
    """

    def make_report(moment: Snapshot | None = None, found: Reconstruction | None = None, sentence: str = "") -> Report:
        return WorkFinished(partial(on_taken, FrameTaken(moment, found, sentence)))

    def report_frame(context: CommandContext) -> None:
        run = context.run
        if generation != run.generation:
            context.report(make_report())
            return
        moment = run.take_snapshot(branch, step, lambda: not (task.is_over or context.closing()))
        if moment is None or task.is_over:
            return
        found = None
        if contours and moment.state.step > 0:
            result = run.reconstruct_state(branch, moment.state)
            found = Reconstruction.from_result(generation, result)
        context.report(make_report(moment, found))

    return WorkerCommand(
        report_frame, tr("drawing a step"), failure_report=lambda sentence: make_report(sentence=sentence)
    )


@record
class ImageShaded(Report):
    """An image in an intensity window."""

    image: Image
    window: IntensityWindow
    display: DisplayImage
    channel: str = "luminance"


def shade_image(image: Image, window: IntensityWindow, channel: str) -> WorkerCommand:
    """Make the display image of a channel for an intensity window."""

    def report_shaded(context: CommandContext) -> None:
        context.report(ImageShaded(image, window, DisplayImage.from_image(image, window, channel), channel))

    return WorkerCommand(report_shaded, tr("changing the levels"), "shade")


EDGES_CATEGORY = "edges"
"""Category of messages about the edges."""


def find_edges(
    image_generation: int, parameters: Parameters, on_found: Callable[[ScaleField], object]
) -> WorkerCommand:
    """Pass the fields of the image at its full size to `on_found`, if it is still current and its method has any."""

    def report_fields(context: CommandContext) -> None:
        fields: object = context.run.method
        if image_generation == context.run.image_generation and isinstance(fields, ImageFields):
            context.report(WorkFinished(partial(on_found, fields.scale_field(parameters))))

    return WorkerCommand(
        report_fields, tr("looking for edges"), "edges", partial(CommandFailed, category=EDGES_CATEGORY)
    )
