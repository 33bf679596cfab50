"""Tens of thousands of Qt calls and emissions do not crash the interpreter, as some releases of the bindings do."""

from __future__ import annotations

import sys

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QApplication, QLabel

CALLS = 50_000


class Emitter(QObject):
    """Emits objects, truths and nothing."""

    sent = Signal(object)
    told = Signal(str, bool)


def test_fifty_thousand_calls_and_emissions_neither_crash_nor_lose_references(qapp: QApplication, qtbot) -> None:
    label = QLabel()
    qtbot.addWidget(label)
    emitter, seen = Emitter(), []
    emitter.sent.connect(seen.append)
    emitter.told.connect(lambda text, trouble: seen.append(trouble))
    token = object()
    before = sys.getrefcount(token)
    for number in range(CALLS):
        label.setEnabled(number % 2 == 0)
        assert label.isEnabled() is (number % 2 == 0)
        label.setVisible(False)
        emitter.sent.emit(token if number % 3 else None)
        emitter.told.emit("said", number % 2 == 0)
        assert len(seen) == 2
        seen.clear()
    assert sys.getrefcount(token) == before
