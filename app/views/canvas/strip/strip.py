"""The line below the image: a message or what to do next, and the legend."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import QSize
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QFrame, QHBoxLayout

from app.views.canvas.layers.legend_entry import LegendEntry
from app.views.canvas.strip.fitting_label import FittingLabel
from app.views.canvas.strip.legend import Legend
from app.views.canvas.strip.message_line import MessageLine

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
