"""Parameter sweep: the runs of a mosaic, several at a time, on separate threads."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal

from app.model.display.mosaic import Plan, Tile
from app.model.document.document import Document
from app.model.text.language import tr
from app.session.exchange.error_messages import sentence
from app.session.exchange.messages import Report
from app.session.features.truth_comparison import GroundTruth
from app.session.session import Session
from app.session.tasks.tasks import Task
from cpm_core.contours.contour import Contour
from cpm_core.contours.kept import with_kept
from cpm_core.contours.result import Result
from cpm_core.contours.review import apply
from cpm_core.image.image import Image
from cpm_core.numerics.parallel import cores
from cpm_core.segmentation.engine import Engine
from cpm_core.shapes.image_starts import SeedCache

_Dice = Callable[[Sequence[Contour]], float | None]


@dataclass(frozen=True, eq=False, slots=True)
class Done:
    """A tile that has been run, without rejected contours; `result` is None and `trouble` is the reason if that failed.

    `dice` is the overlap with the ground truth, if there is one.
    """

    tile: Tile
    result: Result | None
    dice: float | None = None
    trouble: str = ""


@dataclass(frozen=True, slots=True)
class Swept(Report):
    """All tiles of a mosaic have been run."""


class Sweep(QObject):
    """Runs the tiles of a plan as the document would be run, without changing the run of the session."""

    began = Signal(object)
    """The run of a tile has begun: Tile."""
    finished = Signal(object)
    """A tile has been run: Done."""
    ended = Signal()
    """All tiles are done, or the sweep has been cancelled."""

    def __init__(self, session: Session, truth: GroundTruth) -> None:
        super().__init__(session)
        self.task: Task | None = None
        self._session = session
        self._truth = truth
        session.image_changed.connect(self.cancel)
        session.tasks.changed.connect(self._look)

    @property
    def running(self) -> bool:
        """Whether tiles are being run."""
        return self.task is not None

    def start(self, plan: Plan, document: Document) -> None:
        """Run the tiles of a plan, one on each core but the one that the window needs."""
        image, truth = self._session.image, self._truth
        if image is None:
            return
        self.cancel()
        tiles = len(plan.tiles)
        self.task = self._session.tasks.start(
            tr("Running a mosaic of {count} tiles…").format(count=tiles),
            lambda task: self._run(_Runs(image, document, task, truth.dice), plan, task),
            tr("running a mosaic"),
        )

    def cancel(self) -> None:
        """Cancel the tiles that have not been run."""
        if self.task is not None:
            self.task.cancel()
            self.task = None
            self.ended.emit()

    def _run(self, runs: _Runs, plan: Plan, task: Task) -> Report:
        done = 0
        lock = threading.Lock()

        def work(tile: Tile) -> None:
            nonlocal done
            if task.cancelled:
                return
            self.began.emit(tile)
            result = runs.run(tile)
            if result is None or task.cancelled:
                return
            self.finished.emit(result)
            with lock:
                done += 1
                task.fraction = done / len(plan.tiles)

        with ThreadPoolExecutor(max(1, cores() - 1), thread_name_prefix="cpm-mosaic") as pool:
            for future in [pool.submit(work, tile) for tile in plan.tiles]:
                future.result()
        task.go_on()
        return Swept()

    def _look(self) -> None:
        if self.task is not None and self.task.over:
            self.task = None
            self.ended.emit()


class _Runs:
    """Image, document and seeds of the runs of a mosaic, and an engine for each number of scales."""

    def __init__(self, image: Image, document: Document, task: Task, dice: _Dice) -> None:
        self._image = image
        self._document = document
        self._task = task
        self._dice = dice
        self._seed_cache = SeedCache(image)
        self._engines: dict[int, Engine] = {}
        self._lock = threading.Lock()

    def run(self, tile: Tile) -> Done | None:
        """Run a tile to its end; None when it has been cancelled."""
        try:
            result = self._result(tile)
            return None if result is None else Done(tile, result, self._dice(result.contours))
        except Exception as error:  # an error is shown in its tile, and the others go on
            return Done(tile, None, trouble=sentence(error, tr("running a tile")))

    def _result(self, tile: Tile) -> Result | None:
        parameters, document = tile.parameters, self._document
        with self._lock:  # seeds and engine are kept for the other tiles
            image_seeds = self._seed_cache.seeds_for(
                document.image_starts, parameters.smoothing, document.regions, parameters.channel
            )
            if parameters.scales not in self._engines:
                self._engines[parameters.scales] = Engine(self._image, parameters, document.regions)
            engine = self._engines[parameters.scales]
        state = engine.start(document.seeds(image_seeds))
        while not state.stop_reason:
            if self._task.cancelled:
                return None
            state = engine.step(state, parameters, document.charges)
        found = engine.result(state, parameters)
        whole = with_kept(found, document.marks)
        return apply(whole, document.marks)
