"""The window leaves the image its room, has few entries and controls, and can be used when it is small."""

from __future__ import annotations

from cpm_app.session.storage.preferences import Preferences
from cpm_app.views.items.item import image_rectangle
from cpm_app.views.main_window import make_window
from cpm_app.views.widgets.actions import ActionButton
from cpm_app.views.window.bars import ToolPalette
from cpm_app.views.window.window import MainWindow
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QComboBox,
    QLineEdit,
    QMenu,
    QScrollArea,
    QScrollBar,
    QWidget,
)

ENTRIES, CONTROLS = 120, 70
LEFT = Qt.MouseButton.LeftButton
DECISIVE = ("beta", "ratio", "annealing", "reach", "weakest_edge")


def resized(window: MainWindow, hand, width: int, height: int) -> None:
    window.resize(width, height)
    hand.wait(lambda: (window.width(), window.height()) == (width, height))
    hand.qtbot.wait(1)  # the docks are fitted after Qt has laid them out


def seen_whole(widget) -> bool:
    return widget.visibleRegion().boundingRect() == widget.rect()


def test_the_parameters_that_decide_are_seen_without_scrolling(window, hand) -> None:
    resized(window, hand, 1280, 720)
    run = window.panels["run"]
    rows = run.parameters.rows
    hand.wait(lambda: all(seen_whole(rows[name]) for name in DECISIVE))
    assert run.status.mapTo(window, QPoint()).y() < rows["beta"].mapTo(window, QPoint()).y()
    assert not run.plot.isVisible()
    assert seen_whole(run.plots.fold)


def test_the_image_has_its_room_in_small_windows(ready, hand) -> None:
    picture = ready.canvas_area.views.geometry
    for width, height, share in ((1280, 720, 0.6), (960, 540, 0.57)):
        resized(ready, hand, width, height)
        hand.key(Qt.Key.Key_R)
        hand.wait_for_phase("ready")
        for _ in range(2):
            hand.wait(lambda share=share: picture().width() >= share * ready.width())
            hand.wait(lambda: picture().height() >= 0.65 * ready.height())
            hand.key(Qt.Key.Key_Space)
            hand.wait_for_phase("finished")


def test_in_a_window_of_800_by_500_everything_can_be_reached(ready, hand) -> None:
    resized(ready, hand, 800, 500)
    run = ready.panels["run"]
    run.parameters.more.fold.click()
    for row in run.parameters.rows.values():
        if row.isVisibleTo(run):
            run.ensureWidgetVisible(row)
            hand.wait(lambda row=row: seen_whole(row.slider) and seen_whole(row.number))
            assert row.slider.width() >= 60
    hand.key(Qt.Key.Key_Space)
    hand.wait_for_phase("finished")
    assert ready.panels["timeline"].view.width() >= 120
    assert all(map(seen_whole, ready.panels["timeline"].findChildren(ActionButton)))
    palette = ready.findChild(ToolPalette)
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
    assert again.panels["run"].unfolded_sections == ["plots"]
    again.close()


def test_the_image_is_fitted_again_after_the_window_is_resized_unless_the_user_has_zoomed(ready, hand) -> None:
    resized(ready, hand, 900, 600)
    whole, view = image_rectangle(hand.canvas.shape), hand.canvas.view
    for width, height in ((1280, 720), (800, 600)):
        resized(ready, hand, width, height)
        hand.wait(lambda: view.viewRect().contains(whole))
        seen = view.viewRect()
        assert min(seen.width() / whole.width(), seen.height() / whole.height()) < 1.2
    hand.key(Qt.Key.Key_Plus)
    hand.key(Qt.Key.Key_Plus)
    resized(ready, hand, 1000, 650)
    assert not view.viewRect().contains(whole)


def entries(menu: QMenu) -> list[str]:
    """The entries of a menu and of its submenus."""
    menu.aboutToShow.emit()
    found: list[str] = []
    for action in menu.actions():
        if not action.isSeparator():
            found.append(action.text())
            found += entries(action.menu()) if action.menu() else []
    return found


def test_menus_and_controls_are_few_at_the_first_start(window, hand) -> None:
    resized(window, hand, 1280, 720)
    assert sum(len(entries(action.menu())) for action in window.menuBar().actions()) <= ENTRIES
    kinds = QAbstractButton, QAbstractSlider, QAbstractSpinBox, QComboBox, QLineEdit, QAbstractItemView
    parts = QAbstractSpinBox, QComboBox
    for key in (Qt.Key.Key_C, Qt.Key.Key_W, Qt.Key.Key_F8):
        hand.key(key)
        shown = [one for one in window.findChildren(QWidget) if isinstance(one, kinds) and one.isVisible()]
        controls = [one for one in shown if not isinstance(one, QScrollBar) and not isinstance(one.parent(), parts)]
        assert len(controls) <= CONTROLS
