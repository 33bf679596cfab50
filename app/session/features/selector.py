"""The partition of an image or a volume, kept up to date with the run, and selections of clicks on it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal

from app.model.document.document import Document
from app.model.document.modes import MODES
from app.model.text.language import tr
from app.session.exchange.messages import Report
from app.session.features.background import LatestOnlyWorker
from app.session.scene import Proposal
from app.session.session import Session
from app.session.tasks.tasks import Task
from cpm_core import (
    PRESETS,
    Image,
    Parameters,
    Partition,
    Result,
    Selection,
    VolumePartition,
    VolumeSelection,
    partition,
    segment,
    uniform_grid,
)
from cpm_core.image import AnyRegions
from cpm_core.numerics import Array, Mask
from cpm_core.objects import EVERYWHERE
from cpm_core.objects.segmented import Click, SegmentedObject, places_of, selection_of

_QUIET = 250
"""Time without a change to parameters or limits after which a run from everywhere begins again [ms]."""


@dataclass(frozen=True, slots=True)
class Everywhere:
    """What a run from everywhere depends on."""

    image: Image
    parameters: Parameters
    regions: AnyRegions | None


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

    `wanted` returns whether a partition is needed now; call `look` when its answer may have changed.
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
        self._latest = LatestOnlyWorker(session, "cpm-partition", tr("preparing the selection of objects"))
        self._latest.done.connect(self._take)
        self._quiet = QTimer(self, singleShot=True, interval=_QUIET)
        self._quiet.timeout.connect(self.look)
        session.listen(Prepared, self._take)
        session.image_changed.connect(self._forget)
        session.scene_changed.connect(self.look)
        session.document_changed.connect(self._use_document)

    @property
    def preparing(self) -> bool:
        """Whether a run from everywhere continues."""
        return self._task is not None and not self._task.over

    @property
    def source(self) -> Source | None:
        """What `partition` was made from."""
        return self._made_from

    def look(self, again: bool = False) -> None:
        """Begin to make the partition that is needed now, if there is another one; `again` where that failed before."""
        if again and self._latest.idle and not self.preparing:
            self._asked_for = self._made_from
        source, known = self._source(), self._everywhere
        if source is None or self._quiet.isActive() or not self._wanted():
            return
        if known is not None and source == known.source:
            if source != self._made_from:
                self._use(known)
        elif source != self._asked_for:
            self._asked_for = source
            self._end_task()
            if isinstance(source, Everywhere):
                self._run(source)
            else:
                self._latest.ask(lambda: Prepared(source, _ready(partition(source))))

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

    def _run(self, source: Everywhere) -> None:
        def work(task: Task) -> Report:
            image, grid = source.image, uniform_grid(source.image.shape)
            found = segment(
                image, grid, source.parameters, regions=source.regions, progress=lambda _: task.check_cancelled()
            )
            return Prepared(source, _ready(partition(found)))

        name = tr("Finding contours everywhere, to select objects from…")
        self._task = self._session.tasks.start(name, work, tr("preparing the selection of objects"))
        self.changed.emit()

    def _take(self, prepared: Prepared) -> None:
        if prepared.partition.image is not self._session.image:
            return
        if isinstance(prepared.source, Everywhere):
            self._everywhere = prepared
            if prepared.source != self._asked_for:
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
        """Wait until parameters and limits rest before another run from everywhere."""
        source, before = self._source(), self._asked_for
        if isinstance(source, Everywhere) and isinstance(before, Everywhere) and source != before:
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


def _ready(made: AnyPartition) -> AnyPartition:
    """A partition that has computed all that a selection needs, so that the first answer comes at once."""
    made.select([[0.5 * (side - 1) for side in made.shape]])
    return made


_MOST_BODIES = 8
"""Number of answers that are kept: each has a surface."""

_MOST_PLACES = 20
"""Places of a start by which its body is found."""


class BodySelector:
    """Selects on one partition; what has been selected once is the same object the next time.

    Parameters
    ----------
    partition : VolumePartition
        The partition.
    items : sequence of SegmentedObject
        The objects that there are.
    edited : int
        Number of the object that is being changed, 0 for none.
    """

    def __init__(self, partition: VolumePartition, items: Sequence[SegmentedObject], edited: int) -> None:
        self.partition = partition
        self.items = items
        self.edited = edited
        self._known: dict[tuple[bytes, str], VolumeSelection] = {}

    def selection(self, clicks: tuple[Click, ...]) -> VolumeSelection | None:
        """The bodies that clicks select; None while none of them is inside."""
        inside = places_of(clicks, inside=True)
        if not len(inside):
            return None
        selection = self.partition.select(inside, places_of(clicks, inside=False))
        key = selection.bodies.tobytes(), selection.remark
        if key not in self._known and len(self._known) == _MOST_BODIES:
            self._known.pop(next(iter(self._known)))
        known = self._known.setdefault(key, selection)
        if known.found:
            _ = known.surface  # made on this thread, not on that of the window
        return known

    def proposals(self, starts: Sequence[Array]) -> tuple[Proposal, ...]:
        """The bodies in which runs were started, given the seeds of each start, unless they are objects already."""
        found: dict[int, Proposal] = {}
        taken = {body for item in self.items for body in self.partition.bodies_at(item.inside).tolist()}
        for seeds in starts:
            bodies = self.partition.bodies_at(seeds)
            within = bodies[bodies > 0]
            if not len(within):
                continue
            body = int(np.bincount(within).argmax())
            places = seeds[bodies == body][:_MOST_PLACES].tolist()
            clicks = (Click(tuple((plane, row, col) for plane, row, col in places)),)
            selection = self.selection(clicks)
            if body not in taken and body not in found and selection is not None and selection.found:
                _ = selection.packed  # so that it can be taken at once
                found[body] = Proposal(selection, clicks)
        return tuple(found.values())


_SAME_OBJECT = 0.5
"""Overlap (intersection over union) from which the selections of two starts are of one object."""

_UNCHANGED = 0.97
"""Overlap from which a selection is what an object is already."""

_PLACES = 100
"""About so many pixels by which the object of a selection is found."""

_MOST_SELECTIONS = 200
"""Number of selections that are kept."""


class Selector:
    """Selects on one partition; a list of clicks is selected with the selection without the last one as evidence.

    Parameters
    ----------
    partition : Partition
        The partition.
    items : sequence of SegmentedObject
        The objects that there are.
    edited : int
        Number of the object that is being changed, 0 for none: with its own clicks it is as it is.
    """

    def __init__(self, partition: Partition, items: Sequence[SegmentedObject], edited: int) -> None:
        self.partition = partition
        self.items = items
        self.edited = edited
        self._known: dict[tuple[Click, ...], Selection | None] = {}
        self._changed = next((item for item in items if item.number == edited), None)
        others = [item for item in items if item.frozen and item.number != edited]
        self._elsewhere = np.concatenate([np.empty((0, 2)), *(_enclosed(item) for item in others)])

    def selection(self, clicks: tuple[Click, ...]) -> Selection | None:
        """The object that clicks select; None while none of them is inside."""
        if clicks not in self._known:
            if len(self._known) == _MOST_SELECTIONS:
                self._known.clear()
            self._known[clicks] = self._select(clicks)
        return self._known[clicks]

    def _select(self, clicks: tuple[Click, ...]) -> Selection | None:
        inside = places_of(clicks, inside=True)
        if not len(inside):
            return None
        if self._changed is not None and clicks == self._changed.clicks:
            return selection_of(self._changed, self.partition.shape)
        outside, previous = places_of(clicks, inside=False), self.selection(clicks[:-1])
        if previous is None and len(self._elsewhere):  # frozen objects only take away
            previous = self.partition.select(inside, outside)
        return self.partition.select(inside, np.concatenate([outside, self._elsewhere]), previous=previous)

    def proposals(self, starts: Sequence[Array]) -> tuple[Proposal, ...]:
        """The objects in which runs were started, given the seeds of each start; of frozen objects there are none.

        An object that exists already is offered only if it has become another one.
        """
        found: list[Proposal] = []
        for seeds in starts:
            clicks = (Click(tuple((row, col) for row, col in seeds.tolist())),)
            selection = self.selection(clicks)
            if selection is None or not selection.contours or selection.only_places:
                continue  # nothing was found, as from a start across an edge
            if any(overlap(selection.mask, other.selection.mask) > _SAME_OBJECT for other in found):
                continue
            places = _places_in(selection)
            known = next((item for item in self.items if item.encloses(places).mean() > 0.5), None)
            if known is None:
                found.append(Proposal(selection, clicks))
            elif not known.frozen and overlap(known.mask(self.partition.shape), selection.mask) < _UNCHANGED:
                found.append(Proposal(selection, clicks, known.number))
        return tuple(found)


AnySelector = Selector | BodySelector
"""Selects objects in an image or in a volume."""


def selector_on(partition: AnyPartition, items: Sequence[SegmentedObject], edited: int) -> AnySelector:
    """A new selector on a partition; see `Selector`."""
    if isinstance(partition, VolumePartition):
        return BodySelector(partition, items, edited)
    return Selector(partition, items, edited)


def _enclosed(item: SegmentedObject) -> Array:
    """The places of an object that lie in it: not those of a line that was drawn around it."""
    return item.inside[item.encloses(item.inside)]


def _places_in(selection: Selection) -> Array:
    """The places that lie in a selection; of one that a line was drawn around, pixels all over it."""
    within = selection.inside[selection.holds(selection.inside)]
    pixels = np.argwhere(selection.mask)
    return within if len(within) else pixels[:: max(len(pixels) // _PLACES, 1)].astype(float)


def overlap(one: Mask, other: Mask) -> float:
    """Intersection over union of two masks; 0 when both are empty."""
    whole = np.count_nonzero(one | other)
    return np.count_nonzero(one & other) / whole if whole else 0.0
