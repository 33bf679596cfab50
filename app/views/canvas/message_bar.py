"""The bar at the top of the canvas that shows errors and messages."""

from __future__ import annotations

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QSizePolicy, QToolButton, QWidget

from app.model.text.language import tr
from app.views.theme.icons import icon
from app.views.theme.theme import Theme

_SHOWN = 6000
"""Time after which a message disappears [ms]."""


class MessageBar(QFrame):
    """One sentence and a button to dismiss it, along the upper edge of `parent`; only errors stay."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self._label = QLabel()
        self._label.setWordWrap(True)
        self._label.setTextFormat(Qt.TextFormat.PlainText)
        self._label.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self._label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._button = QToolButton()
        self._button.setAutoRaise(True)
        self._button.setToolTip(tr("Dismiss (Esc)"))
        self._button.setAccessibleName(tr("Dismiss message"))
        self._button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self._button.clicked.connect(self.hide)
        self._above = parent
        self._row = QHBoxLayout(self)
        self._row.setContentsMargins(12, 6, 6, 6)
        self._row.addWidget(self._label)
        self._row.addWidget(self._button, alignment=Qt.AlignmentFlag.AlignTop)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.timeout.connect(self.hide)
        self._theme: Theme | None = None
        self.hide()

    @property
    def text(self) -> str:
        """The sentence shown, or empty."""
        return "" if self.isHidden() else self._label.text()

    def say(self, sentence: str, error: bool) -> None:
        """Show a sentence; it does not replace an error unless it is one."""
        if not error and not self.isHidden() and self.objectName() == "error":
            return
        self._label.setText(sentence)
        self.setObjectName("error" if error else "message")
        self.style().unpolish(self)
        self.style().polish(self)
        for child in (self._label, self._button):
            self.style().unpolish(child)
            self.style().polish(child)
        self._tint()
        self.place()
        self.show()
        self.raise_()
        if error:
            self._timer.stop()
        else:
            self._timer.start(_SHOWN)

    def place(self) -> None:
        """Place the bar along the upper edge of the parent."""
        width = self._above.width()
        self.resize(width, self._row.totalHeightForWidth(width))
        self.move(0, 0)

    def use_theme(self, theme: Theme) -> None:
        """Tint the button."""
        self._theme = theme
        self._tint()

    def _tint(self) -> None:
        if self._theme is not None:
            error = self.objectName() == "error"
            self._button.setIcon(icon("close", self._theme.error_text if error else self._theme.message_text))
