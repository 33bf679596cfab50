"""The line below the image: a message or what to do next, and the legend of lines and dots on the canvas."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import QPointF, QRectF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen, QResizeEvent
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QSizePolicy, QToolButton, QWidget

from app.model.text.language import tr, written
from app.views.canvas.layers.layer import LegendEntry
from app.views.canvas.message_line import FittingLabel, MessageLine
from app.views.theme import theme
from app.views.theme.theme import look

_SAMPLE = QSize(22, 14)
_EVERY = 150
"""Least time between two updates [ms]: the numbers of particles change in every frame."""

_GAP = 10


class Legend(QWidget):
    """One sample, number and word for each kind of thing on the canvas; it can be folded away.

    `entries` returns what there is. Where there is not enough room, only samples and numbers are shown; the tool tips
    have the words.
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
        self._short = False
        self._chips: list[_Chip] = []
        self.button = QToolButton()
        self.button.setObjectName("fold")
        self.button.setText(tr("Legend"))
        self.button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.button.setToolTip(tr("Show or hide what the lines and dots mean."))
        self.button.clicked.connect(lambda: self.fold(not self.folded))
        self._row = QHBoxLayout(self)
        self._row.setContentsMargins(6, 0, 6, 0)
        self._row.setSpacing(_GAP)
        self._row.addWidget(self.button)
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
        if entries == self.entries:
            return
        self.entries = entries
        for spare in self._chips[len(entries) :]:
            self._row.removeWidget(spare)
            spare.deleteLater()
        del self._chips[len(entries) :]
        while len(self._chips) < len(entries):
            chip = _Chip()
            self._chips.append(chip)
            self._row.insertWidget(len(self._chips) - 1, chip)
        for chip, entry in zip(self._chips, entries, strict=True):
            chip.show_entry(entry)
        self.setVisible(bool(entries))
        self._lay_out()
        self.width_changed.emit()

    def fold(self, folded: bool) -> None:
        """Hide or show all but the button."""
        changed, self.folded = folded != self.folded, folded
        self.button.setArrowType(Qt.ArrowType.LeftArrow if folded else Qt.ArrowType.RightArrow)
        self._lay_out()
        if changed:
            self.folded_changed.emit(folded)
            self.width_changed.emit()

    def fit(self, width: int) -> None:
        """Show words only where they fit in a width [px]."""
        short = not self.folded and self._width(short=False) > width
        if short != self._short:
            self._short = short
            self._lay_out()

    def _width(self, *, short: bool) -> int:
        """Width with words, or without them [px]."""
        chips = sum(chip.width_for(short) + _GAP for chip in self._chips)
        return chips + self.button.sizeHint().width() + 12

    def _lay_out(self) -> None:
        words = self.folded or not self._chips
        style = Qt.ToolButtonStyle
        self.button.setToolButtonStyle(style.ToolButtonTextBesideIcon if words else style.ToolButtonIconOnly)
        self.button.setAccessibleName(tr("Show the legend") if self.folded else tr("Hide the legend"))
        for chip in self._chips:
            chip.shorten(self._short)
            chip.setVisible(not self.folded)
        self.updateGeometry()


class _Chip(QWidget):
    """Sample, number and word of an entry."""

    def __init__(self) -> None:
        super().__init__()
        self._sample, self._label = Sample(), QLabel()
        self._short = False
        self._entry: LegendEntry | None = None
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(5)
        row.addWidget(self._sample)
        row.addWidget(self._label)

    def show_entry(self, entry: LegendEntry) -> None:
        """Show another entry."""
        self._entry = entry
        self._sample.entry = entry
        self._sample.update()
        self._write()

    def shorten(self, short: bool) -> None:
        """Show only the number, or the word too."""
        if short != self._short:
            self._short = short
            self._write()

    def width_for(self, short: bool) -> int:
        """Its width with the word, or without it [px]."""
        return _SAMPLE.width() + 5 + self._label.fontMetrics().horizontalAdvance(self._text(short))

    def _text(self, short: bool) -> str:
        entry = self._entry
        if entry is None:
            return ""
        return written(f"{entry.count:,}") if short else f"{written(f'{entry.count:,}')} {entry.text}"

    def _write(self) -> None:
        self._label.setText(self._text(self._short))
        self.setToolTip(f"{self._text(short=False)}: {self._entry.tip}" if self._entry is not None else "")


class Sample(QWidget):
    """A short piece of a line or a dot, as on the canvas."""

    def __init__(self) -> None:
        super().__init__()
        self.entry: LegendEntry | None = None
        self.setFixedSize(_SAMPLE)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw it on the color of the canvas."""
        entry = self.entry
        if entry is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        room = QRectF(self.rect())
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(theme.CANVAS))
        painter.drawRoundedRect(room, 3.0, 3.0)
        color, middle = QColor(look().color(entry.color)), room.center()
        if entry.sign == "dot":
            painter.setBrush(color)
            painter.drawEllipse(middle, entry.width / 2, entry.width / 2)
        elif entry.sign == "check":
            painter.setPen(QPen(color, entry.width))
            painter.drawPolyline([middle + QPointF(-4, 0), middle + QPointF(-1, 3), middle + QPointF(5, -4)])
        else:
            pen = QPen(color, entry.width)
            if entry.sign == "dashed":
                pen.setDashPattern((2.5, 1.8))
            pen.setCapStyle(Qt.PenCapStyle.FlatCap)
            painter.setPen(pen)
            painter.drawLine(QPointF(room.left() + 2, middle.y()), QPointF(room.right() - 2, middle.y()))
        painter.end()


_PAD = 10
_SENTENCE = 0.55
"""Part of the width that a sentence may claim before the legend is shortened."""


class Strip(QFrame):
    """Of one height, whatever it shows, so that the image never moves; `entries` returns what the legend shows."""

    def __init__(self, entries: Callable[[], Sequence[LegendEntry]]) -> None:
        super().__init__()
        self.setObjectName("strip")
        self.messages = MessageLine()
        self.hint = FittingLabel()
        self.hint.setObjectName("hint")
        self.hint.setContentsMargins(_PAD, 0, 0, 0)
        self.legend = Legend(entries)
        self.setFixedHeight(self.fontMetrics().height() + _PAD)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(8)
        row.addWidget(self.messages, 1)
        row.addWidget(self.hint, 1)
        row.addWidget(self.legend)
        self.messages.shown_changed.connect(self._share)
        self.legend.width_changed.connect(self._share)

    def say_next(self, text: str) -> None:
        """Show what to do next, unless there is a message."""
        if text != self.hint.text():
            self.hint.setText(text)
            self._share()

    def refresh_legend(self) -> None:
        """Show what is on the canvas now."""
        self.legend.refresh()

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
