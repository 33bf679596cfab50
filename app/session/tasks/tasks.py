"""Long work: what is going on, how far it is, and how it is given up.

A `Task` is the handle that whoever does the work and whoever waits for it share. Work that needs neither engine nor
particles runs on a thread of its own, `Tasks.start`; a command of the worker is given a task by `Tasks.begin`, tells it
how far it is and ends it.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from PySide6.QtCore import QObject, Signal

from app.model.state.time_left import seconds_left
from app.session.exchange.error_messages import sentence
from app.session.exchange.messages import CommandFailed, Report

_TOLD_EVERY = 0.1
"""Time between two looks at how far a task is [s]."""

Clock = Callable[[], float]


class Cancelled(Exception):  # noqa: N818  # no error: it is what was asked for
    """The work has been given up, as asked."""


class Task:
    """One piece of long work; all of it may be called from any thread.

    Parameters
    ----------
    name : str
        What is being done, as in "Opening a.png…".
    cancellable : bool
        Whether it can be given up.
    clock : callable
        Seconds that only go forward.
    """

    def __init__(self, name: str, cancellable: bool = True, clock: Clock = time.perf_counter) -> None:
        self.name = name
        self.cancellable = cancellable
        self.fraction: float | None = None
        self._clock = clock
        self._began = clock()
        self._cancelled = threading.Event()
        self._ended = threading.Event()

    @property
    def seconds(self) -> float:
        """Time since it was begun [s]."""
        return self._clock() - self._began

    @property
    def seconds_left(self) -> float | None:
        """Time that it is still going to take [s], None while that cannot be told."""
        return seconds_left(self.seconds, self.fraction)

    @property
    def cancelled(self) -> bool:
        """Whether it has been given up: whoever does the work stops, and nothing comes of it."""
        return self._cancelled.is_set()

    @property
    def over(self) -> bool:
        """Whether nobody waits for it any more."""
        return self._ended.is_set() or self._cancelled.is_set()

    def advance(self, fraction: float) -> None:
        """Tell how much is done, from 0 to 1.

        Raises
        ------
        Cancelled
            When it has been given up, so that whoever does the work gets out of it.
        """
        self.fraction = fraction
        self.go_on()

    def go_on(self) -> None:
        """Raise `Cancelled` when it has been given up."""
        if self.cancelled:
            raise Cancelled(self.name)

    def cancel(self) -> None:
        """Give it up; what is over stays as it is."""
        if self.cancellable and not self._ended.is_set():
            self._cancelled.set()

    def end(self) -> None:
        """It is done, well or not."""
        self._ended.set()


class Tasks(QObject):
    """The long work of a session.

    Parameters
    ----------
    report : callable
        Sends a report up to the window, from any thread.
    wake : callable
        Sees to it that `look` is called about once a frame while there is anything to look at.
    parent : QObject, optional
        Owner.
    """

    changed = Signal()
    """One has begun or is over."""
    advanced = Signal()
    """One may be further than before; a few times a second at most."""

    def __init__(
        self, report: Callable[[Report], None], wake: Callable[[], None], parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._report = report
        self._wake = wake
        self._tasks: tuple[Task, ...] = ()
        self._threads: list[threading.Thread] = []
        self._told: tuple[Task, ...] = ()
        self._told_at = 0.0

    @property
    def current(self) -> tuple[Task, ...]:
        """What is going on, the oldest first."""
        return tuple(task for task in self._tasks if not task.over)

    @property
    def idle(self) -> bool:
        """Whether nothing is going on, not even work that has been given up and has not noticed yet."""
        return not self._tasks and not self._threads

    def begin(self, name: str, cancellable: bool = True) -> Task:
        """Announce work that somebody else does, who has to `Task.end` it.

        Parameters
        ----------
        name : str
            What is being done, as in "Writing a.gif…".
        cancellable : bool
            Whether it can be given up; then whoever does it has to look at `Task.cancelled`, or call `Task.advance`.
        """
        task = Task(name, cancellable)
        self._tasks = (*self._tasks, task)
        self._told = self._tasks
        self._wake()
        self.changed.emit()
        return task

    def start(
        self,
        name: str,
        work: Callable[[Task], Report | None],
        activity: str,
        failure_report: Callable[[str], Report] = CommandFailed,
        cancellable: bool = True,
    ) -> Task:
        """Do long work on a thread of its own.

        Parameters
        ----------
        name : str
            What is being done, for people.
        work : callable
            Given the task; what it returns is reported, unless the task has been given up meanwhile.
        activity : str
            The same as it stands after "while" in a sentence on trouble.
        failure_report : callable
            From a sentence on what went wrong to what is reported then.
        cancellable : bool
            Whether it can be given up.
        """
        task = self.begin(name, cancellable)

        def run() -> None:
            try:
                report = work(task)
            except Cancelled:
                report = None
            except Exception as error:  # the thread's outermost frame: whatever happens is told
                report = failure_report(sentence(error, activity))
            if report is not None and not task.cancelled:
                self._report(report)
            task.end()

        thread = threading.Thread(target=run, name="cpm-task", daemon=True)
        self._threads.append(thread)
        thread.start()
        return task

    def look(self) -> None:
        """Tell of what has changed since the last time."""
        for thread in [thread for thread in self._threads if not thread.is_alive()]:
            thread.join()
            self._threads.remove(thread)
        self._tasks = self.current
        now = time.perf_counter()
        if self._tasks != self._told:
            self._told = self._tasks
            self.changed.emit()
        elif self._tasks and now - self._told_at >= _TOLD_EVERY:
            self._told_at = now
            self.advanced.emit()

    def close(self) -> None:
        """Give everything up and wait for the threads to end."""
        for task in self._tasks:
            task.cancel()
        for thread in self._threads:
            thread.join()
        self._threads.clear()
        self._tasks = ()
