"""What has been closed is gone: nothing of it answers any more, and nothing of it is kept in memory."""

from __future__ import annotations

import gc
from collections import Counter

import pytest
from cpm_app.session.features.comparison import CURRENT_KEY
from PySide6.QtCore import QCoreApplication, QEvent, QTimer
from PySide6.QtWidgets import QApplication

pytestmark = pytest.mark.shared_window

OPENED = ("keys", "guide", "open_menu")
"""Actions that open a dialog, a menu, or another view of the image, and whose names do not say so by dots."""


def existing() -> Counter[str]:
    """Objects of the program by class, and widgets, when all that can be removed is removed."""
    QApplication.processEvents()
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    gc.collect()
    kinds = (type(each) for each in gc.get_objects())
    found = Counter(kind.__qualname__ for kind in kinds if str(kind.__module__).startswith("cpm_app.views"))
    return found + Counter({"widgets": len(QApplication.allWidgets())})


@pytest.fixture
def rested(ready, hand):
    """A window with a few steps of a run."""
    ready.session.step()
    hand.wait(lambda: ready.session.status.step == 1 and ready.session.idle)
    return ready


def opened_by(window) -> list[str]:
    """All actions that can open something now."""
    actions = dict(window.actions_by_name)
    asking = [name for name, action in actions.items() if action.text().endswith("…") and action.isEnabled()]
    assert len(asking) > 5
    return list(dict.fromkeys([*OPENED, *asking]))


def close_what_waits() -> None:
    """Close a dialog that holds the action until it is answered."""
    waiting = QApplication.activeModalWidget()
    if waiting is not None:
        waiting.close()


def open_and_close(window, name: str) -> None:
    action = window.actions_by_name[name]
    assert action.isEnabled(), name
    before = set(QApplication.topLevelWidgets())
    closing = QTimer(interval=0)
    closing.timeout.connect(close_what_waits)
    closing.start()
    action.trigger()
    QApplication.processEvents()
    closing.stop()
    if action.isCheckable():
        action.trigger()
    for opened in set(QApplication.topLevelWidgets()) - before:
        opened.close()
    QApplication.processEvents()


@pytest.mark.long
def test_a_closed_dialog_menu_or_view_is_not_kept(rested, hand) -> None:
    names = opened_by(rested)
    for name in names:
        open_and_close(rested, name)
    hand.wait(lambda: rested.session.idle)
    before = existing()
    for name in names:
        open_and_close(rested, name)
        hand.wait(lambda: rested.session.idle)
        assert existing() <= before, name


def test_a_divider_that_is_gone_follows_no_layer(rested, hand) -> None:
    compared = rested.workspace.comparison
    compared.select_row(max(compared.rows))
    compared.select_row(CURRENT_KEY)
    existing()
    for layer in hand.canvas.layers:
        layer.set_opacity(0.5)
        layer.set_shown(not layer.shown)
    assert {layer.opacity for layer in hand.canvas.layers} == {0.5}
