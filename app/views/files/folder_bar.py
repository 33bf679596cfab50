"""The place of the image in its folder, in the status bar, with buttons for the images before and after it."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QHBoxLayout, QLabel, QToolButton, QWidget

from app.model.text.language import tr
from app.views.widgets.actions import Actions
from app.views.widgets.containers import arrange


class FolderBar(QWidget):
    """Shows "3 of 24"; hidden where an image is the only one of its folder."""

    def __init__(self) -> None:
        super().__init__()
        self.back, self.forward, self._place = QToolButton(), QToolButton(), QLabel()
        self._place.setObjectName("dim")
        for button in (self.back, self.forward):
            button.setObjectName("quiet")
            button.setAutoRaise(True)
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
        arrange(QHBoxLayout(self), self.back, self._place, self.forward, margins=(6, 0, 6, 0), spacing=2)
        self.hide()

    def use_actions(self, actions: Actions) -> None:
        """Let the buttons be those of the actions of the menu."""
        self.back.setDefaultAction(actions["previous_image"])
        self.forward.setDefaultAction(actions["next_image"])

    def show_place(self, index: int, count: int, folder: str) -> None:
        """Show that an image is one of the images of a folder; the first one has index 0."""
        self._place.setText(tr("{number} of {count}").format(number=index + 1, count=count))
        self._place.setToolTip(tr("Images in {folder}").format(folder=folder))
        self.setVisible(count > 1)
