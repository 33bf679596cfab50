"""Ground truth in the window: what is known to be in the image, and how well the contours agree with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from app.model.display.differences import Difference, differences
from app.model.text.language import tr
from app.session.exchange.mailbox import Latest
from app.session.exchange.messages import Report
from app.session.features.contour_review import ContourReview
from app.session.session import Session
from cpm_core.contours.agreement import TOLERANCE, Comparison, compare
from cpm_core.contours.contour import Contour
from cpm_core.contours.ground_truth import Truth
from cpm_core.formats.ground_truth_file import load_truth


@dataclass(frozen=True, eq=False, slots=True)
class TruthRead(Report):
    """The ground truth of the image opened as `generation` has been read."""

    generation: int
    truth: Truth


@dataclass(frozen=True, eq=False, slots=True)
class Verified:
    """What a comparison with the truth came to."""

    truth: Truth
    comparison: Comparison
    differences: tuple[Difference, ...]


class GroundTruth(QObject):
    """Holds the truth of the image and compares every reconstruction with it, on a thread of its own.

    Parameters
    ----------
    session : Session
        Whose image it belongs to.
    review : ContourReview
        Where contours come from; those rejected are not compared.
    """

    changed = Signal()
    """There is another truth, or none."""
    compared = Signal()
    """The contours have been compared, or there is nothing to be compared any more."""

    def __init__(self, session: Session, review: ContourReview) -> None:
        super().__init__(review)
        self.verified: Verified | None = None
        self.tolerance = TOLERANCE
        self.holes = True
        self._path: Path | None = None
        self._session = session
        self._review = review
        self._latest = Latest("cpm-comparison", self)
        self._latest.done.connect(self._take)
        session.listen(TruthRead, self._take_truth)
        session.image_changed.connect(self.forget)
        review.changed.connect(self._compare)

    @property
    def truth(self) -> Truth | None:
        """What the contours are compared with."""
        return self._session.scene.truth

    @property
    def idle(self) -> bool:
        """Whether what is shown is up to date."""
        return self._latest.idle

    def load(self, path: str | Path) -> None:
        """Read a mask or contours as the truth of the image that is open."""
        image = self._session.document.image
        if image is None:
            self._session.say(tr("There is no image to compare with: open one first."), True)
            return
        file, generation, holes, shape = Path(path), self._session.image_generation, self.holes, image.shape
        self._path = file
        self._session.tasks.start(
            tr("Reading {name}…").format(name=file.name),
            lambda task: TruthRead(generation, load_truth(file, shape, holes=holes)),
            f"reading {file.name}",
        )

    def forget(self) -> None:
        """Compare with nothing any more."""
        self._latest.forget()
        if self._path is not None:
            self._path = None
            self._use(None)
            self._show(None)

    def set_tolerance(self, tolerance: float) -> None:
        """Take boundaries for the same up to this distance [px]."""
        if tolerance != self.tolerance:
            self.tolerance = tolerance
            self._compare()

    def set_holes(self, holes: bool) -> None:
        """Say whether a contour in another is a hole of it."""
        if holes != self.holes:
            self.holes = holes
            if self._path is not None:
                self.load(self._path)

    def dice(self, contours: Sequence[Contour]) -> float | None:
        """The Dice coefficient of some contours, from whichever thread; None when there is no truth."""
        truth = self.truth
        return None if truth is None else compare(contours, truth, self.tolerance, holes=self.holes).dice

    def close(self) -> None:
        """End the thread."""
        self._latest.close()

    def _take_truth(self, report: TruthRead) -> None:
        if report.generation == self._session.image_generation:
            self._use(report.truth)
            self._compare()

    def _use(self, truth: Truth | None) -> None:
        self.verified = None
        self._session.show(replace(self._session.scene, truth=truth, differences=()))
        self.changed.emit()

    def _compare(self) -> None:
        truth, result, tolerance, holes = self.truth, self._review.result, self.tolerance, self.holes
        if truth is None:
            return
        if result is None:
            self._latest.forget()
            self._show(None)
            return
        contours = [item.contour for item in self._review.items if not item.reviewed.rejected]

        def work() -> Verified:
            comparison = compare(contours, truth, tolerance, holes=holes)
            return Verified(truth, comparison, differences(contours, truth, comparison))

        self._latest.ask(work)

    def _take(self, verified: Verified) -> None:
        if verified.truth is self.truth and self._review.result is not None:
            self._show(verified)

    def _show(self, verified: Verified | None) -> None:
        self.verified = verified
        differences = verified.differences if verified is not None else ()
        self._session.show(replace(self._session.scene, differences=differences))
        self.compared.emit()
