"""What a window takes: memory of the process, and Qt's objects by class.

Python's objects are not listed: whoever lists them holds a tuple that another thread still makes, which then fails.
"""

from __future__ import annotations

import ctypes
import gc
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from cpm_app.session.worker.worker_thread import release_free_memory
from PySide6.QtCore import QCoreApplication, QEvent, QObject
from PySide6.QtGui import QPixmapCache
from PySide6.QtWidgets import QApplication

MIB = 2**20

MOST_MORE = 0.01
"""What the last quarter may take more than the third, of memory and of Qt objects, as a fraction."""


@dataclass(frozen=True)
class Taken:
    """What is taken at one moment, when nothing is going on.

    Parameters
    ----------
    resident : float
        Memory of the process [MiB].
    qt : Counter of str
        Qt objects by class that hang on windows that exist.
    """

    resident: float
    qt: Counter[str]

    @property
    def qt_objects(self) -> int:
        """Number of Qt objects."""
        return self.qt.total()


class _Allocation(ctypes.Structure):
    """What `mallinfo2` returns."""

    _fields_ = tuple(
        (name, ctypes.c_size_t)
        for name in (
            "arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks", "fordblks", "keepcost",
        )
    )  # fmt: skip


def resident() -> float:
    """Memory of the process [MiB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / MIB


def allocated() -> int:
    """Memory in use among what the C library of GNU has given out [bytes]."""
    library = ctypes.CDLL(None)
    library.mallinfo2.restype = _Allocation
    now = library.mallinfo2()
    return int(now.uordblks + now.hblkhd)


def quarters(measured: Sequence[Taken]) -> list[Taken]:
    """The measurement of each quarter of the time that takes the memory in the middle; none if there are too few."""
    count = len(measured)
    parts = [measured[count * part // 4 : count * (part + 1) // 4] for part in range(4)]
    return [sorted(part, key=lambda mark: mark.resident)[len(part) // 2] for part in parts] if all(parts) else []


def still_rising(marks: Sequence[Taken]) -> list[str]:
    """Say what has not leveled off: the last quarter takes no more than a little more than the third.

    In the first half much is done for the first time, and what it needs is made and kept.
    """
    if not marks:
        return []
    before, last = marks[2], marks[3]
    rising = []
    if last.resident > before.resident * (1.0 + MOST_MORE):
        rising.append(f"the memory still rises, from {before.resident:.0f} to {last.resident:.0f} MiB")
    if last.qt_objects > before.qt_objects * (1.0 + MOST_MORE):
        rising.append(f"Qt objects become more, from {before.qt_objects} to {last.qt_objects}: {last.qt - before.qt}")
    return rising


def taken() -> Taken:
    """Collect garbage, empty the cache of drawn pictures, which has a limit of its own, and measure."""
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    gc.collect()
    QPixmapCache.clear()
    release_free_memory()
    qt: Counter[str] = Counter()
    for top in QApplication.topLevelWidgets():
        if top.parent() is None:
            qt.update(each.metaObject().className() for each in (top, *top.findChildren(QObject)))
    return Taken(resident(), qt)
