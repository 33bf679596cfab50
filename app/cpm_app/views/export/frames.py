"""Frames of an animation: the worker prepares steps of a run, and the layers of the canvas draw them off-screen."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, wait
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QImage, QPainter

from cpm_app.model.text.language import tr
from cpm_app.session.scene import Scene
from cpm_app.session.session import Session
from cpm_app.session.tasks.tasks import BackgroundTask
from cpm_app.session.worker.requests import FrameTaken, take_frame
from cpm_app.views.canvas.canvas import Canvas
from cpm_app.views.canvas.image_view import ImageView
from cpm_core.numerics import Pixels
from cpm_core.numerics.types import Integers, frozen

_CANCEL_CHECK_INTERVAL = 0.05
"""Time between two checks for cancellation [s]."""

MIN_FRAME_WIDTH = 64
"""Smallest width of a frame [px]."""

MAX_FRAME_WIDTH = 3840
"""Largest width of a frame [px]."""


@frozen
class AnimationPlan:
    """Settings of an animation: the step of each frame, width and height of a frame [px], and the speed."""

    steps: Integers
    size: tuple[int, int]
    frames_per_second: int


def sample_steps(first: int, last: int, stride: int) -> Integers:
    """Return every `stride`-th step from the first, and always the last."""
    steps = list(range(first, last + 1, max(stride, 1)))
    return tuple(steps if steps and steps[-1] == last else [*steps, last])


def frame_size(part: QRectF, width: int) -> tuple[int, int]:
    """Compute width and height of a frame [px], both even as video formats require."""
    height = width * part.height() / max(part.width(), 1e-9)
    return max(2 * round(width / 2), 2), min(max(2 * round(height / 2), 2), 2 * MAX_FRAME_WIDTH)


class FrameRenderer:
    """Off-screen view with the current settings of the layers of a canvas.

    Parameters
    ----------
    scene : Scene
        Scene into which the steps of the run are drawn.
    canvas : Canvas
        Canvas whose layers are copied.
    part : QRectF
        Visible part of the image.
    size : tuple of int
        Width and height [px].
    """

    def __init__(self, scene: Scene, canvas: Canvas, part: QRectF, size: tuple[int, int]) -> None:
        self._size = size
        # selection and differences belong to the current contours, not to those of other steps
        self._scene = replace(scene, selected_contours=frozenset(), hovered_contour=None, differences=())
        self._view = ImageView()
        self._view.setAttribute(Qt.WidgetAttribute.WA_DontShowOnScreen)
        self._view.setMinimumSize(1, 1)
        self._view.setFrameStyle(0)
        self._view.resize(*size)
        self._view.show()
        # a new image resets the options of its layer, so it is drawn before these are set
        first = Scene(scene.image, scene.display, document=scene.document, selected_shape=scene.selected_shape)
        self._view.draw_scene(replace(first, slices=scene.slices, channels=scene.channels))
        for layer in canvas.layers:
            self._view.layers[layer.name].use_view_state(layer.view_state())
        self._view.view.setRange(part, padding=0.0)
        self.shows_contours = canvas.layers["contours"].shown

    def render_frame(self, taken: FrameTaken) -> Pixels:
        """Draw a step of the run; return RGB values of shape (H, W, 3) and dtype uint8."""
        self._view.draw_scene(replace(self._scene, snapshot=taken.snapshot, reconstruction=taken.contours))
        picture = QImage(*self._size, QImage.Format.Format_RGB32)
        painter = QPainter(picture)
        self._view.finish_drawing()
        self._view.render(painter)
        painter.end()
        return read_rgb_pixels(picture)

    def close(self) -> None:
        """Delete the view."""
        self._view.hide()  # close() would delete the graphics scene before its items
        self._view.deleteLater()


def read_rgb_pixels(picture: QImage) -> Pixels:
    """Return the RGB values of a picture, shape (H, W, 3), dtype uint8."""
    plain = picture.convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(plain.constBits(), np.uint8).reshape(plain.height(), plain.bytesPerLine())
    return rows[:, : 3 * plain.width()].reshape(plain.height(), plain.width(), 3).copy()


def create_frame_source(
    session: Session, renderer: FrameRenderer, branch_steps: Sequence[tuple[int, int]]
) -> Callable[[BackgroundTask], Iterator[Pixels]]:
    """Create the function from which the thread that writes an animation gets its frames.

    Each frame is drawn in a separate turn of the event loop while the previous one is written, so that the window stays
    usable.

    Parameters
    ----------
    session : Session
        Session with the run.
    renderer : FrameRenderer
        Draws the frames, on the thread of the window.
    branch_steps : sequence of (int, int)
        Branch and step of each frame.

    Returns
    -------
    callable
        Takes the task that writes; yields RGB values of shape (H, W, 3) and dtype uint8.
    """
    generation, shown = session.store.generation, renderer.shows_contours

    def request_frame(task: BackgroundTask, place: tuple[int, int]) -> Future[Pixels]:
        found = Future[Pixels]()

        def draw_taken(taken: FrameTaken) -> None:
            if task.is_over:
                return
            try:
                if taken.snapshot is None:
                    gone = tr("The run of the animation no longer exists, so nothing was written.")
                    raise ValueError(taken.message or gone)
                found.set_result(renderer.render_frame(taken))
            except Exception as error:  # reported by the thread that waits for the frame
                found.set_exception(error)

        session.tasks.call_in_window(
            lambda: session.post_command(take_frame(task, generation, *place, shown, draw_taken))
        )
        return found

    def produce_frames(task: BackgroundTask) -> Iterator[Pixels]:
        due = request_frame(task, branch_steps[0])
        for place in (*branch_steps[1:], None):
            while not due.done():
                task.check_cancelled()
                wait([due], _CANCEL_CHECK_INTERVAL)
            frame = due.result()
            if place is not None:
                due = request_frame(task, place)
            yield frame

    return produce_frames
