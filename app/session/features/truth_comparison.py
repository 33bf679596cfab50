"""Comparison of the contours, or of a surface, with the ground truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from app.model.display.differences import Apart, Difference, apart_from, differences, surface_differences
from app.model.text.language import tr
from app.session.exchange.messages import CommandFailed
from app.session.features.background import LatestOnlyWorker
from app.session.features.contour_review import ContourReview
from app.session.session import Session
from cpm_core import (
    Comparison,
    Contour,
    Image,
    Surface,
    SurfaceComparison,
    Truth,
    VolumeTruth,
    compare,
    compare_surface,
    load_truth,
    load_volume_truth,
)
from cpm_core.contours import TOLERANCE
from cpm_core.formats import TruthFile

_TOPIC = "truth"


@dataclass(frozen=True, eq=False, slots=True)
class Verified:
    """Result of a comparison with the ground truth; `apart` are the parts of surfaces that differ."""

    truth: Truth | VolumeTruth
    comparison: Comparison | SurfaceComparison
    differences: tuple[Difference, ...]
    apart: tuple[Apart, ...] = ()


class GroundTruth(QObject):
    """Holds the ground truth of the image and compares every reconstruction with it, on a separate thread.

    Rejected contours are not compared. In a volume the tolerance is in smallest sides of a voxel.
    """

    changed = Signal()
    """The ground truth has been replaced or removed."""
    compared = Signal()
    """`verified` has been replaced or removed."""

    def __init__(self, session: Session, review: ContourReview) -> None:
        super().__init__(review)
        self.verified: Verified | None = None
        self.tolerance = TOLERANCE
        self.holes = True
        self._path: Path | None = None
        self._session = session
        self._review = review
        self._latest = LatestOnlyWorker(session, "cpm-comparison", tr("comparing with the ground truth"))
        session.image_changed.connect(self.forget)
        session.image_changed.connect(self.changed)
        review.changed.connect(self._compare)

    @property
    def truth(self) -> Truth | VolumeTruth | None:
        """The ground truth."""
        return self._session.scene.truth

    @property
    def in_volume(self) -> bool:
        """Whether a volume is open, whose surface is compared."""
        return self._session.image is not None and self._session.image.ndim == 3

    @property
    def lacks_result(self) -> bool:
        """Whether nothing has been found yet that could be compared."""
        return self._review.result is None

    @property
    def idle(self) -> bool:
        """Whether the comparison is up to date."""
        return self._latest.idle

    def load(self, path: str | Path) -> None:
        """Read a mask or contours as the ground truth of the current image, or labels as that of a volume."""
        image = self._session.image
        self._session.attempt(_TOPIC)
        if image is None:
            self._session.say(tr("There is no image to compare with: open one first."), True, _TOPIC)
            return
        file, generation, holes = Path(path), self._session.image_generation, self.holes
        self._path = file

        def use(truth: Truth | VolumeTruth) -> None:
            if generation == self._session.image_generation:
                self._use(truth)
                self._compare()

        self._session.tasks.start(
            tr("Reading {name}…").format(name=file.name),
            lambda task: _read(file, image, holes),
            tr("reading {name}").format(name=file.name),
            partial(CommandFailed, topic=_TOPIC),
            then=use,
        )

    @property
    def file(self) -> TruthFile | None:
        """The ground truth as a session keeps it."""
        if self._path is None:
            return None
        return TruthFile(str(self._path.absolute()), tolerance=self.tolerance, holes=self.holes)

    def restore(self, file: TruthFile, folder: Path) -> None:
        """Load the ground truth of a session that lies in a folder."""
        self.tolerance, self.holes = file.tolerance, file.holes
        beside = folder / file.path
        self.load(beside if beside.exists() or not file.absolute else file.absolute)

    def forget(self) -> None:
        """Remove the ground truth."""
        self._latest.forget()
        if self._path is not None:
            self._path = None
            self._use(None)
            self._show(None)

    def set_tolerance(self, tolerance: float) -> None:
        """Set the distance up to which boundaries count as the same [px]."""
        if tolerance != self.tolerance:
            self.tolerance = tolerance
            self._compare()

    def set_holes(self, holes: bool) -> None:
        """Set whether a contour inside another one is a hole."""
        if holes != self.holes:
            self.holes = holes
            if self._path is not None:
                self.load(self._path)

    def dice(self, contours: Sequence[Contour]) -> float | None:
        """The Dice coefficient of contours, from any thread; None when there is no ground truth of an image."""
        truth = self.truth
        return compare(contours, truth, self.tolerance, holes=self.holes).dice if isinstance(truth, Truth) else None

    def close(self) -> None:
        """End the thread."""
        self._latest.close()

    def _use(self, truth: Truth | VolumeTruth | None) -> None:
        self.verified = None
        self._session.show(replace(self._session.scene, truth=truth, differences=(), apart=()))
        self.changed.emit()

    def _compare(self) -> None:
        truth, result, tolerance, holes = self.truth, self._review.result, self.tolerance, self.holes
        if truth is None:
            return
        if result is None:
            self._latest.forget()
            self._show(None)
            return
        surface = result.surface
        contours = [item.contour for item in self._review.items if not item.reviewed.rejected]

        def work() -> Verified:
            if isinstance(truth, VolumeTruth):
                return _verified(surface, truth, tolerance)
            comparison = compare(contours, truth, tolerance, holes=holes)
            return Verified(truth, comparison, differences(contours, truth, comparison))

        # no figures rather than those of other contours
        self._latest.ask(work, self._take, lambda: self._show(None))

    def _take(self, verified: Verified) -> None:
        if verified.truth is self.truth and self._review.result is not None:
            self._show(verified)

    def _show(self, verified: Verified | None) -> None:
        self.verified = verified
        differences, apart = (verified.differences, verified.apart) if verified is not None else ((), ())
        self._session.show(replace(self._session.scene, differences=differences, apart=apart))
        self.compared.emit()


def _read(file: Path, image: Image, holes: bool) -> Truth | VolumeTruth:
    """The ground truth of an image, or of a volume with all that slices need of it."""
    if image.ndim == 2:
        return load_truth(file, image.shape, holes=holes, spacing=image.spacing, unit=image.unit)
    truth = load_volume_truth(file, image)
    _ = truth.surface  # made on this thread, not on that of the window
    return truth


def _verified(surface: Surface | None, truth: VolumeTruth, tolerance: float) -> Verified:
    """A surface compared with the ground truth; the sides of a voxel are those of the run."""
    known = truth
    if surface is not None and (surface.spacing, surface.unit) != (truth.spacing, truth.unit):
        known = replace(truth, spacing=surface.spacing, unit=surface.unit)
    found = compare_surface(surface, known, tolerance * min(known.spacing))
    apart = apart_from(surface, known, found)
    return Verified(truth, found, surface_differences(apart), apart)
