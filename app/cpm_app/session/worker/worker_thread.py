"""The worker thread: steps a method and executes commands in order between steps."""

from __future__ import annotations

import ctypes
import queue
import threading
from collections import deque
from collections.abc import Iterator
from contextlib import suppress

from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import Core, Report, RunFailed, sentence
from cpm_app.session.worker.commands import QUIT, Command, CommandContext
from cpm_app.session.worker.prepared_methods import PreparedMethods
from cpm_app.session.worker.run import Run

QUIET = 1.0
"""Time without a command after which free memory is returned to the system [s]."""


class WorkerThread:
    """One thread that owns the run.

    Commands are sent by `post`, in order and never lost. Snapshots, contours and overlays are left in mailboxes of the
    run, in which the newest wins; messages that must not be missed are in `reports`. The thread never calls the window,
    which takes these messages itself.
    """

    def __init__(self, core: Core | None = None) -> None:
        self._reports: deque[Report] = deque()
        self._commands: queue.SimpleQueue[Command] = queue.SimpleQueue()
        self._posted = 0
        self._executed = 0
        self._waiting = False
        self._closing = False
        self._newest: dict[object, Command] = {}
        core = core or Core()
        self.run = Run(PreparedMethods(core.methods))
        self._context = CommandContext(core, self.run, self.report, lambda: self._closing)
        self._thread = threading.Thread(target=self._work, name="cpm-engine", daemon=True)
        self._thread.start()

    def post(self, command: Command) -> None:
        """Send a command; only from the window's thread."""
        self._posted += 1
        if command.kind is not None:
            self._newest[command.kind] = command
        self._commands.put(command)

    def report(self, report: Report) -> None:
        """Send a report to the window, from any thread."""
        self._reports.append(report)

    def reports(self) -> Iterator[Report]:
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
            self.post(QUIT)
            self._thread.join()
            self.run.reconstructor.close()

    def _work(self) -> None:
        while (command := self._next()) is not QUIT:
            try:
                if command is None:
                    self.run.step()
                elif command.kind is None or command is self._newest[command.kind]:
                    command.work(self._context)
            except Exception as error:  # no error may end the thread
                if command is None:
                    self.run.halt()
                    self._reports.append(RunFailed(self.run.generation, sentence(error, tr("computing a step"))))
                else:
                    self._reports.append(command.failed(sentence(error, command.activity)))
            self._executed += command is not None

    def _next(self) -> Command | None:
        """Wait for the next command; None if a step is due before one arrives."""
        if self.run.stepping:
            try:
                wait = self.run.pacer.wait()
                return self._commands.get(timeout=wait) if wait > 0 else self._commands.get_nowait()
            except queue.Empty:
                return None
        self._waiting = True
        try:
            command = self._commands.get(timeout=QUIET)
        except queue.Empty:
            give_back()
            command = self._commands.get()
        self._waiting = False
        return command


def give_back() -> None:
    """Return free memory to the system if the C library is glibc, which keeps the gaps between arrays."""
    with suppress(OSError, TypeError, AttributeError):
        ctypes.CDLL(None).malloc_trim(0)
