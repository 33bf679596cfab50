"""Skeletons that follow the parameters."""

from __future__ import annotations

from PySide6.QtCore import QObject

from cpm_app.model.document.document import Document
from cpm_app.session.session import Session
from cpm_core import Parameters


class SkeletonUpdater(QObject):
    """Recomputes the skeleton, in three steps at most, when a parameter or its subject changes."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._parameters: Parameters | None = None
        self._changed = False
        self._subject: tuple[object, ...] = ()
        session.document_changed.connect(self._on_document_changed)
        session.store.status_changed.connect(self._on_status_changed)

    def _on_document_changed(self, document: Document) -> None:
        if document.parameters is not self._parameters:
            self._changed = document.mode == "skeleton"
            self._parameters = document.parameters
        regions = document.regions
        subject = (document.outlines, document.outlined_bodies, regions.interest if regions is not None else ())
        before, self._subject = self._subject, subject
        status = self._session.status
        if before != subject and document.mode == "skeleton" and status.method == "skeleton" and status.started:
            self._session.reset()
            self._session.run()

    def _on_status_changed(self) -> None:
        if not self._changed:
            return
        status = self._session.status
        if status.method == "skeleton" and status.phase == "finished" and not status.stale:
            self._changed = False
            if status.steered:
                self._session.run()
