"""The panels leave the image its room, keep what the user has chosen, and can be used in small windows."""

from __future__ import annotations

from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QScrollArea

from app.session.storage.preferences import Preferences
from app.views.main_window import make_window
from app.views.window.bars import ToolPalette
from app.views.window.window import MainWindow

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


def test_the_image_has_its_room_in_a_window_of_1280_by_720(window, hand) -> None:
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


def test_what_is_unfolded_is_remembered(qtbot, workspace, window, hand) -> None:
    run = window.panels["run"]
    hand.qtbot.mouseClick(run.plots.fold, LEFT, pos=QPoint(8, 8))
    assert run.plot.isVisible()
    again = make_window(workspace, Preferences())
    qtbot.addWidget(again)
    assert again.panels["run"].unfolded == ["plots"]
    again.close()
