"""Bars of the window: frequent actions, tools, and background tasks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from typing import cast

from PySide6.QtCore import QSize, Qt, QTimer
from PySide6.QtGui import QAction, QContextMenuEvent, QFontMetrics, QResizeEvent
from PySide6.QtWidgets import (
    QHBoxLayout,
    QLabel,
    QMenu,
    QProgressBar,
    QSizePolicy,
    QToolBar,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from cpm_app.model.document.modes import MODES
from cpm_app.model.state.situation import format_remaining_time
from cpm_app.model.text.language import tr
from cpm_app.session.tasks.tasks import BackgroundTask, TaskManager
from cpm_app.views.theme.icons import load_icon
from cpm_app.views.tools import AUTO_GROUP, TOOLS_BY_GROUP
from cpm_app.views.widgets.actions import PRIMARY_ACTION, Actions
from cpm_app.views.widgets.containers import VerticalScrollArea, create_dim_label, create_flat_button, fill_layout
from cpm_core.shapes import SEEDING_KINDS

_FIRST_BAR_ACTIONS = ("open", "save", "", "undo", "redo")
"""Actions of the tool bar before the modes; an empty name is a separator."""

_RUN_BAR_ACTIONS = ("run", "step", "reset")
"""Actions of the tool bar between the modes and the speed control."""

_LAST_BAR_ACTIONS = ("", "fit", "export")
"""Actions of the tool bar after the speed control; an empty name is a separator."""

_ICON_ONLY_ACTIONS = ("undo", "redo", "fit")
"""Actions whose buttons need no text."""


class ToolBar(QToolBar):
    """Buttons of the most frequent actions, without text if the window is narrow, and the speed control."""

    def __init__(self, actions: Actions, speed: QWidget) -> None:
        super().__init__(tr("Run"))
        self.setObjectName("bar")
        self.setMovable(False)
        self.toggleViewAction().setEnabled(False)
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self._text_buttons: list[QToolButton] = []
        self._shows_text, self._width_with_text = True, 0
        self._add_actions(actions, _FIRST_BAR_ACTIONS)
        self.addWidget(_create_mode_buttons(actions))
        self._add_actions(actions, _RUN_BAR_ACTIONS)
        self.addWidget(speed)
        self._add_actions(actions, _LAST_BAR_ACTIONS)

    def _add_actions(self, actions: Actions, names: Iterable[str]) -> None:
        for name in names:
            if not name:
                self.addSeparator()
                continue
            action = actions[name]
            self.addAction(action)
            button = cast("QToolButton", self.widgetForAction(action))
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.setObjectName("primary" if name == PRIMARY_ACTION else name)
            if name in _ICON_ONLY_ACTIONS:
                button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
                button.setAccessibleName(action.iconText())
            elif name != PRIMARY_ACTION:
                self._text_buttons.append(button)
            if name == PRIMARY_ACTION:
                bold = button.font()
                bold.setBold(True)
                button.setMinimumWidth(QFontMetrics(bold).horizontalAdvance(tr("Run again")) + 52)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Show the texts of the buttons if there is room for them."""
        super().resizeEvent(event)
        if self._shows_text:
            self._width_with_text = self.sizeHint().width()
        words, style = self.width() >= self._width_with_text, Qt.ToolButtonStyle
        if words != self._shows_text:
            self._shows_text = words
            for button in self._text_buttons:
                button.setToolButtonStyle(style.ToolButtonTextBesideIcon if words else style.ToolButtonIconOnly)


def _create_mode_buttons(actions: Actions) -> QWidget:
    """Create the buttons of the modes, side by side as one segmented control."""
    segments = QWidget()
    segments.setObjectName("segments")
    row = fill_layout(QHBoxLayout(segments), margins=(6, 0, 6, 0), spacing=0)
    for mode, place in zip(MODES, ("first", "middle", "middle", "last"), strict=True):
        name = f"mode_{mode}"
        button = QToolButton(toolButtonStyle=Qt.ToolButtonStyle.ToolButtonTextOnly)
        button.setDefaultAction(actions[name])
        button.setProperty("segment", place)
        button.setObjectName(name)
        row.addWidget(button)
    return segments


_TOOL_BUTTON_WIDTH = 80
"""Smallest width of a button [px]."""

_TOOL_BUTTON_MARGIN = 22
"""Space beside the word of a button, with the arrow of its menu [px]."""


class ToolPalette(QToolBar):
    """One button for each group of tools, and one for the starts that need no drawing."""

    def __init__(self, actions: Actions) -> None:
        super().__init__(tr("Tools"))
        self.setObjectName("palette")
        self.setMovable(False)
        self.toggleViewAction().setEnabled(False)
        self.setIconSize(QSize(20, 20))
        names = {group: [tool.name for tool in tools] for group, tools in TOOLS_BY_GROUP.items()}
        names[AUTO_GROUP] = [f"start_{kind}" for kind in SEEDING_KINDS]
        self.buttons = {group: ToolButton(group, [actions[name] for name in named]) for group, named in names.items()}
        self.buttons[AUTO_GROUP].setProperty("start", True)  # its check mark is no tool in use
        column = QWidget()
        longest = max(map(self.fontMetrics().horizontalAdvance, names))
        for button in self.buttons.values():
            button.setIconSize(self.iconSize())
            button.setFixedWidth(max(_TOOL_BUTTON_WIDTH, longest + _TOOL_BUTTON_MARGIN))
        fill_layout(QVBoxLayout(column), *self.buttons.values(), None, spacing=0)
        scrolled = VerticalScrollArea(column, 100)
        scrolled.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Expanding)
        self.addWidget(scrolled)


class ToolButton(QToolButton):
    """Button of the action of a group that was used last; the arrow and a right click open a menu of all."""

    def __init__(self, group: str, actions: Sequence[QAction]) -> None:
        super().__init__()
        self.setObjectName("tools")
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
        self.setPopupMode(QToolButton.ToolButtonPopupMode.MenuButtonPopup)
        self.setAutoRaise(True)
        menu = QMenu(self, toolTipsVisible=True)
        menu.addActions(actions)
        self.setMenu(menu)
        actions[0].setIconText(group)
        self.setDefaultAction(actions[0])
        for action in actions:
            action.triggered.connect(partial(self.setDefaultAction, action))
            action.visibleChanged.connect(self._on_visibility_changed)

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        """Open the menu."""
        self.showMenu()

    def _on_visibility_changed(self) -> None:
        """Show a visible action, or hide the button if there is none."""
        shown = [action for action in self.menu().actions() if action.isVisible()]
        self.setVisible(bool(shown))
        if shown and not self.defaultAction().isVisible():
            self.setDefaultAction(shown[0])


TASK_SHOWN_AFTER = 0.3
"""Time after which a task is shown, so that short tasks do not flicker [s]."""

_PROGRESS_BAR_WIDTH = 140
"""Width of the progress bar [px]."""

_PROGRESS_BAR_MAXIMUM = 1000
"""Value of the progress bar when a task is done."""


class TaskBar(QWidget):
    """Progress of the oldest running task; hidden while none is running."""

    def __init__(self, tasks: TaskManager) -> None:
        super().__init__()
        self._tasks = tasks
        self._task: BackgroundTask | None = None
        self._name = QLabel()
        self._remaining_label = create_dim_label()
        self._bar = QProgressBar(textVisible=False)
        self._bar.setFixedWidth(_PROGRESS_BAR_WIDTH)
        self._bar.setMaximumHeight(self.fontMetrics().height())
        self._button = create_flat_button(tr("Cancel"), "", self.cancel)
        self._button.setIcon(load_icon("close"))
        parts = self._name, self._bar, self._remaining_label, self._button
        fill_layout(QHBoxLayout(self), *parts, margins=(6, 0, 6, 0), spacing=8)
        self._show_timer = QTimer(self, singleShot=True)
        self._show_timer.timeout.connect(self._show_task)
        tasks.changed.connect(self._show_task)
        tasks.advanced.connect(self._show_task)
        self.hide()

    @property
    def text(self) -> str:
        """Text that is shown, or empty."""
        return "" if self.isHidden() else f"{self._name.text()} {self._remaining_label.text()}".strip()

    def cancel(self) -> None:
        """Cancel the task that is shown, or the next one that will be."""
        task = self._task or next((task for task in self._tasks.current if task.cancellable), None)
        if task is not None:
            task.cancel()
            self._tasks.announce_changes()

    def _show_task(self) -> None:
        current = self._tasks.current
        self._task = next((task for task in current if task.seconds >= TASK_SHOWN_AFTER), None)
        if self._task is None:
            self.hide()
            if current:
                self._show_timer.start(int(1000 * TASK_SHOWN_AFTER))
            return
        task, others = self._task, len(current) - 1
        more = tr("{name} (and {others} more)", name=task.name, others=others)
        self._name.setText(more if others else task.name)
        self._remaining_label.setText(format_remaining_time(task.seconds_left))
        self._remaining_label.setVisible(bool(self._remaining_label.text()))
        self._button.setVisible(task.cancellable)
        self._button.setToolTip(tr("Cancel: {name}", name=task.name))
        self.setToolTip("\n".join(each.name for each in current))
        self._bar.setMaximum(0 if task.fraction is None else _PROGRESS_BAR_MAXIMUM)
        if task.fraction is not None:
            self._bar.setValue(round(_PROGRESS_BAR_MAXIMUM * task.fraction))
        self.show()
