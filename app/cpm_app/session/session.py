"""The session: an image with its document and its run, opened, edited, run and exported."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QObject, Qt, QTimer, Signal

from cpm_app.model.display.channels import list_channels
from cpm_app.model.document import edits
from cpm_app.model.document.document import Document, ImageReference, Mode
from cpm_app.model.document.modes import MODES, adapt_shapes_to_mode, initial_parameters, needs_start, switch_mode
from cpm_app.model.document.objects import with_taken_numbers
from cpm_app.model.document.samples import find_copied_sample
from cpm_app.model.document.saving import from_session_file
from cpm_app.model.export import ExportOrder
from cpm_app.model.state.resolve import INITIAL_PACE_INDEX, RUN_PACES, WindowTexts, resolve_texts
from cpm_app.model.state.situation import RunStatus, Situation, can_step
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import explain_error, tr, translate_core_text
from cpm_app.model.volume.slices import Slices
from cpm_app.session.exchange.mailbox import Pacer
from cpm_app.session.exchange.messages import (
    CompilationProgress,
    ImageOpened,
    ImageReady,
    OpeningFailed,
    WarmedUp,
)
from cpm_app.session.run_updater import RunUpdater
from cpm_app.session.scene import Scene
from cpm_app.session.scene_store import SceneStore
from cpm_app.session.session_messages import (
    EDITING_CATEGORY,
    EXPORTING_CATEGORY,
    OPENING_CATEGORY,
    RUNNING_CATEGORY,
    SessionMessages,
)
from cpm_app.session.tasks.opening import Opener, OpenRequest
from cpm_app.session.tasks.tasks import ENDED_TASK, BackgroundTask, TaskManager
from cpm_app.session.undo_history import Change, TimelinePlace, UndoHistory
from cpm_app.session.worker.commands import (
    RunsRestored,
    WorkerCommand,
    call_run,
    compile_kernels,
    restore_runs,
    start_run,
    write_files,
)
from cpm_app.session.worker.run import Run
from cpm_app.session.worker.worker_thread import WorkerThread
from cpm_core import RUN_METHODS, Image, Parameters
from cpm_core.formats import Reading, SessionFile
from cpm_core.formats.images.reading import DEFAULT_READING
from cpm_core.numerics import Place
from cpm_core.shapes import Sphere

_PREPARING_TEXT = tr("Preparing (takes longer the first time)…")

POLL_INTERVAL = 4
"""Time between two polls of the worker, short enough that a step is seen soon after it is taken [ms]."""

FRAME_INTERVAL = 0.013
"""Shortest time between two displayed frames, so that a fast run leaves the window time for the user [s]."""


class Session(QObject):
    """Document, history and run, and the files that they are read from and written to.

    Views connect to its signals and read its scene; long work is done by the worker thread and by tasks.
    """

    image_changed = Signal()
    """Another image has been opened."""
    document_changed = Signal(object)
    """The document has been replaced: Document."""
    closing = Signal()
    """Threads have to end."""

    def __init__(self) -> None:
        super().__init__()
        self._worker_thread = WorkerThread()
        self.messages = SessionMessages(self)
        """The messages for the user."""
        self.store = SceneStore(self._worker_thread, self.messages, self)
        """The scene, the state of the run, and the reports of the worker."""
        self.tasks = TaskManager(self._worker_thread.send_report, self._start_polling, self)
        self.tasks.changed.connect(self.store.announce_status)
        self._numbered = 0
        self._resolved: tuple[Situation, WindowTexts] | None = None
        self.history = UndoHistory()
        """The changes that can be undone and redone."""
        self.run_updater = RunUpdater(self.store, self.post_command)
        self._target: TimelinePlace | None = None
        """Where an undo or a redo is taking the run, until it is shown."""
        self._overlays: frozenset[str] = frozenset()
        self._frames = Pacer()
        self._frames.set_limit(1.0 / FRAME_INTERVAL)
        self._timer = QTimer(self)
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.setInterval(POLL_INTERVAL)
        self._timer.timeout.connect(self._on_frame)
        self.set_pace(RUN_PACES[INITIAL_PACE_INDEX])
        self._opener = Opener(self.tasks)
        self._mode_before = self.document.mode
        """The mode in use when the image that is being opened was requested."""
        self._asked_scales = self._used_scales = self.document.parameters.scales
        self.keeps_parameters = False
        """Whether the next image begins with the parameters of the one before it."""
        self.previous_parameters: Parameters | None = None
        """Parameters of the image that was open before this one."""
        self.can_replace_image: Callable[[ImageOpened], bool] = lambda opened: True
        """Whether an image may replace the open one at once; if not, `replace_image` opens it later."""
        self.store.add_listener(
            ImageReady, lambda ready: self.replace_image(ready.opened) if self.can_replace_image(ready.opened) else None
        )
        self.store.add_listener(ImageOpened, self._on_image_opened)
        self.store.add_listener(
            RunsRestored,
            lambda kept: (
                self.run_updater.restore_runs(kept.begun) if kept.generation == self.store.image_generation else None
            ),
        )
        self._compiling = ENDED_TASK
        self.store.add_listener(CompilationProgress, self._show_compiling)
        self.store.add_listener(WarmedUp, lambda _: self._compiling.end())
        self.store.add_listener(
            OpeningFailed, lambda refused: self.messages.show(refused.message, True, OPENING_CATEGORY)
        )

    # State

    @property
    def scene(self) -> Scene:
        """The scene that is shown."""
        return self.store.scene

    @property
    def image(self) -> Image | None:
        """The image that is open."""
        return self.scene.image

    @property
    def document(self) -> Document:
        """The document of the scene."""
        return self.scene.document

    @property
    def selected_shape(self) -> int | None:
        """Index of the selected shape."""
        return self.scene.selected_shape

    @property
    def status(self) -> RunStatus:
        """State of the run."""
        status, document = self.store.status, self.document
        method = RUN_METHODS[status.method]
        other = status.method != MODES[document.mode].method
        stale = status.started and (other or self.run_updater.is_outdated(document))
        steered = status.phase == "finished" and status.steering != method.steering(document.parameters)
        if status.phase == "empty" and self.opening_name:
            return replace(status, busy=self.opening_name)
        return replace(status, stale=stale, steered=steered) if stale or steered else status

    @property
    def situation(self) -> Situation:
        """Everything that decides what the window shows and enables."""
        return Situation(
            self.document, self.status, self.history.undo_name, self.history.redo_name, self.selected_shape
        )

    @property
    def resolved(self) -> WindowTexts:
        """Everything that the window shows and enables, derived from the situation."""
        situation = self.situation
        if self._resolved is None or self._resolved[0] != situation:
            self._resolved = situation, resolve_texts(situation)
        return self._resolved[1]

    @property
    def idle(self) -> bool:
        """Whether there is no work and every report has been shown."""
        return self._worker_thread.idle and self.tasks.idle

    # Editing

    def edit(self, name: str, edit: Callable[[Document], Document], gesture: str = "") -> None:
        """Change the document in a way that can be undone.

        `name` follows "Undo" in the menu. Successive edits with the same gesture are undone together. A gesture that
        changes the forces on particles at rest, such as the drag of a slider, reactivates them; a run without seeds,
        which takes a few steps, follows every edit. A `ValueError` of `edit` is shown to the user and changes nothing.
        """
        before = self.document
        try:
            after = edit(before)
        except ValueError as error:
            self.messages.show(explain_error(error), True, EDITING_CATEGORY)
            return
        if after != before:
            method = MODES[after.mode].method
            follows = not RUN_METHODS[method].seeded and method == self.status.method
            continues = (follows or bool(gesture)) and self._moves_resting_particles(after)
            self._push_and_show(Change(name, before, after, gesture, place_before=self._find_place()))
            if follows and self.status.stale:
                self.reset()
                self.run()
            elif continues:
                self.run()

    def erase(self, path: tuple[Place, ...], radius: float, gesture: str) -> bool:
        """Erase shapes, points and particles near a path; return whether there were any.

        What one gesture erases is undone together.
        """
        before, place = self.document, self._find_place()
        left, run_changed = self.run_updater.erase_particles(path, radius, gesture)
        if left == before and not run_changed:
            return False
        self._push_and_show(Change(tr("erase"), before, left, gesture, run_changed, place))
        return True

    def set_mode(self, mode: Mode) -> None:
        """Change the mode of the next run; what the last one has found stays until then."""
        name = tr("mode “{mode}”", mode=MODES[mode].title.replace("&", ""))
        self.edit(name, lambda document: document if document.mode == mode else switch_mode(document, mode))

    def take_numbers(self, taken: int) -> None:
        """Let new objects get numbers above the taken ones; this shows nothing, and is no edit to undo."""
        if taken >= self.document.objects.next_number:
            self._set_document(with_taken_numbers(self.document, taken))

    def end_gesture(self) -> None:
        """End a gesture, so that the next edit is undone separately."""
        self.history.end_gesture()
        self.run_updater.end_gesture()

    def undo(self) -> None:
        """Undo the last edit; a run that was at rest before it, or lost particles by it, is shown there again."""
        self._apply_change(self.history.undo(self._find_place()), back=True)

    def redo(self) -> None:
        """Repeat the edit that was undone last; a run that was at rest after it is shown there again."""
        self._apply_change(self.history.redo(self._find_place()), back=False)

    def select_shape(self, index: int | None) -> None:
        """Select a shape, or none; an index beyond the shapes, one that could not be drawn, selects none."""
        if index is not None and index >= len(self.document.shapes):
            index = None
        if index != self.selected_shape:
            self.store.set_scene(replace(self.scene, selected_shape=index))
            self.document_changed.emit(self.document)
            self.store.announce_status()

    def select_next_shape(self) -> None:
        """Select the shape drawn after the selected one, the first after the last."""
        count = len(self.document.shapes)
        self.select_shape(
            None if not count else 0 if self.selected_shape is None else (self.selected_shape + 1) % count
        )

    def delete_selected_shape(self) -> None:
        """Remove the selected shape."""
        index = self.selected_shape
        if index is not None:
            name = tr("delete {shape}", shape=translate_core_text(self.document.shapes[index].title))
            self.select_shape(None)
            self.edit(name, lambda document: edits.delete_shape(document, index))

    def load_document(self, document: Document, before: Document | None = None) -> None:
        """Replace the document, or the one `before` it, by another one with an empty undo history."""
        self.history = UndoHistory()
        self.store.scene = replace(self.scene, selected_shape=None)
        self._set_document(document, before=before)

    # Running

    def run(self) -> None:
        """Continue the run; restart it if the shapes have changed, or if it is at rest and no parameter has changed."""
        if not self._can_run():
            return
        if self.status.phase != "running":
            self._target = None
            self._start_if_needed()
            self.store.set_phase("running")
            self.post_command(call_run(self.store.generation, Run.take_steps))

    def pause(self) -> None:
        """Stop after the current step."""
        if self.status.phase == "running":
            self.pause_and_post(call_run(None, Run.halt))

    def toggle_run(self) -> None:
        """Pause when running, otherwise run."""
        if self.status.phase == "running":
            self.pause()
        else:
            self.run()

    def step(self) -> None:
        """Take one step; start a run first if there is none."""
        if can_step(self.situation) and self._can_run():
            self._start_if_needed()
            self.pause_and_post(call_run(self.store.generation, Run.take_steps, 1))

    def reset(self) -> None:
        """Remove the particles and go back to the start; the run stays on the timeline."""
        if self.status.started:
            self.messages.clear(RUNNING_CATEGORY)
            kept = self.status.step > 0
            self.store.generation = self._next_generation()
            self.store.clear_run()
            self.post_command(call_run(None, Run.discard_state, self.store.generation))
            self.post_command(call_run(None, Run.set_parameters, self.document.parameters))
            if kept:
                kept_on = tr(
                    "The run stays on the timeline: click it there or press {key:timeline_last} to return to it."
                )
                self.messages.show(insert_keys(kept_on))

    def pause_and_post(self, command: WorkerCommand) -> None:
        """Send a command after which the run stays at some step."""
        self.store.set_phase("paused")
        self.post_command(command)

    def set_pace(self, steps_per_second: float | None) -> None:
        """Limit the steps per second; None for no limit."""
        self.post_command(call_run(None, Run.set_pace, steps_per_second))

    def set_overlay_enabled(self, name: str, enabled: bool) -> None:
        """Set whether an overlay is kept up to date; see `cpm_app.session.worker.prepared_methods`."""
        before = self._overlays
        self._overlays = before | {name} if enabled else before - {name}
        if self._overlays != before:
            shown = {kept: array for kept, array in self.scene.overlays.items() if kept in self._overlays}
            if len(shown) < len(self.scene.overlays):
                self.store.set_scene(replace(self.scene, overlays=shown))
            self.post_command(call_run(None, Run.set_overlays, self._overlays))

    def post_command(self, command: WorkerCommand) -> None:
        """Send a command to the worker."""
        self._worker_thread.post_command(command)
        self._start_polling()

    def close(self) -> None:
        """Stop everything and wait for the threads to end."""
        self.closing.emit()
        self._timer.stop()
        self.tasks.close()
        self._worker_thread.close()
        for sender in (self, self.store, self.messages):
            sender.blockSignals(True)  # the receivers may already be deleted

    # Files

    @property
    def opening_name(self) -> str:
        """Name of the task that opens an image, empty if there is none; the open image stays in use meanwhile."""
        return self._opener.opening_name

    @property
    def parameters_for_next_image(self) -> Parameters:
        """The parameters that the next image would take over, with all scales even if this image has no room for them.

        Parameters of a volume do not suit an image, so the previous ones are used.
        """
        parameters = self.document.parameters
        if self.scene.slices is not None:
            return self.previous_parameters or initial_parameters("shape")
        clamped = parameters.scales == self._used_scales
        return replace(parameters, scales=self._asked_scales) if clamped else parameters

    def open_file(
        self,
        path: str | Path,
        resumes: bool = False,
        as_volume: bool | None = None,
        reading: Reading = DEFAULT_READING,
        settings: SessionFile | None = None,
    ) -> None:
        """Open an image or a session file.

        The open image stays until the new one is known to be usable. An image that `resumes` is opened with the session
        next to it. A stack is opened `as_volume`, or one plane of it; None leaves that to the kind of file. `reading`
        says which part of the file is read, and how. An image without a session begins with the `settings`, if given.
        """
        path = Path(path)
        sample = find_copied_sample(path)
        kept = self.parameters_for_next_image if self.keeps_parameters else initial_parameters(self.document.mode)
        parameters = sample.parameters if sample else kept
        request = OpenRequest(path, parameters, None, (), resumes, as_volume, reading, settings)
        self.begin_opening(request)

    def begin_opening(self, request: OpenRequest) -> BackgroundTask:
        """Open an image or a session; see `open_file`."""
        self.messages.clear(OPENING_CATEGORY)
        self._mode_before = self.document.mode
        return self._opener.start_opening(request)

    def replace_image(self, opened: ImageOpened) -> None:
        """Replace the open image."""
        self._worker_thread.send_report(opened)
        self._start_polling()

    def export_files(
        self, order: ExportOrder, on_encoded: Callable[[tuple[bytes, ...]], object] | None = None
    ) -> BackgroundTask:
        """Write files, all or none, or only encode them and pass their contents to `on_encoded`."""
        self.messages.clear(EXPORTING_CATEGORY)
        task = self.tasks.begin_task(tr("Writing {name}…", name=order.files[0].path.name))
        self.post_command(write_files(task, self.scene.reconstruction, self.document, order, on_encoded))
        return task

    def warm_up(self) -> None:
        """Compile or load the kernels before the first step needs them."""
        self.store.set_busy("preparing", _PREPARING_TEXT)
        self._opener.call_when_opened(lambda: self.post_command(compile_kernels()))

    # Internal

    def _show_compiling(self, progress: CompilationProgress) -> None:
        """Show how many of the kernels have been compiled, where they could not be loaded."""
        if self._compiling.is_over:
            self._compiling = self.tasks.begin_task(tr("Preparing, only this once…"), cancellable=False)
        self._compiling.fraction = progress.percent / 100.0

    def _apply_change(self, change: Change | None, back: bool) -> None:
        """Use the document before or after a change, and go where the run was then."""
        if change is None:
            return
        place = change.place_before if back else change.place_after
        if place is not None and not ((place.at_rest or change.erases) and self._is_recorded(place)):
            place = None
        if place is not None:
            self.run_updater.restore_sources(place.run, place.sources)
        rested = change.place_before is not None and change.place_before.at_rest
        resumes = rested and place is None and not (back or change.erases)
        shown, goes_on = self._find_place(), change.erases and self.status.phase == "running"
        with self.store.draw_once():
            document = change.before if back else change.after
            self._set_document(with_taken_numbers(document, self.document.objects.taken), resumes=resumes)
        if place is not None:
            here = self.store.generation
            if change.erases or shown is None or (shown.branch, shown.step) != (place.branch, place.step):
                self._target = place
                self.pause_and_post(call_run(here, Run.go_to, place.branch, place.step))
                self.post_command(call_run(here, Run.reconstruct_if_halted))
            if goes_on:
                self.store.set_phase("running")
                self.post_command(call_run(here, Run.take_steps))
        elif resumes and (self.status.phase == "paused" or self.status.steered):
            self.run()

    def _push_and_show(self, change: Change) -> None:
        """Note a change for undo, and show the document after it."""
        self.history.push(change)
        with self.store.draw_once():
            self._set_document(change.after, complete=not change.gesture)

    def _find_place(self) -> TimelinePlace | None:
        """Return where the run is on the timeline, or where an undo is taking it."""
        shown = self.scene.snapshot
        if self._target is not None or shown is None or not self.status.started:
            return self._target
        run = shown.timeline.run_generation
        return TimelinePlace(
            self.store.image_generation, run, shown.timeline.branch, shown.state.step,
            self.run_updater.find_sources(run), self.status.phase == "finished",
        )  # fmt: skip

    def _is_recorded(self, place: TimelinePlace) -> bool:
        """Return whether a step is still on the timeline of the run that is shown."""
        shown = self.scene.snapshot
        if shown is None or not self.status.started or place.image_generation != self.store.image_generation:
            return False
        return any(line.identity == place.branch for line in shown.timeline.branches)

    def _moves_resting_particles(self, after: Document) -> bool:
        """Return whether the run is at rest, and its particles would move with the parameters of another document."""
        status = self.status
        return (
            self.scene.snapshot is not None
            and status.phase == "finished"
            and not status.stale
            and status.steering != RUN_METHODS[status.method].steering(after.parameters)
        )

    def _set_document(
        self, document: Document, complete: bool = True, before: Document | None = None, resumes: bool = True
    ) -> None:
        """Show another document, or the same one after its history has changed."""
        before, scene = before or self.document, self.scene
        if document != before:
            self.messages.clear(
                EDITING_CATEGORY, RUNNING_CATEGORY
            )  # an edit may be the remedy for why a run did not begin
            selected, image = scene.selected_shape, scene.image
            if selected is not None and selected >= len(document.shapes):
                selected = None
            # a pixel size set by hand has to apply before everything else that depends on the edit
            sized = image if image is None or document.image is None else document.image.with_known_pixel_size(image)
            self.store.scene = replace(scene, image=sized, document=document, selected_shape=selected)
            if sized is not None and sized is not image:
                self.post_command(call_run(None, Run.change_pixel_size, sized, document))
            self.run_updater.update_run(before, document, complete, resumes)
            self.store.announce_scene()
        self.document_changed.emit(document)
        self.store.announce_status()

    def _can_run(self) -> bool:
        self.messages.clear(EDITING_CATEGORY, RUNNING_CATEGORY)
        if self.document.image is None:
            self.messages.show(tr("There is no image to run on: open one first."), True, RUNNING_CATEGORY)
            return False
        if needs_start(self.document.mode) and not self.document.starts:
            self.messages.show(self.document.nothing_to_start_from, True, RUNNING_CATEGORY)
            return False
        return True

    def _start_if_needed(self) -> None:
        status = self.status
        over = status.phase == "finished" and not (status.steered or status.unfinished)
        if status.phase == "ready" or over or status.stale:
            self._set_document(self.history.forget_deleted(self.document))
            self.store.generation = self._next_generation()
            self.run_updater.begin_run(self.store.generation, self.document)
            self.store.clear_run(MODES[self.document.mode].method)
            self.post_command(start_run(self.store.generation, self.store.image_generation, self.document))
        else:
            self.run_updater.continue_run(self.document)

    def _next_generation(self) -> int:
        self._numbered += 1
        return self._numbered

    def _start_polling(self) -> None:
        if not self._timer.isActive():
            self._frames.start_measuring()
            self._timer.start()

    def _on_frame(self) -> None:
        if self._frames.seconds_until_due() > 0.0:
            return
        before = self.scene
        with self.store.defer_status():
            self.tasks.announce_changes()
            self.store.poll_worker()
        if self.scene is not before:
            self._frames.count_step()
        if self.scene.snapshot is not None:
            self.run_updater.set_current_run(self.scene.snapshot.timeline.run_generation)
        if self.idle:
            self._target = None
            self._timer.stop()

    def _on_image_opened(self, opened: ImageOpened) -> None:
        """Replace the open image and its document by those of the report."""
        if self.document.image is not None:
            self.previous_parameters = self.parameters_for_next_image
        self._asked_scales, self._used_scales = opened.scales, opened.parameters.scales
        self.store.generation = self.store.image_generation = self._next_generation()
        self.post_command(call_run(None, Run.use_image, self.store.generation, opened.method, opened.parameters))
        # With its own document from the start: the shapes of the previous one may have another number of axes.
        before, document = self.document, _make_first_document(opened, self._mode_before)
        slices = Slices.through_middle(opened.image)
        first = next((shape for shape in document.shapes if isinstance(shape, Sphere)), None)
        if slices is not None and first is not None:
            slices = slices.with_voxel(first.center)
        channels = list_channels(opened.parts)
        self.store.set_scene(Scene(opened.image, opened.display, document=document, slices=slices, channels=channels))
        self.image_changed.emit()
        self.store.clear_run()
        self.run_updater.clear()
        self.load_document(document, before)
        self.post_command(call_run(None, Run.set_parameters, opened.parameters))
        if opened.image.ndim == 3:
            self.store.set_busy("preparing", _PREPARING_TEXT)
            self.post_command(compile_kernels(volumes=True))
        self._restore_runs(opened)
        if before.mode != self._mode_before and opened.saved is None and opened.image.ndim == 2:
            self.set_mode(before.mode)  # selected meanwhile
        if opened.notes:
            self.messages.show(" ".join(map(translate_core_text, opened.notes)))

    def _restore_runs(self, opened: ImageOpened) -> None:
        """Restore the runs of a session if its image is unchanged."""
        image = self.document.image
        if opened.saved is None or not opened.saved.file.runs or image is None:
            return
        known = opened.saved.file.image
        if known is not None and known.sha256 not in ("", opened.sha256):
            return  # the notes report that the image has changed
        self.store.set_busy("restoring", tr("Restoring the runs…"))
        self.post_command(call_run(None, Run.set_charges, self.store.image_generation, self.document.charges))
        self.post_command(call_run(None, Run.set_regions, self.document.regions))
        runs = opened.saved.file.runs
        self.post_command(restore_runs(self.store.image_generation, runs, image, self.document.mode))


def _make_first_document(opened: ImageOpened, mode: Mode) -> Document:
    """Return the document that an image or a session begins with; only a sample or a session changes the mode."""
    image, path, sample = opened.image, opened.path, find_copied_sample(opened.path)
    if image.ndim == 3 and opened.saved is None and sample is None:
        mode = "shape"  # starts everywhere take long in a volume, which has no skeletons either
    reference = ImageReference.from_image(path, image, opened.reading)
    if opened.saved is not None:
        saved = opened.saved
        folder = None if saved.path is None else saved.path.absolute().parent
        return from_session_file(saved.file, reference, opened.parameters, folder)
    if sample is not None:
        return Document(reference, sample.shapes, opened.parameters, mode=sample.mode)
    return Document(reference, adapt_shapes_to_mode(mode, ()), opened.parameters, mode=mode)
