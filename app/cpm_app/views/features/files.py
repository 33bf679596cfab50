"""Opening and saving: files, folders, the start screen, and work left behind by a crash."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import QDateTime, QLocale, Qt, QTimer, QUrl
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QHBoxLayout, QWidget

from cpm_app.model.document.document import Document
from cpm_app.model.document.samples import find_sample_at, load_samples
from cpm_app.model.preferences.table import SAVE_IN_FOLDER
from cpm_app.model.state.situation import has_image
from cpm_app.model.text.language import elide_middle, tr
from cpm_app.session.exchange.messages import ImageOpened, ImageReady, OpeningFailed
from cpm_app.session.session_messages import JOURNAL_CATEGORY, OPENING_CATEGORY, PROGRAM_CATEGORIES, RECOVERY_CATEGORY
from cpm_app.session.storage.recovery import Journal, Leftover, find_leftovers, journals_folder
from cpm_app.session.storage.session_file import SessionWritten
from cpm_app.session.storage.thumbnails import THUMBNAIL_SIZE, ThumbnailStore, crop_middle, thumbnails_folder
from cpm_app.session.tasks.opening import is_image_folder
from cpm_app.views.canvas.canvas_area import FIRST_TOOL
from cpm_app.views.features.exchange import ImportFeature
from cpm_app.views.files.recent_files import RecentFiles
from cpm_app.views.files.start_screen import StartEntry, StartScreen
from cpm_app.views.widgets.actions import ActionButton, ActionSpec, Submenu
from cpm_app.views.widgets.containers import create_dim_label, fill_layout
from cpm_app.views.window import dialogs
from cpm_app.views.window.dialogs import ALL_FILES, SESSION_FILES, FileKind, QuestionDialog
from cpm_app.views.window.window import Feature
from cpm_core.formats import (
    CENTERLINES_WRITABLE,
    CONTOURS_READABLE,
    IMAGES_READABLE,
    SESSION_SUFFIX,
    SURFACES_READABLE,
    Reading,
)

CONTOUR_SUFFIXES = frozenset((*CONTOURS_READABLE, *SURFACES_READABLE, *CENTERLINES_WRITABLE)) - frozenset(
    IMAGES_READABLE
)
"""Suffixes of files that hold contours or points for the open document rather than a document."""

_SEGMENTATION_ENDINGS = (".seg.nrrd", ".seg.dcm")
"""Endings of segmentation files, which are imported if a volume is open."""


class OpenSaveFeature(Feature):
    """Opening of images, sessions, points and presets, and the session file."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        window = self.window
        self.document_file = window.document_file
        self.recent = RecentFiles(window.preferences, window.open_image)
        self._project = window.workspace.project
        self._confirmed_work: tuple[Document, int] | None = None
        """Document and generation that the user has agreed to close."""
        session = self.session
        session.can_replace_image = self._confirm_replacement
        window.files_wanted.connect(self.open_files)
        window.urls_dropped.connect(self.open_dropped)
        self.document_file.changed.connect(self._update_title)
        self.document_file.restored.connect(window.workspace.slices.use_view_state)
        self.document_file.restored.connect(self.canvas.use_view_state)  # in the slice that has just been restored
        session.document_changed.connect(lambda _: self._update_title())
        session.store.add_listener(ImageOpened, self._on_image_opened)
        session.store.add_listener(
            SessionWritten, lambda written: None if written.automatic else self._remember_path(written.path)
        )
        self._update_title()
        self.actions = (
            ActionSpec("open", "File", "&Open…", "Open an image or a session.", self.ask_for_document, "Ctrl+O",
                       short=tr("Open"), icon="open"),
            ActionSpec("open_folder", "File", "Open fol&der…",
                       "Open the images of a folder one after another, each saved as you go on.",
                       self.ask_for_folder, "Ctrl+Alt+O"),
            Submenu("recent", "File", "Open &recent", self.recent.fill_menu),
            ActionSpec("save", "File", "&Save session", "Save everything: drawing, runs, contours, objects and view.",
                       self.save, "Ctrl+S", short=tr("Save"), icon="save", gap=True, when=has_image),
            ActionSpec("save_as", "File", "Save session &as…",
                       "Save the session to another file and continue with it.", self.save_as, "Ctrl+Shift+S",
                       when=has_image),
            ActionSpec("quit", "File", "&Quit", "Quit the program.", window.close, "Ctrl+Q", gap=True),
        )  # fmt: skip

    def open_files(self, paths: Sequence[Path], resumes: bool = False) -> None:
        """Open files by their kind: images, sessions, contours and points, or a folder of images as a project.

        Contours and points are used in the image that is open.

        With `resumes` an image is opened with the session next to it. The part of a recent file that was selected last
        is opened again.
        """
        self.window.canvas_area.messages.keep_categories(*PROGRAM_CATEGORIES)
        documents = []
        for path in paths:
            segments = path.name.lower().endswith(_SEGMENTATION_ENDINGS) and self.session.scene.slices is not None
            if path.suffix.lower() in CONTOUR_SUFFIXES or segments:
                self.window.get_feature(ImportFeature).import_file(path)
            else:
                documents.append(path)
        if documents and self._confirm_opening():
            self._open_document(documents[0], resumes)
            if len(documents) > 1:
                message = tr("Only one image can be open at a time: of {count} files, {name} is opened.")
                self.session.messages.show(
                    message.format(count=len(documents), name=documents[0].name), category=OPENING_CATEGORY
                )

    def _open_document(self, path: Path, resumes: bool) -> None:
        """Open an image, a session, or a folder of images."""
        if is_image_folder(path):
            self._project.open_folder(path)
        elif self._project.contains(path):
            self._project.open_image(path)
        else:
            as_volume, reading = self.recent.find_part(path)
            self.session.open_file(path, resumes=resumes, as_volume=as_volume, reading=reading)

    def open_part(self, path: Path, as_volume: bool, reading: Reading) -> None:
        """Open a part of a file as a volume or as an image."""
        self.window.canvas_area.messages.keep_categories(*PROGRAM_CATEGORIES)
        if self._confirm_opening():
            self.session.open_file(path, as_volume=as_volume, reading=reading)

    def open_dropped(self, urls: Sequence[QUrl]) -> None:
        """Open files that were dropped on the window."""
        elsewhere = [url for url in urls if not url.isLocalFile()]
        self.open_files([Path(url.toLocalFile()) for url in urls if url.isLocalFile()])
        if elsewhere:
            place = elsewhere[0].toDisplayString()
            message = tr("{place} is not a file on this computer. Save it first, then open it.", place=place)
            self.session.messages.show(message, True, OPENING_CATEGORY)

    def ask_for_document(self) -> None:
        """Ask for an image or a session and open it."""
        both, images = (
            FileKind(tr("Images and sessions"), (*IMAGES_READABLE, SESSION_SUFFIX)),
            FileKind(tr("Images"), tuple(IMAGES_READABLE)),
        )
        chosen = self.window.files.ask_for_file("open", tr("Open"), (both, images, SESSION_FILES, ALL_FILES))
        if chosen is not None:
            self.open_files([chosen])

    def ask_for_folder(self) -> None:
        """Ask for a folder of images and open it as a project."""
        chosen = self.window.files.ask_for_folder(tr("Folder of the images"))
        if chosen:
            self.open_files([Path(chosen)])

    def save(self) -> None:
        """Save to the current file, to that of the image in its project, or ask for one."""
        path = self.document_file.path
        if path is None and self._project.session_path is not None and self._project.make_folder():
            path = self._project.session_path
        if path is None:
            self.save_as()
        else:
            self.document_file.save(path)

    def save_as(self) -> None:
        """Ask for a file and save to it."""
        path = self._ask_session_path()
        if path is not None:
            self.document_file.save(path)

    def close(self) -> bool:
        """Return whether the document may be closed; ask about unsaved work, and save it if the user agrees.

        Work on an image of a project is saved without a question, if it can be.
        """
        self.document_file.finish_saving()
        if self._project.save_and_wait() or not self.document_file.unsaved:
            return True
        answer = dialogs.ask_about_unsaved(self.window, self.document_file.name, self.document_file.unsaved_parts)
        if answer != "save":
            return answer == "discard"
        path = self.document_file.path or self._ask_session_path()
        return path is not None and self.document_file.save_and_wait(path)

    # Internal

    @property
    def _work_at_risk(self) -> tuple[Document, int]:
        """Document and generation that would be lost."""
        return self.session.document, self.session.store.generation

    def _confirm_opening(self) -> bool:
        """Return whether another image may be opened.

        The user is not asked again while one is being opened and nothing has changed.
        """
        if not (self.session.opening_name and self._confirmed_work == self._work_at_risk):
            if not self.close():
                return False
            self._confirmed_work = self._work_at_risk
        return True

    def _confirm_replacement(self, opened: ImageOpened) -> bool:
        """Return whether a loaded image may replace this one; ask about work done in the meantime.

        Turning a page loses nothing and needs no question.
        """
        turned = opened.saved is not None and opened.saved.is_other_page
        if turned or not self.document_file.unsaved or self._confirmed_work == self._work_at_risk:
            return True
        if self._project.save_and_wait():
            return True

        def confirm_again() -> None:
            if self.close():
                self.session.replace_image(opened)
            else:
                self.session.messages.show(
                    tr("{name} was not opened, and your work stays open.", name=opened.path.name)
                )

        QTimer.singleShot(0, self.window, confirm_again)
        return False

    def _ask_session_path(self) -> Path | None:
        path, name = self.document_file.path, self.document_file.name
        folder = path.parent if path is not None else None
        return self.window.files.ask_where_to_save("session", tr("Save session"), name, [SESSION_FILES], folder)

    def _on_image_opened(self, opened: ImageOpened) -> None:
        self._confirmed_work = None
        saved, objects = opened.saved, self.session.document.objects
        path = saved.path if saved and saved.path else opened.path
        begins = saved is not None and not saved.is_other_page and self._project.folder is None
        if begins and (objects.items or objects.clicks) and self.canvas.dispatcher.tool.name == FIRST_TOOL:
            # nobody has chosen the first tool for this session; its action is enabled once the image is shown
            QTimer.singleShot(0, self.window, partial(self.window.trigger_action, "objects"))
        if saved is not None and saved.file.truth is not None:
            self.window.workspace.comparison.restore_truth(saved.file.truth, path.absolute().parent)
        if self._project.folder is not None:
            self._remember_path(self._project.folder)
        elif find_sample_at(opened.path) is None or saved:
            self._remember_path(path)
            self.recent.remember_part(opened)

    def _remember_path(self, path: Path) -> None:
        self.recent.add_path(path)
        self.window.files.remember_path("open", path)

    def _update_title(self) -> None:
        image = self.session.document.image
        name = self.document_file.path.name if self.document_file.path else image.name if image else ""
        title = f"{name}[*] – CPM" if name else "CPM"
        if self.window.windowTitle() != title:
            self.window.setWindowTitle(title)
        self.window.setWindowModified(self.document_file.unsaved)


class StartFeature(Feature):
    """Start screen, with a picture of each image and session that has been open."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        window = self.window
        self.pictures = ThumbnailStore(thumbnails_folder())
        self.screen = StartScreen(window.canvas_area)
        self._recent = window.get_feature(OpenSaveFeature).recent
        self._recent.cleared.append(self.pictures.clear)
        self.screen.open_requested.connect(window.get_feature(OpenSaveFeature).ask_for_document)
        self.screen.file_selected.connect(window.open_image)
        self.screen.back_requested.connect(self.show_image)
        session = self.session
        session.image_changed.connect(self.show_image)
        session.store.add_listener(ImageReady, lambda _: self._store_picture())
        session.store.add_listener(SessionWritten, lambda _: self._store_picture())
        session.store.add_listener(OpeningFailed, self._on_not_opened)
        self.actions = (
            ActionSpec("start", "File", "Sa&mples and recent files", "Show samples and recent files as pictures.",
                       self.toggle_start_screen, "Alt+Home", short=tr("Start"), icon="home"),
        )  # fmt: skip

    def close(self) -> bool:
        """Store a picture of the open image."""
        self._store_picture()
        return True

    def show_start_screen(self, error: str = "") -> None:
        """Show the start screen in place of the image, with the `error` of a file that could not be opened."""
        shown = [
            StartEntry(
                sample.path, crop_middle(QImage(str(sample.picture)), THUMBNAIL_SIZE), sample.title, "", sample.about
            )
            for sample in load_samples()
        ]
        recent = []
        for path in self._recent_paths:
            changed = QDateTime.fromSecsSinceEpoch(int(path.stat().st_mtime)).date()
            below = f"{path.parent.name} · {QLocale().toString(changed, QLocale.FormatType.ShortFormat)}"
            recent.append(StartEntry(path, self.pictures.load_thumbnail(path), path.name, below, str(path)))
        self.screen.show_entries(recent, shown, self.session.document.image is not None, error)

    def show_image(self) -> None:
        """Show the image, if there is one."""
        if self.screen.isVisible() and self.session.document.image is not None:
            self.screen.hide()
            self.canvas.setFocus()

    def toggle_start_screen(self) -> None:
        """Show the start screen, or the image again."""
        if self.screen.isVisible():
            self.show_image()
        else:
            self.show_start_screen()

    def offer_recent_work(self) -> None:
        """Offer the newest work when the program starts with a sample."""
        session = self.session

        def on_opened(opened: ImageOpened) -> None:
            session.store.remove_listener(ImageOpened, on_opened)
            newest = next(iter(self._recent_paths), None)
            if newest is not None and opened.saved is None:
                self.window.offers.add_offer(
                    tr("Continue with {name}?", name=newest.name),
                    (tr("Open {name}", name=newest.name), partial(self.window.open_image, newest, True)),
                    (tr("Recent work"), self.show_start_screen),
                )

        session.store.add_listener(ImageOpened, on_opened)

    @property
    def _recent_paths(self) -> list[Path]:
        """Recent files and folders that still exist."""
        return [path for path in self._recent.paths if path.exists()]

    def _on_not_opened(self, refused: OpeningFailed) -> None:
        """Show the start screen unless there is work: an untouched sample would be mistaken for the file."""
        image = self.session.document.image
        if image is None or (find_sample_at(Path(image.path)) and not self.window.document_file.unsaved):
            self.show_start_screen(refused.message)

    def _store_picture(self) -> None:
        """Store the view of the canvas as the picture of the image, and of its session if there is one."""
        image = self.session.document.image
        if image is None:
            return
        picture, folder = self.canvas.grab().toImage(), self.window.workspace.project.folder
        for path in (Path(image.path), self.window.document_file.path) if folder is None else (folder,):
            if path is not None and find_sample_at(path) is None:
                self.pictures.save_thumbnail(path, picture)


class FolderBar(QWidget):
    """Position in the folder ("File 3 of 24") with buttons; hidden if the image is the only one of its folder."""

    def __init__(self) -> None:
        super().__init__()
        style = Qt.ToolButtonStyle.ToolButtonIconOnly
        self.back, self.forward = (ActionButton(name, style) for name in ("previous_image", "next_image"))
        self._place = create_dim_label()
        fill_layout(QHBoxLayout(self), self.back, self._place, self.forward, margins=(6, 0, 6, 0), spacing=2)
        self.hide()

    def show_folder_position(self, index: int, count: int, folder: str) -> None:
        """Show the position of an image in its folder; the first one has index 0."""
        self._place.setText(tr("File {number} of {count}", number=index + 1, count=count))
        self._place.setToolTip(tr("Images in {folder}", folder=folder))
        self.setVisible(count > 1)


class FolderFeature(Feature):
    """Steps to the previous and the next image of a folder, each with the session next to it."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        window = self.window
        self.bar = FolderBar()
        window.statusBar().addPermanentWidget(self.bar)
        self._images: tuple[Path, ...] = ()
        self._index = self._next_index = 0
        self.session.store.add_listener(ImageOpened, self._on_image_opened)
        self.session.store.add_listener(OpeningFailed, self._on_not_opened)
        self.actions = (
            ActionSpec("previous_image", "File", "Pre&vious image in the folder",
                       "Open the previous image in the folder, with its session.", partial(self.open_neighbor, -1),
                       "Alt+Left", "back", gap=True, when=lambda _: self._index > 0),
            ActionSpec("next_image", "File", "Ne&xt image in the folder",
                       "Open the next image in the folder, with its session.", partial(self.open_neighbor, 1),
                       "Alt+Right", "forward", when=lambda _: self._index + 1 < len(self._images)),
        )  # fmt: skip

    def open_neighbor(self, by: int) -> None:
        """Open the next image (1) or the previous one (-1) that still exists."""
        begin = self._next_index if self.session.opening_name else self._index
        ahead = range(begin + by, len(self._images) if by > 0 else -1, by)
        place = next((place for place in ahead if self._images[place].is_file()), None)
        if place is not None and self._save_silently():
            self._next_index = place
            self.window.open_image(self._images[place], True)

    def _save_silently(self) -> bool:
        """Save without a question if the user prefers that and no file is overwritten; return False on failure."""
        file, image = self.window.document_file, self.session.document.image
        if image is None or not file.unsaved or not self.window.preferences.read_preference(SAVE_IN_FOLDER):
            return True
        if self.window.workspace.project.current is not None:
            return True  # saved there
        default_path = Path(image.path).with_suffix(SESSION_SUFFIX)
        if file.path is None and default_path.exists():
            return True  # the usual question follows
        return file.save_and_wait(file.path or default_path)

    def _on_image_opened(self, opened: ImageOpened) -> None:
        project, path, images = self.window.workspace.project, opened.path, opened.folder_images
        if project.current is not None:
            path, images = project.current, project.images
        known = path in images and find_sample_at(path) is None
        self._images = images if known else ()
        self._index = self._next_index = images.index(path) if known else 0
        self.bar.show_folder_position(self._index, len(self._images), path.parent.name)
        self.window.refresh_actions()

    def _on_not_opened(self, _: OpeningFailed) -> None:
        self._next_index = self._index


_MAX_SHOWN_PATH = 300
"""Largest number of characters of a path that a question shows."""


class RecoveryFeature(Feature):
    """Recovery of unsaved work after a crash."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        self._folder = journals_folder()
        self.journal = Journal(self.window.document_file, self._folder, self.window.preferences)
        self.journal.write_ended.connect(lambda error: self.session.messages.set_error(error, JOURNAL_CATEGORY))
        self.box: QuestionDialog | None = None
        self._waiting: list[Leftover] = []
        self._restoring: Leftover | None = None
        self.session.store.add_listener(ImageOpened, self._on_image_opened)

    def offer_recovery(self) -> None:
        """Offer to restore the unsaved work of earlier windows, and report what cannot be read."""
        self._waiting, troubles = find_leftovers(self._folder)
        if troubles:
            self.session.messages.show(" ".join(troubles), True, RECOVERY_CATEGORY)
        self._ask_next()

    def close(self) -> bool:
        """Remove the journal of this window; keep work that the user has not decided on."""
        for leftover in self._waiting:
            leftover.keep_for_later()
        if self._restoring is not None:
            self._restoring.keep_for_later()
        self._waiting, self._restoring = [], None
        if self.box is not None:
            self.box.close()
        self.journal.close()
        return True

    def _ask_next(self) -> None:
        if not self._waiting:
            return
        leftover = self._waiting[0]
        answers = {"restore": tr("&Restore"), "discard": tr("&Discard this work"), "later": tr("Ask me &later")}
        text = tr("CPM ended unexpectedly. Restore “{name}”?", name=elide_middle(leftover.name, _MAX_SHOWN_PATH))
        details = "\n".join(_describe_leftover(leftover))
        title = tr("Restore unsaved work")
        self.box = box = QuestionDialog(self.window, title, text, details, answers, ("discard",))
        box.buttonClicked.connect(lambda _: self._on_answer(box.read_answer()))
        box.open()

    def _on_answer(self, answer: str) -> None:
        if not self._waiting:  # another key has reached the box before it was gone
            return
        if answer == "restore":
            if self._restoring is not None:  # its image was not found: keep it for another time
                self._restoring.keep_for_later()
            self._restoring = self._waiting.pop(0)
            self.session.begin_opening(self._restoring.open_request)
        elif answer == "discard":
            self._waiting.pop(0).discard()
            self._ask_next()

    def _on_image_opened(self, opened: ImageOpened) -> None:
        """Write a restored document to the new journal, and delete the old one only once that is on the disk."""
        saved, restoring = opened.saved, self._restoring
        if saved is not None and restoring is not None and saved.file is restoring.file:
            self.journal.write()
            if self.journal.flush() and self.journal.path.exists():
                restoring.discard()
                self._restoring = None


def _describe_leftover(leftover: Leftover) -> Sequence[str]:
    when = QLocale().toString(
        QDateTime.fromSecsSinceEpoch(int(leftover.when.timestamp())), QLocale.FormatType.ShortFormat
    )
    image = leftover.file.image
    objects, shapes = leftover.count_objects_and_shapes()
    session = elide_middle(str(leftover.path), _MAX_SHOWN_PATH) if leftover.path else tr("never saved")
    return (
        tr("Last changed: {when}", when=when),
        tr("Image: {path}", path=elide_middle(image.path, _MAX_SHOWN_PATH) if image else "–"),
        tr("Session file: {path}", path=session),
        tr("Objects: {objects}, shapes: {shapes}", objects=objects, shapes=shapes),
    )
