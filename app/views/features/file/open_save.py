"""Opening and saving."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from PySide6.QtCore import QTimer, QUrl
from PySide6.QtWidgets import QMenu

from app.model.document.document import Document
from app.model.document.samples import sample_at, samples
from app.model.parameters.presets import SUFFIX as PRESET
from app.model.state.situation import has_image
from app.model.text.language import tr
from app.session.exchange.messages import Opened
from app.session.signals import OF_THE_PROGRAM, OPENING
from app.session.storage.session_file import DocumentFile, Written
from app.views.files.recent_files import RecentFiles
from app.views.widgets.action_spec import ActionSpec, Submenu
from app.views.window import dialogs
from app.views.window.feature import Feature, FeatureContext
from app.views.window.file_dialogs import images_and_sessions, sessions
from cpm_core.formats import CONTOURS_READABLE, FOR_CENTERLINES, READABLE, SURFACES_READABLE
from cpm_core.formats.images.reading import Reading

CONTOURS = frozenset((*CONTOURS_READABLE, *SURFACES_READABLE, *FOR_CENTERLINES)) - frozenset(READABLE)
"""Suffixes of files that are no documents, but contours or points for the one that is open."""


class OpenSaveFeature(Feature):
    """Opening of images, sessions, points and presets, and the session file."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.document_file = DocumentFile(context.session, self._view_state)
        self.recent = RecentFiles(context.preferences, lambda path: self.take([path]))
        self.bring_in: Callable[[Path], None] | None = None
        """Imports the file of a preset; set by the window."""
        self.import_contours: Callable[[Path], None] | None = None
        """Reads a file of contours or points; set by the window."""
        self._left: tuple[Document, int] | None = None
        context.session.may_replace = self._may_replace
        self.document_file.truth = lambda: context.workspace.truth.file
        self.document_file.changed.connect(self._name_window)
        self.document_file.restored.connect(self._use_view_state)
        context.session.document_changed.connect(lambda _: self._name_window())
        context.session.listen(Opened, self._take_opened)
        context.session.listen(Written, lambda written: self._remember(written.order.path))
        self._name_window()

    def action_specs(self) -> Sequence[ActionSpec | Submenu]:
        """Open, save, quit."""
        return (
            ActionSpec(name="open", menu="File", text=tr("&Open…"), short=tr("Open"), do=self.ask_for_file,
                       shortcuts=("Ctrl+O",), tip=tr("Open an image or a session."), icon="open"),
            Submenu(name="recent", menu="File", text=tr("Open &recent"), fill=self.recent.fill),
            Submenu(name="samples", menu="File", text=tr("Open sa&mple"), fill=self._fill_samples),
            ActionSpec(name="save", menu="File", text=tr("&Save session"), short=tr("Save"), do=self.save,
                       shortcuts=("Ctrl+S",), icon="save",
                       tip=tr("Save what you see: drawing, runs, contours, objects, view."), gap=True, when=has_image),
            ActionSpec(name="save_as", menu="File", text=tr("Save session &as…"), do=self.save_as,
                       shortcuts=("Ctrl+Shift+S",), tip=tr("Save the session to another file and continue with it."),
                       when=has_image),
            ActionSpec(name="quit", menu="File", text=tr("&Quit"), do=self.context.window.close, shortcuts=("Ctrl+Q",),
                       tip=tr("Quit the program."), gap=True),
        )  # fmt: skip

    def take(self, paths: Sequence[Path], resumes: bool = False) -> None:
        """Open files by their kind: images, sessions, contours, points and presets.

        Contours and points are used in the image that is open, presets are imported.

        An image that `resumes` is opened with the session beside it. Of a recent file that part is opened which was
        chosen last.
        """
        self.context.canvas_area.messages.keep_only(*OF_THE_PROGRAM)
        documents = [path for path in paths if path.suffix.lower() not in (*CONTOURS, PRESET)]
        for path in paths:
            if path.suffix.lower() == PRESET:
                self._bring_in(path)
            elif path.suffix.lower() in CONTOURS and self.import_contours is not None:
                self.import_contours(path)
        if documents and self._may_open():
            as_volume, reading = self.recent.part_of(documents[0])
            self.context.session.open(documents[0], resumes=resumes, as_volume=as_volume, reading=reading)
            if len(documents) > 1:
                message = tr("Only one image can be open at a time: of {count} files, {name} is opened.")
                self.context.session.say(message.format(count=len(documents), name=documents[0].name), topic=OPENING)

    def take_part(self, path: Path, as_volume: bool, reading: Reading) -> None:
        """Open a part of a file, as a volume or as an image."""
        self.context.canvas_area.messages.keep_only(*OF_THE_PROGRAM)
        if self._may_open():
            self.context.session.open(path, as_volume=as_volume, reading=reading)

    def take_dropped(self, urls: Sequence[QUrl]) -> None:
        """Open files that were dropped on the window."""
        elsewhere = [url for url in urls if not url.isLocalFile()]
        self.take([Path(url.toLocalFile()) for url in urls if url.isLocalFile()])
        if elsewhere:
            message = tr("{place} is not a file on this computer. Save it first, then open it.")
            self.context.session.say(message.format(place=elsewhere[0].toDisplayString()), True, OPENING)

    def ask_for_file(self) -> None:
        """Ask for a file and open it."""
        chosen = self.context.files.ask_for_file("open", tr("Open"), images_and_sessions())
        if chosen is not None:
            self.take([chosen])

    def save(self) -> None:
        """Save to the present file, or ask for one."""
        if self.document_file.path is None:
            self.save_as()
        else:
            self.document_file.save(self.document_file.path)

    def save_as(self) -> None:
        """Ask for a file and save to it."""
        path = self._ask_where()
        if path is not None:
            self.document_file.save(path)

    def may_leave(self) -> bool:
        """Whether the document may be closed; asks about unsaved work and saves it if the user agrees."""
        self.document_file.finish()
        if not self.document_file.unsaved:
            return True
        answer = dialogs.ask_about_unsaved(self.context.window, self.document_file.name, self.document_file.lost)
        if answer != "save":
            return answer == "discard"
        path = self.document_file.path or self._ask_where()
        return path is not None and self.document_file.save_at_once(path)

    def close(self) -> bool:
        """Ask about unsaved work first."""
        return self.may_leave()

    # Internal

    def _view_state(self) -> dict[str, Any]:
        """What is shown and how, as plain JSON."""
        context = self.context
        return {**context.canvas_area.canvas.view_state(), **context.workspace.slices.view_state()}

    def _use_view_state(self, state: Mapping[str, Any]) -> None:
        self.context.workspace.slices.use_view_state(state)  # the place on the canvas lies in the slice
        self.context.canvas_area.canvas.use_view_state(state)

    @property
    def _work(self) -> tuple[Document, int]:
        """What would be lost."""
        return self.context.session.document, self.context.session.generation

    def _may_open(self) -> bool:
        """Whether another image may be opened; not asked again while one is being opened and nothing has changed."""
        if not (self.context.session.opening and self._left == self._work):
            if not self.may_leave():
                return False
            self._left = self._work
        return True

    def _may_replace(self, opened: Opened) -> bool:
        """Whether an image that has been prepared may replace this one; work done meanwhile is asked about.

        When a page is turned nothing is lost.
        """
        turned = opened.saved is not None and opened.saved.turned
        if turned or not self.document_file.unsaved or self._left == self._work:
            return True
        QTimer.singleShot(0, self.context.window, lambda: self._ask_again(opened))
        return False

    def _ask_again(self, opened: Opened) -> None:
        if self.may_leave():
            self.context.session.use(opened)
        else:
            kept = tr("{name} was not opened, and your work stays open.")
            self.context.session.say(kept.format(name=opened.path.name))

    def _fill_samples(self, menu: QMenu) -> None:
        for sample in samples():
            action = menu.addAction(sample.title)
            action.triggered.connect(lambda _=False, path=sample.path: self.take([path]))
            action.setStatusTip(sample.about)

    def _ask_where(self) -> Path | None:
        path, name = self.document_file.path, self.document_file.name
        folder = path.parent if path is not None else None
        return self.context.files.ask_where_to_save("session", tr("Save session"), name, [sessions()], folder)

    def _bring_in(self, path: Path) -> None:
        if self.bring_in is not None:
            self.bring_in(path)

    def _take_opened(self, opened: Opened) -> None:
        self._left = None
        if opened.saved is not None and opened.saved.file.truth is not None:
            folder = (opened.saved.path or opened.path).absolute().parent
            self.context.workspace.truth.restore(opened.saved.file.truth, folder)
        path = opened.saved.path if opened.saved and opened.saved.path else opened.path
        if sample_at(opened.path) is None or opened.saved:
            self._remember(path)
            self.recent.keep_part(opened)

    def _remember(self, path: Path) -> None:
        self.recent.add(path)
        self.context.files.remember("open", path)

    def _name_window(self) -> None:
        image = self.context.session.document.image
        name = self.document_file.path.name if self.document_file.path else image.name if image else ""
        title = f"{name}[*] – CPM" if name else "CPM"
        window = self.context.window
        if window.windowTitle() != title:
            window.setWindowTitle(title)
        window.setWindowModified(self.document_file.unsaved)
