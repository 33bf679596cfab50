"""Fitting objects to the contours that there are now: each is selected anew by its own clicks."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QObject

from app.model.document import objects
from app.model.text.language import tr
from app.session.exchange.messages import Report
from app.session.features.objects.partitions import Partitions
from app.session.features.objects.selector import Selector
from app.session.session import Session
from app.session.tasks.tasks import Task
from cpm_core.image.image import Image
from cpm_core.objects.segmented.segmented_object import Click
from cpm_core.objects.selection import Selection


@dataclass(frozen=True, eq=False, slots=True)
class Fitted(Report):
    """Selections of objects of an image, with their clicks and their numbers."""

    image: Image
    found: tuple[tuple[Selection, tuple[Click, ...], int], ...]


class ObjectFitting(QObject):
    """Selects objects anew on the present partition, in a task of its own; frozen ones stay as they are."""

    def __init__(self, session: Session, partitions: Partitions) -> None:
        super().__init__(session)
        self._session = session
        self._partitions = partitions
        session.listen(Fitted, self._use)

    def fit(self, numbers: frozenset[int]) -> None:
        """Fit the objects of these numbers, as one step of undo."""
        partition, items = self._partitions.partition, self._session.document.objects.items
        fitted = [item for item in items if item.number in numbers and item.clicks and not item.frozen]
        if partition is None or not fitted:
            self._session.say(tr("There is nothing to fit: choose objects that are not frozen."))
            return

        def work(task: Task) -> Report:
            found = []
            selector = Selector(partition, items, 0)
            for done, item in enumerate(fitted):
                task.advance(done / len(fitted))
                selection = selector.selection(item.clicks)
                if selection is not None:
                    found.append((selection, item.clicks, item.number))
            return Fitted(partition.image, tuple(found))

        self._session.tasks.start(tr("Fitting objects to the contours…"), work, "fitting objects")

    def _use(self, fitted: Fitted) -> None:
        if fitted.image is self._session.image:
            self._session.edit(tr("fit objects"), lambda document: objects.replace_boundaries(document, fitted.found))
