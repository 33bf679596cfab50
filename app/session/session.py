"""The session: the one door through which documents are edited and runs are driven."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QObject, Qt, QTimer

from app.model.document import edits
from app.model.document.document import NOTHING_TO_START_FROM, Document, ImageReference, Mode
from app.model.document.modes import starting
from app.model.document.naming import describe
from app.model.document.samples import sample_at
from app.model.document.saving import restored
from app.model.state.resolve import FIRST_PACE, PACES, Resolved, resolve
from app.model.state.situation import Situation, can_step
from app.model.state.status import RunStatus
from app.model.text.language import tr
from app.session.core_functions import Core
from app.session.document.editor import Editor
from app.session.document.live_edits import Live
from app.session.exchange.messages import Opened
from app.session.exchange.pacing import Pacer
from app.session.features.contour_review import ContourReview
from app.session.features.skeleton import Skeletons
from app.session.signals import SessionSignals
from app.session.tasks.opening import Opener, Wanted
from app.session.tasks.tasks import Tasks
from app.session.updates import Progress
from app.session.worker.commands.run import (
    Adopt,
    Command,
    Copy,
    Discard,
    Export,
    Go,
    Halt,
    SetOverlays,
    SetPace,
    SetParameters,
    Start,
    WarmUp,
)
from app.session.worker.worker_thread import WorkerThread

FRAME = 16
"""Time between looks at what the worker has sent up [ms]."""


class Session(SessionSignals):
    """Document, history and run.

    Parameters
    ----------
    core : Core
        The core's functions; the real ones unless given.
    parent : QObject
        Owner.
    """

    def __init__(self, core: Core | None = None, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._editor = Editor()
        core = core or Core()
        self._worker_thread = WorkerThread(core)
        self.tasks = Tasks(self._worker_thread.report, self._wake, self)
        self._opener = Opener(core, self.tasks)
        self._progress = Progress(self, self._worker_thread)
        self.review = ContourReview(self)
        self._numbered = 0
        self._generation = 0
        self._image_generation = 0
        self.live = Live(self, self._progress.busy)
        self._overlays: frozenset[str] = frozenset()
        self._frames = Pacer()
        self._timer = QTimer(self)
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.setInterval(FRAME)
        self._timer.timeout.connect(self._frame)
        self.skeletons = Skeletons(self)
        self.set_pace(PACES[FIRST_PACE])

    # Looking

    @property
    def document(self) -> Document:
        """What the user means."""
        return self._editor.document

    @property
    def selected(self) -> int | None:
        """Index of the selected shape."""
        return self._editor.selected

    @property
    def changes(self) -> tuple[tuple[str, ...], int]:
        """Names of all changes to the document, and how many of them are done; the others are undone."""
        return self._editor.changes

    @property
    def generation(self) -> int:
        """Number of the current run; what belongs to another is not shown."""
        return self._generation

    @property
    def image_generation(self) -> int:
        """Number under which the image was opened."""
        return self._image_generation

    @property
    def status(self) -> RunStatus:
        """How the run stands."""
        status = self._progress.status
        stale = status.started and self.live.outdated(self.document)
        steered = status.phase == "finished" and status.steering != self.document.parameters.steering
        return replace(status, stale=stale, steered=steered, busy=self._opener.opening or status.busy)

    @property
    def situation(self) -> Situation:
        """All that decides what the window shows and enables."""
        editor = self._editor
        skeleton = self.skeletons.found is not None
        return Situation(self.document, self.status, editor.undo_name, editor.redo_name, self.selected, skeleton)

    @property
    def resolved(self) -> Resolved:
        """What the window shows."""
        return resolve(self.situation)

    @property
    def frames_per_second(self) -> float:
        """How often, measured, the newest particles are looked for and drawn."""
        return self._frames.per_second

    @property
    def idle(self) -> bool:
        """Whether nothing is going on and everything that was sent up has been shown."""
        return self._worker_thread.idle and self.tasks.idle

    # Editing

    def edit(self, name: str, edit: Callable[[Document], Document], gesture: str = "") -> None:
        """Change the document so that it can be undone.

        Parameters
        ----------
        name : str
            What is done, as it stands after "Undo".
        edit : callable
            Document to document; a `ValueError` is told to the user and changes nothing.
        gesture : str
            Edits in a row with the same gesture are undone together.
        """
        try:
            self._change(lambda: self._editor.edit(name, edit, gesture), settled=not gesture)
        except ValueError as error:
            self.say(str(error), True)

    def seal(self) -> None:
        """End a gesture: the next edit is undone by itself."""
        self._editor.seal()
        self.live.settle()

    def undo(self) -> None:
        """Take back the last edit."""
        self._change(self._editor.undo)

    def redo(self) -> None:
        """Do again what was undone last."""
        self._change(self._editor.redo)

    def go_to(self, done: int) -> None:
        """Take back or do again until so many of the changes in `changes` are done."""
        self._change(lambda: self._editor.go_to(done))

    def select(self, index: int | None) -> None:
        """Select a shape, or none."""
        if index != self.selected:
            self._editor.selected = index
            self.document_changed.emit(self.document)
            self.status_changed.emit()

    def select_next(self) -> None:
        """Select the shape drawn after the selected one, the first after the last."""
        self.select(self._editor.next_shape())

    def delete_selected(self) -> None:
        """Remove the selected shape."""
        index = self.selected
        if index is not None:
            name = tr("delete {shape}").format(shape=describe(self.document.shapes[index]))
            self.select(None)
            self.edit(name, lambda document: edits.delete_shape(document, index))

    # Files

    def open(self, path: str | Path, otherwise: Path | None = None) -> None:
        """Open an image or a session; what is open stays until the other one is known to be usable.

        Parameters
        ----------
        path : str or Path
            File of the image, or of a session.
        otherwise : Path, optional
            File to open when that one turns out to be unusable.
        """
        path = Path(path)
        sample = sample_at(path)
        self.begin(Wanted(path, sample.parameters if sample else self.document.parameters, otherwise))

    def begin(self, wanted: Wanted) -> None:
        """Open an image or a session; see `open`."""
        self._opener.open(wanted)

    def export(self, path: str | Path) -> None:
        """Write the contours that are shown; the suffix tells the format."""
        path = Path(path)
        task = self.tasks.begin(tr("Writing {name}…").format(name=path.name))
        self.post(Export(task, self._progress.contours, self.document.marks, path))

    def copy_contours(self, suffix: str) -> None:
        """Make the contours that are shown ready for the clipboard, as a file of this suffix would hold them."""
        task = self.tasks.begin(tr("Copying contours…"))
        self.post(Copy(task, self._progress.contours, self.document.marks, suffix))

    # Running

    def run(self) -> None:
        """Go on, or start anew when the drawing has changed or the run is over and no parameter has changed since."""
        if not self._ready():
            return
        if self.status.phase != "running":
            self._start_if_needed()
            self._progress.phase("running")
            self.post(Go(self._generation))

    def pause(self) -> None:
        """Stop after the step that is being taken."""
        if self.status.phase == "running":
            self.hold(Halt())

    def toggle(self) -> None:
        """Pause when running, otherwise run, or find the skeleton where that is wanted."""
        if self.status.phase == "running":
            self.pause()
        elif self.document.mode == "skeleton":
            self.skeletons.find()
        else:
            self.run()

    def step(self) -> None:
        """Take one step, starting when nothing has been started."""
        if can_step(self.situation) and self._ready():
            self._start_if_needed()
            self.hold(Go(self._generation, steps=1))

    def reset(self) -> None:
        """Forget the particles and go back to the drawing."""
        if self.status.started:
            self._generation = self._next_generation()
            self._progress.forget()
            self.post(Discard(self._generation))

    def hold(self, command: Command) -> None:
        """Hold a run that has been begun, by a command after which it stands at some step."""
        self._progress.phase("paused")
        self.post(command)

    def set_pace(self, steps_per_second: float | None) -> None:
        """Limit the speed; None for none."""
        self.post(SetPace(steps_per_second))

    def want_overlay(self, name: str, wanted: bool) -> None:
        """Say whether an overlay is to be kept up to date; see `app.session.worker.overlays`."""
        before = self._overlays
        self._overlays = before | {name} if wanted else before - {name}
        if self._overlays != before:
            self.post(SetOverlays(self._overlays))

    def warm_up(self) -> None:
        """Compile or load the kernels ahead of the first step."""
        self._progress.busy("preparing", tr("Preparing (longer the very first time)…"))
        self._opener.afterwards(lambda: self.post(WarmUp()))

    def post(self, command: Command) -> None:
        """Send a command to the worker."""
        self._worker_thread.post(command)
        self._wake()

    def close(self) -> None:
        """Stop everything and wait for the worker to end."""
        self._timer.stop()
        self.tasks.close()
        self._worker_thread.close()

    # What the worker has sent up leads to

    def accept(self, opened: Opened) -> None:
        """Take over an image that has been opened."""
        self._generation = self._image_generation = self._next_generation()
        self.post(Adopt(self._generation, opened))
        self.image_changed.emit(opened.image, opened.shades)
        self._progress.forget()
        self._change(lambda: self._editor.begin(_document(opened, self.document.mode)))
        self.post(SetParameters(opened.parameters))

    # Inside

    def _ready(self) -> bool:
        if self.document.image is None:
            self.say(tr("There is no image to run on: open one first."), True)
            return False
        if not self.document.starts:
            self.say(NOTHING_TO_START_FROM, True)
            return False
        return True

    def _start_if_needed(self) -> None:
        status = self.status
        over = status.phase == "finished" and not status.steered
        if status.phase == "ready" or over or status.stale:
            self._generation = self._next_generation()
            self.live.begin(self.document)
            self._progress.forget()
            self.post(Start(self._generation, self._image_generation, self.document))

    def _next_generation(self) -> int:
        self._numbered += 1
        return self._numbered

    def _change(self, change: Callable[[], None], settled: bool = True) -> None:
        before = self.document
        change()
        if before != self.document:
            self.live.follow(before, self.document, settled)
            self.document_changed.emit(self.document)
            self.status_changed.emit()

    def _wake(self) -> None:
        if not self._timer.isActive():
            self._frames.begin()
            self._timer.start()

    def _frame(self) -> None:
        self._frames.stepped()
        self.tasks.look()
        self._progress.look()
        if self.idle:
            self._timer.stop()


def _document(opened: Opened, mode: Mode) -> Document:
    """The document that an image or a session begins with; the mode stays unless it is a sample or a session."""
    image, path, sample = opened.image, opened.path, sample_at(opened.path)
    contrast = float(image.values.max() - image.values.min())
    reference = ImageReference(path.name, str(path), image.shape, contrast, opened.sha256)
    if opened.saved is not None:
        return restored(opened.saved.file, reference, opened.parameters)
    if sample is not None:
        return Document(reference, sample.shapes, opened.parameters, mode=sample.mode)
    return Document(reference, starting(mode, ()), opened.parameters, mode=mode)
