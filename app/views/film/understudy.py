"""A stand-in for the session, by which a second canvas that nobody sees shows other moments of the run."""

from __future__ import annotations

from typing import Any, cast

from PySide6.QtCore import QObject

from app.session.exchange.messages import Overlays, Report, SeedsFound
from app.session.features.contour_review import ContourReview
from app.session.session import Session
from app.session.signals import SessionSignals
from app.session.worker.commands.frames import FrameTaken
from app.session.worker.commands.run import Command
from app.session.worker.commands.timeline import Compared


class Understudy(SessionSignals):
    """Tells layers what it is given to tell; whatever else they ask is answered by the session itself.

    Nothing that layers do to it has any effect on the session.

    Parameters
    ----------
    session : Session
        Whose part it plays.
    """

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._played = session
        self.review = ContourReview(cast(Session, self))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._played, name)

    def post(self, command: Command) -> None:
        """Whoever asks the worker has asked it already."""

    def want_overlay(self, name: str, wanted: bool) -> None:
        """Overlays are those of the session."""


class Told(QObject):
    """What a session has told that still holds, for telling it to an understudy.

    Parameters
    ----------
    session : Session
        Who is listened to, from the beginning on.
    """

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._image: tuple[object, object] | None = None
        self._overlays: Overlays | None = None
        self._image_seeds: object = None
        self._reports: dict[type[Report], Report] = {}
        session.image_changed.connect(self._keep_image)
        session.overlays_changed.connect(self._keep_overlays)
        session.image_seeds_changed.connect(self._keep_image_seeds)
        session.reported.connect(self._keep_report)

    def tell(self, understudy: Understudy) -> None:
        """Tell all of it."""
        if self._image is not None:
            understudy.image_changed.emit(*self._image)
        understudy.document_changed.emit(self._session.document)
        if self._image_seeds is not None:
            understudy.image_seeds_changed.emit(self._image_seeds)
        understudy.status_changed.emit()

    def tell_what_lies_over(self, understudy: Understudy) -> None:
        """Tell what layers want to hear once they know whether they are shown."""
        for report in self._reports.values():
            understudy.reported.emit(report)
        if self._overlays is not None:
            understudy.overlays_changed.emit(self._overlays)

    def _keep_image(self, image: object, shades: object) -> None:
        self._image, self._overlays, self._image_seeds = (image, shades), None, None
        self._reports.clear()

    def _keep_overlays(self, overlays: Overlays) -> None:
        self._overlays = overlays

    def _keep_image_seeds(self, image_seeds: object) -> None:
        self._image_seeds = image_seeds

    def _keep_report(self, report: Report) -> None:
        if not isinstance(report, FrameTaken | Compared | SeedsFound):
            self._reports[type(report)] = report
