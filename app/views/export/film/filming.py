"""Filming: the worker prepares the moments of a film one at a time, and the window draws the frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import QObject, QTimer

from app.model.text.language import tr
from app.session.exchange.messages import sentence
from app.session.session import Session
from app.session.signals import FILMING
from app.session.tasks.tasks import Task
from app.session.worker.requests import FrameTaken, TakeFrame
from app.views.export.film.frame_renderer import FrameRenderer
from cpm_core.numerics.types import Pixels

_INTERVAL = 15
"""Time between two checks whether another frame can be taken [ms]."""


class Filming(QObject):
    """Passes the frames of a film to `take`, one after the other, until its task is over.

    One frame is requested at a time and drawn in its own turn of the event loop, so that the window stays usable.

    Parameters
    ----------
    session : Session
        Session with the run.
    renderer : FrameRenderer
        Draws the frames; closed at the end.
    task : Task
        The task; canceling it ends the film.
    places : sequence of tuple of int
        Branches and steps.
    contours : bool
        Whether contours are shown.
    take : callable
        Called with every frame.
    end : callable
        Called after the last frame.
    has_room : callable
        Returns whether another frame can be taken.
    """

    def __init__(
        self,
        session: Session,
        renderer: FrameRenderer,
        task: Task,
        places: Sequence[tuple[int, int]],
        contours: bool,
        take: Callable[[Pixels], None],
        end: Callable[[], None],
        has_room: Callable[[], bool] = lambda: True,
    ) -> None:
        super().__init__(session)
        self._session = session
        self._renderer = renderer
        self._task = task
        self._places = list(places)
        self._contours = contours
        self._take = take
        self._end = end
        self._has_room = has_room
        self._generation = session.generation
        self._next = 0
        self._due = False
        self.over = False
        """Whether no more frames are taken."""
        self._timer = QTimer(self)
        self._timer.setInterval(_INTERVAL)
        self._timer.timeout.connect(self._go_on)
        self._timer.start()
        session.listen(FrameTaken, self._take_frame)
        self._go_on()

    def stop(self) -> None:
        """Take no more frames."""
        if not self.over:
            self.over = True
            self._timer.stop()
            self._session.stop_listening(FrameTaken, self._take_frame)
            self._renderer.close()
            self.deleteLater()

    def _go_on(self) -> None:
        if self._task.over:
            self.stop()
        elif not self._due and self._next < len(self._places) and self._has_room():
            self._due = True
            branch, step = self._places[self._next]
            command = TakeFrame(self._task, self._generation, branch, step, self._contours)
            self._session.post(command)

    def _take_frame(self, report: FrameTaken) -> None:
        if report.task is not self._task or self.over or self._task.over:
            return
        self._due = False
        if report.moment is None:
            self._task.cancel()
            gone = tr("The run of the film is gone, so nothing has been written.")
            self._session.say(report.sentence or gone, True, FILMING)
            self.stop()
            return
        try:
            self._take(self._renderer.draw(report))
        except Exception as error:  # it would be the same for each further try
            self._task.cancel()
            self._session.say(sentence(error, tr("drawing a film")), True, FILMING)
            self.stop()
            return
        self._next += 1
        if self._next == len(self._places):
            self.stop()
            self._end()
