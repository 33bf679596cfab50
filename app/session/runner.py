"""The worker thread: builds the engine and steps it, obeying commands in order between steps."""

from __future__ import annotations

import gc
import queue
import threading
from collections import deque
from dataclasses import replace

from app.model import shades
from app.model.document import NOWHERE
from app.session.core import Core
from app.session.mailbox import Mailbox
from app.session.messages import (
    Command,
    Discard,
    Export,
    Exported,
    Failed,
    Go,
    Halt,
    NotOpened,
    Open,
    Opened,
    Overlays,
    Quit,
    Report,
    SetOverlays,
    SetPace,
    SetParameters,
    Snapshot,
    Sow,
    Sowing,
    Start,
    Trouble,
    WarmedUp,
    WarmUp,
)
from app.session.reconstructor import Reconstructor
from app.session.run import Run
from app.session.trouble import sentence
from cpm_core.multiscale import most_scales


class Runner:
    """One thread that owns the engine.

    Commands go down through `post`, in order and never lost; snapshots, contours and overlays come up through mailboxes
    in which the newest wins; the few things that must not be missed come up through `reports`. Nothing here calls back
    into the window: whoever wants to know looks.

    Parameters
    ----------
    core : Core
        The core's functions.
    """

    def __init__(self, core: Core | None = None) -> None:
        self._core = core or Core()
        self.snapshots: Mailbox[Snapshot] = Mailbox()
        self.overlays: Mailbox[Overlays] = Mailbox()
        self.reconstructor = Reconstructor()
        self._reports: deque[Report] = deque()
        self._commands: queue.SimpleQueue[Command] = queue.SimpleQueue()
        self._posted = 0
        self._obeyed = 0
        self._waiting = False
        self._closing = False
        self._last_sow: Sow | None = None
        self._run = Run(self._core.engine, self.snapshots, self.overlays, self.reconstructor)
        self._thread = threading.Thread(target=self._work, name="cpm-engine", daemon=True)
        self._thread.start()

    def post(self, command: Command) -> None:
        """Send a command; only ever from the window's thread."""
        self._posted += 1
        if isinstance(command, Sow):
            self._last_sow = command
        self._commands.put(command)

    def reports(self) -> list[Report]:
        """Reports since the last call, oldest first."""
        taken = []
        while self._reports:
            taken.append(self._reports.popleft())
        return taken

    @property
    def idle(self) -> bool:
        """Whether every command has been obeyed, nothing steps and everything that was sent up has been taken."""
        return (
            self._obeyed == self._posted
            and self._waiting
            and self.reconstructor.idle
            and not (self._reports or self.snapshots or self.overlays or self.reconstructor.results)
        )

    def close(self) -> None:
        """Stop between two steps, end both threads and wait for them."""
        if self._thread.is_alive():
            self._closing = True
            self.post(Quit())
            self._thread.join()
            self.reconstructor.close()

    def _work(self) -> None:
        while not isinstance(command := self._next(), Quit):
            if command is None:
                self._guarded_step()
            else:
                self._guarded_obey(command)
                self._obeyed += 1

    def _next(self) -> Command | None:
        """The next command; None when a step is due before one comes."""
        if not self._run.stepping:
            self._waiting = True
            command = self._commands.get()
            self._waiting = False
            return command
        try:
            wait = self._run.pacer.wait()
            return self._commands.get(timeout=wait) if wait > 0 else self._commands.get_nowait()
        except queue.Empty:
            return None

    def _guarded_step(self) -> None:
        try:
            self._run.step()
        except Exception as error:  # the thread's outermost frame: whatever happens must not end it
            self._run.halt()
            self._reports.append(Failed(self._run.generation, sentence(error, "taking a step")))

    def _guarded_obey(self, command: Command) -> None:
        try:
            self._obey(command)
        except Exception as error:  # the thread's outermost frame: whatever happens must not end it
            self._reports.append(_refusal(command, error))

    def _obey(self, command: Command) -> None:
        match command:
            case Open():
                self._open(command)
            case Start(generation, image_generation, document):
                if image_generation == self._run.image_generation:
                    self._run.start(generation, document)
            case Go(generation, steps):
                if generation == self._run.generation:
                    self._run.go(steps)
            case Halt():
                self._run.halt()
            case Discard(generation):
                self._run.discard(generation)
            case SetParameters(parameters):
                self._run.set_parameters(parameters)
            case SetPace(steps_per_second):
                self._run.pacer.limit(steps_per_second)
            case SetOverlays(edge_map, field):
                self._run.set_overlays(edge_map, field)
            case Sow(image_generation, document):
                # Of many in a row, as while a slider is moved, only the last is worth the work.
                if image_generation == self._run.image_generation and command is self._last_sow:
                    self._reports.append(Sowing(image_generation, self._run.sow(document)))
            case Export(path):
                self._core.export(self._run.result(), path)
                self._reports.append(Exported(path))
            case WarmUp():
                self._core.warm_up(lambda: self._closing)
                # All that is loaded by now stays; looking through it for garbage would hold up the window for frames,
                # even a single time.
                gc.freeze()
                self._reports.append(WarmedUp())

    def _open(self, command: Open) -> None:
        image = self._core.load_image(command.path)
        parameters, notes = command.parameters, image.notes
        most = most_scales(image.shape)
        if parameters.scales > most:
            parameters = replace(parameters, scales=most)
            notes = (*notes, f"The image is small: the scales are set to {most}.")
        self._run.use(command.generation, image, parameters)
        shown = shades.of_image(image.values)
        self._reports.append(Opened(command.generation, image, shown, command.path, parameters, notes))


def _refusal(command: Command, error: Exception) -> Report:
    """What is reported when a command cannot be obeyed."""
    match command:
        case Open(generation, path, _, otherwise):
            return NotOpened(generation, sentence(error, f"opening {path.name}"), otherwise)
        case Start(generation):
            return Failed(generation, sentence(error, "starting"))
        case Sow(generation):
            return Sowing(generation, NOWHERE, sentence(error, "looking for places to start from"))
        case Export(path):
            return Trouble(sentence(error, f"writing {path.name}"))
    return Trouble(sentence(error, type(command).__name__.lower()))
