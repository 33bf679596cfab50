"""Dialog of the session applied to a folder: which formats are written, where, and what is replaced there."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QFormLayout, QLabel, QWidget

from cpm_app.model.text.language import elide_middle, tr
from cpm_app.session.features.image_batch import count_written_files, results_folder
from cpm_app.session.storage.preferences import Preferences
from cpm_app.views.export.dialog import FormatList
from cpm_app.views.widgets.containers import AcceptButtons, create_wrapped_label, lay_out_form

_LIST_SIZE = 360, 180
"""Smallest width and height of the list of formats [px]."""


class BatchDialog(QDialog):
    """Dialog before the images of a folder are run; the formats are those checked in the export dialog.

    Parameters
    ----------
    parent : QWidget
        Window.
    preferences : Preferences
        Where the checked formats are kept.
    folder : Path
        Folder of the images.
    images : sequence of Path
        The images in it.
    in_volume : bool
        Whether the session is about volumes.
    """

    def __init__(
        self, parent: QWidget, preferences: Preferences, folder: Path, images: Sequence[Path], in_volume: bool
    ) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Apply this session to a folder"))
        self._folder, self._images = folder, images
        self.list = FormatList(preferences, {"objects": 1}, in_volume)
        self.list.setColumnCount(1)
        self.list.setHeaderHidden(True)
        self.list.setMinimumSize(*_LIST_SIZE)
        self.summary = create_wrapped_label()
        self.summary.setMinimumHeight(2 * self.summary.fontMetrics().lineSpacing())
        buttons = AcceptButtons(self, tr("&Find objects"))
        self.run_button = buttons.accept_button
        form = QFormLayout()
        form.addRow(tr("Formats"), self.list)
        form.addRow(tr("Folder"), QLabel(elide_middle(str(results_folder(folder)))))
        form.addRow(self.summary)
        heading = tr("Find the objects of {count} images in {folder}, and write them.")
        lay_out_form(self, heading.format(count=len(images), folder=folder.name), form, buttons)
        self.run_button.setDefault(True)
        self.list.itemChanged.connect(self._show_summary)
        self._show_summary()

    @property
    def suffixes(self) -> tuple[str, ...]:
        """Suffixes of the checked formats."""
        return tuple(suffix for _, suffix in self.list.checked_formats)

    def accept(self) -> None:
        """Remember the formats, for the export dialog as well."""
        self.list.remember_formats()
        super().accept()

    def _show_summary(self) -> None:
        count = count_written_files(self._folder, self.suffixes)
        text = tr("Files that will be replaced: {count}, except for images already done with this session.")
        text = text.format(count=count) if count else tr("No file will be replaced.")
        problem = "" if self.suffixes else tr("Choose what to export.")
        if not self._images:
            problem = tr("This folder contains no readable image: choose another one.")
        self.summary.setText(problem or text)
        self.run_button.setEnabled(not problem)
