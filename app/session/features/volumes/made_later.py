"""Parts of slices that take longer than a frame: made on other threads, with something in their place at first."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from PySide6.QtCore import QObject, Signal

from app.model.text.language import tr
from app.session.features.latest import Latest
from app.session.features.volumes.made_once import is_same
from app.session.signals import SessionSignals

T = TypeVar("T")


@dataclass(frozen=True, eq=False, slots=True)
class _Made:
    """A part, and what it was made of."""

    given: tuple[Any, ...]
    part: Any
    whole: bool


class _Newest(QObject):
    """The newest part of one name."""

    def __init__(self, session: SessionSignals, tell: Callable[[], None]) -> None:
        super().__init__(session)
        self._tell = tell
        self._made: _Made | None = None
        self.latest = Latest(session, "cpm-slices", tr("drawing a slice"))
        self.latest.done.connect(self._take)

    def of(self, given: tuple[Any, ...], make: Callable[[], Any], meanwhile: Callable[[], Any]) -> Any:
        if self._made is None or not is_same(self._made.given, given):
            self._made = _Made(given, meanwhile(), False)
            self.latest.ask(lambda: _Made(given, make(), True))
        return self._made.part

    def _take(self, made: _Made) -> None:
        if self._made is not None and not self._made.whole and is_same(self._made.given, made.given):
            self._made = made
            self._tell()


class MadeLater(QObject):
    """Gives the newest parts of the slice of one view, each by its name."""

    completed = Signal()
    """A part that was asked for is whole now."""

    def __init__(self, session: SessionSignals) -> None:
        super().__init__(session)
        self._session = session
        self._parts: dict[str, _Newest] = {}

    def of(self, name: str, given: tuple[Any, ...], make: Callable[[], T], meanwhile: Callable[[], T]) -> T:
        """What is made of something, or at first what stands in its place meanwhile."""
        if name not in self._parts:
            self._parts[name] = _Newest(self._session, self.completed.emit)
        part: T = self._parts[name].of(given, make, meanwhile)
        return part

    def close(self) -> None:
        """End the threads."""
        for newest in self._parts.values():
            newest.latest.close()
