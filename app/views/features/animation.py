"""Export of a run as an animation, and of some of its steps as a snapshot strip."""

from __future__ import annotations

import queue
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from PySide6.QtCore import QRectF

from app.model.export.provenance import comment_on
from app.model.state.situation import has_particles
from app.model.text.language import tr
from app.model.text.reasons import reason
from app.session.exchange.messages import Exported, Report
from app.session.signals import FILMING
from app.session.tasks.tasks import Task
from app.views.export.film.animation_dialog import AnimationDialog, AnimationPlan
from app.views.export.film.filming import Filming
from app.views.export.film.frame_renderer import FrameRenderer, frame_size, seen_part
from app.views.export.film.strip_dialog import StripDialog, StripPlan
from app.views.widgets.action_spec import ActionSpec
from app.views.window.dialogs import Files
from app.views.window.feature import Feature, FeatureContext
from cpm_core.formats.animations.animation import ANIMATED, check_animation, write_animation
from cpm_core.formats.animations.snapshot_strip import strip, write_picture
from cpm_core.numerics.types import Pixels

_AHEAD = 4
"""Maximum number of frames that wait to be written."""

_TIMEOUT = 0.05
"""Time between two checks for cancellation [s]."""


@dataclass(frozen=True, eq=False, slots=True)
class StripReady(Report):
    """A strip has been composed."""

    task: Task
    pixels: Pixels


class AnimationFeature(Feature):
    """Exports animations and snapshot strips."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self._navigation = context.workspace.navigation
        self._filming: list[Filming] = []
        self._strip_task: Task | None = None
        self._strip_dialog: StripDialog | None = None
        context.session.listen(StripReady, self._show_strip)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Both exports."""
        return (
            ActionSpec(name="export_animation", menu="File", text=tr("Export a&nimation…"), do=self.ask_for_animation,
                       shortcuts=("Ctrl+Shift+A",), tip=tr("Export the run as GIF, APNG or MP4."), when=has_particles),
            ActionSpec(name="export_strip", menu="File", text=tr("Export snapshot s&trip…"), do=self.ask_for_strip,
                       tip=tr("Export some steps of the run side by side as one image."), when=has_particles),
        )  # fmt: skip

    def close(self) -> bool:
        """Stop the rendering of frames."""
        for filming in self._filming:
            filming.stop()
        return True

    # Animation

    def ask_for_animation(self) -> AnimationDialog:
        """Ask for the settings and the file of the animation, then write it."""
        branch = self._navigation.place[0]
        dialog = AnimationDialog(
            self.context.window,
            self.context.preferences,
            self._navigation.first,
            self._navigation.last(branch),
            self._part,
        )
        dialog.accepted.connect(lambda: self._ask_for_place(branch, dialog.plan))
        dialog.finished.connect(dialog.deleteLater)
        dialog.open()
        return dialog

    def write(self, branch: int, plan: AnimationPlan, path: Path) -> Task | None:
        """Write an animation; None if it cannot be written, which is reported."""
        session = self.context.session
        session.attempt(FILMING)
        try:
            check_animation(path)
        except ValueError as error:
            session.say(reason(error), True, FILMING)
            return None
        frames: queue.Queue[Pixels | None] = queue.Queue()
        task = session.tasks.start(
            tr("Writing {name}…").format(name=path.name),
            partial(_encode, frames, len(plan.steps), path, plan.frames_per_second, self._comment),
            tr("writing {name}").format(name=path.name),
        )
        self._film(
            task,
            FrameRenderer(session.scene, self.context.canvas_area.canvas, self._part(plan.zoomed), plan.size),
            [(branch, step) for step in plan.steps],
            frames,
        )
        return task

    def _film(
        self,
        task: Task,
        renderer: FrameRenderer,
        places: Sequence[tuple[int, int]],
        frames: queue.Queue[Pixels | None],
    ) -> None:
        layers = self.context.canvas_area.canvas.layers
        filming = Filming(
            self.context.session,
            renderer,
            task,
            places,
            contours=layers["contours"].shown or layers["ghost"].shown,
            compared=self._navigation.comparison.branch if layers["ghost"].shown else None,
            take=frames.put,
            end=lambda: frames.put(None),
            has_room=lambda: frames.qsize() < _AHEAD,
        )
        self._filming = [*(other for other in self._filming if not other.over), filming]

    def _ask_for_place(self, branch: int, plan: AnimationPlan) -> None:
        kinds = [Files(text, (suffix,)) for suffix, text in ANIMATED.items()]
        name = self._suggestion("run", plan.suffix)
        path = self.context.files.ask_where_to_save("export", tr("Export animation"), name, kinds)
        if path is not None:
            self.write(branch, plan, path)

    # Strip

    def ask_for_strip(self) -> StripDialog:
        """Show a strip of evenly spaced steps, which the user can save."""
        branch = self._navigation.place[0]
        dialog = StripDialog(
            self.context.window,
            self._navigation.first,
            self._navigation.last(branch),
            partial(self._draw_strip, branch),
            self._ask_to_save_strip,
        )
        dialog.finished.connect(self._end_strip)
        dialog.finished.connect(dialog.deleteLater)
        self._strip_dialog = dialog
        dialog.open()
        return dialog

    def _draw_strip(self, branch: int, plan: StripPlan) -> None:
        if self._strip_task is not None:
            self._strip_task.cancel()
        session, part = self.context.session, self._part(False)
        frames: queue.Queue[Pixels | None] = queue.Queue()
        captions = [tr("step {step}").format(step=step) for step in plan.steps]

        def compose(task: Task) -> Report:
            taken = list(_taken(frames, task))
            return StripReady(task, strip(taken, captions, columns=plan.columns))

        task = self._strip_task = session.tasks.start(tr("Drawing the strip…"), compose, tr("drawing the strip"))
        renderer = FrameRenderer(session.scene, self.context.canvas_area.canvas, part, frame_size(part, plan.width))
        self._film(task, renderer, [(branch, step) for step in plan.steps], frames)

    def _show_strip(self, report: StripReady) -> None:
        if report.task is self._strip_task and self._strip_dialog is not None:
            self._strip_dialog.show_strip(report.pixels)

    def _end_strip(self) -> None:
        if self._strip_task is not None:
            self._strip_task.cancel()
        self._strip_dialog = self._strip_task = None

    def _ask_to_save_strip(self, pixels: Pixels) -> None:
        path = self.context.files.ask_where_to_save(
            "export",
            tr("Export snapshot strip"),
            self._suggestion("strip", ".png"),
            [Files(tr("PNG image"), (".png",))],
            parent=self._strip_dialog,
        )
        if path is not None:
            self.save_strip(pixels, path)

    def save_strip(self, pixels: Pixels, path: Path) -> Task:
        """Write a strip."""
        comment = self._comment

        def work(task: Task) -> Report:
            write_picture(pixels, path, comment)
            return Exported(path)

        name = tr("Writing {name}…").format(name=path.name)
        return self.context.session.tasks.start(
            name, work, tr("writing {name}").format(name=path.name), cancellable=False
        )

    # Both

    @property
    def _comment(self) -> str:
        """How the pictures came about, for their file."""
        return comment_on(self.context.session.document, steered=self.context.session.status.steered)

    def _part(self, zoomed: bool) -> QRectF:
        canvas = self.context.canvas_area.canvas
        return seen_part(canvas, canvas.shape or (1, 1), zoomed)

    def _suggestion(self, what: str, suffix: str) -> str:
        image = self.context.session.document.image
        stem = Path(image.name).stem if image is not None else "cpm"
        return f"{stem}_{what}{suffix}"


def _taken(frames: queue.Queue[Pixels | None], task: Task) -> Iterator[Pixels]:
    """Frames as they arrive, until there are no more; raises when the task is canceled."""
    while True:
        task.go_on()
        try:
            frame = frames.get(timeout=_TIMEOUT)
        except queue.Empty:
            continue
        if frame is None:
            return
        yield frame


def _encode(
    frames: queue.Queue[Pixels | None], count: int, path: Path, frames_per_second: float, comment: str, task: Task
) -> Report | None:
    """Write frames as they arrive; runs on a worker thread."""
    done = write_animation(
        _taken(frames, task),
        path,
        frames_per_second,
        progress=lambda written: task.advance(written / count),
        cancelled=lambda: task.cancelled,
        comment=comment,
    )
    return Exported(path) if done else None
