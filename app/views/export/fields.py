"""Fields of the export dialog: format, name and folder of the file, and size of a pixel."""

from __future__ import annotations

from collections.abc import Container, Sequence
from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QStandardItemModel
from PySide6.QtWidgets import (
    QComboBox,
    QDoubleSpinBox,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from app.model.export.formats import Format, formats, listed
from app.model.text.language import reason, tr
from app.views.widgets.fields.decimal_field import DecimalField
from app.views.window.dialogs import ask_for_folder
from cpm_core.formats import WRITABLE, check_export, suffix_of

_UNITS = ("nm", "µm", "mm", "cm", "m")


class FormatField(QComboBox):
    """The formats with some suffixes in groups; its data are suffixes."""

    def __init__(self, suffixes: Container[str] = WRITABLE, offered: Sequence[Format] | None = None) -> None:
        super().__init__()
        self.setAccessibleName(tr("Format"))
        self.setMaxVisibleItems(24)
        group = ""
        for one in formats() if offered is None else offered:
            if one.suffix not in suffixes:
                continue
            if one.group != group:
                group = one.group
                self.addItem(group)
                model = self.model()
                assert isinstance(model, QStandardItemModel)
                heading = model.item(self.count() - 1)
                heading.setFlags(Qt.ItemFlag.NoItemFlags)
                font = heading.font()
                font.setBold(True)
                heading.setFont(font)
            self.addItem(f"   {one.name}  (*{one.suffix})", one.suffix)

    @property
    def suffix(self) -> str:
        """The chosen one."""
        return str(self.currentData())

    def choose(self, suffix: str) -> None:
        """Choose the format of a suffix."""
        self.setCurrentIndex(max(1, self.findData(listed(suffix))))


class FileFields(QWidget):
    """Name and folder of a file other than that of the image; `edited` is sent when the user has changed one."""

    edited = Signal()

    def __init__(self, folder: Path, stem: str, image: Path) -> None:
        super().__init__()
        self._image = image
        self.name, self.folder = QLineEdit(stem), QLineEdit(str(folder))
        self.name.setAccessibleName(tr("File name"))
        self.folder.setAccessibleName(tr("Folder"))
        browse = QPushButton(tr("&Browse…"))
        browse.setAutoDefault(False)
        browse.clicked.connect(self._browse)
        row = QHBoxLayout()
        row.addWidget(self.folder, 1)
        row.addWidget(browse)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.name)
        layout.addLayout(row)
        for field in (self.name, self.folder):
            field.textEdited.connect(lambda _: self.edited.emit())

    @property
    def path(self) -> Path:
        """The file."""
        return Path(self.folder.text()).expanduser() / self.name.text().strip()

    @property
    def suffix(self) -> str:
        """Suffix of the name, if it is that of a format."""
        return suffix_of(self.name.text().strip())

    def use_suffix(self, suffix: str) -> None:
        """Give the name another suffix."""
        name, before = self.name.text().strip(), self.suffix
        stem = name[: len(name) - len(before)] if before else name
        self.name.setText(stem + suffix)

    @property
    def trouble(self) -> str:
        """One sentence on why the file cannot be written, or empty."""
        name = self.name.text().strip()
        if not name:
            return tr("The file has no name: type one.")
        if not self.suffix:
            ending = Path(name).suffix
            if ending:
                text = tr("{name} ends in “{ending}”, which is not a format: choose one from the list above.")
                return text.format(name=name, ending=ending)
            return tr("{name} has no suffix: choose a format from the list above.").format(name=name)
        if self.path.resolve() == self._image.resolve():
            return tr("{name} is the image itself: choose another name.").format(name=name)
        try:
            check_export(self.path)
        except ValueError as error:
            return reason(error)
        return ""

    def _browse(self) -> None:
        chosen = ask_for_folder(self, tr("Folder"), self.folder.text())
        if chosen:
            self.folder.setText(chosen)
            self.edited.emit()


class PixelSizeField(QWidget):
    """Size of a pixel and its unit; 0 where it is not known. `edited` is sent when the user has changed it."""

    edited = Signal()

    def __init__(self, spacing: tuple[float, ...], unit: str | None) -> None:
        super().__init__()
        self.number, self.unit = DecimalField(), QComboBox()
        self.number.setRange(0.0, 1e6)
        self.number.setDecimals(6)
        self.number.setStepType(QDoubleSpinBox.StepType.AdaptiveDecimalStepType)
        self.number.setSpecialValueText(tr("not known"))
        self.number.setKeyboardTracking(False)
        self.number.setAccessibleName(tr("Size of a pixel"))
        self.unit.addItems(_UNITS if unit is None or unit in _UNITS else (*_UNITS, unit))
        self.unit.setCurrentText(unit or "µm")
        self.unit.setAccessibleName(tr("Unit of the size of a pixel"))
        self._square = len(set(spacing)) == 1
        if unit is not None and self._square:
            self.number.setValue(spacing[0])
        elif unit is not None:
            self.number.setSpecialValueText(" x ".join(f"{size:g}" for size in spacing))
        self._given = self.value
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(self.number, 1)
        row.addWidget(self.unit)
        self.number.valueChanged.connect(lambda _: self.edited.emit())
        self.unit.currentTextChanged.connect(lambda _: self.edited.emit())

    @property
    def value(self) -> tuple[float, str]:
        """Size and unit."""
        return self.number.value(), self.unit.currentText() if self.number.value() > 0.0 else ""

    @property
    def changed(self) -> tuple[float, str]:
        """Size and unit where they are not those of the image, else 0."""
        return self.value if self.value != self._given else (0.0, "")
