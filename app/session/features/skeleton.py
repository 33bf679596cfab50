"""Skeletons that follow the parameters."""

from __future__ import annotations

from PySide6.QtCore import QObject

from app.model.display.lengths import measured
from app.model.document.document import Document
from app.model.state.resolve import skeleton_of
from app.model.text.language import tr
from app.session.session import Session
from cpm_core import Image, Parameters, Skeleton


class Skeletons(QObject):
    """Finds the skeleton again, in three steps at most, when a parameter changes, or what it is of."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._parameters: Parameters | None = None
        self._changed = False
        self._of: tuple[object, ...] = ()
        self._described: Skeleton | None = None
        session.document_changed.connect(self._use_document)
        session.status_changed.connect(self._follow)
        session.scene_changed.connect(self._describe)

    def _use_document(self, document: Document) -> None:
        if document.parameters is not self._parameters:
            self._changed = document.mode == "skeleton"
            self._parameters = document.parameters
        regions = document.regions
        of = (document.outlines, document.outlined_surfaces, regions.interest if regions is not None else ())
        before, self._of = self._of, of
        status = self._session.status
        if before != of and document.mode == "skeleton" and status.method == "skeleton" and status.started:
            self._session.reset()
            self._session.run()

    def _follow(self) -> None:
        if not self._changed:
            return
        status = self._session.status
        if status.method == "skeleton" and status.phase == "finished" and not status.stale:
            self._changed = False
            if status.steered:
                self._session.run()

    def _describe(self) -> None:
        found = self._session.scene.skeleton
        image = self._session.image
        if found is not None and found is not self._described and image is not None:
            self._session.say(description_of(found, image))
        self._described = found


def description_of(found: Skeleton, image: Image) -> str:
    """What has been found, in a sentence."""
    message = tr("Skeleton of {what}; branches: {branches}, length: {length}; 95 % of it is at most {thick} thick.")
    sides = (min(image.spacing),) * image.ndim if image.ndim == 3 else image.spacing
    return message.format(
        what=skeleton_of(found.polarity, found.width),
        branches=len(found.contours),
        length=measured(found.length, sides, image.unit, 0),
        thick=measured(found.thickness, sides, image.unit),
    )
