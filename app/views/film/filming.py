"""Filming: frame after frame is found on the worker thread and drawn in the window, one at a time."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import QObject, QTimer

from app.model.text.language import tr
from app.session.session import Session
from app.session.tasks.tasks import Task
from app.session.worker.commands.frames import FrameTaken, TakeFrame
from app.views.film.frame_renderer import FrameRenderer
from cpm_core.numerics.types import Pixels

_PATIENCE = 15
"""Time between two looks whether there is room for a frame [ms]."""


class Filming(QObject):
    """Gives the frames of a film one after the other to whoever takes them, until its task is over.

    Only one frame is asked for at a time and drawn in a turn of the event loop of its own, so that the window stays
    usable meanwhile.

    Parameters
    ----------
    session : Session
        Whose run is filmed.
    renderer : FrameRenderer
        Who draws; closed at the end.
    task : Task
        What it is done for.
    places : sequence of tuple of int
        Branches and steps.
    contours : bool
        Whether contours are seen.
    compared : int or None
        Branch seen beside.
    take : callable
        Given every frame.
    end : callable
        Called after the last one has been taken.
    has_room : callable
        Whether another frame can be taken already.
    """

    def __init__(
        self,
        session: Session,
        renderer: FrameRenderer,
        task: Task,
        places: Sequence[tuple[int, int]],
        contours: bool,
        compared: int | None,
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
        self._compared = compared
        self._take = take
        self._end = end
        self._has_room = has_room
        self._generation = session.generation
        self._next = 0
        self._due = False
        self._over = False
        self._timer = QTimer(self)
        self._timer.setInterval(_PATIENCE)
        self._timer.timeout.connect(self._go_on)
        self._timer.start()
        session.listen(FrameTaken, self._take_frame)
        self._go_on()

    @property
    def over(self) -> bool:
        """Whether no more frames are taken."""
        return self._over

    def stop(self) -> None:
        """Take no more frames."""
        if not self._over:
            self._over = True
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
            command = TakeFrame(self._task, self._generation, branch, step, self._contours, self._compared)
            self._session.post(command)

    def _take_frame(self, report: FrameTaken) -> None:
        if report.task is not self._task or self._over or self._task.over:
            return
        self._due = False
        if report.moment is None:
            self._task.cancel()
            told = report.sentence or tr("The run that was to be filmed is gone, so nothing has been written.")
            self._session.say(told, True)
            self.stop()
            return
        self._take(self._renderer.draw(report))
        self._next += 1
        if self._next == len(self._places):
            self.stop()
            self._end()
