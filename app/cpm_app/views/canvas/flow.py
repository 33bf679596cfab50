"""The scene between two steps: in a volume, particles flow to where a step has brought them."""

from __future__ import annotations

import time
from dataclasses import replace
from math import inf

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal

from cpm_app.session.exchange.messages import Snapshot
from cpm_app.session.session import Session
from cpm_core.numerics import Array

_BETWEEN = 25
"""Time from one picture to the next while particles flow [ms]."""

_STEP_SHOWN, _SLACK = (0.04, 0.6), 1.4
"""Time between two steps from which, and up to which, pictures show particles on the way between them [s], and how much
longer than the last step the next one may take without a halt."""


class Flow(QObject):
    """The scene of a session, with the particles of a volume on their way for as long as the step took.

    All views of a volume draw this scene, so that they show the same moment.
    """

    changed = Signal()
    """There is another scene."""

    def __init__(self, session: Session, parent: QObject) -> None:
        super().__init__(parent)
        self._session, self.scene = session, session.scene
        self._newest: Snapshot | None = None
        self._start: Array | None = None
        self._arrived, self._pause = 0.0, inf
        self._timer = QTimer(self, interval=_BETWEEN)
        self._timer.timeout.connect(self._show)
        session.scene_changed.connect(self._follow)

    def _follow(self) -> None:
        before, self._newest = self._newest, self._session.scene.snapshot
        if self._newest is not before:
            self._pause, self._arrived = time.perf_counter() - self._arrived, time.perf_counter()
            shown = _STEP_SHOWN[0] < self._pause < _STEP_SHOWN[1]
            self._start = start(before, self._newest) if shown else None
            if self._start is not None:
                self._timer.start()
        self._show()

    def _show(self) -> None:
        scene, way = self._session.scene, (time.perf_counter() - self._arrived) / (_SLACK * self._pause)
        if self._start is None or self._newest is None or way >= 1.0:
            self._start = None
            self._timer.stop()
        else:
            at = self._start + way * (self._newest.position - self._start)
            scene = replace(scene, snapshot=replace(self._newest, position=at))
        self.scene = scene
        self.changed.emit()


def start(before: Snapshot | None, after: Snapshot | None) -> Array | None:
    """Where the particles of a volume were a step before, new ones where they are; None for another step."""
    if before is None or after is None or after.position.shape[1] != 3 or not len(before.position):
        return None
    if (after.generation, after.state.step) != (before.generation, before.state.step + 1):
        return None
    known, numbers = before.state.particles.identity, after.state.particles.identity
    order = np.argsort(known, kind="stable")  # they are nearly in order
    at = order[np.searchsorted(known, numbers, sorter=order).clip(max=len(order) - 1)]
    return np.where((known[at] == numbers)[:, None], before.position[at], after.position)
