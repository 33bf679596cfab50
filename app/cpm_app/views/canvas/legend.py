"""The line below the image: a message or what to do next, and the legend of lines and dots on the canvas."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import QSize, Qt, QTimer, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QSizePolicy, QWidget

from cpm_app.model.text.language import localize_number, tr
from cpm_app.views.canvas.message_line import MessageLine
from cpm_app.views.layers.layer import LegendEntry
from cpm_app.views.theme import theme
from cpm_app.views.theme.theme import get_canvas_style
from cpm_app.views.widgets.containers import ElidedLabel, FoldButton, fill_layout

_LEGEND_INTERVAL = 150
"""Minimum time between two updates [ms]; the number of particles changes in every frame."""

_SIGN_CHARACTERS = {"line": "━━", "dashed": "╍╍", "dot": "●", "area": "■"}
"""Character that stands for each way of drawing."""

_STRIP_PADDING = 10
"""Padding of the strip [px]."""

_MAX_SENTENCE_FRACTION = 0.55
"""Largest fraction of the width that a sentence may take before the legend is shortened."""


class Legend(QWidget):
    """A sign, a number and a word for each kind of item on the canvas; it can be folded away.

    `entries` returns all entries. Where room is short, only signs and numbers are shown; the tool tip has the words.
    """

    width_changed = Signal()
    """It needs more or less space than before."""

    def __init__(self, entries: Callable[[], Sequence[LegendEntry]]) -> None:
        super().__init__()
        self._read_entries = entries
        self.entries: tuple[LegendEntry, ...] = ()
        """Entries that are shown."""
        self._label = QLabel(textFormat=Qt.TextFormat.RichText)
        self.button = FoldButton()
        self.button.setText(tr("Legend"))
        self.button.setToolTip(tr("Show or hide what the lines and dots mean."))
        self.button.toggled.connect(self._on_toggled)
        fill_layout(QHBoxLayout(self), self._label, self.button, margins=(6, 0, 6, 0))
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self._timer = QTimer(self, singleShot=True, interval=_LEGEND_INTERVAL)
        self._timer.timeout.connect(self.update_now)
        self.button.setChecked(True)
        self.hide()

    def schedule_update(self) -> None:
        """Schedule an update of the entries."""
        if not self._timer.isActive():
            self._timer.start()

    def update_now(self) -> None:
        """Update the entries now."""
        entries = tuple(entry for entry in self._read_entries() if entry.count)
        if entries != self.entries:
            self.entries = entries
            self._label.setToolTip("<br>".join(f"{_format_count(entry)}. {entry.tip}" for entry in entries))
            self.setVisible(bool(entries))
            self.width_changed.emit()

    def _on_toggled(self, is_unfolded: bool) -> None:
        """Hide or show all but the button."""
        style = Qt.ToolButtonStyle
        self.button.setToolButtonStyle(style.ToolButtonIconOnly if is_unfolded else style.ToolButtonTextBesideIcon)
        self.button.setAccessibleName(tr("Hide the legend") if is_unfolded else tr("Show the legend"))
        self._label.setVisible(is_unfolded)
        self.width_changed.emit()

    def fit_width(self, width: int) -> None:
        """Show words only where they fit in a width [px]."""
        self._label.setText(self._format_entries(short=False))
        if self.sizeHint().width() > width:
            self._label.setText(self._format_entries(short=True))

    def _format_entries(self, *, short: bool) -> str:
        """Format the entries as rich text, each sign on the background color of the canvas."""
        return "&nbsp; ".join(
            f"<span style='color:{get_canvas_style().resolve_color(entry.color)}; "
            f"background-color:{theme.CANVAS_COLOR}'>"
            f"&nbsp;{_SIGN_CHARACTERS[entry.sign]}&nbsp;</span>&nbsp;"
            + (localize_number(f"{entry.count:,}") if short else _format_count(entry).replace(" ", "&nbsp;"))
            for entry in self.entries
        )


def _format_count(entry: LegendEntry) -> str:
    return tr("{name}: {count}", name=entry.text, count=localize_number(f"{entry.count:,}"))


class CanvasStrip(QFrame):
    """Message or hint, and legend, at a fixed height so that the image never moves; `entries` feeds the legend."""

    def __init__(self, entries: Callable[[], Sequence[LegendEntry]]) -> None:
        super().__init__()
        self.setObjectName("strip")
        self.messages = MessageLine()
        self.hint = ElidedLabel()
        self.hint.setObjectName("hint")
        self.hint.setContentsMargins(_STRIP_PADDING, 0, 0, 0)
        self.legend = Legend(entries)
        self.setFixedHeight(self.fontMetrics().height() + _STRIP_PADDING)
        row = fill_layout(QHBoxLayout(self), self.messages, self.hint, self.legend, spacing=8, wide=self.messages)
        row.setStretchFactor(self.hint, 1)
        self.messages.shown_changed.connect(self._share_width)
        self.legend.width_changed.connect(self._share_width)

    def show_hint(self, text: str) -> None:
        """Show a hint on the next step, unless there is a message."""
        if text != self.hint.text():
            self.hint.setText(text)
            self.hint.setToolTip(text)
            self._share_width()

    def minimumSizeHint(self) -> QSize:
        """Return no minimum width: a legend growing during a run must not widen the window."""
        return QSize(0, super().minimumSizeHint().height())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Share the width again."""
        super().resizeEvent(event)
        self._share_width()

    def _share_width(self) -> None:
        """Give the sentence what it needs, up to a part of the width, and the rest to the legend."""
        has_message = bool(self.messages.text)
        self.hint.setVisible(not has_message)
        wanted = self.messages.sizeHint().width() if has_message else self.hint.sizeHint().width() + _STRIP_PADDING
        self.legend.fit_width(self.width() - min(wanted, round(_MAX_SENTENCE_FRACTION * self.width())) - _STRIP_PADDING)
