"""Images of a project: the table of their states, and buttons to say how far one is."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import QItemSelectionModel, Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QAbstractItemView, QHBoxLayout, QVBoxLayout, QWidget

from cpm_app.model.document.project import STATE_WORDS, TO_PROPOSE, ImageRow
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import tr
from cpm_app.session.features.image_project import ImageProject
from cpm_app.views.panels.tables import CellIndex, Column, SortableTable, TableModel
from cpm_app.views.widgets.actions import ActionButton
from cpm_app.views.widgets.containers import ENTER_KEYS, create_wrapped_label, fill_layout

_STATES = tuple(STATE_WORDS)
"""States in their order."""

IMAGE_COLUMNS: tuple[Column[ImageRow], ...] = (
    Column("image", tr("Image"), tr("Image of the folder; a click opens it."), lambda row: row.path.name, "image.png",
           sort_by=lambda row: row.place),
    Column("state", tr("State"), tr("How far the work on the image is: {key:image_done} says that it is done, "
                                    "{key:image_doubtful} that it is doubtful."),
           lambda row: str(row.words), f"{max(map(str, (*STATE_WORDS.values(), TO_PROPOSE)), key=len)}m",
           sort_by=lambda row: _STATES.index(row.state)),
    Column("objects", tr("Count"), tr("Number of objects."), lambda row: row.objects, "0000", number_format=".0f"),
)  # fmt: skip
"""Columns in the order shown."""

_IMAGE_BUTTONS = ("image_done", "image_doubtful", "next_undone")
"""Names of the actions that have a button."""


class ImageTable(SortableTable):
    """Table of the images of a project; a click or Enter opens one."""

    image_requested = Signal(object)
    """The user asks to open an image: its path."""

    def __init__(self, project: ImageProject) -> None:
        super().__init__(TableModel(IMAGE_COLUMNS, lambda row: row.path), "image", tr("Images of the folder"))
        self._project = project
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.clicked.connect(self._request_image)

    def show_rows(self, rows: Sequence[ImageRow]) -> None:
        """Show the images, and select the open one."""
        before = self.currentIndex()
        shown: Path | None = self.rows.item_key(before.row()) if before.isValid() else None
        self.rows.update_items(rows, None)
        current = self._project.current
        if current is not None and current != shown:
            row = [item.path for item in self.rows.items].index(current)
            kind = QItemSelectionModel.SelectionFlag
            self.selectionModel().setCurrentIndex(self.rows.index(row, 0), kind.ClearAndSelect | kind.Rows)
            self.scrollTo(self.rows.index(row, 0))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Open the current image on Enter, unless it is open."""
        here = self.currentIndex()
        if event.key() not in ENTER_KEYS:
            super().keyPressEvent(event)
        elif here.isValid() and self.rows.item_key(here.row()) != self._project.current:
            self._request_image(here)
        else:
            event.ignore()

    def _request_image(self, index: CellIndex) -> None:
        path = self.rows.item_key(index.row())
        if path != self._project.current:
            self.image_requested.emit(path)


class ImagePanel(QWidget):
    """Table of the images of a project, how many there are in each state, and buttons for the open one."""

    def __init__(self, project: ImageProject) -> None:
        super().__init__()
        self._project = project
        self.table, self.summary = ImageTable(project), create_wrapped_label(dim=True)
        self.setFocusProxy(self.table)
        row = fill_layout(QHBoxLayout(), *map(ActionButton, _IMAGE_BUTTONS), spacing=4)
        fill_layout(QVBoxLayout(self), self.summary, self.table, row, margins=(4, 6, 4, 6), wide=self.table)
        project.changed.connect(self.show_images)

    def show_images(self) -> None:
        """Show the images with their states, and count them."""
        rows = self._project.rows
        self.table.show_rows(rows)
        found = Counter(row.state for row in rows)
        text = tr("{done} of {count} images done.", done=found["done"], count=found.total())
        if found["doubtful"]:
            text += " " + tr("{count} doubtful.", count=found["doubtful"])
        if self._project.proposes:
            text += " " + insert_keys(tr("Untouched ones are run when you open them: Enter accepts what is proposed."))
        self.summary.setText(text)
