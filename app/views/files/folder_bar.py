"""The place of the image in its folder, in the status bar, with buttons for the images before and after it."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QToolButton, QWidget

from app.model.text.language import tr
from app.views.theme.icons import icon
from app.views.theme.theme import Theme


class FolderBar(QWidget):
    """Says "3 of 24"; hidden where an image is the only one of its folder."""

    asked = Signal(int)
    """The user asks for another image: -1 for the one before, 1 for the one after."""

    def __init__(self) -> None:
        super().__init__()
        self.back, self.forward, self._place = QToolButton(), QToolButton(), QLabel()
        self._place.setObjectName("dim")
        row = QHBoxLayout(self)
        row.setContentsMargins(6, 0, 6, 0)
        row.setSpacing(2)
        for widget in (self.back, self._place, self.forward):
            row.addWidget(widget)
        names = ((self.back, tr("Previous image"), -1), (self.forward, tr("Next image"), 1))
        for button, name, by in names:
            button.setObjectName("quiet")
            button.setAutoRaise(True)
            button.setAccessibleName(name)
            button.clicked.connect(lambda _=False, by=by: self.asked.emit(by))
        self.hide()

    @property
    def text(self) -> str:
        """The text shown, or empty."""
        return "" if self.isHidden() else self._place.text()

    def show_place(self, index: int, count: int, folder: str) -> None:
        """Show that an image is one of the images of a folder; the first one has index 0."""
        self._place.setText(tr("{number} of {count}").format(number=index + 1, count=count))
        self.setToolTip(tr("Images in {folder}").format(folder=folder))
        self.back.setToolTip(tr("Previous image of the folder"))
        self.forward.setToolTip(tr("Next image of the folder"))
        self.back.setEnabled(index > 0)
        self.forward.setEnabled(index < count - 1)
        self.setVisible(count > 1)

    def use_theme(self, theme: Theme) -> None:
        """Tint the buttons."""
        self.back.setIcon(icon("back", theme.text))
        self.forward.setIcon(icon("forward", theme.text))
