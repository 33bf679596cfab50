"""The panels leave the image its room, keep what the user has chosen, and can be used in small windows."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QCoreApplication, QPoint, Qt
from PySide6.QtWidgets import QScrollArea, QToolButton

from app.session.storage.preferences import Preferences
from app.views.main_window import MainWindow
from app.views.widgets.containers import Scrolled
from app.views.window.bars import ToolPalette

LEFT = Qt.MouseButton.LeftButton
DECISIVE = ("reach", "weakest_edge", "beta", "ratio", "annealing")


def resized(window: MainWindow, hand, width: int, height: int) -> None:
    window.resize(width, height)
    hand.wait(lambda: (window.width(), window.height()) == (width, height))
    hand.qtbot.wait(1)  # the docks are fitted after Qt has laid them out


def seen_whole(widget) -> bool:
    return widget.visibleRegion().boundingRect() == widget.rect()


def test_the_parameters_that_decide_are_seen_without_scrolling(window, hand) -> None:
    resized(window, hand, 1400, 880)
    rows = window.panels["parameters"].rows
    hand.wait(lambda: all(seen_whole(rows[name]) for name in DECISIVE))
    run = window.panels["run"]
    assert run.status.mapTo(window, QPoint()).y() < rows["reach"].mapTo(window, QPoint()).y()
    assert not run.plot.isVisible()
    assert seen_whole(run.plots.fold)


def test_the_image_has_half_of_a_window_of_1280_by_720(window, hand) -> None:
    resized(window, hand, 1280, 720)
    canvas = window.canvas_area.canvas
    hand.wait(lambda: canvas.width() * canvas.height() >= 0.5 * 1280 * 720)


def test_in_a_window_of_800_by_500_everything_can_be_reached(window, hand) -> None:
    resized(window, hand, 800, 500)
    panel = window.panels["parameters"]
    panel.advanced.fold.click()
    (area,) = (area for area in panel.findChildren(QScrollArea) if area.widget().isAncestorOf(panel.rows["beta"]))
    for row in panel.rows.values():
        if row.isVisibleTo(panel):
            area.ensureWidgetVisible(row)
            hand.wait(lambda row=row: seen_whole(row.slider) and seen_whole(row.number))
            assert row.slider.width() >= 60
    assert window.panels["timeline"].view.width() >= 120
    assert seen_whole(window.panels["timeline"].branch)
    palette = window.findChild(ToolPalette)
    (tools,) = palette.findChildren(QScrollArea)
    for button in palette.buttons.values():
        tools.ensureWidgetVisible(button)
        assert seen_whole(button)


def test_the_explanation_keeps_its_form_while_plots_are_folded(window, hand) -> None:
    resized(window, hand, 1400, 880)
    explanation, run = window.panels["parameters"].explanation, window.panels["run"]
    height = explanation.height()
    assert explanation.isVisible()
    for fold in (run.plots.fold, run.status.section.fold, run.plots.fold):
        before = run.height()
        hand.qtbot.mouseClick(fold, LEFT, pos=QPoint(8, 8))
        hand.wait(lambda before=before: run.height() != before)
        assert explanation.isVisible()
        assert explanation.height() == height


def test_what_is_unfolded_is_remembered(qtbot, workspace, window, hand) -> None:
    run = window.panels["run"]
    hand.qtbot.mouseClick(run.plots.fold, LEFT, pos=QPoint(8, 8))
    assert run.plot.isVisible()
    again = MainWindow(workspace, Preferences())
    qtbot.addWidget(again)
    assert again.panels["run"].unfolded == ["plots"]
    again.close()


@pytest.fixture
def tabbed(window, hand):
    """A window in which the table of contours has been opened beside the timeline."""
    resized(window, hand, 1280, 800)
    below = window.canvas_area.height()
    window.docks.reveal("contours")
    hand.wait(lambda: window.canvas_area.height() < below - 150)
    hand.wait(lambda: window.docks["contours"].height() == 250)
    return window


def test_each_panel_below_the_image_has_a_height_of_its_own(tabbed, hand) -> None:
    table = tabbed.docks["contours"].height()
    tabbed.docks.reveal("timeline")
    hand.wait(lambda: tabbed.docks["timeline"].height() < table / 2)
    tabbed.docks.reveal("contours")
    hand.wait(lambda: tabbed.docks["contours"].height() == table)
    tabbed.docks["contours"].close()
    hand.wait(lambda: tabbed.docks["timeline"].height() < table / 2)


def test_what_is_beside_a_low_table_scrolls_and_stands_clear_of_its_scroll_bar(tabbed, hand) -> None:
    beside = tabbed.panels["contours"].findChild(Scrolled)
    bar, content = beside.verticalScrollBar(), beside.widget()
    tabbed.resizeDocks([tabbed.docks["contours"]], [160], Qt.Orientation.Vertical)
    hand.wait(bar.isVisible)
    hand.wait(lambda: bar.mapTo(beside, QPoint()).x() >= content.mapTo(beside, QPoint(content.width() + 4, 0)).x())
    assert content.minimumSizeHint().width() <= content.width()


def test_a_height_that_was_dragged_is_kept_per_panel_and_forgotten_by_restore(tabbed, hand) -> None:
    dock, above = tabbed.docks["contours"], tabbed.canvas_area
    initial = dock.height()
    handle = QPoint(above.x() + 60, above.geometry().bottom() + 3)
    hand.qtbot.mousePress(tabbed, LEFT, pos=handle)
    for by in (10, 30, 50):
        hand.qtbot.mouseMove(tabbed, handle - QPoint(0, by))
        QCoreApplication.processEvents()
    hand.qtbot.mouseRelease(tabbed, LEFT, pos=handle - QPoint(0, 50))
    hand.wait(lambda: dock.height() > initial + 20)
    dragged = dock.height()
    tabbed.docks.reveal("timeline")
    hand.wait(lambda: tabbed.docks["timeline"].height() < initial / 2)
    tabbed.docks.reveal("contours")
    hand.wait(lambda: dock.height() == dragged)
    tabbed.docks.restore()
    tabbed.docks.reveal("contours")
    hand.wait(lambda: abs(dock.height() - initial) <= 30)


def test_the_heading_of_the_timeline_takes_no_height(window, hand) -> None:
    dock = window.docks["timeline"]
    hand.wait(lambda: dock.widget().height() == dock.height())
    close = next(button for button in dock.titleBarWidget().findChildren(QToolButton) if "Close" in button.toolTip())
    hand.qtbot.mouseClick(close, LEFT)
    assert dock.isHidden()
