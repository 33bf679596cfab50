"""The comparison of methods: up to four of them run on the same image from the same start, each on its own thread."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal

from app.model.text.language import tr
from app.session.exchange.messages import Report
from app.session.features.side_by_side.method_run import Frame, History, MethodRun, Order
from app.session.session import Session
from app.session.tasks.tasks import Task
from cpm_core.contours.ground_truth import Truth
from cpm_core.formats.animations.comparison import Tile, write_comparison
from cpm_core.image.image import Image
from cpm_core.objects.methods import CONTOUR_METHODS, PLACES, Start
from cpm_core.shapes import Barrier, Charge, Region
from cpm_core.shapes.document_shapes import starts_of
from cpm_core.shapes.outlines import outlines_of

_FRAME = 33
"""Time between two looks at what the runs have done [ms]."""


@dataclass(frozen=True, slots=True)
class ComparisonWritten(Report):
    """Files of a comparison have been written; `notes` say what they leave out."""

    files: tuple[Path, ...]
    notes: tuple[str, ...] = ()


class MethodComparison(QObject):
    """Runs the methods of the document in up to `PLACES` places, from the drawn circles, ellipses and polygons."""

    advanced = Signal(int)
    """The newest frame of this place has been replaced."""
    changed = Signal()
    """Runs have begun, ended, or been held or led on."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self.frames: list[Frame | None] = [None] * PLACES
        self.histories = [History() for _ in range(PLACES)]
        self.held = False
        self._session = session
        self._runs: list[MethodRun | None] = [None] * PLACES
        self._ending: list[MethodRun] = []
        self._timer = QTimer(self)
        self._timer.setInterval(_FRAME)
        self._timer.timeout.connect(self._look)
        session.image_changed.connect(self.cancel)

    @property
    def running(self) -> bool:
        """Whether a method is running, or held."""
        return any(run is not None for run in self._runs)

    @property
    def truth(self) -> Truth | None:
        """The ground truth of the image, where one is known."""
        truth = self._session.scene.truth
        return truth if isinstance(truth, Truth) else None

    def start_of(self) -> Start:
        """The start that is drawn; ValueError when there is none with an inside."""
        document = self._session.document
        return Start(outlines_of(document.shapes), document.comparison.around)

    @property
    def left_out(self) -> str:
        """What is drawn and takes no part in the comparison, in words."""
        shapes = self._session.document.shapes
        starts, limits = starts_of(shapes), any(isinstance(shape, Region | Barrier | Charge) for shape in shapes)
        loose = len(starts) > len(outlines_of(starts))
        return " ".join(
            said
            for said, so in (
                (tr("Starts without an inside are left out, as most of the methods need one."), loose),
                (tr("Regions, barriers and charges are left out: the other methods have none."), limits),
            )
            if so
        )

    def run_all(self, held: bool = False) -> None:
        """Run all methods from the beginning, or hold them there; ValueError when there is no start."""
        self.start_of()
        self.held = held
        for place in range(PLACES):
            self.run(place)

    def run(self, place: int) -> None:
        """Run the method of a place from the beginning, if there is one; ValueError when there is no start."""
        self.clear(place)
        image, document = self._session.image, self._session.document
        method = document.comparison.methods[place]
        if image is None or not method:
            return
        ours, channel = CONTOUR_METHODS[method].of_particles, document.parameters.channel
        plain = ours or image.colors is None or channel == "luminance"
        taken = image if plain else Image(image.gray(channel), source=image.source)
        settings = document.parameters if ours else document.comparison.settings_of(method)
        truth = self._session.scene.truth
        truth = truth if isinstance(truth, Truth) else None
        order = Order(method, taken, self.start_of(), settings, truth)
        run = self._runs[place] = MethodRun(order, self.held)
        self.frames[place], self.histories[place] = Frame(order), run.history
        self._timer.start()
        self.advanced.emit(place)
        self.changed.emit()

    def hold(self) -> None:
        """Let all runs wait after their present step."""
        self.held = True
        for run in filter(None, self._runs):
            run.hold()
        self.changed.emit()

    def go_on(self) -> None:
        """Let all runs go on."""
        self.held = False
        for run in filter(None, self._runs):
            run.go_on()
        self.changed.emit()

    def step(self) -> None:
        """Do one step of each method; those of a comparison that has not begun wait at their start."""
        if not self.running:
            self.run_all(held=True)
        elif not self.held:
            self.hold()
        else:
            for run in filter(None, self._runs):
                run.step()

    def clear(self, place: int) -> None:
        """Run nothing in a place."""
        self._end(place)
        self.frames[place], self.histories[place] = None, History()
        self.advanced.emit(place)
        self.changed.emit()

    def cancel(self) -> None:
        """End all runs; what they have found so far stays."""
        for place in range(PLACES):
            self._end(place)
        self.held = False
        self.changed.emit()

    def write(self, paths: tuple[Path, ...]) -> None:
        """Write what has been found, on a thread of its own."""
        found = [(frame.order, Tile(frame.contours, frame.facts, frame.order.settings))
                 for frame in self.frames if frame and frame.over and frame.facts]  # fmt: skip
        image = self._session.image
        if image is None or not found:
            return
        first, tiles = found[0][0], [tile for _, tile in found]

        def work(task: Task) -> Report:
            task.go_on()
            notes: list[str] = []
            return ComparisonWritten(
                write_comparison(image, first.start, tiles, paths, notes.append, first.truth), tuple(notes)
            )

        self._session.tasks.start(tr("Writing the comparison…"), work, tr("writing the comparison"), cancellable=False)

    def close(self) -> None:
        """End all runs and wait for their threads."""
        self._timer.stop()
        for run in [*self._runs, *self._ending]:
            if run is not None:
                run.stop()
        for run in [*self._runs, *self._ending]:
            if run is not None:
                run.thread.join()

    def _end(self, place: int) -> None:
        run = self._runs[place]
        if run is not None:
            run.stop()
            self._ending.append(run)
            self._runs[place] = None
            frame = self.frames[place]
            if frame is not None and not (frame.facts or frame.trouble):
                self.frames[place] = None
                self.advanced.emit(place)

    def _look(self) -> None:
        self._ending = [run for run in self._ending if run.thread.is_alive()]
        ended = False
        for place, run in enumerate(self._runs):
            frame = run.frames.take() if run is not None else None
            if frame is not None:
                self.frames[place] = frame
                if frame.over:
                    self._end(place)
                    ended = True
                self.advanced.emit(place)
        if ended:
            self.changed.emit()
        if not self.running and not self._ending:
            self._timer.stop()
