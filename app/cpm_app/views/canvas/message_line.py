"""Messages to the user in one line, with details on demand."""

from __future__ import annotations

from PySide6.QtCore import QPoint, Qt, QTimer, Signal
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QVBoxLayout

from cpm_app.model.state.messages import Message, Messages
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import tr
from cpm_app.session.session_messages import LASTING_CATEGORIES
from cpm_app.views.theme.icons import load_icon
from cpm_app.views.widgets.containers import ElidedLabel, create_flat_button, fill_layout

_MESSAGE_DURATION = 6000
"""Time after which news disappears, unless it is of `LASTING_CATEGORIES` [ms]."""

_DETAILS_WIDTH = 420
"""Width of the text of the whole message [px]."""


class MessageLine(QFrame):
    """One message, with buttons to read it in full and to dismiss it; hidden while there is none."""

    shown_changed = Signal()
    """Another message is shown, or none."""

    def __init__(self) -> None:
        super().__init__()
        self._messages = Messages()
        self._label = ElidedLabel()
        self.details = create_flat_button(tr("Details"), tr("Read the whole message."), self._show_details)
        self._label.fits_changed.connect(lambda: self.details.setVisible(not self._label.fits))
        self._button = create_flat_button("", tr("Dismiss message"), self.dismiss_message)
        self._button.setIcon(load_icon("close"))
        parts = self._label, self.details, self._button
        fill_layout(QHBoxLayout(self), *parts, margins=(10, 0, 2, 0), spacing=4, wide=self._label)
        self._timer = QTimer(self, singleShot=True, interval=_MESSAGE_DURATION)
        self._timer.timeout.connect(lambda: self._set_messages(self._messages.without_news()))
        self.hide()

    @property
    def text(self) -> str:
        """The message shown, or empty."""
        shown = self._messages.shown
        return shown.text if shown is not None else ""

    @property
    def is_error(self) -> bool:
        """Whether an error is shown."""
        shown = self._messages.shown
        return shown is not None and shown.error

    def show_message(self, message: str, error: bool, category: str = "") -> None:
        """Show a message."""
        self._set_messages(self._messages.with_message(Message(message, error, category)))

    def clear_category(self, category: str) -> None:
        """Clear the messages of a category, before another attempt."""
        self._set_messages(self._messages.without_categories(category))

    def keep_categories(self, *categories: str) -> None:
        """Clear all messages except those of some categories."""
        self._set_messages(self._messages.only_categories(*categories))

    def dismiss_message(self) -> None:
        """Dismiss the message that is shown."""
        self._set_messages(self._messages.without_shown())

    def clear(self) -> None:
        """Clear all messages."""
        self._set_messages(Messages())

    def show_keys(self) -> None:
        """Name the current keys in the tool tip."""
        self._button.setToolTip(insert_keys(tr("Dismiss ({key:escape})")))

    def _set_messages(self, messages: Messages) -> None:
        before, self._messages = self._messages, messages
        shown = messages.shown
        if messages.news is not None and messages.news is not before.news:
            self._timer.stop()
            if messages.news.category not in LASTING_CATEGORIES:
                self._timer.start()
        if shown is before.shown:
            return
        self.setVisible(shown is not None)
        if shown is not None:
            self._display_message(shown)
        self.shown_changed.emit()

    def _display_message(self, shown: Message) -> None:
        self._label.setText(shown.text)
        self.setObjectName("error" if shown.error else "message")
        for widget in (self, self._label, self.details, self._button):
            self.style().unpolish(widget)
            self.style().polish(widget)
        self.details.setVisible(not self._label.fits)

    def _show_details(self) -> None:
        popup = QFrame(self.window(), Qt.WindowType.Popup)
        popup.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        popup.setObjectName("popup")
        label = QLabel(
            self.text,
            textFormat=Qt.TextFormat.PlainText,
            wordWrap=True,
            textInteractionFlags=Qt.TextInteractionFlag.TextSelectableByMouse,
        )
        label.setFixedWidth(_DETAILS_WIDTH)
        QVBoxLayout(popup).addWidget(label)
        popup.adjustSize()
        popup.move(self.mapToGlobal(QPoint(0, -popup.height() - 2)))
        popup.show()
