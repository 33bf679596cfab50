"""The partition of the image into faces, prepared in the background and kept up to date with the run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace

from PySide6.QtCore import QObject, QTimer, Signal

from app.model.document.document import Document
from app.model.document.modes import MODES
from app.model.text.language import tr
from app.session.exchange.messages import Report
from app.session.features.latest import Latest
from app.session.session import Session
from app.session.tasks.tasks import Task
from cpm_core.contours.result import Result
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.starts import uniform_grid
from cpm_core.objects.faces.space import VolumePartition
from cpm_core.objects.partition import EVERYWHERE, Partition, partition
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.segmentation.segment import segment

_QUIET = 250
"""Time without a change to parameters or limits after which a run from everywhere begins again [ms]."""


@dataclass(frozen=True, eq=False, slots=True)
class Everywhere:
    """What a run from everywhere depends on."""

    image: Image
    parameters: Parameters
    regions: AnyRegions | None

    def same(self, other: Everywhere | None) -> bool:
        """Whether the run would find the same."""
        if other is None or self.image is not other.image:
            return False
        return (self.parameters, self.regions) == (other.parameters, other.regions)


AnyPartition = Partition | VolumePartition
"""What objects are selected from, in an image or in a volume."""

Source = Result | Everywhere
"""What a partition is made from."""


@dataclass(frozen=True, eq=False, slots=True)
class Prepared(Report):
    """A partition, ready to select from, and what it was made from."""

    source: Source
    partition: AnyPartition


class Partitions(QObject):
    """Makes partitions on other threads: of the contours of the run, or without a run, of one from everywhere.

    `wanted` tells whether a partition is needed now; call `look` when its answer may have changed.
    """

    changed = Signal()
    """`partition` or `preparing` has changed."""

    def __init__(self, session: Session, wanted: Callable[[], bool]) -> None:
        super().__init__(session)
        self.partition: AnyPartition | None = None
        self._session = session
        self._wanted = wanted
        self._made_from: Source | None = None
        self._asked_for: Source | None = None
        self._everywhere: Prepared | None = None
        self._task: Task | None = None
        self._latest = Latest(session, "cpm-partition", tr("preparing the selection of objects"))
        self._latest.done.connect(self._take)
        self._quiet = QTimer(self, singleShot=True, interval=_QUIET)
        self._quiet.timeout.connect(self.look)
        session.listen(Prepared, self._take)
        session.image_changed.connect(self._forget)
        session.scene_changed.connect(self.look)
        session.document_changed.connect(self._use_document)

    @property
    def preparing(self) -> bool:
        """Whether a run from everywhere goes on."""
        return self._task is not None and not self._task.over

    @property
    def source(self) -> Source | None:
        """What `partition` was made from."""
        return self._made_from

    def look(self, again: bool = False) -> None:
        """Begin to make the partition that is needed now, if there is another one; `again` where that failed before."""
        if again and self._latest.idle and not self.preparing:
            self._asked_for = self._made_from
        source = self._source()
        if source is None or self._quiet.isActive() or not self._wanted():
            return
        if isinstance(source, Result):
            if source is not self._asked_for:
                self._ask(source)
        elif self._everywhere is not None and source.same(_everywhere_of(self._everywhere)):
            if self._made_from is not self._everywhere.source:
                self._use(self._everywhere)
        elif not (isinstance(self._asked_for, Everywhere) and source.same(self._asked_for)):
            self._run(source)

    def close(self) -> None:
        """End the thread."""
        self._latest.close()

    def _source(self) -> Source | None:
        scene = self._session.scene
        if scene.image is None:
            return None
        found = scene.reconstruction.result if scene.reconstruction is not None else None
        if scene.slices is not None:  # a run from everywhere takes too long to be begun without being asked for
            return found if isinstance(found, Result) and found.surface is not None else None
        if isinstance(found, Result) and found.image is not None and found.contours:
            return found
        return Everywhere(scene.image, parameters_everywhere(scene.document), scene.document.regions)

    def _ask(self, source: Result) -> None:
        self._end_task()
        self._asked_for = source
        self._latest.ask(lambda: Prepared(source, _ready(partition(source))))

    def _run(self, source: Everywhere) -> None:
        self._end_task()
        self._asked_for = source

        def work(task: Task) -> Report:
            image, grid = source.image, uniform_grid(source.image.shape)
            found = segment(image, grid, source.parameters, regions=source.regions, progress=lambda _: task.go_on())
            return Prepared(source, _ready(partition(found)))

        name = tr("Finding contours everywhere, to select objects from…")
        self._task = self._session.tasks.start(name, work, tr("preparing the selection of objects"))
        self.changed.emit()

    def _take(self, prepared: Prepared) -> None:
        if prepared.partition.image is not self._session.image:
            return
        if isinstance(prepared.source, Everywhere):
            self._everywhere = prepared
            if prepared.source is not self._asked_for:
                return
        elif not isinstance(self._source(), Result):
            return  # the run has been reset
        self._use(prepared)

    def _use(self, prepared: Prepared) -> None:
        self.partition = prepared.partition
        self._made_from = self._asked_for = prepared.source
        self.changed.emit()
        self.look()

    def _use_document(self, document: Document) -> None:
        source = self._source()
        before = self._asked_for
        if (
            isinstance(source, Everywhere)
            and isinstance(before, Everywhere)
            and source.image is before.image
            and not source.same(before)
        ):
            self._quiet.start()

    def _end_task(self) -> None:
        if self._task is not None:
            self._task.cancel()
            self._task = None

    def _forget(self) -> None:
        self._end_task()
        self._latest.forget()
        self._quiet.stop()
        self.partition = self._made_from = self._asked_for = self._everywhere = None
        self.changed.emit()


def parameters_everywhere(document: Document) -> Parameters:
    """Parameters of a run from everywhere: those of a partition, with what differs from the preset of the mode."""
    preset, chosen = PRESETS[MODES[document.mode].preset], document.parameters
    moved = {
        field.name: getattr(chosen, field.name)
        for field in fields(Parameters)
        if getattr(chosen, field.name) != getattr(preset, field.name)
    }
    return replace(EVERYWHERE, **moved)


def _everywhere_of(prepared: Prepared) -> Everywhere | None:
    return prepared.source if isinstance(prepared.source, Everywhere) else None


def _ready(made: AnyPartition) -> AnyPartition:
    """A partition that has computed all that a selection needs, so that the first answer comes at once."""
    made.select([[0.5 * (side - 1) for side in made.shape]])
    return made
