"""A grid of pictures with names, one of which is chosen by a click, Enter or Space."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QSize, Qt, Signal
from PySide6.QtGui import QIcon, QKeyEvent, QPixmap
from PySide6.QtWidgets import QFrame, QListWidget, QListWidgetItem

_CHOOSING = (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Space)
_PLAIN = Qt.KeyboardModifier.NoModifier


class PictureGrid(QListWidget):
    """Pictures of one size in cells of another; arrow keys and the first letters of a name lead through them."""

    chosen = Signal(QListWidgetItem)
    """The user chooses a picture."""
    left = Signal()
    """The user presses Esc."""

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
        """Choose the marked picture on Enter or Space, leave on Esc."""
        item = self.currentItem()
        if event.key() in _CHOOSING and item is not None:
            self.chosen.emit(item)
        elif event.key() == Qt.Key.Key_Escape:
            self.left.emit()
        else:
            super().keyPressEvent(event)
