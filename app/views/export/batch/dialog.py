"""The dialog that applies the session to a folder: images, formats, where to, and how far it is."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QProgressBar,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from app.model.export.formats import formats
from app.model.state.situation import remaining_text
from app.model.text.language import tr
from app.session.features.background import LatestOnlyWorker
from app.session.features.image_batch import ImageBatch
from app.session.session import Session
from app.session.tasks.opening import images_in
from app.views.export.batch.table import ImageTable
from app.views.window.dialogs import ask_for_folder, ask_for_images

_USUAL = (".svg", ".measures.csv", ".png")
"""Formats that are chosen at first."""

_SUBFOLDER = "contours"
"""Folder for the results, in that of the images."""

_FULL = 1000
_SHOWN_EVERY = 100
"""Time between two updates of the table [ms]."""


class BatchDialog(QDialog):
    """Starts a batch and shows how far it is; it may be closed meanwhile, and opened again."""

    def __init__(self, parent: QWidget, session: Session, batch: ImageBatch, folder: Path) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("Apply this session to a folder"))
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._session, self._batch = session, batch
        self._images: tuple[Path, ...] = batch.images
        self._looking = LatestOnlyWorker(session, "cpm-folder", tr("looking into a folder"))
        self._looking.done.connect(self._take_images)
        self._soon = QTimer(self, singleShot=True, interval=_SHOWN_EVERY)
        self._soon.timeout.connect(self.show_state)
        self._make_fields()
        self._lay_out()
        batch.changed.connect(self._show_soon)
        session.tasks.advanced.connect(self._show_soon)
        session.document_changed.connect(self._show_soon)
        self.finished.connect(lambda _: self._looking.close())
        if batch.images:
            self.folder.setText(str(batch.images[0].parent))
            self.output.setText(str(batch.output))
        else:
            self.use_folder(folder)
        self.resize(820, 620)
        self.show_state()

    @property
    def suffixes(self) -> tuple[str, ...]:
        """The formats that are chosen."""
        rows = (self.formats.item(row) for row in range(self.formats.count()))
        return tuple(
            str(row.data(Qt.ItemDataRole.UserRole)) for row in rows if row.checkState() == Qt.CheckState.Checked
        )

    @property
    def trouble(self) -> str:
        """Why it cannot be started, in a sentence; empty when it can."""
        if self._batch.trouble:
            return self._batch.trouble
        if not self._images:
            return tr("There is no image in this folder that can be read: choose another one.")
        if not self.output.text().strip():
            return tr("The results have no folder: type one.")
        return "" if self.suffixes else tr("No format is chosen: choose one.")

    def use_folder(self, folder: Path) -> None:
        """Take all images of a folder, and write into a folder in it."""
        self.folder.setText(str(folder))
        self.output.setText(str(folder / _SUBFOLDER))
        self._look()

    def use_files(self, files: Sequence[Path]) -> None:
        """Take these images alone."""
        if files:
            self.folder.setText(str(files[0].parent))
            self.output.setText(str(files[0].parent / _SUBFOLDER))
            self._take_images(tuple(files))

    def start(self) -> None:
        """Start, or stop what is under way."""
        if self._batch.running:
            self._batch.cancel()
        elif not self.trouble:
            self._batch.start(self._images, Path(self.output.text().strip()).expanduser(), self.suffixes)
        self.show_state()

    def show_state(self) -> None:
        """Show how far it is, and what can be done."""
        batch, running = self._batch, self._batch.running
        applied = running or batch.images == self._images
        self.table.show_images(self._images, batch.rows if applied else {})
        done = len(batch.rows) if applied else 0
        self.progress.setValue(round(_FULL * done / max(1, len(self._images))))
        left = remaining_text(batch.task.seconds_left) if batch.task is not None else ""
        told = batch.summary_text if applied and batch.images else ""
        self.told.setText(f"{told} {left}".strip() if told else self.trouble or self._ready())
        self.button.setText(tr("&Stop") if running else tr("&Start"))
        self.button.setEnabled(running or not self.trouble)
        for field in (self.folder, self.output, self.formats, *self._browsers):
            field.setEnabled(not running)

    # Internal

    def _make_fields(self) -> None:
        self.folder, self.output = QLineEdit(), QLineEdit()
        self.folder.setAccessibleName(tr("Folder of the images"))
        self.output.setAccessibleName(tr("Folder for the results"))
        self.formats = QListWidget()
        self.formats.setAccessibleName(tr("Formats"))
        self.formats.setMaximumHeight(6 * (self.fontMetrics().height() + 6))
        for one in formats():
            row = QListWidgetItem(f"{one.name}  (*{one.suffix})", self.formats)
            row.setData(Qt.ItemDataRole.UserRole, one.suffix)
            row.setFlags(Qt.ItemFlag.ItemIsUserCheckable | Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable)
            row.setCheckState(Qt.CheckState.Checked if one.suffix in _USUAL else Qt.CheckState.Unchecked)
        self.table = ImageTable()
        self.progress = QProgressBar()
        self.progress.setRange(0, _FULL)
        self.progress.setTextVisible(False)
        self.told = QLabel()
        self.told.setWordWrap(True)
        self.button = QPushButton()
        self.button.setDefault(True)
        self.folder.textEdited.connect(lambda _: self._look())
        self.output.textEdited.connect(lambda _: self.show_state())
        self.formats.itemChanged.connect(lambda _: self._show_soon())
        self.button.clicked.connect(self.start)

    def _lay_out(self) -> None:
        about = QLabel(
            tr(
                "Starts, regions, charges, parameters and the review of this session are applied to each image, at the "
                "same pixels. The session is kept beside the results, with a table of all images."
            )
        )
        about.setWordWrap(True)
        about.setObjectName("dim")
        choose, pick, where = (QPushButton(text) for text in (tr("&Folder…"), tr("F&iles…"), tr("&Browse…")))
        self._browsers = (choose, pick, where)
        for button, act in zip(self._browsers, (self._ask_folder, self._ask_files, self._ask_output), strict=True):
            button.setAutoDefault(False)
            button.clicked.connect(act)
        form = QFormLayout()
        form.addRow(tr("Images"), _row(self.folder, choose, pick))
        form.addRow(tr("Results"), _row(self.output, where))
        form.addRow(tr("Formats"), self.formats)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.addButton(self.button, QDialogButtonBox.ButtonRole.ActionRole)
        buttons.rejected.connect(self.reject)
        layout = QVBoxLayout(self)
        layout.setSpacing(10)
        layout.addWidget(about)
        layout.addLayout(form)
        layout.addWidget(self.table, 1)
        layout.addWidget(self.progress)
        layout.addWidget(self.told)
        layout.addWidget(buttons)

    def _ready(self) -> str:
        return tr("{count} images are ready.").format(count=len(self._images))

    def _show_soon(self) -> None:
        if not self._soon.isActive():
            self._soon.start()

    def _look(self) -> None:
        """Look for the images of the folder, on a thread: there may be very many."""
        folder = Path(self.folder.text().strip()).expanduser()
        self._looking.ask(lambda: images_in(folder))

    def _take_images(self, found: tuple[Path, ...]) -> None:
        if not self._batch.running:
            self._images = found
            self.show_state()

    def _ask_folder(self) -> None:
        chosen = ask_for_folder(self, tr("Folder of the images"), self.folder.text())
        if chosen:
            self.use_folder(Path(chosen))

    def _ask_files(self) -> None:
        chosen = ask_for_images(self, tr("Images"), self.folder.text())
        if chosen:
            self.use_files(chosen)

    def _ask_output(self) -> None:
        chosen = ask_for_folder(self, tr("Folder for the results"), self.output.text())
        if chosen:
            self.output.setText(chosen)
            self.show_state()


def _row(*widgets: QWidget) -> QHBoxLayout:
    row = QHBoxLayout()
    row.addWidget(widgets[0], 1)
    for widget in widgets[1:]:
        row.addWidget(widget)
    return row
