"""The place on the timeline: the runs, the branch and the step that are shown."""

from __future__ import annotations

from PySide6.QtCore import QObject

from app.model.text.language import tr
from app.session.session import Session
from app.session.timeline.branches import Branch
from app.session.timeline.outline import Outline

NOTHING = Outline()


class TimelinePlace(QObject):
    """What is known of the timeline of a session."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._outline = NOTHING
        self._here = (0, 0)
        self._count = 0
        self._target: tuple[int, int] | None = None

    @property
    def outline(self) -> Outline:
        """The branches."""
        return self._outline

    @property
    def place(self) -> tuple[int, int]:
        """Branch and step of the run, or those that it has been sent to."""
        return self._target or self._here

    @property
    def first(self) -> int:
        """The first step of the runs."""
        return next((branch.first for branch in self._outline.branches if branch.parent is None), 0)

    @property
    def recorded(self) -> bool:
        """Whether there are runs to go to."""
        return bool(self._outline.branches)

    @property
    def count(self) -> int:
        """Number of particles shown."""
        return self._count

    def branch(self, identity: int) -> Branch | None:
        """A branch by its number."""
        return next((branch for branch in self._outline.branches if branch.identity == identity), None)

    def last(self, identity: int) -> int:
        """The last step of a branch, 0 when it does not exist."""
        branch = self.branch(identity)
        if branch is None:
            return 0
        return max(branch.last, self._here[1]) if identity == self._here[0] else branch.last

    def beside(self, identity: int) -> int:
        """The step of a branch to go to from the present one: the same step of the same run, the end of another run."""
        here, there = self.branch(self.place[0]), self.branch(identity)
        if here is None or there is None or here.run != there.run:
            return self.last(identity)
        return self.place[1]

    def _take_outline(self, outline: Outline) -> None:
        fallen = outline.fallen[len(self._outline.fallen) :]
        self._outline = outline
        if fallen:
            message = tr(
                "{runs} had to be removed from the timeline to make room; a run with a name of its own stays longer."
            )
            self._session.say(message.format(runs=", ".join(fallen)))

    def _place_or_end(self) -> tuple[int, int]:
        """The place, or the end of the last branch while the run is on none."""
        if self.place[0] or not self._outline.branches:
            return self.place
        newest = self._outline.branches[-1].identity
        return newest, self.last(newest) + 1
