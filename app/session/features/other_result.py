"""The other result: what the canvas shows beyond the divider of a wipe."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal

from app.model.text.language import tr
from app.session.exchange.contour_tracking import TrackedContours
from app.session.exchange.messages import Reconstruction
from app.session.scene import NO_CONTOURS, ReviewedContours, Scene
from app.session.session import Session
from app.session.timeline.stored_runs import Branch
from app.session.timeline.timeline import Outline
from app.session.worker.requests import Compared, compare
from cpm_core import Contour, Image, Result, Truth, VolumeTruth, measure

NOTHING = Outline()

_EVERY, _SELDOM, _QUIET = 100, 500, 200
"""Time between two comparisons while the timeline is scrubbed and during a run, and time without a change after which
contours are compared [ms]."""

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
    """Chooses what the result is compared with, and gives the scenes on both sides of the divider.

    The state of another branch at the step that is shown is requested; the answer is `Scene.compared`.
    """

    changed = Signal()
    """Something else is compared, or nothing."""
    found_changed = Signal()
    """`found` has been replaced."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._scene = session.scene
        self._chosen: Other | None = None
        self._kept: Scene | None = None
        self._made: tuple[object, object, ReviewedContours] = (None, None, NO_CONTOURS)
        self._later = QTimer(self, singleShot=True)
        self._later.timeout.connect(self._ask)
        self._quiet = QTimer(self, singleShot=True, interval=_QUIET)
        self._quiet.timeout.connect(lambda: self._ask(thorough=True))
        session.scene_changed.connect(self._follow)
        session.image_changed.connect(self._forget)

    @property
    def chosen(self) -> Other | None:
        """What is compared; None for nothing."""
        return self._chosen

    @property
    def branch(self) -> int | None:
        """The branch that is compared."""
        return None if self._chosen is None else self._chosen.branch

    @property
    def found(self) -> Compared | None:
        """The branch at the step that is shown; None while that is not known."""
        compared = self._session.scene.compared
        return compared if compared is not None and compared.branch is not None else None

    @property
    def choices(self) -> tuple[Other, ...]:
        """All that can be compared, the most telling first."""
        if self._session.document.image is None:
            return ()
        found = [Other("branch", branch.name, branch.identity) for branch in reversed(self._branches)]
        if self._kept is not None:
            shown = self._kept.snapshot
            step = shown.state.step if shown is not None else 0
            found.append(Other("kept", tr("Kept result, step {step}").format(step=step) if step else tr("Kept result")))
        if self._session.scene.truth is not None:
            found.append(Other("truth", tr("Ground truth")))
        return (*found, Other("image", tr("Image alone")))

    @property
    def titles(self) -> tuple[str, str]:
        """What is on the left and on the right of the divider."""
        outline = self._outline
        here = next((branch.name for branch in outline.branches if branch.identity == outline.branch), "")
        near = here if len(outline.branches) > 1 else tr("Result")
        return near, self._chosen.title if self._chosen is not None else ""

    def choose(self, other: Other | None) -> None:
        """Compare with something else, or with nothing."""
        before, self._chosen = self.branch, other
        if self.branch != before:
            self._ask()
            self._quiet.start()
        self.changed.emit()

    def compare(self, branch: int | None) -> None:
        """Compare with a branch; None ends that."""
        if branch != self.branch:
            found = next((other for other in self.choices if other.branch == branch), None)
            self.choose(None if branch is None else found)

    def toggle(self) -> None:
        """Compare with nothing, or else with the first choice."""
        self.choose(None if self._chosen is not None else next(iter(self.choices), None))

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
        compared = scene.compared
        if kind != "branch" or compared is None:
            return bare
        bare = replace(bare, document=scene.document, snapshot=compared.snapshot)
        if isinstance(compared.result, Result) and compared.result.surface is None:
            contours = self._contours(scene, compared.result, compared.result.contours, with_marks=True)
            return replace(bare, contours=contours)
        found = None if compared.result is None else Reconstruction(compared.generation, compared.result, None)
        return replace(bare, reconstruction=found)

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

    @property
    def _outline(self) -> Outline:
        snapshot = self._session.scene.snapshot
        return NOTHING if snapshot is None else snapshot.timeline

    @property
    def _branches(self) -> tuple[Branch, ...]:
        """The branches but that which is shown."""
        outline = self._outline
        return tuple(branch for branch in outline.branches if branch.identity != outline.branch)

    def _follow(self) -> None:
        before, scene = self._scene, self._session.scene
        self._scene = scene
        if scene.compared is not before.compared:
            self.found_changed.emit()
        if self.branch is None:
            return
        if all(branch.identity != self.branch for branch in self._branches):
            self._later.stop()
            self.choose(None)
            self._session.show(replace(self._session.scene, compared=None))
        elif scene.snapshot is not before.snapshot or scene.contours.result is not before.contours.result:
            self._quiet.start()
            if not self._later.isActive():
                self._later.start(_SELDOM if self._session.status.phase == "running" else _EVERY)

    def _ask(self, thorough: bool = False) -> None:
        """Ask for the branch, if `thorough` with its contours, which takes longer, once nothing changes any more."""
        snapshot = self._session.scene.snapshot
        against = self._session.scene.contours.result if thorough else None
        if thorough and (against is None or self.branch is None or self._session.status.phase == "running"):
            return
        step = snapshot.state.step if snapshot is not None else 0
        self._session.post(compare(self._session.generation, self.branch, step, against))

    def _forget(self) -> None:
        """Another image has been opened."""
        self._kept, self._made = None, (None, None, NO_CONTOURS)
        if self._chosen is not None:
            self.choose(None)


def _result(contours: tuple[Contour, ...], image: Image) -> Result:
    """Contours that no run has found."""
    return Result(
        np.empty((0, len(image.shape))), contours, None, 0, True, "", image.shape, image.spacing, image.unit, ""
    )
