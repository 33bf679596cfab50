"""What a window takes: memory of the process, Python's objects, and Qt's by class."""

from __future__ import annotations

import gc
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QCoreApplication, QEvent, QObject
from PySide6.QtWidgets import QApplication

MIB = 2**20

MOST_MORE, MOST_MORE_OBJECTS = 32.0, 0.1
"""What the last quarter may take more than the one before: memory [MiB], and Qt objects as a fraction."""


@dataclass(frozen=True)
class Taken:
    """What is taken at one moment, when nothing is going on.

    Parameters
    ----------
    resident : float
        Memory of the process [MiB].
    objects : int
        Objects that Python's garbage collection knows.
    qt : Counter of str
        Qt objects by class that hang on windows that exist.
    """

    resident: float
    objects: int
    qt: Counter[str]

    @property
    def qt_objects(self) -> int:
        """Number of Qt objects."""
        return self.qt.total()


def resident() -> float:
    """Memory of the process [MiB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / MIB


def quarters(measured: Sequence[Taken]) -> list[Taken]:
    """What was taken after each quarter of the time."""
    return [measured[max(len(measured) * part // 4 - 1, 0)] for part in range(1, 5)] if measured else []


def still_rising(marks: Sequence[Taken]) -> list[str]:
    """Say what has not leveled off: the last quarter adds no more than a little to the one before."""
    if not marks:
        return []
    before, last = marks[-2], marks[-1]
    rising = []
    if last.resident > before.resident + MOST_MORE:
        rising.append(f"the memory still rises, from {before.resident:.0f} to {last.resident:.0f} MiB")
    if last.qt_objects > before.qt_objects * (1.0 + MOST_MORE_OBJECTS):
        rising.append(f"Qt objects become more, from {before.qt_objects} to {last.qt_objects}: {last.qt - before.qt}")
    return rising


def taken() -> Taken:
    """Collect garbage, and measure."""
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    gc.collect()
    qt: Counter[str] = Counter()
    for top in QApplication.topLevelWidgets():
        if top.parent() is None:
            qt.update(each.metaObject().className() for each in (top, *top.findChildren(QObject)))
    return Taken(resident(), len(gc.get_objects()), qt)
