"""The worker thread: steps a method and executes commands in order between steps."""

from __future__ import annotations

import ctypes
import queue
import threading
from collections import deque
from collections.abc import Iterator
from contextlib import suppress

from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import Report, RunFailed, explain_failure
from cpm_app.session.worker.commands import QUIT_COMMAND, CommandContext, WorkerCommand
from cpm_app.session.worker.prepared_methods import PreparedMethods
from cpm_app.session.worker.run import Run

Due = tuple[WorkerCommand | None, dict[object, WorkerCommand]]
"""A command, None for a step, and the newest of each kind among the commands that may change places with it."""

IDLE_BEFORE_RELEASE = 1.0
"""Time without a command after which free memory is returned to the system [s]."""


class WorkerThread:
    """One thread that owns the run.

    Commands are sent by `post_command`, in order and never lost. Snapshots, contours and overlays are left in mailboxes
    of the run, in which the newest wins; messages that must not be missed are in `take_reports`. The thread never calls
    the window, which takes these messages itself.
    """

    def __init__(self) -> None:
        self._reports: deque[Report] = deque()
        self._commands: queue.SimpleQueue[Due] = queue.SimpleQueue()
        self._posted = 0
        self._executed = 0
        self._waiting = False
        self._closing = False
        self._newest: dict[object, WorkerCommand] = {}
        self.run = Run(PreparedMethods(), lambda: self._closing)
        self._context = CommandContext(self.run, self.send_report, lambda: self._closing)
        self._thread = threading.Thread(target=self._run_loop, name="cpm-engine", daemon=True)
        self._thread.start()

    def post_command(self, command: WorkerCommand) -> None:
        """Send a command; only from the window's thread.

        Of several of a kind that wait, only the newest is executed, unless one without a kind is between them: that one
        may depend on what the earlier ones set, whereas commands of different kinds may change places.
        """
        self._posted += 1
        if command.kind is None:
            self._newest = {}
        self._newest[command.kind] = command
        self._commands.put((command, self._newest))

    def send_report(self, report: Report) -> None:
        """Send a report to the window, from any thread."""
        self._reports.append(report)

    def take_reports(self) -> Iterator[Report]:
        """Take the reports since the last call, oldest first; if the loop over them fails, the rest stay."""
        while self._reports:
            yield self._reports.popleft()

    @property
    def idle(self) -> bool:
        """Whether every command has been executed, no step remains and every message has been taken."""
        return (
            self._executed == self._posted
            and self._waiting
            and self.run.reconstructor.idle
            and not (self._reports or self.run.snapshots or self.run.overlays or self.run.reconstructor.results)
        )

    def close(self) -> None:
        """Stop between two steps, end both threads and wait for them."""
        if self._thread.is_alive():
            self._closing = True
            self.post_command(QUIT_COMMAND)
            self._thread.join()
            self.run.reconstructor.close()

    def _run_loop(self) -> None:
        while (due := self._next_command())[0] is not QUIT_COMMAND:
            command, newest = due
            try:
                if command is None:
                    self.run.take_step()
                elif command is newest[command.kind]:
                    command.execute(self._context)
            except Exception as error:  # no error may end the thread
                if command is None:
                    self.run.halt()
                    self._reports.append(RunFailed(self.run.generation, explain_failure(error, tr("computing a step"))))
                else:
                    self._reports.append(command.failure_report(explain_failure(error, command.activity)))
            self._executed += command is not None

    def _next_command(self) -> Due:
        """Wait for the next command, or until a step is due; overlays are made once no command waits."""
        while self._commands.empty() and self.run.refresh_overlay():
            pass
        if self.run.is_stepping:
            try:
                wait = self.run.pacer.seconds_until_due()
                return self._commands.get(timeout=wait) if wait > 0 else self._commands.get_nowait()
            except queue.Empty:
                return None, {}
        self._waiting = True
        try:
            due = self._commands.get(timeout=IDLE_BEFORE_RELEASE)
        except queue.Empty:
            release_free_memory()
            due = self._commands.get()
        self._waiting = False
        return due


def release_free_memory() -> None:
    """Return free memory to the system if the C library is glibc, which keeps the gaps between arrays."""
    with suppress(OSError, TypeError, AttributeError):
        ctypes.CDLL(None).malloc_trim(0)
