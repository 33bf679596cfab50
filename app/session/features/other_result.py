"""The other result: what the canvas shows beyond the divider of a wipe."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from PySide6.QtCore import QObject, Signal

from app.model.text.language import tr
from app.session.exchange.contour_tracking import TrackedContours
from app.session.exchange.messages import Reconstruction
from app.session.features.timeline import TimelineNavigation
from app.session.scene import NO_CONTOURS, ReviewedContours, Scene
from app.session.session import Session
from app.session.worker.requests import Compared
from app.session.worker.run import RESTING_SPEED
from cpm_core import Contour, Image, Result, Skeleton, Truth, VolumeTruth, measure

Kind = Literal["branch", "kept", "truth", "image"]


@dataclass(frozen=True, slots=True)
class Other:
    """Something that the result can be compared with.

    Attributes
    ----------
    kind : {"branch", "kept", "truth", "image"}
        Another branch of the run; a result that was kept; the ground truth; the image without any result.
    title : str
        Its name.
    branch : int or None
        Number of the branch.
    """

    kind: Kind
    title: str
    branch: int | None = None


class OtherResult(QObject):
    """Chooses what the result is compared with, and gives the scenes on both sides of the divider."""

    changed = Signal()
    """Something else is compared, or nothing."""

    def __init__(self, session: Session, navigation: TimelineNavigation) -> None:
        super().__init__(session)
        self._session = session
        self._navigation = navigation
        self._chosen: Other | None = None
        self._kept: Scene | None = None
        self._made: tuple[object, object, ReviewedContours] = (None, None, NO_CONTOURS)
        session.image_changed.connect(self._forget)
        navigation.comparison.changed.connect(self._follow_branch)

    @property
    def chosen(self) -> Other | None:
        """What is compared; None for nothing."""
        return self._chosen

    @property
    def choices(self) -> tuple[Other, ...]:
        """All that can be compared, the most telling first."""
        if self._session.document.image is None:
            return ()
        here = self._navigation.place[0]
        branches = [branch for branch in self._navigation.outline.branches if branch.identity != here]
        found = [Other("branch", branch.name, branch.identity) for branch in reversed(branches)]
        if self._kept is not None:
            found.append(Other("kept", _kept_title(self._kept)))
        if self._session.scene.truth is not None:
            found.append(Other("truth", tr("Ground truth")))
        return (*found, Other("image", tr("Image alone")))

    @property
    def titles(self) -> tuple[str, str]:
        """What is on the left and on the right of the divider."""
        here = self._navigation.branch(self._navigation.place[0])
        near = here.name if here is not None and len(self._navigation.outline.branches) > 1 else tr("Result")
        return near, self._chosen.title if self._chosen is not None else ""

    def choose(self, other: Other | None) -> None:
        """Compare with something else, or with nothing."""
        before, self._chosen = self._chosen, other
        if other is not None and other.kind == "branch":
            if self._navigation.comparison.branch != other.branch:
                self._navigation.comparison.compare(other.branch)
        elif before is not None and before.kind == "branch":
            self._navigation.comparison.compare(None)
        self.changed.emit()

    def toggle(self) -> None:
        """Compare with nothing, or with the branch that is shown in the timeline, or else with the first choice."""
        compared = self._navigation.comparison.branch
        choices = self.choices
        first = next((other for other in choices if compared is not None and other.branch == compared), None)
        self.choose(None if self._chosen is not None else first or next(iter(choices), None))

    def keep(self) -> None:
        """Keep the present result, to compare later ones with it."""
        self._kept = self._session.scene
        kept = next(other for other in self.choices if other.kind == "kept")
        if self._chosen is not None and self._chosen.kind == "kept":
            self._chosen = kept
        self._session.say(tr("{name} can be compared with later results.").format(name=kept.title))
        self.changed.emit()

    def near(self, scene: Scene) -> Scene:
        """The scene on the left: without what is shown on the right."""
        if self._chosen is not None and self._chosen.kind == "truth":
            return replace(scene, truth=None, differences=(), apart=())
        return scene

    def far(self, scene: Scene) -> Scene:
        """The scene on the right."""
        kind = self._chosen.kind if self._chosen is not None else ""
        bare = Scene(scene.image, scene.display, scene.shaded, overlays=scene.overlays)
        bare = replace(bare, slices=scene.slices)
        if kind == "kept" and self._kept is not None:
            kept = self._kept
            return replace(
                bare, document=kept.document, snapshot=kept.snapshot, reconstruction=kept.reconstruction,
                contours=kept.contours,
            )  # fmt: skip
        if kind == "truth" and isinstance(scene.truth, VolumeTruth) and scene.image is not None:
            result = replace(_result((), scene.image), surface=scene.truth.surface)
            return replace(bare, reconstruction=Reconstruction(0, result, None))
        if kind == "truth" and isinstance(scene.truth, Truth):
            return replace(bare, contours=self._contours(scene, scene.truth, scene.truth.contours, with_marks=False))
        if kind == "branch" and scene.compared is not None and scene.compared.state is not None:
            return self._branch(bare, scene, scene.compared)
        return bare

    def _branch(self, bare: Scene, scene: Scene, compared: Compared) -> Scene:
        """The branch at the same step."""
        state, shown = compared.state, scene.snapshot
        snapshot = None
        if shown is not None and state is not None and compared.position is not None:
            speed = np.linalg.norm(state.particles.velocity, axis=1) * 2.0**state.scale
            snapshot = replace(shown, state=state, position=compared.position, resting=speed < RESTING_SPEED)
        contours, reconstruction = NO_CONTOURS, None
        if isinstance(compared.result, Skeleton) or getattr(compared.result, "surface", None) is not None:
            assert compared.result is not None
            reconstruction = Reconstruction(scene.snapshot.generation if scene.snapshot else 0, compared.result, None)
        elif compared.result is not None:
            contours = self._contours(scene, compared.result, compared.result.contours, with_marks=True)
        return replace(
            bare, document=scene.document, snapshot=snapshot, reconstruction=reconstruction, contours=contours
        )

    def _contours(
        self, scene: Scene, source: object, contours: tuple[Contour, ...], *, with_marks: bool
    ) -> ReviewedContours:
        """Contours as the canvas shows them, made once for each source and each review."""
        marks = scene.document.marks if with_marks else ()
        if self._made[0] is not source or self._made[1] is not marks:
            assert scene.image is not None
            result = source if isinstance(source, Result) else _result(contours, scene.image)
            measures = measure(contours, result.spacing, contrast=False)
            tracked = TrackedContours(result, tuple(range(len(contours))), measures)
            self._made = (source, marks, ReviewedContours.of(tracked, marks))
        return self._made[2]

    def _follow_branch(self) -> None:
        """The timeline compares another branch, or none."""
        shown = self._navigation.comparison.branch
        if shown != (self._chosen.branch if self._chosen is not None else None):
            branch = self._navigation.branch(shown) if shown is not None else None
            self._chosen = Other("branch", branch.name, branch.identity) if branch is not None else None
            self.changed.emit()

    def _forget(self) -> None:
        """Another image has been opened."""
        self._kept, self._made = None, (None, None, NO_CONTOURS)
        if self._chosen is not None:
            self.choose(None)


def _kept_title(scene: Scene) -> str:
    step = scene.snapshot.state.step if scene.snapshot is not None else 0
    return tr("Kept result, step {step}").format(step=step) if step else tr("Kept result")


def _result(contours: tuple[Contour, ...], image: Image) -> Result:
    """Contours that no run has found."""
    return Result(
        np.empty((0, len(image.shape))), contours, None, 0, True, "", image.shape, image.spacing, image.unit, ""
    )
