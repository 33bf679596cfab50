"""Skeletons: found on a thread of their own when a person asks for one, and anew when what they depend on changes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from PySide6.QtCore import QObject

from app.model.document.document import Document
from app.model.text.language import tr
from app.session.exchange.messages import Exported, Report
from app.session.session import Session
from app.session.tasks.tasks import Task
from cpm_core.formats import export
from cpm_core.medial_axis.skeleton import Skeleton, skeleton
from cpm_core.parameters import Parameters

_DEPENDS_ON = ("smoothing", "edge_floor", "min_strength", "min_length")
"""Parameters that a skeleton depends on."""


@dataclass(frozen=True, eq=False, slots=True)
class SkeletonFound(Report):
    """The skeleton of the image opened as `image_generation`, or why there is none."""

    image_generation: int
    skeleton: Skeleton | None
    sentence: str = ""


class Skeletons(QObject):
    """The skeleton of the image that is open, if one has been asked for.

    Parameters
    ----------
    session : Session
        Whose image it is of.
    """

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._asked: tuple[object, ...] = ()
        self._loud = False
        self._task: Task | None = None
        session.document_changed.connect(self._follow)
        session.listen(SkeletonFound, self._take)

    @property
    def found(self) -> Skeleton | None:
        """The skeleton that is shown."""
        return self._session.scene.skeleton

    def find(self) -> None:
        """Find the skeleton of the image by the parameters of the document."""
        if self._session.image is None:
            self._session.say(tr("There is no image to run on: open one first."), True)
            return
        self._loud = True
        self._ask(self._session.document)

    def export(self, path: str | Path) -> None:
        """Write the skeleton that was found."""
        found, path = self.found, Path(path)
        if found is None:
            return

        def work(task: Task) -> Report:
            export(found, path)
            return Exported(path)

        activity = tr("writing {file}").format(file=path.name)
        self._session.tasks.start(tr("Writing {file}…").format(file=path.name), work, activity, cancellable=False)

    def _ask(self, document: Document) -> None:
        image = self._session.image
        if image is None:
            return
        if self._task is not None:
            self._task.cancel()
        self._asked = _asked(document.parameters)
        number, parameters = self._session.image_generation, document.parameters

        def work(task: Task) -> Report:
            return SkeletonFound(number, skeleton(image, parameters))

        def failure_report(told: str) -> Report:
            return SkeletonFound(number, None, told)

        self._task = self._session.tasks.start(
            tr("Finding the skeleton…"), work, tr("finding the skeleton"), failure_report
        )

    def _follow(self, document: Document) -> None:
        if document.mode != "skeleton":
            self._show(None)
        elif self.found is not None and _asked(document.parameters) != self._asked:
            self._ask(document)

    def _take(self, report: SkeletonFound) -> None:
        if report.image_generation != self._session.image_generation:
            return
        if report.sentence:
            self._session.say(report.sentence, True)
        elif self._session.document.mode == "skeleton" and _asked(self._session.document.parameters) == self._asked:
            self._show(report.skeleton)
            if self._loud:
                self._session.say(_told(report.skeleton))
        self._loud = False

    def _show(self, found: Skeleton | None) -> None:
        if found is not self.found:
            self._session.show(replace(self._session.scene, skeleton=found))
            self._session.show_status()


def _asked(parameters: Parameters) -> tuple[object, ...]:
    return tuple(getattr(parameters, name) for name in _DEPENDS_ON)


def _told(found: Skeleton | None) -> str:
    if found is None or not found.contours:
        return tr("There is no skeleton: no edge encloses anything; smooth less or lower the edge floor.")
    thickest = max(float(radii.max()) for radii in found.radii)
    told = tr("Skeleton: {branches} branches, {length} px long together, up to {thick} px thick.")
    return told.format(branches=len(found.contours), length=f"{found.length:,.0f}", thick=f"{2 * thickest:.1f}")
