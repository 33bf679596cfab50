"""Frames of an animation: the worker prepares moments of a run, and the layers of the canvas draw them off-screen."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, wait
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QImage, QPainter

from cpm_app.model.text.language import tr
from cpm_app.session.scene import ReviewedContours, Scene
from cpm_app.session.session import Session
from cpm_app.session.tasks.tasks import Task
from cpm_app.session.worker.requests import FrameTaken, take_frame
from cpm_app.views.canvas.canvas import Canvas
from cpm_app.views.canvas.image_view import ImageView
from cpm_core.numerics import Pixels
from cpm_core.numerics.types import Integers, frozen

_CHECKED_EVERY = 0.05
"""Time between two checks for cancellation [s]."""

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


def recorded(
    session: Session, renderer: FrameRenderer, places: Sequence[tuple[int, int]]
) -> Callable[[Task], Iterator[Pixels]]:
    """What gives the frames of an animation to the thread that writes them, of branches and steps.

    Each frame is drawn in a turn of the event loop of its own while the one before is written, so that the window stays
    usable.
    """
    generation, shown = session.generation, renderer.shows_contours

    def ask(task: Task, place: tuple[int, int]) -> Future[Pixels]:
        found = Future[Pixels]()

        def draw(taken: FrameTaken) -> None:
            if task.over:
                return
            try:
                if taken.moment is None:
                    gone = tr("The run of the animation no longer exists, so nothing was written.")
                    raise ValueError(taken.sentence or gone)
                found.set_result(renderer.draw(taken))
            except Exception as error:  # reported by the thread that waits for the frame
                found.set_exception(error)

        session.tasks.call(lambda: session.post(take_frame(task, generation, *place, shown, draw)))
        return found

    def frames(task: Task) -> Iterator[Pixels]:
        due = ask(task, places[0])
        for place in (*places[1:], None):
            while not due.done():
                task.check_cancelled()
                wait([due], _CHECKED_EVERY)
            frame = due.result()
            if place is not None:
                due = ask(task, place)
            yield frame

    return frames
