"""Runs that are compared with one another, several at a time: with other parameters, or of other methods."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from app.model.display.comparison import Tile
from app.model.document.document import NOTHING_TO_START_FROM, Document
from app.model.text.language import from_core, tr
from app.session.exchange.messages import sentence
from app.session.features.truth_comparison import GroundTruth
from app.session.session import Session
from app.session.tasks.tasks import Cancelled, Task
from cpm_core import CONTOUR_METHODS, Engine, Facts, Image, Result, Start, Truth, compare, facts_of, moments
from cpm_core.contours import apply, with_kept
from cpm_core.formats import comparison
from cpm_core.numerics import cores
from cpm_core.objects.methods import result_of
from cpm_core.shapes import Barrier, Charge, Region, SeedCache, outlines_of, starts_of


@dataclass(frozen=True, eq=False, slots=True)
class Done:
    """A run that has ended, without rejected contours; where it failed there is no result, and `trouble` says why."""

    tile: Tile
    result: Result | None = None
    facts: Facts | None = None
    trouble: str = ""


class Comparison(QObject):
    """Runs tiles without changing the run of the session."""

    began = Signal(object)
    """The run of a tile has begun: Tile."""
    finished = Signal(object)
    """A tile has been run: Done."""
    ended = Signal()
    """All tiles are done, or the comparison has been cancelled."""

    def __init__(self, session: Session, truth: GroundTruth) -> None:
        super().__init__(session)
        self.task: Task | None = None
        self._session = session
        self._truth = truth
        session.image_changed.connect(self.cancel)
        session.tasks.changed.connect(self._look)

    @property
    def left_out(self) -> str:
        """What is drawn and takes no part in a comparison of methods, in words."""
        shapes = self._session.document.shapes
        starts, limits = starts_of(shapes), any(isinstance(shape, Region | Barrier | Charge) for shape in shapes)
        loose = len(starts) > len(outlines_of(starts))
        return " ".join(
            (
                *((tr("Starts without an inside are left out, as most of the methods need one."),) if loose else ()),
                *((tr("Regions, barriers and charges are left out: the other methods have none."),) if limits else ()),
            )
        )

    def start(self, tiles: Sequence[Tile]) -> None:
        """Run tiles, one on each core but the one that the window needs; ValueError when there is no start."""
        image, document = self._session.image, self._session.document
        if any(tile.method for tile in tiles):
            self._start_of(document)
        elif not document.starts:
            raise ValueError(NOTHING_TO_START_FROM)
        if image is None:
            return
        self.cancel()
        self.task = self._session.tasks.start(
            tr("Running a mosaic of {count} tiles…").format(count=len(tiles)),
            lambda task: self._run(image, document, tiles, task),
            tr("running a mosaic"),
        )

    def cancel(self) -> None:
        """Cancel the runs that have not ended."""
        if self.task is not None:
            self.task.cancel()
            self.task = None
            self.ended.emit()

    def write(self, found: Sequence[Done], path: Path) -> None:
        """Write what methods have found, on a thread of its own."""
        image, document, truth = self._session.image, self._session.document, self._session.scene.truth
        tiles = [comparison.Tile(done.result.contours, done.facts, done.tile.settings)
                 for done in found if done.result and done.facts]  # fmt: skip
        if image is None or not tiles:
            return
        start = self._start_of(document)

        notes: list[str] = []

        def work(task: Task) -> Sequence[Path]:
            known = truth if isinstance(truth, Truth) else None
            return comparison.write_comparison(image, start, tiles, (path,), notes.append, known)

        def use(files: Sequence[Path]) -> None:
            names = ", ".join(file.name for file in files)
            wrote = (tr("Wrote {name}.").format(name=names),) if names else ()
            self._session.say(" ".join((*wrote, *map(from_core, notes))))

        name, activity = tr("Writing the comparison…"), tr("writing the comparison")
        self._session.tasks.start(name, work, activity, cancellable=False, then=use)

    # Internal

    def _start_of(self, document: Document) -> Start:
        return Start(outlines_of(document.shapes), document.comparison.around)

    def _look(self) -> None:
        if self.task is not None and self.task.over:
            self.task = None
            self.ended.emit()

    def _run(self, image: Image, document: Document, tiles: Sequence[Tile], task: Task) -> None:
        """Run tiles; seeds, and an engine for each number of scales, serve all of them."""
        seed_cache, engines, lock, done = SeedCache(image), dict[int, Engine](), threading.Lock(), 0

        def of_parameters(tile: Tile) -> tuple[Result, Facts]:
            parameters, began = tile.settings, time.perf_counter()
            with lock:
                image_seeds = seed_cache.seeds_for(
                    document.image_starts, parameters.smoothing, document.regions, parameters.channel
                )
                if parameters.scales not in engines:
                    engines[parameters.scales] = Engine(image, parameters, document.regions)
                engine = engines[parameters.scales]
            state = engine.start(document.seeds(image_seeds))
            while not state.stop_reason:
                task.check_cancelled()
                state = engine.step(state, parameters, document.charges)
            result = apply(with_kept(engine.result(state, parameters), document.marks), document.marks)
            contours = result.contours
            return result, Facts(
                "cpm", result.steps, time.perf_counter() - began, result.converged, result.stop_reason, len(contours),
                sum(contour.closed for contour in contours),
            )  # fmt: skip

        def of_method(tile: Tile) -> tuple[Result, Facts]:
            method, start, channel = CONTOUR_METHODS[tile.method], self._start_of(document), document.parameters.channel
            plain = method.of_particles or image.colors is None or channel == "luminance"
            taken = image if plain else Image(image.gray(channel), source=image.source)
            for moment in moments(method, taken, start, tile.settings):
                task.check_cancelled()
                last = moment
            facts = facts_of(last)
            return result_of(facts, last.state.contours, taken, start, tile.settings), facts

        def work(tile: Tile) -> None:
            nonlocal done
            try:
                task.check_cancelled()
                self.began.emit(tile)
                result, facts = (of_method if tile.method else of_parameters)(tile)
                task.check_cancelled()
                ended = Done(tile, result, self._measured(result, facts))
            except Cancelled:
                return
            except Exception as error:  # an error is shown in its tile, and the others go on
                ended = Done(tile, trouble=sentence(error, tr("running a tile")))
            self.finished.emit(ended)
            with lock:
                done += 1
                task.fraction = done / len(tiles)

        with ThreadPoolExecutor(max(1, cores() - 1), thread_name_prefix="cpm-compare") as pool:
            list(pool.map(work, tiles))

    def _measured(self, result: Result, facts: Facts) -> Facts:
        """The facts of a run with its agreement with the ground truth, where one is known."""
        truth = self._truth.truth
        if not isinstance(truth, Truth):
            return facts
        seen = compare(result.contours, truth, self._truth.tolerance, holes=self._truth.holes)
        return replace(facts, dice=seen.dice, f=seen.f, hausdorff=seen.hausdorff,
                       mean_distance=seen.mean_boundary_distance)  # fmt: skip
