"""The session: an image with its document and its run, opened, edited, run and exported."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QObject, Qt, QTimer

from cpm_app.model.document import edits
from cpm_app.model.document.document import Document, ImageReference, Mode
from cpm_app.model.document.modes import MODES, initial_parameters, needs_start, adapt_shapes_to_mode, switch_mode
from cpm_app.model.document.samples import find_copied_sample
from cpm_app.model.document.saving import from_session_file
from cpm_app.model.export import ExportOrder
from cpm_app.model.state.resolve import INITIAL_PACE_INDEX, RUN_PACES, WindowTexts, resolve_texts
from cpm_app.model.state.situation import RunStatus, Situation, can_step
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import translate_core_text, explain_error, tr
from cpm_app.model.volume.slices import Slices
from cpm_app.session.exchange.mailbox import Pacer
from cpm_app.session.exchange.messages import Core, ImageReady, NotOpened, Opened
from cpm_app.session.live_edits import Live
from cpm_app.session.scene import ReviewedContours, Scene
from cpm_app.session.signals import EDITING, EXPORTING, OPENING, RUNNING, Board
from cpm_app.session.tasks.opening import Opener, Wanted
from cpm_app.session.tasks.tasks import Tasks
from cpm_app.session.undo_history import Change, Erasure, History
from cpm_app.session.worker.commands import Command, RunsRestored, restore_runs, run_call, start, warm_up, write_files
from cpm_app.session.worker.run import Run
from cpm_app.session.worker.worker_thread import WorkerThread
from cpm_core import METHODS, Image, Parameters
from cpm_core.formats import Reading
from cpm_core.formats.images.reading import DEFAULT_READING
from cpm_core.shapes import Sphere

_PREPARING_TEXT = tr("Preparing (takes longer the first time)…")

LOOK = 4
"""Time between two polls of the worker, short enough that a step is seen soon after it is taken [ms]."""

FRAME = 0.013
"""Shortest time between two displayed frames, so that a fast run leaves the window time for the user [s]."""


class Session(QObject):
    """Document, history and run, and the files that they are read from and written to.

    Views connect to its signals and read its scene; long work is done by the worker thread and by tasks.
    """

    def __init__(self, core: Core | None = None) -> None:
        super().__init__()
        core = core or Core()
        self._worker_thread = WorkerThread(core)
        self._board = board = Board(self._worker_thread, self)
        self.scene_changed, self.image_changed = board.scene_changed, board.image_changed
        self.document_changed, self.status_changed = board.document_changed, board.status_changed
        self.said, self.attempted = board.said, board.attempted
        self.show, self.show_status, self.gathering = board.show, board.show_status, board.gathering
        self.listen, self.stop_listening, self.pass_on = board.listen, board.stop_listening, board.pass_on
        self.say, self.trouble, self.attempt = board.say, board.trouble, board.attempt
        self.tasks = Tasks(self._worker_thread.report, self._wake, self)
        self.tasks.changed.connect(self.show_status)
        self._numbered = 0
        self._resolved: tuple[Situation, WindowTexts] | None = None
        self.history = History()
        """The changes that can be undone and redone."""
        self.live = Live(board, self.post)
        self._overlays: frozenset[str] = frozenset()
        self._frames = Pacer()
        self._frames.limit(1.0 / FRAME)
        self._timer = QTimer(self)
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.setInterval(LOOK)
        self._timer.timeout.connect(self._frame)
        self.set_pace(RUN_PACES[INITIAL_PACE_INDEX])
        self._opener = Opener(core, self.tasks)
        self._mode_before = self.document.mode
        """The mode in use when the image that is being opened was requested."""
        self._asked_scales = self._used_scales = self.document.parameters.scales
        self.keeps_parameters = False
        """Whether the next image begins with the parameters of the one before it."""
        self.former_parameters: Parameters | None = None
        """Parameters of the image that was open before this one."""
        self.may_replace: Callable[[Opened], bool] = lambda opened: True
        """Whether an image may replace the open one at once; if not, `use` opens it later."""
        self.listen(ImageReady, lambda ready: self.use(ready.opened) if self.may_replace(ready.opened) else None)
        self.listen(Opened, self._accept)
        self.listen(
            RunsRestored,
            lambda kept: self.live.restore(kept.begun) if kept.generation == self.image_generation else None,
        )
        self.listen(NotOpened, lambda refused: self.say(refused.message, True, OPENING))

    # State

    @property
    def scene(self) -> Scene:
        """The scene that is shown."""
        return self._board.scene

    @property
    def generation(self) -> int:
        """Number of the current run; snapshots and reports of other runs are not shown."""
        return self._board.generation

    @property
    def image_generation(self) -> int:
        """Number under which the image was opened."""
        return self._board.image_generation

    @property
    def image(self) -> Image | None:
        """The image that is open."""
        return self.scene.image

    @property
    def document(self) -> Document:
        """The document of the scene."""
        return self.scene.document

    @property
    def selected(self) -> int | None:
        """Index of the selected shape."""
        return self.scene.selected

    @property
    def status(self) -> RunStatus:
        """State of the run."""
        status, document = self._board.status, self.document
        method = METHODS[status.method]
        other = status.method != MODES[document.mode].method
        stale = status.started and (other or (method.seeded and self.live.outdated(document)))
        steered = status.phase == "finished" and status.steering != method.steering(document.parameters)
        if status.phase == "empty" and self.opening:
            return replace(status, busy=self.opening)
        return replace(status, stale=stale, steered=steered)

    @property
    def situation(self) -> Situation:
        """Everything that decides what the window shows and enables."""
        return Situation(self.document, self.status, self.history.undo_name, self.history.redo_name, self.selected)

    @property
    def resolved(self) -> WindowTexts:
        """Everything that the window shows and enables, derived from the situation."""
        situation = self.situation
        if self._resolved is None or self._resolved[0] != situation:
            self._resolved = situation, resolve_texts(situation)
        return self._resolved[1]

    @property
    def frames_per_second(self) -> float:
        """Measured rate of display frames."""
        return self._frames.per_second

    @property
    def idle(self) -> bool:
        """Whether there is no work and every report has been shown."""
        return self._worker_thread.idle and self.tasks.idle

    # Editing

    def edit(
        self, name: str, edit: Callable[[Document], Document], gesture: str = "", erasure: Erasure | None = None
    ) -> None:
        """Change the document in a way that can be undone.

        `name` follows "Undo" in the menu. Successive edits with the same gesture are undone together, as is the
        `erasure` of particles. A gesture that changes the forces on particles at rest, such as the drag of a slider,
        wakes them. A `ValueError` of `edit` is shown to the user and changes nothing.
        """
        before = self.document
        try:
            after = edit(before)
        except ValueError as error:
            self.say(explain_error(error), True, EDITING)
            return
        if after != before or erasure is not None:
            rest = self._rest_before(after) if gesture else None
            self.history.push(Change(name, before, after, gesture, erasure, rest))
            with self.gathering():
                self._use(after, complete=not gesture)
            if rest is not None:
                self.run()

    def use_mode(self, mode: Mode) -> None:
        """Change the mode."""
        name = tr("mode “{mode}”", mode=MODES[mode].title.replace("&", ""))
        self.edit(name, lambda document: document if document.mode == mode else switch_mode(document, mode))

    def seal(self) -> None:
        """End a gesture, so that the next edit is undone separately."""
        self.history.seal()
        self.live.end_gesture()

    def undo(self) -> None:
        """Undo the last edit."""
        self._turn(self.history.undo(), back=True)

    def redo(self) -> None:
        """Repeat the edit that was undone last."""
        self._turn(self.history.redo(), back=False)

    def select(self, index: int | None) -> None:
        """Select a shape, or none; an index beyond the shapes, one that could not be drawn, selects none."""
        if index is not None and index >= len(self.document.shapes):
            index = None
        if index != self.selected:
            self.show(replace(self.scene, selected=index))
            self.document_changed.emit(self.document)
            self.show_status()

    def select_next(self) -> None:
        """Select the shape drawn after the selected one, the first after the last."""
        count = len(self.document.shapes)
        self.select(None if not count else 0 if self.selected is None else (self.selected + 1) % count)

    def delete_selected(self) -> None:
        """Remove the selected shape."""
        index = self.selected
        if index is not None:
            name = tr("delete {shape}", shape=translate_core_text(self.document.shapes[index].title))
            self.select(None)
            self.edit(name, lambda document: edits.delete_shape(document, index))

    def begin_document(self, document: Document, before: Document | None = None) -> None:
        """Replace the document, or the one `before` it, by another one with an empty undo history."""
        self.history = History()
        self._board.scene = replace(self.scene, selected=None)
        self._use(document, before=before)

    # Running

    def run(self) -> None:
        """Continue the run; restart it if the shapes have changed, or if it has ended and no parameter has changed."""
        if not self._ready():
            return
        if self.status.phase != "running":
            self._start_if_needed()
            self._board.phase("running")
            self.post(run_call(self._board.generation, Run.go))

    def pause(self) -> None:
        """Stop after the current step."""
        if self.status.phase == "running":
            self.hold(run_call(None, Run.halt))

    def toggle(self) -> None:
        """Pause when running, otherwise run."""
        if self.status.phase == "running":
            self.pause()
        else:
            self.run()

    def step(self) -> None:
        """Take one step; start a run first if there is none."""
        if can_step(self.situation) and self._ready():
            self._start_if_needed()
            self.hold(run_call(self._board.generation, Run.go, 1))

    def reset(self) -> None:
        """Remove the particles and go back to the start; the run stays on the timeline."""
        if self.status.started:
            self.attempt(RUNNING)
            kept = self.status.step > 0
            self._board.generation = self._next_generation()
            self._board.forget()
            self.post(run_call(None, Run.discard, self._board.generation))
            if kept:
                kept_on = tr(
                    "The run stays on the timeline: click it there or press {key:timeline_last} to return to it."
                )
                self.say(insert_keys(kept_on))

    def hold(self, command: Command) -> None:
        """Send a command after which the run stays at some step."""
        self._board.phase("paused")
        self.post(command)

    def set_pace(self, steps_per_second: float | None) -> None:
        """Limit the steps per second; None for no limit."""
        self.post(run_call(None, Run.set_pace, steps_per_second))

    def want_overlay(self, name: str, wanted: bool) -> None:
        """Set whether an overlay is kept up to date; see `cpm_app.session.worker.prepared_methods`."""
        before = self._overlays
        self._overlays = before | {name} if wanted else before - {name}
        if self._overlays != before:
            shown = {kept: array for kept, array in self.scene.overlays.items() if kept in self._overlays}
            if len(shown) < len(self.scene.overlays):
                self.show(replace(self.scene, overlays=shown))
            self.post(run_call(None, Run.set_overlays, self._overlays))

    def post(self, command: Command) -> None:
        """Send a command to the worker."""
        self._worker_thread.post(command)
        self._wake()

    def close(self) -> None:
        """Stop everything and wait for the worker to end."""
        self._timer.stop()
        self.tasks.close()
        self._worker_thread.close()
        self._board.blockSignals(True)  # their receivers may already be deleted

    # Files

    @property
    def opening(self) -> str:
        """Name of the task that opens an image, empty if there is none; the open image stays in use meanwhile."""
        return self._opener.opening

    @property
    def wanted_parameters(self) -> Parameters:
        """The parameters that the next image would take over, with all scales even if this image has no room for them.

        Parameters of a volume do not suit an image, so the previous ones are used.
        """
        parameters = self.document.parameters
        if self.scene.slices is not None:
            return self.former_parameters or initial_parameters("shape")
        clamped = parameters.scales == self._used_scales
        return replace(parameters, scales=self._asked_scales) if clamped else parameters

    def open(
        self,
        path: str | Path,
        resumes: bool = False,
        as_volume: bool | None = None,
        reading: Reading = DEFAULT_READING,
    ) -> None:
        """Open an image or a session file.

        The open image stays until the new one is known to be usable. An image that `resumes` is opened with the session
        next to it. A stack is opened `as_volume`, or one plane of it; None leaves that to the kind of file. `reading`
        says which part of the file is read, and how.
        """
        path = Path(path)
        sample = find_copied_sample(path)
        kept = self.wanted_parameters if self.keeps_parameters else initial_parameters(self.document.mode)
        parameters = sample.parameters if sample else kept
        self.begin(Wanted(path, parameters, resumes=resumes, as_volume=as_volume, reading=reading))

    def begin(self, wanted: Wanted) -> None:
        """Open an image or a session; see `open`."""
        self.attempt(OPENING)
        self._mode_before = self.document.mode
        self._opener.open(wanted)

    def use(self, opened: Opened) -> None:
        """Replace the open image."""
        self._worker_thread.report(opened)
        self._wake()

    def export(self, order: ExportOrder, then: Callable[[tuple[bytes, ...]], object] | None = None) -> None:
        """Write files, all or none, or only encode them and pass their contents to `then`."""
        self.attempt(EXPORTING)
        task = self.tasks.begin(tr("Writing {name}…", name=order.files[0].path.name))
        self.post(write_files(task, self.scene.reconstruction, self.document, order, then))

    def warm_up(self) -> None:
        """Compile or load the kernels before the first step needs them."""
        self._board.busy("preparing", _PREPARING_TEXT)
        self._opener.afterwards(lambda: self.post(warm_up()))

    # Internal

    def _turn(self, change: Change | None, back: bool) -> None:
        """Use the document before or after a change, and restore or remove its erased particles."""
        if change is None:
            return
        if change.erasure is not None:
            goes_on = self.status.phase == "running"
            self.live.turn(change.erasure, back)
            self.hold(run_call(None, Run.turn_erasure, change.erasure.number, back))
            if goes_on:
                self._board.phase("running")
                self.post(run_call(self._board.generation, Run.go))
        with self.gathering():
            self._use(change.before if back else change.after)
        if change.rest is None:
            return
        generation, branch, step = change.rest
        if back and generation == self.generation:
            self.hold(run_call(generation, Run.go_to, branch, step, lambda: True))
            self.post(run_call(generation, Run.stay))
        elif self.status.phase == "paused" or self.status.steered:
            self.run()

    def _rest_before(self, after: Document) -> tuple[int, int, int] | None:
        """Return where the run is at rest, if another document makes it continue; see `Change`."""
        status, shown = self.status, self.scene.snapshot
        if shown is None or status.phase != "finished" or status.stale:
            return None
        if status.steering == METHODS[status.method].steering(after.parameters):
            return None
        return self.generation, shown.timeline.branch, shown.state.step

    def _use(self, document: Document, complete: bool = True, before: Document | None = None) -> None:
        """Show another document, or the same one after its history has changed."""
        before, scene = before or self.document, self.scene
        if document != before:
            self.attempt(EDITING, RUNNING)  # an edit may be the remedy for why a run did not begin
            selected, contours, image = scene.selected, scene.contours, scene.image
            if selected is not None and selected >= len(document.shapes):
                selected = None
            if document.marks != before.marks:
                contours = ReviewedContours.of(contours.tracked, document.marks)
            # a pixel size set by hand has to apply before everything else that depends on the edit
            sized = image if image is None or document.image is None else document.image.with_known_pixel_size(image)
            self._board.scene = replace(scene, image=sized, document=document, selected=selected, contours=contours)
            if sized is not None and sized is not image:
                self.post(run_call(None, Run.rescale, sized, document))
            self.live.follow(before, document, complete)
            self.scene_changed.emit()
        self.document_changed.emit(document)
        self.show_status()

    def _ready(self) -> bool:
        self.attempt(RUNNING)
        if self.document.image is None:
            self.say(tr("There is no image to run on: open one first."), True, RUNNING)
            return False
        if needs_start(self.document.mode) and not self.document.starts:
            self.say(self.document.nothing_to_start_from, True, RUNNING)
            return False
        return True

    def _start_if_needed(self) -> None:
        status = self.status
        over = status.phase == "finished" and not status.steered
        if status.phase == "ready" or over or status.stale:
            self._board.generation = self._next_generation()
            self.live.begin(self._board.generation, self.document)
            self._board.forget(MODES[self.document.mode].method)
            self.post(start(self._board.generation, self._board.image_generation, self.document))

    def _next_generation(self) -> int:
        self._numbered += 1
        return self._numbered

    def _wake(self) -> None:
        if not self._timer.isActive():
            self._frames.begin()
            self._timer.start()

    def _frame(self) -> None:
        if self._frames.wait() > 0.0:
            return
        before = self.scene
        with self.gathering():
            self.tasks.look()
            self._board.look()
        if self.scene is not before:
            self._frames.stepped()
        if self.scene.snapshot is not None:
            self.live.use(self.scene.snapshot.timeline.began)
        if self.idle:
            self._timer.stop()

    def _accept(self, opened: Opened) -> None:
        """Replace the open image and its document by those of the report."""
        if self.document.image is not None:
            self.former_parameters = self.wanted_parameters
        self._asked_scales, self._used_scales = opened.scales, opened.parameters.scales
        self._board.generation = self._board.image_generation = self._next_generation()
        self.post(run_call(None, Run.use, self._board.generation, opened.method, opened.parameters))
        # With its own document from the start: the shapes of the previous one may have another number of axes.
        before, document = self.document, _document(opened, self._mode_before)
        slices = Slices.through_middle(opened.image.shape)
        first = next((shape for shape in document.shapes if isinstance(shape, Sphere)), None)
        if slices is not None and first is not None:
            slices = slices.with_voxel(first.center)
        self.show(Scene(opened.image, opened.display, document=document, slices=slices))
        self.image_changed.emit()
        self._board.forget()
        self.live.forget()
        self.begin_document(document, before)
        self.post(run_call(None, Run.edit_by_hand, self.document.hand_edits))
        self.post(run_call(None, Run.set_parameters, opened.parameters))
        if opened.image.ndim == 3:
            self._board.busy("preparing", _PREPARING_TEXT)
            self.post(warm_up(volumes=True))
        self._restore_runs(opened)
        if before.mode != self._mode_before and opened.saved is None and opened.image.ndim == 2:
            self.use_mode(before.mode)  # selected meanwhile
        if opened.notes:
            self.say(" ".join(map(translate_core_text, opened.notes)))

    def _restore_runs(self, opened: Opened) -> None:
        """Restore the runs of a session if its image is unchanged."""
        image = self.document.image
        if opened.saved is None or not opened.saved.file.runs or image is None:
            return
        known = opened.saved.file.image
        if known is not None and known.sha256 not in ("", opened.sha256):
            return  # the notes report that the image has changed
        self._board.busy("restoring", tr("Restoring the runs…"))
        self.post(run_call(None, Run.place, self._board.image_generation, self.document.charges))
        self.post(run_call(None, Run.limit, self.document.regions))
        self.post(restore_runs(self._board.image_generation, opened.saved.file.runs, image))


def _document(opened: Opened, mode: Mode) -> Document:
    """Return the document that an image or a session begins with; only a sample or a session changes the mode."""
    image, path, sample = opened.image, opened.path, find_copied_sample(opened.path)
    if image.ndim == 3 and opened.saved is None and sample is None:
        mode = "shape"  # starts everywhere take long in a volume, which has no skeletons either
    reference = ImageReference.from_image(path, image, opened.reading)
    if opened.saved is not None:
        return from_session_file(opened.saved.file, reference, opened.parameters)
    if sample is not None:
        return Document(reference, sample.shapes, opened.parameters, mode=sample.mode)
    return Document(reference, adapt_shapes_to_mode(mode, ()), opened.parameters, mode=mode)
