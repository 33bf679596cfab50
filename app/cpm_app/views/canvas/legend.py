"""The line below the image: a message or what to do next, and the legend of lines and dots on the canvas."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import QSize, Qt, QTimer, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QSizePolicy, QToolButton, QWidget

from cpm_app.model.text.language import tr, written
from cpm_app.views.canvas.message_line import MessageLine
from cpm_app.views.layers.layer import LegendEntry
from cpm_app.views.theme import theme
from cpm_app.views.theme.theme import look
from cpm_app.views.widgets.containers import ElidedLabel, arrange

_EVERY = 150
"""Least time between two updates [ms]: the numbers of particles change in every frame."""

_SIGNS = {"line": "━━", "dashed": "╍╍", "dot": "●", "check": "✔", "area": "■"}

_PAD = 10
_SENTENCE = 0.55
"""Part of the width that a sentence may claim before the legend is shortened."""


class Legend(QWidget):
    """A sign, a number and a word for each kind of thing on the canvas; it can be folded away.

    `entries` returns what there is. Where there is not enough room, only signs and numbers are shown; the tool tip
    has the words.
    """

    folded_changed = Signal(bool)
    """It has been folded or unfolded."""
    width_changed = Signal()
    """It needs more or less space than before."""

    def __init__(self, entries: Callable[[], Sequence[LegendEntry]]) -> None:
        super().__init__()
        self._read = entries
        self.entries: tuple[LegendEntry, ...] = ()
        """What is shown."""
        self.folded = False
        self._label = QLabel(textFormat=Qt.TextFormat.RichText)
        self.button = QToolButton()
        self.button.setObjectName("fold")
        self.button.setText(tr("Legend"))
        self.button.setToolTip(tr("Show or hide what the lines and dots mean."))
        self.button.clicked.connect(lambda: self.fold(not self.folded))
        arrange(QHBoxLayout(self), self._label, self.button, margins=(6, 0, 6, 0))
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self._timer = QTimer(self, singleShot=True, interval=_EVERY)
        self._timer.timeout.connect(self.show_now)
        self.fold(False)
        self.hide()

    def refresh(self) -> None:
        """Show what has changed, soon."""
        if not self._timer.isActive():
            self._timer.start()

    def show_now(self) -> None:
        """Show what there is."""
        entries = tuple(entry for entry in self._read() if entry.count)
        if entries != self.entries:
            self.entries = entries
            self._label.setToolTip(
                "<br>".join(f"{written(f'{entry.count:,}')} {entry.text}: {entry.tip}" for entry in entries)
            )
            self.setVisible(bool(entries))
            self.width_changed.emit()

    def fold(self, folded: bool) -> None:
        """Hide or show all but the button."""
        changed, self.folded = folded != self.folded, folded
        style = Qt.ToolButtonStyle
        self.button.setToolButtonStyle(style.ToolButtonTextBesideIcon if folded else style.ToolButtonIconOnly)
        self.button.setArrowType(Qt.ArrowType.LeftArrow if folded else Qt.ArrowType.RightArrow)
        self.button.setAccessibleName(tr("Show the legend") if folded else tr("Hide the legend"))
        self._label.setHidden(folded)
        if changed:
            self.folded_changed.emit(folded)
            self.width_changed.emit()

    def fit(self, width: int) -> None:
        """Show words only where they fit in a width [px]."""
        self._label.setText(self._text(short=False))
        if self.sizeHint().width() > width:
            self._label.setText(self._text(short=True))

    def _text(self, *, short: bool) -> str:
        """Each sign is on the color of the canvas, so that it looks as it does there."""
        return "&nbsp; ".join(
            f"<span style='color:{look().color(entry.color)}; background-color:{theme.CANVAS}'>"
            f"&nbsp;{_SIGNS[entry.sign]}&nbsp;</span>&nbsp;{written(f'{entry.count:,}')}"
            + ("" if short else f"&nbsp;{entry.text.replace(' ', '&nbsp;')}")
            for entry in self.entries
        )


class Strip(QFrame):
    """Of one height, whatever it shows, so that the image never moves; `entries` returns what the legend shows."""

    def __init__(self, entries: Callable[[], Sequence[LegendEntry]]) -> None:
        super().__init__()
        self.setObjectName("strip")
        self.messages = MessageLine()
        self.hint = ElidedLabel()
        self.hint.setObjectName("hint")
        self.hint.setContentsMargins(_PAD, 0, 0, 0)
        self.legend = Legend(entries)
        self.setFixedHeight(self.fontMetrics().height() + _PAD)
        row = arrange(QHBoxLayout(self), self.messages, self.hint, self.legend, spacing=8, wide=self.messages)
        row.setStretchFactor(self.hint, 1)
        self.messages.shown_changed.connect(self._share)
        self.legend.width_changed.connect(self._share)

    def say_next(self, text: str) -> None:
        """Show what to do next, unless there is a message."""
        if text != self.hint.text():
            self.hint.setText(text)
            self.hint.setToolTip(text)
            self._share()

    def minimumSizeHint(self) -> QSize:
        """No width: a legend that grows during a run must not make the window wider than the screen."""
        return QSize(0, super().minimumSizeHint().height())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Share the width anew."""
        super().resizeEvent(event)
        self._share()

    def _share(self) -> None:
        """Give the sentence what it needs, up to a part of the width, and the rest to the legend."""
        said = bool(self.messages.text)
        self.hint.setVisible(not said)
        wanted = self.messages.sizeHint().width() if said else self.hint.sizeHint().width() + _PAD
        self.legend.fit(self.width() - min(wanted, round(_SENTENCE * self.width())) - _PAD)
