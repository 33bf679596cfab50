"""Frames of an animation: the worker prepares moments of a run, and the layers of the canvas draw them off-screen."""

from __future__ import annotations

import queue
from collections import deque
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QObject, QRectF, Qt, QTimer
from PySide6.QtGui import QImage, QPainter

from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import sentence
from cpm_app.session.scene import ReviewedContours, Scene
from cpm_app.session.session import Session
from cpm_app.session.signals import FILMING
from cpm_app.session.tasks.tasks import Task
from cpm_app.session.worker.requests import FrameTaken, take_frame
from cpm_app.views.canvas.canvas import Canvas
from cpm_app.views.canvas.image_view import ImageView
from cpm_core.numerics import Pixels
from cpm_core.numerics.types import Integers, frozen

_INTERVAL = 15
"""Time between two checks whether another frame can be taken [ms]."""

_AHEAD = 4
"""Maximum number of frames that wait to be written."""

NARROWEST, WIDEST = 64, 3840
"""Smallest and largest width of a frame [px]."""


@frozen
class AnimationPlan:
    """Settings of an animation: a step for each frame, width and height of a frame [px], and the speed."""

    steps: Integers
    size: tuple[int, int]
    frames_per_second: int


def every(first: int, last: int, stride: int) -> Integers:
    """Every `stride`-th step from the first, and always the last."""
    steps = list(range(first, last + 1, max(stride, 1)))
    return tuple(steps if steps and steps[-1] == last else [*steps, last])


def frame_size(part: QRectF, width: int) -> tuple[int, int]:
    """Width and height of a frame, both even as video formats need them [px]."""
    height = width * part.height() / max(part.width(), 1e-9)
    return max(2 * round(width / 2), 2), min(max(2 * round(height / 2), 2), 2 * WIDEST)


class FrameRenderer:
    """An off-screen view with the present settings of the layers of a canvas.

    Parameters
    ----------
    scene : Scene
        The scene shown in addition to the moments of the run.
    canvas : Canvas
        The canvas whose layers are copied.
    part : QRectF
        Visible part of the image.
    size : tuple of int
        Width and height [px].
    """

    def __init__(self, scene: Scene, canvas: Canvas, part: QRectF, size: tuple[int, int]) -> None:
        self._size = size
        # selection and differences belong to the present contours, not to those of other moments
        self._scene = replace(scene, selected_contours=frozenset(), hovered_contour=None, differences=())
        self._view = ImageView()
        self._view.setAttribute(Qt.WidgetAttribute.WA_DontShowOnScreen)
        self._view.setMinimumSize(1, 1)
        self._view.setFrameStyle(0)
        self._view.resize(*size)
        self._view.show()
        # a new image resets the options of its layer; the moments are drawn later
        first = Scene(scene.image, scene.display, document=scene.document, selected=scene.selected)
        self._view.draw(replace(first, slices=scene.slices))
        for layer in canvas.layers:
            self._view.layers[layer.name].use_view_state(layer.view_state())
        self._view.view.setRange(part, padding=0.0)
        self.shows_contours = canvas.layers["contours"].shown

    def draw(self, taken: FrameTaken) -> Pixels:
        """Draw a moment as RGB values, shape (H, W, 3)."""
        tracked = taken.contours.tracked if taken.contours is not None else None
        contours = ReviewedContours.of(tracked, self._scene.document.marks)
        self._view.draw(replace(self._scene, snapshot=taken.moment, reconstruction=taken.contours, contours=contours))
        picture = QImage(*self._size, QImage.Format.Format_RGB32)
        painter = QPainter(picture)
        self._view.finish()
        self._view.render(painter)
        painter.end()
        return to_array(picture)

    def close(self) -> None:
        """Delete the view."""
        self._view.hide()  # close() would delete the graphics scene before its items
        self._view.deleteLater()


def to_array(picture: QImage) -> Pixels:
    """RGB values of a picture, shape (H, W, 3)."""
    plain = picture.convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(plain.constBits(), np.uint8).reshape(plain.height(), plain.bytesPerLine())
    return rows[:, : 3 * plain.width()].reshape(plain.height(), plain.width(), 3).copy()


class FrameRecorder(QObject):
    """Puts the frames of an animation into a queue, one after the other and None at the end, until its task is over.

    One frame is requested at a time and drawn in its own turn of the event loop, so that the window stays usable.

    Parameters
    ----------
    session : Session
        Session with the run.
    renderer : FrameRenderer
        Draws the frames; closed at the end.
    task : Task
        The task; canceling it ends the recording.
    places : sequence of tuple of int
        Branches and steps.
    frames : queue.Queue
        Takes the frames.
    """

    def __init__(
        self,
        session: Session,
        renderer: FrameRenderer,
        task: Task,
        places: Sequence[tuple[int, int]],
        frames: queue.Queue[Pixels | None],
    ) -> None:
        super().__init__(session)
        self._session = session
        self._renderer = renderer
        self._task = task
        self._waiting = deque(places)
        self._frames = frames
        self._generation = session.generation
        self._due = False
        self.over = False
        """Whether no more frames are taken."""
        self._timer = QTimer(self, interval=_INTERVAL)
        self._timer.timeout.connect(self._advance)
        self._timer.start()
        self._advance()

    def stop(self) -> None:
        """Take no more frames."""
        if not self.over:
            self.over = True
            self._timer.stop()
            self._renderer.close()
            self.deleteLater()

    def _advance(self) -> None:
        if self._task.over:
            self.stop()
        elif not self._due and self._waiting and self._frames.qsize() < _AHEAD:
            self._due = True
            shown, place = self._renderer.shows_contours, self._waiting[0]
            self._session.post(take_frame(self._task, self._generation, *place, shown, self._take_frame))

    def _take_frame(self, report: FrameTaken) -> None:
        if self.over or self._task.over:
            return
        self._due = False
        trouble = ""
        if report.moment is None:
            gone = tr("The run of the animation no longer exists, so nothing was written.")
            trouble = report.sentence or gone
        else:
            try:
                self._frames.put(self._renderer.draw(report))
            except Exception as error:  # it would be the same for each further try
                trouble = sentence(error, tr("drawing an animation"))
        if trouble:
            self._task.cancel()
            self._session.say(trouble, True, FILMING)
            self.stop()
            return
        self._waiting.popleft()
        if not self._waiting:
            self.stop()
            self._frames.put(None)
