"""Objects selected by what is known of others: anew by their own clicks, and all that are like a chosen one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QObject

from app.model.document import objects
from app.model.document.objects import AnySelection
from app.model.text.language import tr
from app.session.exchange.messages import Report
from app.session.features.objects.partitions import Partitions
from app.session.features.objects.selector import selector_on
from app.session.session import Session
from app.session.tasks.tasks import Task
from cpm_core.image.image import Image
from cpm_core.objects.faces.space import VolumeSelection
from cpm_core.objects.partition import Partition
from cpm_core.objects.segmented.segmented_object import Click, selection_of
from cpm_core.objects.selection import Selection
from cpm_core.objects.similar import similar

_COVERED = 0.5
"""Share of an object that others cover from which it counts as one of them."""


@dataclass(frozen=True, eq=False, slots=True)
class Fitted(Report):
    """Selections of objects of an image, with their clicks and their numbers."""

    image: Image
    found: tuple[tuple[AnySelection, tuple[Click, ...], int], ...]


@dataclass(frozen=True, eq=False, slots=True)
class Alike(Report):
    """Selections of objects of an image that are like one, and the class of that one."""

    image: Image
    found: tuple[Selection, ...]
    category: int


class ObjectFitting(QObject):
    """Selects objects on the present partition in tasks of their own; what is found is one step of undo."""

    def __init__(self, session: Session, partitions: Partitions) -> None:
        super().__init__(session)
        self._session = session
        self._partitions = partitions
        session.listen(Fitted, self._use)
        session.listen(Alike, self._add)

    def fit(self, numbers: frozenset[int]) -> None:
        """Select the objects of these numbers anew by their own clicks; frozen ones stay as they are."""
        partition, items = self._partitions.partition, self._session.document.objects.items
        fitted = [item for item in items if item.number in numbers and item.clicks and not item.frozen]
        if partition is None or not fitted:
            self._session.say(tr("There is nothing to fit: choose objects that are not frozen."))
            return

        def work(task: Task) -> Report:
            found = []
            selector = selector_on(partition, items, 0)
            for done, item in enumerate(fitted):
                task.advance(done / len(fitted))
                selection = selector.selection(item.clicks)
                if isinstance(selection, VolumeSelection) and selection.found:
                    _ = selection.packed  # here, not on the window's thread
                if selection is not None:
                    found.append((selection, item.clicks, item.number))
            return Fitted(partition.image, tuple(found))

        self._session.tasks.start(tr("Fitting objects to the contours…"), work, tr("fitting objects"))

    def find_like(self, number: int) -> None:
        """Add all objects that are like one and not among the objects yet."""
        partition, known = self._partitions.partition, self._session.document.objects
        if not isinstance(partition, Partition):  # a volume has no objects that are alike
            self._partitions.look(again=True)
            self._session.say(tr("The image is not prepared yet: try again in a moment."))
            return

        def work(task: Task) -> Report:
            chosen = known[number]
            taken = np.any([item.mask(partition.shape) for item in known.items], axis=0)
            alike = similar(partition, selection_of(chosen, partition.shape))[1:]
            new = (each for each in alike if (each.mask & taken).sum() < _COVERED * each.mask.sum())
            return Alike(partition.image, tuple(new), chosen.category)

        self._session.tasks.start(tr("Finding objects like this one…"), work, tr("finding objects"))

    def _add(self, alike: Alike) -> None:
        if alike.image is not self._session.image:
            return
        if not alike.found:
            self._session.say(tr("No other object like this one was found."))
            return
        self._session.edit(tr("all like this"), lambda document: objects.add(document, alike.found, alike.category))
        self._session.say(tr("{count} objects like this one were found.").format(count=len(alike.found)))

    def _use(self, fitted: Fitted) -> None:
        if fitted.image is self._session.image:
            self._session.edit(tr("fit objects"), lambda document: objects.replace_boundaries(document, fitted.found))
