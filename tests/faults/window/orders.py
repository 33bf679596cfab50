"""Orders to a session in every sequence, under delays in its threads: the last ones decide, and closing always ends."""

from __future__ import annotations

import itertools
import random
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
from cpm_app.model.document import edits
from cpm_app.model.document.document import Document
from cpm_app.model.export import ExportFile, ExportOrder
from cpm_app.session.features.workspace import Workspace
from cpm_app.session.storage.preferences import Preferences
from cpm_app.session.storage.recovery import Journal
from cpm_app.session.storage.session_file import DocumentFile
from PIL import Image as Picture
from PySide6.QtCore import QCoreApplication, QEvent

from cpm_core.formats.sessions.session_file import load_session
from cpm_core.parameters import Parameters
from cpm_core.shapes import Circle

from ..clock import now
from ..report import Budget, Report, going_on
from .delays import Delays
from .program import ours, surroundings
from .watch import ANSWERS_WITHIN, Watch

SIDE = 24
ORDERS = ("run", "pause", "step", "parameter", "draw", "seek", "branch", "open", "undo", "save", "export", "reset")
"""What is ordered; each sequence ends with closing."""


class Office:
    """A session that takes orders by name, and knows what must hold after each."""

    def __init__(self, folder: Path, images: Sequence[Path], choice: random.Random) -> None:
        self.broken: list[str] = []
        self._folder, self._images, self._choice = folder, images, choice
        self._opened = 0
        self._wanted = images[0]
        self._kept: Document | None = None
        self._saved: dict[Path, Document] = {}
        self.workspace = Workspace()
        self.session = session = self.workspace.session
        session.set_pace(None)
        session.messages.shown.connect(self._hear)
        session.store.scene_changed.connect(self._look)
        self.document_file = DocumentFile(session, lambda: {})
        self._preferences = Preferences(session)
        self._journal = Journal(self.document_file, folder / "journals", self._preferences)
        session.open_file(images[0])
        self.wait(lambda: session.document.image is not None, "opening")
        session.edit("set", lambda document: edits.set_parameters(document, Parameters(scales=1)))
        session.edit("draw", lambda document: edits.add_shape(document, Circle((12.0, 12.0), 6.0)))

    def wait(self, condition: Callable[[], bool], what: str) -> None:
        """Let the session work until a condition holds."""
        began = now()
        while not condition():
            QCoreApplication.processEvents()
            if now() - began > ANSWERS_WITHIN:
                raise TimeoutError(f"{what} has not ended within {ANSWERS_WITHIN:.0f} s")
            time.sleep(0.0005)

    def order(self, name: str) -> None:
        """Give an order, and let some events pass."""
        getattr(self, f"_{name}")()
        self._look()
        end = time.monotonic() + self._choice.choice([0.0, 0.0, 0.002, 0.02])
        while time.monotonic() < end:
            QCoreApplication.processEvents()

    def end(self, last: str) -> None:
        """Close, at once or when all has ended, and check what is left."""
        if self._choice.random() < 0.5:
            if self.session.status.phase == "running":
                self.session.pause()
            self.wait(lambda: self.session.idle, "coming to rest")
            self._check_rest(last)
        began = now()
        self.document_file.finish_saving()
        self._journal.close()
        self.workspace.session.close()
        if now() - began > ANSWERS_WITHIN:
            self._fail(f"closing took {now() - began:.0f} s")
        left = [thread.name for thread in threading.enumerate() if ours(thread)]
        if left:
            self._fail(f"threads are left: {left}")
        self._check_files()
        self.session.deleteLater()
        QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)

    # Orders

    def _run(self) -> None:
        self.session.run()

    def _pause(self) -> None:
        self.session.pause()

    def _step(self) -> None:
        self.session.step()

    def _reset(self) -> None:
        self.session.reset()

    def _parameter(self) -> None:
        beta = self._choice.uniform(0.1, 3.0)
        self.session.edit("beta", lambda document: edits.set_parameter(document, "beta", beta))

    def _draw(self) -> None:
        at = self._choice.uniform(6, 18), self._choice.uniform(6, 18)
        self.session.edit("draw", lambda document: edits.add_shape(document, Circle(at, 3.0)))

    def _seek(self) -> None:
        navigation = self.workspace.navigation
        branch = navigation.current_step[0]
        if navigation.find_branch(branch) is not None:
            navigation.go_to(branch, self._choice.randint(0, navigation.last_step(branch)))

    def _branch(self) -> None:
        self._seek()
        self._parameter()
        self.session.step()

    def _open(self) -> None:
        self.document_file.finish_saving()  # as before the question about unsaved work
        self._opened += 1
        self._wanted = self._images[self._opened % len(self._images)]
        self.session.open_file(self._wanted)

    def _undo(self) -> None:
        self.session.undo()

    def _save(self) -> None:
        path = self._folder / "work.cpm"
        self._saved[path] = self.session.document
        self.document_file.save(path)

    def _export(self) -> None:
        suffix = self._choice.choice([".csv", ".json", ".svg"])
        self.session.export_files(ExportOrder((ExportFile(self._folder / f"contours{suffix}", "contours", suffix),)))

    # Laws

    def _hear(self, sentence: str, trouble: bool) -> None:
        if trouble and "nothing to export yet" not in sentence and "nothing to start from" not in sentence:
            self._fail(f"said: {sentence}")

    def _look(self) -> None:
        """Whatever is shown belongs to the run and to the image that are open."""
        scene, session = self.session.scene, self.session
        for part in (scene.snapshot, scene.reconstruction):
            if part is not None and part.generation != session.store.generation:
                self._fail(f"{type(part).__name__} of run {part.generation} is shown in run {session.store.generation}")
        snapshot, image = scene.snapshot, scene.image
        if snapshot is not None and image is not None and (snapshot.position > np.array(image.shape)).any():
            self._fail("particles of another image are shown")

    def _check_rest(self, last: str) -> None:
        status, image = self.session.status, self.session.document.image
        if image is None or Path(image.path) != self._wanted:
            self._fail(f"{self._wanted.name} was opened last, and {image} is open")
        if status.phase not in ("ready", "paused", "finished"):
            self._fail(f"at rest the run is {status.phase}")
        if (status.phase == "finished") != bool(status.stop_reason) or status.busy:
            self._fail(f"at rest the run is {status}")
        if last in ("open", "reset") and (status.phase, status.step) != ("ready", 0):
            self._fail(f"after {last} the run is {status}")
        snapshot = self.session.scene.snapshot
        if (snapshot is None) != (status.phase == "ready"):
            self._fail(f"the run is {status.phase}, and its particles are {snapshot}")

    def _check_files(self) -> None:
        for path, document in self._saved.items():
            if not path.exists():
                self._fail(f"{path.name} was not written")
            elif load_session(path).shapes != document.shapes:
                self._fail(f"{path.name} holds another drawing than was saved")
        for path in self._folder.rglob("*"):
            if path.is_file() and not path.stat().st_size:
                self._fail(f"{path.name} is empty")
        journals = self._folder / "journals"
        if journals.exists() and list(journals.iterdir()):
            self._fail("a journal is left")

    def _fail(self, sentence: str) -> None:
        self.broken.append(sentence)


def sequences(length: int) -> Iterator[tuple[str, ...]]:
    """Give every row of orders of a length."""
    return itertools.product(ORDERS, repeat=length)


def carried_out(row: Sequence[str], seed: object, folder: Path, images: Path) -> tuple[list[str], int]:
    """Carry out a row of orders under delays: what was broken, and the number of delays."""
    folder.mkdir(parents=True)
    delays = Delays(seed)
    office = Office(folder, [images / name for name in ("small.png", "other.png")], random.Random(str(seed)))
    try:
        with delays.injected():
            for name in row:
                office.order(name)
            office.end(row[-1])
    except TimeoutError as error:
        office.broken.append(str(error))
        office.workspace.session.close()
    return office.broken, delays.count


def every_row(seed: int) -> Iterator[tuple[str, ...]]:
    """Give all rows of three orders, all of four, and then random ones without end."""
    choice = random.Random(seed)
    for length in (3, 4):
        rows = list(sequences(length))
        choice.shuffle(rows)
        yield from rows
    while True:
        yield tuple(choice.choices(ORDERS, k=choice.randint(5, 12)))


def try_orders(budget: Budget, rows: Iterator[tuple[str, ...]] | None = None) -> Report:
    """Try the rows that are given; else all of three orders, all of four, and then random ones of up to twelve."""
    tried = faults = 0
    failures: list[str] = []
    end = time.monotonic() + budget.seconds
    with surroundings(budget.folder) as images, Watch().kept() as watch:
        draw_small_images(images)
        for row in every_row(budget.seed) if rows is None else rows:
            if not going_on(end):
                break
            tried += 1
            seed = f"{budget.seed}:{tried}"
            broken, delays = carried_out(row, seed, budget.folder / "orders" / str(tried), images)
            faults += delays
            failures += [f"{' '.join(row)} (seed {seed}): {sentence}" for sentence in (*broken, *watch.troubles)]
            watch.troubles.clear()
    return Report(tried, faults, tuple(failures))


def draw_small_images(folder: Path) -> None:
    """Draw two images on which a run takes a moment."""
    row, col = np.indices((SIDE, SIDE))
    for name, radius, middle in (("small.png", 7.0, 12.0), ("other.png", 4.0, 10.0)):
        disc = np.where(np.hypot(row - middle, col - middle) < radius, 200, 30).astype(np.uint8)
        Picture.fromarray(disc).save(folder / name)
