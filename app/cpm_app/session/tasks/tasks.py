"""Long tasks: their list, progress and cancellation.

A `BackgroundTask` is the handle that the work shares with the window. Work that needs no run gets a thread of its own
by `TaskManager.start_task`; a command of the worker gets its task from `TaskManager.begin_task`, updates its progress
and ends it.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from functools import partial
from typing import TypeVar

from PySide6.QtCore import QObject, Signal

from cpm_app.model.state.situation import estimate_seconds_left
from cpm_app.session.exchange.messages import CommandFailed, Report, WorkFinished, explain_failure
from cpm_core.numerics.types import Callback

Outcome = TypeVar("Outcome")

_PROGRESS_INTERVAL = 0.1
"""Time between two updates of the progress of tasks [s]."""


class Cancelled(Exception):  # noqa: N818  # not an error: the user asked for it
    """The task has been cancelled."""


class BackgroundTask:
    """A long task, such as "Opening a.png…"; all of its methods may be called from any thread."""

    def __init__(self, name: str, cancellable: bool = True) -> None:
        self.name = name
        self.cancellable = cancellable
        self.fraction: float | None = None
        self._began = time.perf_counter()
        self._cancelled = threading.Event()
        self._ended = threading.Event()

    @property
    def seconds(self) -> float:
        """Time since the task began [s]."""
        return time.perf_counter() - self._began

    @property
    def seconds_left(self) -> float | None:
        """Estimate of the remaining time [s], None while unknown."""
        return estimate_seconds_left(self.seconds, self.fraction)

    @property
    def is_cancelled(self) -> bool:
        """Whether the task has been cancelled: the work stops, and its result is not used."""
        return self._cancelled.is_set()

    @property
    def is_over(self) -> bool:
        """Whether the task has ended or has been cancelled."""
        return self._ended.is_set() or self._cancelled.is_set()

    def advance(self, fraction: float) -> None:
        """Set the finished fraction, from 0 to 1; raise `Cancelled` if the task has been cancelled."""
        self.fraction = fraction
        self.check_cancelled()

    def check_cancelled(self) -> None:
        """Raise `Cancelled` if the task has been cancelled."""
        if self.is_cancelled:
            raise Cancelled(self.name)

    def cancel(self) -> None:
        """Cancel the task, unless it has ended."""
        if self.cancellable and not self._ended.is_set():
            self._cancelled.set()

    def wait(self) -> None:
        """Wait until the task has ended."""
        self._ended.wait()

    def end(self) -> None:
        """End the task, whether it has succeeded or not."""
        self._ended.set()


ENDED_TASK = BackgroundTask("")
"""A task that is over, for use before there has been any."""
ENDED_TASK.end()


class TaskManager(QObject):
    """The long tasks of a session.

    `report` sends a report to the window, from any thread; `wake` has `announce_changes` called in each display frame
    while there are tasks.
    """

    changed = Signal()
    """A task has begun or ended."""
    advanced = Signal()
    """The progress of tasks may have changed; sent a few times a second."""

    def __init__(self, report: Callable[[Report], None], wake: Callback, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._report = report
        self._wake = wake
        self._tasks: tuple[BackgroundTask, ...] = ()
        self._threads: list[threading.Thread] = []
        self._announced: tuple[BackgroundTask, ...] = ()
        self._shown_at = 0.0

    @property
    def current(self) -> tuple[BackgroundTask, ...]:
        """The tasks that are going on, the oldest first."""
        return tuple(task for task in self._tasks if not task.is_over)

    @property
    def idle(self) -> bool:
        """Whether there is no task, not even a cancelled one that has not stopped yet."""
        return not self._tasks and not self._threads

    def begin_task(self, name: str, cancellable: bool = True) -> BackgroundTask:
        """Announce a task whose work is done elsewhere, which has to call `BackgroundTask.end`.

        The work of a cancellable task has to check `BackgroundTask.is_cancelled`, or call `BackgroundTask.advance`.
        """
        task = BackgroundTask(name, cancellable)
        self._tasks = (*self._tasks, task)
        self._announced = self._tasks
        self._wake()
        self.changed.emit()
        return task

    def start_task(
        self,
        name: str,
        compute: Callable[[BackgroundTask], Outcome],
        activity: str,
        failure_report: Callable[[str], Report] = CommandFailed,
        cancellable: bool = True,
        on_result: Callable[[Outcome], object] | None = None,
    ) -> BackgroundTask:
        """Do a long task on a separate thread.

        The result of `compute` is passed to `on_result` on the window's thread, or without `on_result` is reported,
        unless the task has been cancelled. An error is reported by `failure_report`; `activity` follows "while" in its
        message.
        """
        task = self.begin_task(name, cancellable)

        def compute_and_report() -> None:
            report: object = None
            try:
                result = compute(task)
                report = result if on_result is None else WorkFinished(partial(on_result, result))
            except Cancelled:
                pass
            except Exception as error:  # any error is reported
                report = failure_report(explain_failure(error, activity))
            if isinstance(report, Report) and not task.is_cancelled:
                self._report(report)
            task.end()

        thread = threading.Thread(target=compute_and_report, name="cpm-task", daemon=True)
        self._threads.append(thread)
        thread.start()
        return task

    def call_in_window(self, callback: Callback) -> None:
        """Call a function on the window's thread, from any thread."""
        self._report(WorkFinished(callback))

    def announce_changes(self) -> None:
        """Announce tasks that have ended and progress since the last call."""
        for thread in [thread for thread in self._threads if not thread.is_alive()]:
            thread.join()
            self._threads.remove(thread)
        self._tasks = self.current
        now = time.perf_counter()
        if self._tasks != self._announced:
            self._announced = self._tasks
            self.changed.emit()
        elif self._tasks and now - self._shown_at >= _PROGRESS_INTERVAL:
            self._shown_at = now
            self.advanced.emit()

    def close(self) -> None:
        """Cancel all tasks and wait for their threads to end."""
        for task in self._tasks:
            task.cancel()
        for thread in self._threads:
            thread.join()
        self._threads.clear()
        self._tasks = ()
