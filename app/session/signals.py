"""What is told to the views: one signal for each kind of news."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from app.session.exchange.messages import Overlays, Reconstruction, Report, Snapshot
from cpm_core.shapes.image_starts import ImageSeeds


class SessionSignals(QObject):
    """The signals that views follow, and the methods by which they are given."""

    document_changed = Signal(object)
    """The document is another one: Document."""
    image_changed = Signal(object, object)
    """Another image is shown: Image, and its Shades."""
    status_changed = Signal()
    """What `resolved` says may have changed."""
    snapshot_changed = Signal(object)
    """Newer particles: Snapshot, or None when there are none."""
    contours_changed = Signal(object)
    """Newer contours: Result, or None when there are none."""
    surveyed = Signal(object)
    """What is known about newer contours: Survey, or None when there are none."""
    reconstructed = Signal(object)
    """Newer contours of whatever method: Reconstruction, or None when there are none."""
    overlays_changed = Signal(object)
    """Newer edge map and field: Overlays."""
    image_seeds_changed = Signal(object)
    """Other places from which particles start all over the image: Sown."""
    reported = Signal(object)
    """The worker has reported something: Report. Whoever is concerned looks at its kind."""
    said = Signal(str, bool)
    """A sentence for the user, and whether it tells of trouble."""

    def show_snapshot(self, snapshot: Snapshot | None) -> None:
        """Pass particles on."""
        self.snapshot_changed.emit(snapshot)

    def show_contours(self, reconstruction: Reconstruction | None) -> None:
        """Pass contours on."""
        tracked = reconstruction.tracked if reconstruction else None
        self.surveyed.emit(tracked)
        self.contours_changed.emit(tracked.result if tracked else None)
        self.reconstructed.emit(reconstruction)

    def show_overlays(self, overlays: Overlays) -> None:
        """Pass edge map and field on."""
        self.overlays_changed.emit(overlays)

    def show_image_seeds(self, image_seeds: ImageSeeds) -> None:
        """Pass places to start from on."""
        self.image_seeds_changed.emit(image_seeds)

    def show_status(self) -> None:
        """Say that what is resolved may have changed."""
        self.status_changed.emit()

    def pass_on(self, report: Report) -> None:
        """Tell whoever listens what the worker has reported."""
        self.reported.emit(report)

    def say(self, sentence: str, trouble: bool = False) -> None:
        """Tell the user one sentence."""
        self.said.emit(sentence, trouble)
