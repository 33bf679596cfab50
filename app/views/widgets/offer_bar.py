"""A line above the image that offers something, with buttons to take it or not."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QSizePolicy, QToolButton

from app.model.text.language import tr
from app.views.theme.icons import icon
from app.views.theme.theme import Theme


class OfferBar(QFrame):
    """One sentence, buttons, and a cross that turns the offer down; it waits without a limit of time."""

    changed = Signal()
    """Something is offered, or no longer."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("offer")
        self._label = QLabel()
        self._label.setTextFormat(Qt.TextFormat.PlainText)
        self._label.setWordWrap(True)
        self._label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.buttons: list[QPushButton] = []
        self.cross = QToolButton()
        self.cross.setObjectName("quiet")
        self.cross.setAutoRaise(True)
        self.cross.setToolTip(tr("No, thank you"))
        self.cross.setAccessibleName(tr("No, thank you"))
        self.cross.clicked.connect(self.end)
        self._row = QHBoxLayout(self)
        self._row.setContentsMargins(12, 4, 6, 4)
        self._row.setSpacing(8)
        self._row.addWidget(self._label, 1)
        self._row.addWidget(self.cross)
        self.waiting = False
        """Whether something is offered that has not been answered."""
        self.hide()

    @property
    def text(self) -> str:
        """The offer, or empty."""
        return "" if self.isHidden() else self._label.text()

    def offer(self, sentence: str, *answers: tuple[str, Callable[[], object]]) -> None:
        """Offer something in place of what was offered before; each answer has a text and what it does."""
        self._label.setText(sentence)
        self._label.setToolTip(sentence)
        for button in self.buttons:
            self._row.removeWidget(button)
            button.deleteLater()
        self.buttons = [self._button(text, do) for text, do in answers]
        for place, button in enumerate(self.buttons, start=1):
            self._row.insertWidget(place, button)
        self.waiting = True
        self.show()
        self.changed.emit()

    def end(self) -> None:
        """Offer nothing any more."""
        self.waiting = False
        self.hide()
        self.changed.emit()

    def use_theme(self, theme: Theme) -> None:
        """Tint the cross."""
        self.cross.setIcon(icon("close", theme.text))

    def _button(self, text: str, do: Callable[[], object]) -> QPushButton:
        button = QPushButton(text)
        button.setAutoDefault(False)

        def take() -> None:
            self.end()
            do()

        button.clicked.connect(take)
        return button
