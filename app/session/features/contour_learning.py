"""Learning from the review: contours that resemble rejected ones more than kept ones are left out."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from PySide6.QtCore import QObject

from app.model.document import marking
from app.model.text.language import tr
from app.session.exchange.contour_tracking import TrackedContours
from app.session.features.contour_review import ContourReview
from app.session.features.latest import Latest
from app.session.scene import ReviewedContours
from app.session.session import Session
from cpm_core.contours.features import contour_features
from cpm_core.contours.learning import most_doubtful
from cpm_core.contours.review import described
from cpm_core.numerics.types import Array


@dataclass(frozen=True, eq=False, slots=True)
class _Measured:
    """Features of the contours of a reconstruction."""

    tracked: TrackedContours
    features: Array


class ContourLearning(QObject):
    """Sorts the contours of the scene by the verdicts on some of them, while the document says so.

    Their features are measured on a separate thread; after that a verdict takes effect at once.
    """

    def __init__(self, session: Session, review: ContourReview) -> None:
        super().__init__(session)
        self._session = session
        self._review = review
        self._asked: TrackedContours | None = None
        self._starting = False
        self._latest = Latest(session, "cpm-learning", tr("measuring contours"))
        self._latest.done.connect(self._take)
        self._latest.failed.connect(self._give_up)
        session.scene_changed.connect(self._follow)
        session.image_changed.connect(self._forget)

    @property
    def on(self) -> bool:
        """Whether contours are sorted."""
        return self._session.document.learning

    @property
    def idle(self) -> bool:
        """Whether the contours are sorted by all verdicts."""
        contours = self._session.scene.contours
        measured = not self.on or contours.tracked is None or contours.features is not None
        return measured and self._latest.idle and not self._starting

    @property
    def summary(self) -> str:
        """What has been learned from how many verdicts, and its effect; empty while off."""
        if not self.on:
            return ""
        items, marks = self._review.items, self._session.document.marks
        kept, rejected = (sum(mark.verdict == verdict for mark in marks) for verdict in ("kept", "rejected"))
        if not kept + rejected:
            return tr("Nothing is learned yet: keep and reject some contours.")
        found = tr("Learned from {kept} kept and {rejected} rejected: {out} of {all} contours left out.")
        out = sum(item.reviewed.left_out for item in items)
        return found.format(kept=kept, rejected=rejected, out=out, all=len(items))

    def switch(self) -> None:
        """Begin or stop to sort contours by verdicts; an edit that can be undone."""
        if self.on:
            self._session.edit(tr("stop learning from verdicts"), marking.stop_learning)
            self._session.say(tr("All contours count again, except rejected ones."))
            return
        self._starting = True
        self._follow()

    def select_most_doubtful(self) -> None:
        """Select the contour whose verdict would teach most."""
        items = self._review.items
        chances = np.array([self._session.scene.contours.chances.get(item.key, 0.5) for item in items])
        marked = [index for index, item in enumerate(items) if item.reviewed.mark is not None]
        index = most_doubtful([item.contour for item in items], chances, marked)
        if index is None:
            self._session.say(tr("Every contour has a verdict."))
        else:
            self._review.select((items[index].key,))

    def close(self) -> None:
        """End the thread."""
        self._latest.close()

    def _forget(self) -> None:
        self._starting = False
        self._asked = None
        self._latest.forget()

    def _give_up(self, _: str) -> None:
        """Begin to learn anew when it is asked for again."""
        self._starting = False
        self._asked = None

    def _follow(self) -> None:
        """Measure the contours shown, if that is needed and has not begun."""
        contours = self._session.scene.contours
        tracked = contours.tracked
        if not (self.on or self._starting):
            return
        if tracked is None:
            if self._starting:
                self._begin(contours)
        elif contours.features is None and self._asked is not tracked:
            self._asked = tracked
            self._latest.ask(lambda: _Measured(tracked, contour_features(tracked.result.contours)))
        elif contours.features is not None and self._starting:
            self._begin(contours)

    def _take(self, measured: _Measured) -> None:
        scene = self._session.scene
        if scene.contours.tracked is not measured.tracked:
            return
        document = scene.document
        contours = ReviewedContours.of(
            measured.tracked, document.marks, document.learning, measured.features, scene.contours.chances
        )
        self._session.show(replace(scene, contours=contours))

    def _begin(self, contours: ReviewedContours) -> None:
        """Learn from all verdicts so far, and tell what follows from them."""
        self._starting = False
        marks = self._session.document.marks
        if contours.tracked is not None and contours.features is not None:
            marks = described(marks, contours.tracked.result.contours, contours.features)
        self._session.edit(tr("learn from verdicts"), lambda document: marking.learn(document, marks))
        self._session.say(self.summary)
