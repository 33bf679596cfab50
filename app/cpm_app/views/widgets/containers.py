"""Widgets that hold others or show a line of text, and claims to keys."""

from __future__ import annotations

from collections.abc import Container, Sequence
from typing import TypeVar

from PySide6.QtCore import QEvent, QObject, QSize, Qt, Signal
from PySide6.QtGui import QKeyEvent, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import (
    QBoxLayout,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QFrame,
    QHBoxLayout,
    QLabel,
    QLayout,
    QListWidget,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from cpm_app.model.text.language import tr
from cpm_app.views.theme.icons import load_icon
from cpm_core.numerics.types import Callback

Layout = TypeVar("Layout", bound=QBoxLayout)

_SCROLL_BAR_GAP = 5
"""Space between the content and the scroll bar [px]."""


def fill_layout(
    layout: Layout,
    *parts: QWidget | QLayout | None,
    margins: tuple[int, int, int, int] = (0, 0, 0, 0),
    spacing: int | None = None,
    wide: QWidget | None = None,
) -> Layout:
    """Fill a row or a column and return it; None is a stretch, `wide` the part that takes the remaining space."""
    layout.setContentsMargins(*margins)
    if spacing is not None:
        layout.setSpacing(spacing)
    for part in parts:
        if part is None:
            layout.addStretch(1)
        elif isinstance(part, QLayout):
            layout.addLayout(part)
        else:
            layout.addWidget(part, part is wide)
    return layout


def create_wrapped_label(text: str = "", dim: bool = False) -> QLabel:
    """Create a label that breaks lines, in a pale color if `dim`."""
    label = QLabel(text, wordWrap=True)
    label.setObjectName("dim" if dim else "")
    return label


def create_dim_label(text: str = "", tip: str = "") -> QLabel:
    """Create a label in a pale color."""
    label = QLabel(text)
    label.setObjectName("dim")
    label.setToolTip(tip)
    return label


def create_flat_button(text: str, tip: str, do: Callback) -> QToolButton:
    """Create a button without a frame; without a text, its tip is its accessible name."""
    button = QToolButton(autoRaise=True)
    button.setText(text)
    button.setToolTip(tip)
    button.setAccessibleName(text or tip)
    button.clicked.connect(lambda _=False: do())
    return button


class PageList(QListWidget):
    """List of the titles of the pages of a dialog; `name` is its accessible name."""

    def __init__(self, name: str, titles: Sequence[str]) -> None:
        super().__init__()
        self.setObjectName("contents")
        self.setAccessibleName(name)
        self.addItems(titles)
        self.setFixedWidth(self.sizeHintForColumn(0) + 40)


ENTER_KEYS = (Qt.Key.Key_Return, Qt.Key.Key_Enter)
"""The Enter keys of the main block and of the keypad."""

DELETE_KEYS = (Qt.Key.Key_Delete, Qt.Key.Key_Backspace)
"""Keys that delete the selection."""


class AcceptButtons(QDialogButtonBox):
    """Buttons of a dialog: one that accepts it, and Cancel."""

    def __init__(self, dialog: QDialog, text: str) -> None:
        super().__init__(QDialogButtonBox.StandardButton.Cancel)
        self.accept_button = self.addButton(text, QDialogButtonBox.ButtonRole.AcceptRole)
        self.accepted.connect(dialog.accept)
        self.rejected.connect(dialog.reject)


def lay_out_form(dialog: QDialog, heading: str, form: QFormLayout, buttons: AcceptButtons) -> None:
    """Fill a dialog with a sentence, a form, and the buttons."""
    form.setHorizontalSpacing(16)
    layout = QVBoxLayout(dialog)
    layout.setSpacing(12)
    layout.addWidget(QLabel(heading))
    layout.addLayout(form)
    layout.addWidget(buttons)


class VerticalScrollArea(QScrollArea):
    """Area that scrolls vertically, as wide as its content and at least `min_height` high [px]."""

    def __init__(self, content: QWidget, min_height: int) -> None:
        super().__init__()
        self._content, self._least = content, min_height
        self._wanted = (0, 0)
        content.setObjectName("scrolled")
        self.setWidget(content)
        content.setAutoFillBackground(False)
        self.viewport().setAutoFillBackground(False)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)

    def sizeHint(self) -> QSize:
        """Return the size of the content, with the scroll bar if it is needed."""
        content = self._content.sizeHint()
        return QSize(content.width() + self._scroll_bar_width(), content.height())

    def minimumSizeHint(self) -> QSize:
        """Return the minimum width of the content and the minimum height."""
        return QSize(self._content.minimumSizeHint().width() + self._scroll_bar_width(), self._least)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Make room for the scroll bar and a gap next to it, if they are needed."""
        super().resizeEvent(event)
        gap = _SCROLL_BAR_GAP if self._scroll_bar_width() else 0
        if self.viewportMargins().right() != gap:
            self.setViewportMargins(0, 0, gap, 0)
        if event.oldSize().height() != event.size().height():
            self.updateGeometry()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Tell the layout when the content needs another size, which scroll areas keep to themselves.

        Not with every request: each changed number would lay out and paint everything around it again.
        """
        if event.type() == QEvent.Type.LayoutRequest:
            before, self._wanted = self._wanted, (self.minimumSizeHint().width(), self.sizeHint().height())
            if self._wanted != before:
                self.updateGeometry()
        return super().eventFilter(watched, event)

    def _scroll_bar_width(self) -> int:
        """Return the width of the scroll bar and its gap, or 0 if it is not needed."""
        needed = self._content.minimumSizeHint().height() > self.height()
        return self.verticalScrollBar().sizeHint().width() + _SCROLL_BAR_GAP if needed else 0


class FoldButton(QToolButton):
    """Button that folds or unfolds something; folded at first."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("fold")
        self.setCheckable(True)
        self.toggled.connect(self._turn_arrow)
        self._turn_arrow(False)

    def _turn_arrow(self, unfolded: bool) -> None:
        self.setArrowType(Qt.ArrowType.DownArrow if unfolded else Qt.ArrowType.RightArrow)


class FoldableSection(QWidget):
    """Heading and content that is folded away until the user unfolds it."""

    def __init__(self, title: str, content: QWidget) -> None:
        super().__init__()
        self.fold = FoldButton()
        self.fold.setText(title)
        self.fold.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.fold.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.fold.toggled.connect(content.setVisible)
        fill_layout(QVBoxLayout(self), self.fold, content, spacing=2)
        content.hide()


class ElidedLabel(QLabel):
    """Label that shows the first line of a text, with an ellipsis if there is more."""

    fits_changed = Signal()
    """The whole text fits now, or no longer fits."""

    def __init__(self) -> None:
        super().__init__()
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.fits = True

    def setText(self, text: str) -> None:
        """Show another text."""
        if text != self.text():
            super().setText(text)
            self._check_fit()

    def minimumSizeHint(self) -> QSize:
        """Return one line of any width."""
        return QSize(0, self.fontMetrics().height())

    def sizeHint(self) -> QSize:
        """Return the size of the first line."""
        return QSize(
            self.fontMetrics().horizontalAdvance(self.text().partition("\n")[0]) + 2, self.fontMetrics().height()
        )

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Check whether the text still fits."""
        super().resizeEvent(event)
        self._check_fit()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw what fits."""
        painter = QPainter(self)
        painter.setPen(self.palette().color(self.foregroundRole()))
        first, more, _ = self.text().partition("\n")
        box = self.contentsRect()
        shown = self.fontMetrics().elidedText(f"{first} …" if more else first, Qt.TextElideMode.ElideRight, box.width())
        painter.drawText(box, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, shown)
        painter.end()

    def _check_fit(self) -> None:
        text, before = self.text(), self.fits
        self.fits = "\n" not in text and self.fontMetrics().horizontalAdvance(text) <= self.contentsRect().width()
        if self.fits != before:
            self.fits_changed.emit()


class OfferBar(QFrame):
    """A sentence, buttons, and a cross that declines the offer; further offers wait in a queue."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("offer")
        self._label = QLabel(textFormat=Qt.TextFormat.PlainText, wordWrap=True)
        self._label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.buttons: list[QPushButton] = []
        self.cross = create_flat_button("", tr("No, thank you"), self.dismiss_offer)
        self.cross.setObjectName("quiet")
        self.cross.setIcon(load_icon("close"))
        row = QHBoxLayout(self)
        self._row = fill_layout(row, self._label, self.cross, margins=(12, 4, 6, 4), spacing=8, wide=self._label)
        self._offers: list[tuple[str, tuple[tuple[str, Callback], ...]]] = []
        self.hide()

    @property
    def text(self) -> str:
        """Offer that is shown, or empty."""
        return self._offers[0][0] if self._offers else ""

    def add_offer(self, sentence: str, *answers: tuple[str, Callback]) -> None:
        """Add an offer to the queue; each answer has a text and a function."""
        self._offers.append((sentence, answers))
        self._show_first_offer()

    def dismiss_offer(self) -> None:
        """Drop the offer that is shown, and show the next one."""
        self._offers = self._offers[1:]
        self._show_first_offer()

    def clear(self) -> None:
        """Drop all offers."""
        self._offers = []
        self._show_first_offer()

    def _show_first_offer(self) -> None:
        for button in self.buttons:
            self._row.removeWidget(button)
            button.deleteLater()
        sentence, answers = self._offers[0] if self._offers else ("", ())
        self._label.setText(sentence)
        self._label.setToolTip(sentence)
        self.buttons = [self._create_answer_button(text, do) for text, do in answers]
        for place, button in enumerate(self.buttons, start=1):
            self._row.insertWidget(place, button)
        self.setVisible(bool(self._offers))

    def _create_answer_button(self, text: str, do: Callback) -> QPushButton:
        button = QPushButton(text, autoDefault=False)

        def accept_offer() -> None:
            self.dismiss_offer()
            do()

        button.clicked.connect(accept_offer)
        return button


def claim_key(event: QEvent, keys: Container[int]) -> bool:
    """Claim an event if it is about one of a widget's own keys, so that the key is no shortcut of the window.

    Returns whether the event was claimed.
    """
    claimed = event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent) and event.key() in keys
    if claimed:
        event.accept()
    return claimed


_OWN_ESCAPE_PROPERTY = "own_escape"
"""Qt property of widgets that handle Escape themselves."""


def mark_own_escape(widget: QWidget) -> None:
    """Let a widget and the widgets inside it handle Escape; text fields inside it also handle Enter."""
    widget.setProperty(_OWN_ESCAPE_PROPERTY, True)


def has_own_escape(widget: QWidget) -> bool:
    """Return whether a widget or one of its ancestors handles Escape itself."""
    ancestor: QWidget | None = widget
    while ancestor is not None:
        if ancestor.property(_OWN_ESCAPE_PROPERTY):
            return True
        ancestor = ancestor.parentWidget()
    return False
