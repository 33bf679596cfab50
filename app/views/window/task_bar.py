"""Long tasks in the status bar: name, progress, remaining time, and a button to cancel."""

from __future__ import annotations

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QHBoxLayout, QLabel, QProgressBar, QToolButton, QWidget

from app.model.state.situation import in_words
from app.model.text.language import tr
from app.session.tasks.tasks import Task, Tasks
from app.views.theme.icons import icon
from app.views.theme.theme import Theme

SHOWN_AFTER = 0.3
"""Time after which a task is shown, so that short tasks do not flicker [s]."""

_WIDTH = 140
_FULL = 1000


class TaskBar(QWidget):
    """Shows the oldest running task, and is hidden while none is running."""

    def __init__(self, tasks: Tasks) -> None:
        super().__init__()
        self._tasks = tasks
        self._task: Task | None = None
        self._name = QLabel()
        self._left = QLabel()
        self._left.setObjectName("dim")
        self._bar = QProgressBar()
        self._bar.setFixedWidth(_WIDTH)
        self._bar.setMaximumHeight(self.fontMetrics().height())
        self._bar.setTextVisible(False)
        self._button = QToolButton()
        self._button.setAutoRaise(True)
        self._button.setText(tr("Cancel"))
        self._button.setAccessibleName(tr("Cancel"))
        self._button.clicked.connect(self.cancel)
        row = QHBoxLayout(self)
        row.setContentsMargins(6, 0, 6, 0)
        row.setSpacing(8)
        for widget in (self._name, self._bar, self._left, self._button):
            row.addWidget(widget)
        self._later = QTimer(self)
        self._later.setSingleShot(True)
        self._later.timeout.connect(self._show)
        tasks.changed.connect(self._show)
        tasks.advanced.connect(self._show)
        self.hide()

    @property
    def text(self) -> str:
        """The text shown, or empty."""
        return "" if self.isHidden() else f"{self._name.text()} {self._left.text()}".strip()

    def cancel(self) -> None:
        """Cancel the task shown, or the first one that will be shown."""
        shown = self._task
        task = shown or next((task for task in self._tasks.current if task.cancellable), None)
        if task is not None:
            task.cancel()
            self._tasks.look()

    def use_theme(self, theme: Theme) -> None:
        """Tint the button."""
        self._button.setIcon(icon("close", theme.text))

    def _show(self) -> None:
        current = self._tasks.current
        self._task = next((task for task in current if task.seconds >= SHOWN_AFTER), None)
        if self._task is None:
            self.hide()
            if current:
                self._later.start(int(1000 * SHOWN_AFTER))
            return
        task, others = self._task, len(current) - 1
        more = tr("{name} (and {others} more)").format(name=task.name, others=others)
        _set(self._name, more if others else task.name)
        _set(self._left, in_words(task.seconds_left))
        self._left.setVisible(bool(self._left.text()))
        self._button.setVisible(task.cancellable)
        self._button.setToolTip(tr("Cancel: {name}").format(name=task.name))
        self.setToolTip("\n".join(each.name for each in current))
        self._bar.setMaximum(0 if task.fraction is None else _FULL)
        if task.fraction is not None:
            self._bar.setValue(round(_FULL * task.fraction))
        self.show()


def _set(label: QLabel, text: str) -> None:
    if label.text() != text:
        label.setText(text)
