"""Export of a run as an animation."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from PySide6.QtCore import QRectF

from cpm_app.model.document.modes import MODES
from cpm_app.model.text.language import explain_error, tr
from cpm_app.session.exchange.messages import CommandFailed, FilesExported, Report
from cpm_app.session.session import Session
from cpm_app.session.session_messages import EXPORTING_CATEGORY, FILMING_CATEGORY
from cpm_app.session.tasks.tasks import BackgroundTask
from cpm_app.views.export.frames import AnimationPlan, FrameRenderer, create_frame_source
from cpm_app.views.items.item import image_rectangle
from cpm_app.views.window.window import Feature
from cpm_core import RUN_METHODS, write_animation
from cpm_core.formats import check_animation, describe_image_provenance, describe_shapes, dump_provenance
from cpm_core.numerics import Pixels
from cpm_core.parameters import Provenance, select_parameters


def provenance_comment(session: Session) -> str:
    """Return the comment that states in a file how its pictures came about; empty without an image."""
    document, image = session.document, session.document.image
    if image is None:
        return ""
    method, shapes = RUN_METHODS[MODES[document.mode].method], describe_shapes(document.shapes)
    parameters = select_parameters(document.parameters, method.parameters)
    steered = session.status.steered
    made = Provenance(method.name, parameters, shapes=shapes, steered=steered, sha256=image.sha256)
    return dump_provenance(describe_image_provenance(image.name, made))


def start_writing_task(session: Session, path: Path, write_file: Callable[[BackgroundTask], Report]) -> BackgroundTask:
    """Start the task that writes a file on another thread."""
    session.messages.clear(EXPORTING_CATEGORY)
    doing, done = tr("Writing {name}…", name=path.name), tr("writing {name}", name=path.name)
    return session.tasks.start_task(doing, write_file, done, partial(CommandFailed, category=FILMING_CATEGORY))


def start_animation_task(
    session: Session,
    path: Path,
    frames: Callable[[BackgroundTask], Iterator[Pixels]],
    count: int,
    frames_per_second: float,
) -> BackgroundTask:
    """Start the task that writes an animation of `count` frames, which `frames` yields, on another thread."""
    comment = provenance_comment(session)

    def write_frames(task: BackgroundTask) -> Report:
        advance: Callable[[int], None] = lambda written: task.advance(written / count)  # noqa: E731
        write_animation(frames(task), path, frames_per_second, comment=comment, progress=advance)
        return FilesExported(path)

    return start_writing_task(session, path, write_frames)


class AnimationFeature(Feature):
    """Export of a run as an animation."""

    def set_up(self) -> None:
        """Listen for the end of tasks."""
        self._renderers: dict[BackgroundTask, FrameRenderer] = {}
        self.session.tasks.changed.connect(self._on_tasks_changed)

    def close(self) -> bool:
        """Cancel the animations that are being written and delete their renderers."""
        for task in self._renderers:
            task.cancel()
        self._on_tasks_changed()
        return True

    def export_animation(self, branch: int, plan: AnimationPlan, path: Path) -> BackgroundTask | None:
        """Write an animation; None if it cannot be written, which is reported."""
        session, canvas = self.session, self.canvas
        session.messages.clear(FILMING_CATEGORY)
        try:
            check_animation(path)
        except ValueError as error:
            session.messages.show(explain_error(error), True, FILMING_CATEGORY)
            return None
        renderer = FrameRenderer(session.scene, canvas, self.visible_part(), plan.size)
        frames = create_frame_source(session, renderer, [(branch, step) for step in plan.steps])
        task = start_animation_task(session, path, frames, len(plan.steps), plan.frames_per_second)
        self._renderers[task] = renderer
        return task

    def visible_part(self) -> QRectF:
        """Return the part of the image that frames show: the visible one."""
        canvas = self.canvas
        whole = image_rectangle(canvas.shape or (1, 1))
        part = canvas.view.viewRect().intersected(whole)
        return whole if part.isEmpty() else part

    def _on_tasks_changed(self) -> None:
        """Delete the renderers of finished tasks."""
        for task in [task for task in self._renderers if task.is_over]:
            self._renderers.pop(task).close()
