"""The gallery of presets: a button with the name of the one in use, which opens pictures of all."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import QBuffer, QIODevice, QPoint, QSize, Qt, Signal
from PySide6.QtGui import QAction, QColor, QImage, QImageWriter, QKeyEvent, QPixmap
from PySide6.QtWidgets import (
    QFrame,
    QGridLayout,
    QLabel,
    QListWidgetItem,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
)

from app.model.parameters.presets import Preset
from app.model.text.language import tr
from app.session.storage.pictures import middle
from app.views.theme import theme
from app.views.widgets.picture_grid import PictureGrid

_COLUMNS, _CELL = 2, QSize(180, 124)
PICTURE = QSize(160, 94)
_MOST_HEIGHT = 440


class PresetGallery(QToolButton):
    """Shows the name of the preset in use and, when pressed, pictures of all; `actions` become buttons below."""

    chosen = Signal(object)
    """The user chooses a preset: Preset."""

    def __init__(self, actions: Iterable[QAction]) -> None:
        super().__init__()
        self.setObjectName("preset")
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setAccessibleName(tr("Preset"))
        self.setToolTip(tr("Parameters that suit a kind of image, and your own presets."))
        self._presets: tuple[Preset, ...] = ()
        self._current: Preset | None = None
        self.pictures = PictureGrid(PICTURE, _CELL)
        self.pictures.setAccessibleName(tr("Presets"))
        self.popup = self._make_popup(actions)
        self.pictures.chosen.connect(self._choose)
        self.pictures.left.connect(self.popup.hide)
        self.pictures.currentItemChanged.connect(lambda item, _: self._show_about(item))
        self.clicked.connect(self.open)

    @property
    def current(self) -> Preset | None:
        """The preset whose parameters are in use."""
        return self._current

    def show_presets(self, presets: tuple[Preset, ...]) -> None:
        """Show these presets."""
        self._presets = presets
        self.pictures.clear()
        if self.popup.isVisible():
            self._add_pictures()

    def show_current(self, preset: Preset | None, otherwise: str = "") -> None:
        """Show the name of the preset in use; None and another name if the parameters are not those of a preset."""
        self._current = preset
        name = preset.name if preset is not None else otherwise or tr("Custom parameters")
        room = 30
        self.setText(f"{name if len(name) <= room else name[: room - 1] + '…'}  ▾")

    def open(self) -> None:
        """Show the pictures below the button."""
        if not self.pictures.count():
            self._add_pictures()
        rows = -(-len(self._presets) // _COLUMNS)
        self.pictures.setFixedHeight(min(rows * _CELL.height() + 6, _MOST_HEIGHT))
        self.popup.adjustSize()
        corner = self.mapToGlobal(QPoint(self.width() - self.popup.width(), self.height() + 2))
        screen = self.screen().availableGeometry()
        lowest = screen.bottom() - self.popup.height()
        self.popup.move(max(screen.left(), corner.x()), max(screen.top(), min(corner.y(), lowest)))
        self.popup.show()
        names = [preset.name for preset in self._presets]
        self.pictures.setCurrentRow(names.index(self._current.name) if self._current else 0)
        self.pictures.setFocus()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Open on the arrow key as well."""
        if event.key() == Qt.Key.Key_Down:
            self.open()
        else:
            super().keyPressEvent(event)

    def _add_pictures(self) -> None:
        """Add the pictures of all presets: only when they are seen, because to decode them takes long."""
        for preset in self._presets:
            self.pictures.add(_picture(preset), preset.name, preset, preset.about or preset.name)

    def _make_popup(self, actions: Iterable[QAction]) -> QFrame:
        popup = QFrame(self, Qt.WindowType.Popup)
        popup.setObjectName("popup")
        self._about = QLabel()
        self._about.setObjectName("dim")
        self._about.setWordWrap(True)
        self._about.setFixedHeight(2 * self._about.fontMetrics().lineSpacing() + 4)
        self._about.setAlignment(Qt.AlignmentFlag.AlignTop)
        buttons = QGridLayout()
        buttons.setSpacing(4)
        for index, action in enumerate(actions):
            button = QToolButton()
            button.setDefaultAction(action)
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
            button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.clicked.connect(popup.hide)
            buttons.addWidget(button, index // 3, index % 3)
        layout = QVBoxLayout(popup)
        layout.setContentsMargins(10, 10, 10, 10)
        layout.addWidget(self.pictures)
        layout.addWidget(self._about)
        layout.addLayout(buttons)
        self.pictures.setFixedWidth(_COLUMNS * _CELL.width() + 16)
        return popup

    def _show_about(self, item: QListWidgetItem | None) -> None:
        self._about.setText(item.data(Qt.ItemDataRole.UserRole).about if item is not None else "")

    def _choose(self, item: QListWidgetItem) -> None:
        self.popup.hide()
        self.chosen.emit(item.data(Qt.ItemDataRole.UserRole))


def _picture(preset: Preset) -> QPixmap:
    pixmap = QPixmap()
    return pixmap if preset.picture and pixmap.loadFromData(preset.picture) else no_picture()


def picture_of(canvas: QImage) -> bytes:
    """A picture of the canvas for the gallery, at twice its size, as PNG."""
    scaled = middle(canvas, PICTURE * 2)
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    QImageWriter(buffer, b"png").write(scaled)
    return bytes(buffer.data().data())


def no_picture() -> QPixmap:
    """A blank picture for presets without one."""
    pixmap = QPixmap(PICTURE)
    pixmap.fill(QColor(theme.CANVAS))
    return pixmap
