"""Skeletons: found on the worker thread when a person asks for one, and anew when what they depend on changes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from app.model.document import Document
from app.model.language import tr
from app.session.commands import Command
from app.session.messages import Exported, Report, Trouble
from app.session.trouble import sentence
from app.session.workshop import Workshop
from cpm_core.formats import export
from cpm_core.image import Image
from cpm_core.parameters import Parameters
from cpm_core.skeleton import Skeleton, skeleton

if TYPE_CHECKING:
    from app.session.session import Session

_DEPENDS_ON = ("smoothing", "edge_floor", "min_strength", "min_length")
"""Parameters that a skeleton depends on."""


@dataclass(frozen=True, eq=False, slots=True)
class SkeletonFound(Report):
    """The skeleton of the image opened as `image_generation`, or why there is none."""

    image_generation: int
    skeleton: Skeleton | None
    sentence: str = ""


@dataclass(frozen=True, eq=False, slots=True)
class FindSkeleton(Command):
    """Find the skeleton of an image."""

    image_generation: int
    image: Image
    parameters: Parameters

    latest_only = True

    def obey(self, shop: Workshop) -> None:
        """Find it."""
        if not shop.closing():
            shop.report(SkeletonFound(self.image_generation, skeleton(self.image, self.parameters)))

    def refusal(self, error: Exception) -> Report:
        """There is none."""
        return SkeletonFound(self.image_generation, None, sentence(error, tr("finding the skeleton")))


@dataclass(frozen=True, eq=False, slots=True)
class ExportSkeleton(Command):
    """Write a skeleton to a file whose suffix tells the format."""

    skeleton: Skeleton
    path: Path

    def obey(self, shop: Workshop) -> None:
        """Write it."""
        export(self.skeleton, self.path)
        shop.report(Exported(self.path))

    def refusal(self, error: Exception) -> Report:
        """Nothing has been written."""
        return Trouble(sentence(error, tr("writing {file}").format(file=self.path.name)))


class Skeletons(QObject):
    """The skeleton of the image that is open, if one has been asked for.

    Parameters
    ----------
    session : Session
        Whose image it is of.
    """

    changed = Signal(object)
    """Another skeleton, or None when there is none any more: Skeleton or None."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._image: Image | None = None
        self._asked: tuple[object, ...] = ()
        self._loud = False
        self.found: Skeleton | None = None
        session.image_changed.connect(self._use_image)
        session.document_changed.connect(self._follow)
        session.reported.connect(self._take)

    def find(self) -> None:
        """Find the skeleton of the image by the parameters of the document."""
        if self._image is None:
            self._session.say(tr("There is no image to run on: open one first."), True)
            return
        self._loud = True
        self._session.say(tr("Finding the skeleton…"))
        self._ask(self._session.document)

    def export(self, path: str | Path) -> None:
        """Write the skeleton that was found."""
        if self.found is not None:
            self._session.post(ExportSkeleton(self.found, Path(path)))

    def _ask(self, document: Document) -> None:
        if self._image is not None:
            self._asked = _asked(document.parameters)
            self._session.post(FindSkeleton(self._session.image_generation, self._image, document.parameters))

    def _use_image(self, image: Image, _: object) -> None:
        self._image = image
        self._show(None)

    def _follow(self, document: Document) -> None:
        if document.mode != "skeleton":
            self._show(None)
        elif self.found is not None and _asked(document.parameters) != self._asked:
            self._ask(document)

    def _take(self, report: Report) -> None:
        if not isinstance(report, SkeletonFound) or report.image_generation != self._session.image_generation:
            return
        if report.sentence:
            self._session.say(report.sentence, True)
        elif self._session.document.mode == "skeleton":
            self._show(report.skeleton)
            if self._loud:
                self._session.say(_told(report.skeleton))
        self._loud = False

    def _show(self, found: Skeleton | None) -> None:
        if found is not self.found:
            self.found = found
            self.changed.emit(found)
            self._session.status_changed.emit()


def _asked(parameters: Parameters) -> tuple[object, ...]:
    return tuple(getattr(parameters, name) for name in _DEPENDS_ON)


def _told(found: Skeleton | None) -> str:
    if found is None or not found.contours:
        return tr("There is no skeleton: no edge encloses anything; smooth less or lower the edge floor.")
    thickest = max(float(radii.max()) for radii in found.radii)
    told = tr("Skeleton: {branches} branches, {length} px long together, up to {thick} px thick.")
    return told.format(branches=len(found.contours), length=f"{found.length:,.0f}", thick=f"{2 * thickest:.1f}")
