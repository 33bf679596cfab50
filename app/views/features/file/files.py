"""Opening, saving, exporting."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from PySide6.QtCore import QUrl
from PySide6.QtWidgets import QMenu

from app.model.document import edits
from app.model.document.samples import sample_at, samples
from app.model.parameters.presets import SUFFIX as PRESET
from app.model.state.situation import has_contours, has_image
from app.model.text.language import tr
from app.session.exchange.messages import Exported, Opened, Report
from app.session.features.import_points import PointsRead, read_points
from app.session.storage.session_file import Keeper, Written
from app.views.canvas.view_state import use_view_state, view_state
from app.views.widgets.entry import Entry, Submenu
from app.views.window import unsaved
from app.views.window.dialogs import ask_for_export, ask_for_file, ask_where_to_save
from app.views.window.part import Desk, Part
from app.views.window.recent_files import RecentFiles

_FOLDER, _EXPORTS = "files/folder", "files/exports"
"""Preferences: folders of what was opened or saved, and exported, last."""

POINTS = ".csv"


class FilesPart(Part):
    """What is read and written."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        canvas = desk.stage.canvas
        self.keeper = Keeper(desk.session, lambda: view_state(canvas))
        self.recent = RecentFiles(desk.preferences, lambda path: self.take([path]))
        self.bring_in: Callable[[Path], None] | None = None
        """Takes in the file of a preset; the window knows who does."""
        self._exported: Path | None = None
        self.keeper.changed.connect(self._name_window)
        self.keeper.restored.connect(lambda state: use_view_state(canvas, state))
        desk.session.document_changed.connect(lambda _: self._name_window())
        desk.session.reported.connect(self._hear)
        self._name_window()

    def entries(self) -> Sequence[Entry | Submenu]:
        """Open, save, export, quit."""
        return (
            Entry(
                name="open",
                menu="File",
                text=tr("&Open…"),
                short=tr("Open"),
                do=self._open,
                shortcuts=("Ctrl+O",),
                tip=tr("Open an image or a session."),
                icon="open",
            ),
            Submenu(name="recent", menu="File", text=tr("Open &recent"), fill=self.recent.fill),
            Submenu(name="samples", menu="File", text=tr("Open sa&mple"), fill=self._fill_samples),
            Entry(
                name="save",
                menu="File",
                text=tr("&Save session"),
                short=tr("Save"),
                do=self.save,
                shortcuts=("Ctrl+S",),
                icon="save",
                tip=tr("Save what is drawn, the parameters, what was said about contours, and the view."),
                gap=True,
                when=has_image,
            ),
            Entry(
                name="save_as",
                menu="File",
                text=tr("Save session &as…"),
                do=self.save_as,
                shortcuts=("Ctrl+Shift+S",),
                tip=tr("Save the session to another file, and keep to that."),
                when=has_image,
            ),
            *self._exports(),
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

    def take(self, paths: Sequence[Path]) -> None:
        """Do with files what suits them: open images and sessions, draw points, bring in presets."""
        self.desk.stage.messages.hide()
        documents = [path for path in paths if path.suffix.lower() not in (POINTS, PRESET)]
        for path in paths:
            if path.suffix.lower() == PRESET:
                self._bring_in(path)
            elif path.suffix.lower() == POINTS:
                self._draw(path)
        if documents and self.may_leave():
            self.desk.session.open(documents[0])
            if len(documents) > 1:
                told = tr("One image is open at a time: of {count} files, {name} is opened.")
                self.desk.session.say(told.format(count=len(documents), name=documents[0].name))

    def take_dropped(self, urls: Sequence[QUrl]) -> None:
        """Take files that were dropped on the window."""
        elsewhere = [url for url in urls if not url.isLocalFile()]
        self.take([Path(url.toLocalFile()) for url in urls if url.isLocalFile()])
        if elsewhere:
            told = tr("{place} is not a file on this computer: save it first, then open it.")
            self.desk.session.say(told.format(place=elsewhere[0].toDisplayString()), True)

    def save(self) -> None:
        """Save to the file there is, else ask for one."""
        if self.keeper.path is None:
            self.save_as()
        else:
            self.keeper.save(self.keeper.path)

    def save_as(self) -> None:
        """Ask for a file and save to it."""
        path = self._ask_where()
        if path is not None:
            self.keeper.save(path)

    def may_leave(self) -> bool:
        """Whether what is open may be closed; unsaved work is asked about, and saved if that is wished."""
        if not self.keeper.unsaved:
            return True
        answer = unsaved.ask(self.desk.window, self.keeper.name)
        if answer != "save":
            return answer == "discard"
        path = self.keeper.path or self._ask_where()
        return path is not None and self.keeper.save_at_once(path)

    def close(self) -> bool:
        """Not before unsaved work has been asked about."""
        return self.may_leave()

    # Inside

    def _exports(self) -> Sequence[Entry]:
        return (
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
                when=has_contours,
            ),
            Entry(
                name="export_again",
                menu="File",
                text=tr("Export a&gain"),
                do=self._export_again,
                shortcuts=("Ctrl+Shift+E",),
                tip=tr("Write the contours to the same file as the last time."),
                when=lambda situation: has_contours(situation) and self._exported is not None,
                worded=lambda situation: self._again_text(),
            ),
        )

    def _again_text(self) -> str:
        if self._exported is None:
            return tr("Export a&gain")
        return tr("Export a&gain to {name}").format(name=self._exported.name.replace("&", "&&"))

    def _fill_samples(self, menu: QMenu) -> None:
        for sample in samples():
            action = menu.addAction(sample.title)
            action.triggered.connect(lambda _=False, path=sample.path: self.take([path]))
            action.setStatusTip(sample.about)

    def _open(self) -> None:
        chosen = ask_for_file(self.desk.window, self.desk.preferences.get(_FOLDER, ""))
        if chosen:
            self.take([Path(chosen)])

    def _ask_where(self) -> Path | None:
        image, path = self.desk.session.document.image, self.keeper.path
        beside = path.parent if path else None
        if beside is None and image is not None and sample_at(Path(image.path)) is None:
            beside = Path(image.path).parent
        folder = beside or Path(self.desk.preferences.get(_FOLDER, ""))
        chosen = ask_where_to_save(self.desk.window, str(folder / self.keeper.name))
        return Path(chosen) if chosen else None

    def _export(self) -> None:
        image, last = self.desk.session.document.image, self._exported
        suffix = "".join(last.suffixes[-1:]) if last else ".svg"
        stem = Path(image.name).stem if image else "contours"
        folder = Path(self.desk.preferences.get(_EXPORTS, ""))
        chosen = ask_for_export(self.desk.window, str(folder / f"{stem}_contours{suffix}"))
        if chosen:
            self.desk.session.export(chosen)

    def _export_again(self) -> None:
        if self._exported is not None:
            self.desk.session.export(self._exported)

    def _draw(self, path: Path) -> None:
        if self.desk.session.document.image is None:
            self.desk.session.say(tr("Open an image first; then {name} can be drawn.").format(name=path.name), True)
        else:
            read_points(self.desk.session, path)

    def _bring_in(self, path: Path) -> None:
        if self.bring_in is not None:
            self.bring_in(path)

    def _hear(self, report: Report) -> None:
        if isinstance(report, Opened):
            path = report.saved.path if report.saved and report.saved.path else report.path
            self._exported = None
            if sample_at(report.path) is None or report.saved:
                self._remember(path)
        elif isinstance(report, Written):
            self._remember(report.path)
        elif isinstance(report, Exported):
            self._exported = report.path
            self.desk.preferences.put(_EXPORTS, str(report.path.absolute().parent))
            self.desk.session.status_changed.emit()
        elif isinstance(report, PointsRead):
            name = tr("draw {name}").format(name=report.path.name)
            self.desk.session.edit(name, lambda document: edits.add_shape(document, report.points))

    def _remember(self, path: Path) -> None:
        self.recent.add(path)
        self.desk.preferences.put(_FOLDER, str(path.absolute().parent))

    def _name_window(self) -> None:
        image = self.desk.session.document.image
        name = self.keeper.path.name if self.keeper.path else image.name if image else ""
        title = f"{name}[*] – CPM" if name else "CPM"
        window = self.desk.window
        if window.windowTitle() != title:
            window.setWindowTitle(title)
        window.setWindowModified(self.keeper.unsaved)
