"""The export dialog for what a run in a volume has found: surface, label volume or particles."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QComboBox, QDialog, QDialogButtonBox, QFormLayout, QLabel, QVBoxLayout, QWidget

from app.model.display.lengths import size_text
from app.model.export.formats import formats_of_volumes
from app.model.export.order import ExportOrder
from app.model.state.surface_figures import SurfaceFigures, figure_texts
from app.model.text.language import tr
from app.views.export.fields import FileFields, FormatField
from cpm_core.formats import FOR_CENTERLINES, FOR_VOLUMES
from cpm_core.formats.writers import IN_SPACE
from cpm_core.image.geometry import CONVENTIONS
from cpm_core.image.image import Image

_WIDTH = 420
_SPACES = {
    "LPS": tr("To the left, back and head of the patient (LPS), as in DICOM"),
    "RAS": tr("To the right, front and head of the patient (RAS), as in NIfTI"),
}


class SurfaceDialog(QDialog):
    """Asks for format and place of a file, and tells what there is to write.

    Where `lines` says something of center lines, these are written, and no surface.
    """

    ordered = Signal(object, object)
    """Path of the file and the order for it."""

    def __init__(
        self, parent: QWidget, figures: SurfaceFigures | None, objects: int, volume: Image, path: Path, place: Path,
        suffix: str, lines: str = "",
    ) -> None:  # fmt: skip
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Export center lines") if lines else tr("Export surface"))
        self._formats = FOR_CENTERLINES if lines else FOR_VOLUMES
        self.format = FormatField(self._formats, formats_of_volumes())
        self.file = FileFields(place.parent, place.name, path)
        self.source = QComboBox()
        self.source.setAccessibleName(tr("What"))
        if figures is not None:
            self.source.addItem(tr("The surface of the run"), ("all", _summary(figures)))
        if lines:
            self.source.addItem(tr("The center lines"), ("all", lines))
        elif objects:
            self.source.addItem(tr("The objects"), ("objects", _counted(objects)))
        self.space = QComboBox()
        self.space.setAccessibleName(tr("Coordinates"))
        for space in CONVENTIONS:
            self.space.addItem(_SPACES[space], space)
        self._placed = volume.geometry is not None
        self.figures, self.note = QLabel(), QLabel()
        for label in (self.figures, self.note):
            label.setWordWrap(True)
            label.setMinimumWidth(_WIDTH)
        self.buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel)
        self.export_button = self.buttons.addButton(tr("&Export"), QDialogButtonBox.ButtonRole.AcceptRole)
        form = QFormLayout()
        form.addRow(tr("What"), self.source)
        form.addRow("", self.figures)
        form.addRow(tr("Size of a voxel"), QLabel(size_text(volume.spacing, volume.unit) or tr("not known")))
        form.addRow(tr("Format"), self.format)
        form.addRow(tr("Coordinates"), self.space)
        form.addRow(tr("File"), self.file)
        form.addRow("", self.note)
        self._form = form
        layout = QVBoxLayout(self)
        layout.addLayout(form)
        layout.addWidget(self.buttons)
        self.export_button.setDefault(True)  # once it is in the dialog, else Tab makes another button the default
        self.format.choose(suffix)
        self.file.use_suffix(self.format.suffix)
        self.format.activated.connect(lambda _: self._use_format())
        self.file.edited.connect(self._follow_name)
        self.source.currentIndexChanged.connect(self._follow)
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        self._follow()

    def accept(self) -> None:
        """Order the export."""
        if self.export_button.isEnabled():
            order = ExportOrder(self.source.currentData()[0], space=self.space.currentData())
            self.ordered.emit(self.file.path, order)
            super().accept()

    def _use_format(self) -> None:
        self.file.use_suffix(self.format.suffix)
        self._follow()

    def _follow_name(self) -> None:
        if self.file.suffix in self._formats:
            self.format.choose(self.file.suffix)
        self._follow()

    def _follow(self) -> None:
        """Tell what stands in the way."""
        self.figures.setText(self.source.currentData()[1])
        self._form.setRowVisible(self.space, self._placed and self.file.suffix in IN_SPACE)
        trouble = self.file.trouble
        if not trouble and self.file.suffix not in self._formats:
            trouble = tr("This format is for contours: choose one from the list above.")
        self.export_button.setEnabled(not trouble)
        if not trouble and self.file.path.exists():
            trouble = tr("{name} is there already and will be replaced.").format(name=self.file.path.name)
        self.note.setText(trouble)


def _counted(objects: int) -> str:
    count = tr("1 object") if objects == 1 else tr("{count} objects").format(count=objects)
    return tr("{count}; in a label volume each voxel has the number of its object.").format(count=count)


def _summary(figures: SurfaceFigures) -> str:
    """The figures of a surface, one in each line."""
    return "\n".join(f"{label}: {value}" for label, value, _ in figure_texts(figures))
