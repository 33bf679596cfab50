"""The scene between two steps: in a volume, particles flow to their new positions."""

from __future__ import annotations

import time
from dataclasses import replace
from math import inf

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal

from cpm_app.session.exchange.messages import Snapshot
from cpm_app.session.session import Session
from cpm_core.numerics import Array

_FLOW_INTERVAL = 25
"""Time between two pictures while particles flow [ms]."""

_MIN_FLOW_STEP = 0.04
"""Shortest time between two steps for which particles flow [s]; faster steps already look continuous."""

_MAX_FLOW_STEP = 0.6
"""Longest time between two steps for which particles flow [s]."""

_STEP_TIME_SLACK = 1.4
"""Duration of the flow, in durations of the last step, so that a slower step brings no halt."""


class ParticleFlow(QObject):
    """The scene of a session, in which the particles of a volume move on for as long as the last step took.

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
        self._timer = QTimer(self, interval=_FLOW_INTERVAL)
        self._timer.timeout.connect(self._update_scene)
        session.store.drawing_wanted.connect(self._on_scene_changed)

    def _on_scene_changed(self) -> None:
        before, self._newest = self._newest, self._session.scene.snapshot
        if self._newest is not before:
            self._pause, self._arrived = time.perf_counter() - self._arrived, time.perf_counter()
            shown = _MIN_FLOW_STEP < self._pause < _MAX_FLOW_STEP
            self._start = start_positions(before, self._newest) if shown else None
            if self._start is not None:
                self._timer.start()
        self._update_scene()

    def _update_scene(self) -> None:
        scene, way = self._session.scene, (time.perf_counter() - self._arrived) / (_STEP_TIME_SLACK * self._pause)
        if self._start is None or self._newest is None or way >= 1.0:
            self._start = None
            self._timer.stop()
        else:
            at = self._start + way * (self._newest.position - self._start)
            scene = replace(scene, snapshot=replace(self._newest, position=at))
        self.scene = scene
        self.changed.emit()


def start_positions(before: Snapshot | None, after: Snapshot | None) -> Array | None:
    """Find the positions of the particles of a volume one step earlier.

    Parameters
    ----------
    before, after : Snapshot or None
        Two snapshots of a run.

    Returns
    -------
    ndarray, shape (N, 3), or None
        A position (plane, row, col) [voxels] for each particle of `after`, that in `after` for new particles; None
        unless `after` directly follows `before` in the run of a volume.
    """
    if before is None or after is None or after.position.shape[1] != 3 or not len(before.position):
        return None
    if (after.generation, after.state.step) != (before.generation, before.state.step + 1):
        return None
    known, numbers = before.state.particles.identity, after.state.particles.identity
    order = np.argsort(known, kind="stable")  # they are nearly in order
    at = order[np.searchsorted(known, numbers, sorter=order).clip(max=len(order) - 1)]
    return np.where((known[at] == numbers)[:, None], before.position[at], after.position)
