"""Opening images and exporting contours."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtWidgets import QMenu

from app.model.language import tr
from app.model.samples import samples
from app.model.situation import is_started
from app.views.dialogs import ask_for_export, ask_for_image
from app.views.entry import Entry, Submenu
from app.views.part import Desk, Part


class FilesPart(Part):
    """What is read and written."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self._folder = ""

    def entries(self) -> Sequence[Entry | Submenu]:
        """Open, samples, export, quit."""
        return (
            Entry(
                name="open",
                menu="File",
                text=tr("&Open image…"),
                short=tr("Open"),
                do=self._open,
                shortcuts=("Ctrl+O",),
                tip=tr("Open an image."),
                icon="open",
            ),
            Submenu(name="samples", menu="File", text=tr("Open &sample"), fill=self._fill_samples),
            Entry(
                name="export",
                menu="File",
                text=tr("&Export contours…"),
                short=tr("Export"),
                do=self._export,
                shortcuts=("Ctrl+E",),
                tip=tr("Write the contours to a file."),
                icon="export",
                gap=True,
                when=is_started,
            ),
            Entry(
                name="quit",
                menu="File",
                text=tr("&Quit"),
                do=self.desk.window.close,
                shortcuts=("Ctrl+Q",),
                tip=tr("End the program."),
                gap=True,
            ),
        )

    def open_image(self, path: str) -> None:
        """Open an image; what was said about an earlier one is over."""
        self.desk.stage.messages.hide()
        self.desk.session.open(path)

    def _fill_samples(self, menu: QMenu) -> None:
        for sample in samples():
            action = menu.addAction(sample.title)
            action.triggered.connect(lambda _=False, path=str(sample.path): self.open_image(path))
            action.setStatusTip(sample.about)

    def _open(self) -> None:
        chosen = ask_for_image(self.desk.window, self._folder)
        if chosen:
            self._folder = str(Path(chosen).parent)
            self.open_image(chosen)

    def _export(self) -> None:
        image = self.desk.session.document.image
        stem = Path(image.name).stem if image else "contours"
        chosen = ask_for_export(self.desk.window, str(Path(self._folder) / f"{stem}_contours.svg"))
        if chosen:
            self._folder = str(Path(chosen).parent)
            self.desk.session.export(chosen)
