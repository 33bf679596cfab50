"""Widgets that hold others or show a line of text, and those that handle Escape themselves."""

from __future__ import annotations

from collections.abc import Container, Sequence
from typing import TypeVar

from PySide6.QtCore import QEvent, QObject, QSize, Qt, Signal
from PySide6.QtGui import QIcon, QKeyEvent, QPainter, QPaintEvent, QPixmap, QResizeEvent
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
    QListWidgetItem,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from cpm_app.model.text.language import tr
from cpm_app.views.theme.icons import icon
from cpm_app.views.theme.theme import Theme
from cpm_core.numerics.types import Callback

Layout = TypeVar("Layout", bound=QBoxLayout)

_GAP = 5
"""Between the content and the scroll bar [px]."""


def arrange(
    layout: Layout,
    *parts: QWidget | QLayout | None,
    margins: tuple[int, int, int, int] = (0, 0, 0, 0),
    spacing: int | None = None,
    wide: QWidget | None = None,
) -> Layout:
    """Fill a row or a column, and return it; None is free room, `wide` the part that takes what remains."""
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


def wrapped(text: str = "", dim: bool = False) -> QLabel:
    """A label that breaks lines, in a pale color if `dim`."""
    label = QLabel(text, wordWrap=True)
    label.setObjectName("dim" if dim else "")
    return label


def dim_label(text: str = "", tip: str = "") -> QLabel:
    """A label in a pale color."""
    label = QLabel(text)
    label.setObjectName("dim")
    label.setToolTip(tip)
    return label


def flat_button(text: str, tip: str, do: Callback) -> QToolButton:
    """A button without a frame; one without a text is called by its tip."""
    button = QToolButton(autoRaise=True)
    button.setText(text)
    button.setToolTip(tip)
    button.setAccessibleName(text or tip)
    button.clicked.connect(lambda _=False: do())
    return button


class Contents(QListWidget):
    """The titles of the pages of a dialog; `name` says of what."""

    def __init__(self, name: str, titles: Sequence[str]) -> None:
        super().__init__()
        self.setObjectName("contents")
        self.setAccessibleName(name)
        self.addItems(titles)
        self.setFixedWidth(self.sizeHintForColumn(0) + 40)


ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)


class AcceptButtons(QDialogButtonBox):
    """The buttons of a dialog: one that accepts it, and Cancel."""

    def __init__(self, dialog: QDialog, text: str) -> None:
        super().__init__(QDialogButtonBox.StandardButton.Cancel)
        self.accept_button = self.addButton(text, QDialogButtonBox.ButtonRole.AcceptRole)
        self.accepted.connect(dialog.accept)
        self.rejected.connect(dialog.reject)


def lay_out_form(dialog: QDialog, heading: str, form: QFormLayout, buttons: AcceptButtons) -> None:
    """Fill a dialog: a sentence, a form, and the buttons."""
    form.setHorizontalSpacing(16)
    layout = QVBoxLayout(dialog)
    layout.setSpacing(12)
    layout.addWidget(QLabel(heading))
    layout.addLayout(form)
    layout.addWidget(buttons)


class Scrolled(QScrollArea):
    """Scrolls its content up and down; it is as wide as that, and at least `least` high [px]."""

    def __init__(self, content: QWidget, least: int) -> None:
        super().__init__()
        self._content, self._least = content, least
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
        """The size of the content, with a scroll bar where it is needed."""
        content = self._content.sizeHint()
        return QSize(content.width() + self._bar(), content.height())

    def minimumSizeHint(self) -> QSize:
        """The least width of the content, and the given height."""
        return QSize(self._content.minimumSizeHint().width() + self._bar(), self._least)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Make room for the scroll bar and a gap next to it, or take it back."""
        super().resizeEvent(event)
        gap = _GAP if self._bar() else 0
        if self.viewportMargins().right() != gap:
            self.setViewportMargins(0, 0, gap, 0)
        if event.oldSize().height() != event.size().height():
            self.updateGeometry()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Pass on that the content wants another size, which scroll areas keep to themselves.

        With every other number in it, all that is around it would be laid out and painted again.
        """
        if event.type() == QEvent.Type.LayoutRequest:
            before, self._wanted = self._wanted, (self.minimumSizeHint().width(), self.sizeHint().height())
            if self._wanted != before:
                self.updateGeometry()
        return super().eventFilter(watched, event)

    def _bar(self) -> int:
        """Width of the scroll bar and its gap, 0 where there is none."""
        needed = self._content.minimumSizeHint().height() > self.height()
        return self.verticalScrollBar().sizeHint().width() + _GAP if needed else 0


class Fold(QToolButton):
    """The button that folds something away, as it is at first, or unfolds it."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("fold")
        self.setCheckable(True)
        self.toggled.connect(self._point)
        self._point(False)

    def _point(self, unfolded: bool) -> None:
        self.setArrowType(Qt.ArrowType.DownArrow if unfolded else Qt.ArrowType.RightArrow)


class Section(QWidget):
    """A heading and a content that is folded away until the user unfolds it."""

    def __init__(self, title: str, content: QWidget) -> None:
        super().__init__()
        self.fold = Fold()
        self.fold.setText(title)
        self.fold.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.fold.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.fold.toggled.connect(content.setVisible)
        arrange(QVBoxLayout(self), self.fold, content, spacing=2)
        content.hide()


class ElidedLabel(QLabel):
    """The first line of a text, with an ellipsis where there is more."""

    fits_changed = Signal()
    """The whole text fits now, or no longer."""

    def __init__(self) -> None:
        super().__init__()
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.fits = True

    def setText(self, text: str) -> None:
        """Show another text."""
        super().setText(text)
        self._follow()

    def minimumSizeHint(self) -> QSize:
        """One line, of any width."""
        return QSize(0, self.fontMetrics().height())

    def sizeHint(self) -> QSize:
        """Room for the first line."""
        return QSize(
            self.fontMetrics().horizontalAdvance(self.text().partition("\n")[0]) + 2, self.fontMetrics().height()
        )

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Look whether the text fits."""
        super().resizeEvent(event)
        self._follow()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw what fits."""
        painter = QPainter(self)
        painter.setPen(self.palette().color(self.foregroundRole()))
        first, more, _ = self.text().partition("\n")
        box = self.contentsRect()
        shown = self.fontMetrics().elidedText(f"{first} …" if more else first, Qt.TextElideMode.ElideRight, box.width())
        painter.drawText(box, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, shown)
        painter.end()

    def _follow(self) -> None:
        text, before = self.text(), self.fits
        self.fits = "\n" not in text and self.fontMetrics().horizontalAdvance(text) <= self.contentsRect().width()
        if self.fits != before:
            self.fits_changed.emit()


class OfferBar(QFrame):
    """One sentence, buttons, and a cross that turns the offer down; other offers wait behind it."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("offer")
        self._label = QLabel(textFormat=Qt.TextFormat.PlainText, wordWrap=True)
        self._label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.buttons: list[QPushButton] = []
        self.cross = flat_button("", tr("No, thank you"), self.end)
        self.cross.setObjectName("quiet")
        row = QHBoxLayout(self)
        self._row = arrange(row, self._label, self.cross, margins=(12, 4, 6, 4), spacing=8, wide=self._label)
        self._offers: list[tuple[str, tuple[tuple[str, Callback], ...]]] = []
        self.hide()

    @property
    def text(self) -> str:
        """The offer, or empty."""
        return self._offers[0][0] if self._offers else ""

    def offer(self, sentence: str, *answers: tuple[str, Callback]) -> None:
        """Offer something after what is offered already; each answer has a text and what it does."""
        self._offers.append((sentence, answers))
        self._show()

    def end(self) -> None:
        """Show the next offer in place of the one that is shown."""
        self._offers = self._offers[1:]
        self._show()

    def clear(self) -> None:
        """Offer nothing any more."""
        self._offers = []
        self._show()

    def use_theme(self, theme: Theme) -> None:
        """Tint the cross."""
        self.cross.setIcon(icon("close", theme.text))

    def _show(self) -> None:
        for button in self.buttons:
            self._row.removeWidget(button)
            button.deleteLater()
        sentence, answers = self._offers[0] if self._offers else ("", ())
        self._label.setText(sentence)
        self._label.setToolTip(sentence)
        self.buttons = [self._button(text, do) for text, do in answers]
        for place, button in enumerate(self.buttons, start=1):
            self._row.insertWidget(place, button)
        self.setVisible(bool(self._offers))

    def _button(self, text: str, do: Callback) -> QPushButton:
        button = QPushButton(text, autoDefault=False)

        def take() -> None:
            self.end()
            do()

        button.clicked.connect(take)
        return button


_CHOOSING = (*ENTER, Qt.Key.Key_Space)
_PLAIN = Qt.KeyboardModifier.NoModifier


class PictureGrid(QListWidget):
    """Pictures of one size in cells of another; arrow keys and the first letters of a name lead through them."""

    chosen = Signal(QListWidgetItem)
    """The user chooses a picture."""

    def __init__(self, picture: QSize, cell: QSize) -> None:
        super().__init__()
        self.setViewMode(QListWidget.ViewMode.IconMode)
        self.setMovement(QListWidget.Movement.Static)
        self.setResizeMode(QListWidget.ResizeMode.Adjust)
        self.setIconSize(picture)
        self.setGridSize(cell)
        self.setUniformItemSizes(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.itemClicked.connect(self.chosen)

    def add(self, picture: QPixmap, name: str, what: object, tip: str) -> None:
        """Add a picture of something."""
        icon = QIcon()
        # The picture is the same whether marked or not.
        icon.addPixmap(picture, QIcon.Mode.Normal)
        icon.addPixmap(picture, QIcon.Mode.Selected)
        item = QListWidgetItem(icon, name)
        item.setData(Qt.ItemDataRole.UserRole, what)
        item.setToolTip(tip)
        item.setTextAlignment(Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignBottom)
        self.addItem(item)

    def event(self, event: QEvent) -> bool:
        """Take plain keys before they act as shortcuts of the window."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent):
            plain = event.modifiers() in (_PLAIN, Qt.KeyboardModifier.ShiftModifier)
            if plain and (event.text() or event.key() in _CHOOSING):
                event.accept()
                return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Choose the marked picture on Enter or Space."""
        item = self.currentItem()
        if event.key() in _CHOOSING and item is not None:
            self.chosen.emit(item)
        else:
            super().keyPressEvent(event)


def takes_key(event: QEvent, keys: Container[int]) -> bool:
    """Whether one of a widget's own keys has been pressed, which is no shortcut of the window then."""
    taken = event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent) and event.key() in keys
    if taken:
        event.accept()
    return taken


_OWN = "own_escape"


def keep_escape(widget: QWidget) -> None:
    """Let a widget, and those in it, handle Escape; text fields in it handle Enter, too."""
    widget.setProperty(_OWN, True)


def has_own_escape(widget: QWidget) -> bool:
    """Whether a widget, or one around it, handles Escape itself."""
    around: QWidget | None = widget
    while around is not None:
        if around.property(_OWN):
            return True
        around = around.parentWidget()
    return False
