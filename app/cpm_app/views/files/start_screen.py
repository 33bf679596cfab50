"""Start screen: recent work and samples as pictures, in place of the image."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import QEvent, QObject, QSize, Qt, Signal
from PySide6.QtGui import QIcon, QImage, QKeyEvent, QPixmap
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from cpm_app.model.text.language import tr
from cpm_app.views.widgets.containers import (
    ENTER_KEYS,
    VerticalScrollArea,
    create_dim_label,
    create_wrapped_label,
    fill_layout,
    mark_own_escape,
)
from cpm_core.numerics.types import record

_PICTURE_SIZE = QSize(192, 120)
"""Size of a picture [px]."""

_GRID_CELL_SIZE = QSize(212, 172)
"""Size of a picture with the text below it [px]."""

_SCREEN_MARGIN = 32
"""Space on the left and on the right of the pictures [px]."""


@record
class StartEntry:
    """A file that can be opened: picture, which may be null, name, a line below it, and a description."""

    path: Path
    picture: QImage
    name: str
    subtitle: str
    tooltip: str


_SELECTION_KEYS = (*ENTER_KEYS, Qt.Key.Key_Space)
"""Keys that select the current picture."""


class PictureGrid(QListWidget):
    """Grid of pictures with names; arrow keys and the first letters of a name move through it."""

    file_selected = Signal(Path)
    """The user has selected a picture: its file."""

    def __init__(self) -> None:
        super().__init__()
        self.setViewMode(QListWidget.ViewMode.IconMode)
        self.setMovement(QListWidget.Movement.Static)
        self.setResizeMode(QListWidget.ResizeMode.Adjust)
        self.setIconSize(_PICTURE_SIZE)
        self.setGridSize(_GRID_CELL_SIZE)
        self.setUniformItemSizes(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.itemClicked.connect(self._select_item)

    def add_entry(self, entry: StartEntry) -> None:
        """Add the picture of a file, a black one if there is none."""
        picture = QPixmap(_PICTURE_SIZE)
        picture.fill(Qt.GlobalColor.black)
        if not entry.picture.isNull():
            picture = QPixmap.fromImage(entry.picture)
        icon = QIcon()
        # Qt would tint the picture of the current item.
        icon.addPixmap(picture, QIcon.Mode.Normal)
        icon.addPixmap(picture, QIcon.Mode.Selected)
        item = QListWidgetItem(icon, f"{entry.name}\n{entry.subtitle}")
        item.setData(Qt.ItemDataRole.UserRole, entry.path)
        item.setToolTip(entry.tooltip)
        item.setTextAlignment(Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignBottom)
        self.addItem(item)

    def event(self, event: QEvent) -> bool:
        """Claim plain keys before they act as shortcuts of the window."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent):
            plain = event.modifiers() in (Qt.KeyboardModifier.NoModifier, Qt.KeyboardModifier.ShiftModifier)
            if plain and (event.text() or event.key() in _SELECTION_KEYS):
                event.accept()
                return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Select the current picture on Enter or Space."""
        item = self.currentItem()
        if event.key() in _SELECTION_KEYS and item is not None:
            self._select_item(item)
        else:
            super().keyPressEvent(event)

    def _select_item(self, item: QListWidgetItem) -> None:
        self.file_selected.emit(item.data(Qt.ItemDataRole.UserRole))


class StartScreen(QWidget):
    """Pictures of recent work and samples that cover `parent`."""

    file_selected = Signal(Path)
    """The user has selected a file."""
    open_requested = Signal()
    """The user asks for another file."""
    back_requested = Signal()
    """The user returns to the image."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("start")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self._covered = parent
        mark_own_escape(self)
        self.open_button, self.back_button = QPushButton(tr("&Open…")), QPushButton(tr("&Back to the image"))
        self.open_button.clicked.connect(self.open_requested)
        self.back_button.clicked.connect(self.back_requested)
        self.recent, self.samples = PictureGrid(), PictureGrid()
        self.recent.setAccessibleName(tr("Recent work"))
        self.samples.setAccessibleName(tr("Samples"))
        self.error_label = create_wrapped_label()
        self._nothing = create_dim_label(tr("Files that you open or save appear here."))
        self._lay_out()
        for grid in (self.recent, self.samples):
            grid.file_selected.connect(self.file_selected)
        parent.installEventFilter(self)
        self.hide()

    def show_entries(
        self, recent: Sequence[StartEntry], samples: Sequence[StartEntry], can_go_back: bool, error: str
    ) -> None:
        """Show files in place of the image, below an `error`; `can_go_back` offers to return to the image."""
        self.error_label.setText(error)
        self.error_label.setVisible(bool(error))
        for grid, entries in ((self.recent, recent), (self.samples, samples)):
            grid.clear()
            for entry in entries:
                grid.add_entry(entry)
            grid.setVisible(bool(entries))
        self._nothing.setVisible(not recent)
        self.back_button.setVisible(can_go_back)
        self._cover_parent()
        self.show()
        self.raise_()
        first = self.recent if recent else self.samples
        first.setCurrentRow(0)
        first.setFocus(Qt.FocusReason.OtherFocusReason)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Leave on Esc."""
        if event.key() == Qt.Key.Key_Escape:
            self.back_requested.emit()
        else:
            super().keyPressEvent(event)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Adapt to the size of the parent."""
        if event.type() == QEvent.Type.Resize and self.isVisible():
            self._cover_parent()
        return super().eventFilter(watched, event)

    def _lay_out(self) -> None:
        content = QWidget()
        fill_layout(
            QVBoxLayout(content),
            self.error_label,
            fill_layout(
                QHBoxLayout(), _create_heading(tr("Recent work")), None, self.back_button, self.open_button, spacing=6
            ),
            self._nothing,
            self.recent,
            _create_heading(tr("Samples")),
            self.samples,
            None,
            margins=(_SCREEN_MARGIN, _SCREEN_MARGIN // 2, _SCREEN_MARGIN, _SCREEN_MARGIN // 2),
            spacing=10,
        )
        fill_layout(QVBoxLayout(self), VerticalScrollArea(content, _SCREEN_MARGIN))

    def _cover_parent(self) -> None:
        """Take the size of the parent, and give each grid the height of all its rows."""
        self.setGeometry(self._covered.rect())
        columns = max(1, (self.width() - 2 * _SCREEN_MARGIN - 20) // _GRID_CELL_SIZE.width())
        for grid in (self.recent, self.samples):
            grid.setFixedHeight(-(-grid.count() // columns) * _GRID_CELL_SIZE.height() + 4)


def _create_heading(text: str) -> QLabel:
    label = QLabel(text)
    label.setObjectName("heading")
    return label
