"""The project of a folder: its images with their states, saved as one goes from one to the next."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import field, replace
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal

from cpm_app.model.document.document import ImageReference
from cpm_app.model.document.modes import MODES
from cpm_app.model.document.project import (
    ImageRow,
    find_next_undone,
    has_own_work,
    list_images_of,
    settings_of,
)
from cpm_app.model.document.saving import from_session_file
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import explain_error, tr
from cpm_app.session.exchange.messages import CommandFailed, ImageOpened, OpeningFailed, WorkFinished
from cpm_app.session.features.kept_pages import run_recorded
from cpm_app.session.features.object_list import ObjectList
from cpm_app.session.features.object_rows import ItemKey
from cpm_app.session.features.object_selection import ObjectSelection
from cpm_app.session.features.project_table import write_table
from cpm_app.session.features.selector import MAX_OFFERED_PIXELS
from cpm_app.session.features.stack_pages import StackPages
from cpm_app.session.session import Session
from cpm_app.session.session_messages import (
    EDITING_CATEGORY,
    EXPORTING_CATEGORY,
    OPENING_CATEGORY,
    PROJECT_CATEGORY,
    RUNNING_CATEGORY,
    SAVING_CATEGORY,
)
from cpm_app.session.storage.session_file import DocumentFile, SessionWritten
from cpm_app.session.tasks.opening import list_images
from cpm_app.session.tasks.tasks import ENDED_TASK, BackgroundTask
from cpm_core import load_image
from cpm_core.formats import (
    ImageState,
    Project,
    ProjectImage,
    SessionFile,
    adapt_reading,
    load_project,
    make_project_folder,
    project_session,
    update_project,
)
from cpm_core.formats.images.reading import DEFAULT_READING
from cpm_core.numerics.types import record
from cpm_core.pages import limit_scales
from cpm_core.results import is_likely
from cpm_core.shapes import Everywhere

_BACKGROUND_NICENESS = 10
"""How much the thread that prepares the next image gives way to others, as the system counts it."""

_SAVE_DELAY = 5000
"""Time from a change until the work on the open image is saved, together with all changes in between [ms]."""


@record
class FolderContent:
    """What is known of a folder of images.

    Attributes
    ----------
    folder : Path or None
        The folder; None while no project is open.
    images : tuple of Path
        Its images in natural order.
    by_path : mapping of Path to Path
        Each image under its own path, and under the one that it leads to if it is a link.
    project : Project
        The states of its images.
    sessions : frozenset of str
        Names of the images that have a session.
    error : str
        Message if the states could not be read.
    """

    folder: Path | None = None
    images: tuple[Path, ...] = ()
    by_path: Mapping[Path, Path] = field(default_factory=dict)
    project: Project = field(default_factory=Project)
    sessions: frozenset[str] = frozenset()
    error: str = ""

    @classmethod
    def read(cls, folder: Path) -> FolderContent:
        """Read a folder; not for use on the window's thread."""
        folder = folder.resolve()
        images, project, error = list_images(folder), Project(), ""
        if not images:
            raise ValueError(tr("This folder contains no readable image: choose another one."))
        try:
            project = load_project(folder)
        except ValueError as damaged:
            error = explain_error(damaged)
        by_path = {image.resolve(): image for image in images} | {image: image for image in images}
        sessions = frozenset(image.name for image in images if project_session(image).is_file())
        return cls(folder, images, by_path, project, sessions, error)


class ImageProject(QObject):
    """The folder of images that is open as a project, and the open image in it."""

    changed = Signal()
    """Another folder or image is open, or the state of an image has changed."""
    image_wanted = Signal(object)
    """The user goes on to an image: its path."""

    def __init__(
        self, session: Session, object_list: ObjectList, object_selection: ObjectSelection, pages: StackPages
    ) -> None:
        super().__init__(session)
        self._session, self._list, self._selection, self._pages = session, object_list, object_selection, pages
        self._file: DocumentFile
        self._content = FolderContent()
        self.current: Path | None = None
        """The open image, if it is one of the project."""
        self._wanted: Path | None = None
        """The image that was asked for last."""
        self._first_settings: SessionFile | None = None
        """The settings that the open image began with."""
        self._opened_to_run = False
        """Whether the open image was opened to be run, if it is untouched."""
        self._shown: object = None
        """State and number of objects of the open image, as last announced."""
        self._writing = self._preparing = ENDED_TASK
        self._prepared_after: Path | None = None
        """The open image when it was last considered which one is next."""
        self._prepared: dict[Path, tuple[SessionFile, SessionFile]] = {}
        """The image that has been run before it is opened, with the settings, and these with its run."""
        self._asked: object = None
        """Image, mark and the proposals that would be lost, as the last message about such said."""
        self._saving_fails = False
        self._timer = QTimer(self, singleShot=True)
        self._timer.timeout.connect(self._save)
        session.store.add_listener(ImageOpened, self._on_image_opened)
        session.store.add_listener(SessionWritten, self._on_session_written)
        session.store.add_listener(CommandFailed, self._on_command_failed)
        session.store.scene_changed.connect(self._prepare_next)

    def set_session_file(self, document_file: DocumentFile) -> None:
        """Set the session file, in which the work on the open image is saved."""
        self._file = document_file
        document_file.edited.connect(self._announce_state)
        document_file.edited.connect(self._save_soon)

    # State

    @property
    def folder(self) -> Path | None:
        """The folder; None while no project is open."""
        return self._content.folder

    @property
    def images(self) -> tuple[Path, ...]:
        """The images of the folder, in natural order."""
        return self._content.images

    @property
    def proposes(self) -> bool:
        """Whether untouched images are run as soon as they are opened."""
        return self._content.project.proposes

    @property
    def rows(self) -> tuple[ImageRow, ...]:
        """The images with their states."""
        content, current = self._content, self.current
        if current is None:
            return list_images_of(content.images, content.project, content.sessions)
        project = content.project.with_image(current.name, self._here)
        rows = list_images_of(content.images, project, content.sessions)
        return tuple(replace(row, is_proposed=False) if row.path == current else row for row in rows)

    @property
    def state(self) -> ImageState:
        """State of the open image; untouched if it is none of the project."""
        return self._here.state

    @property
    def session_path(self) -> Path | None:
        """File in which the work on the open image is saved.

        None if the image is none of the project, or if there is a session of it that is not open, as of another page.
        """
        path = None if self.current is None else project_session(self.current)
        return None if path is None or (path.exists() and path != self._file.path) else path

    def contains(self, path: Path) -> bool:
        """Return whether a path is that of an image of the project."""
        return self._find_image(path) is not None

    # Opening

    def open_folder(self, folder: Path) -> BackgroundTask:
        """Open a folder of images as a project, and in it the first image that is not done."""
        self._session.messages.clear(OPENING_CATEGORY, PROJECT_CATEGORY)
        return self._session.tasks.start_task(
            tr("Opening {name}…", name=folder.name),
            lambda _: FolderContent.read(folder),
            tr("opening {name}", name=folder.name),
            OpeningFailed,
            on_result=self._begin,
        )

    def open_image(self, path: Path) -> None:
        """Open an image of the project with its session; an untouched one begins with the settings of the project."""
        image, settings = self._find_image(path), self._content.project.settings
        if image is None:
            return
        self._wanted, session = image, project_session(image)
        made_of, prepared = self._prepared.get(image, (None, None))
        settings = prepared if prepared is not None and made_of == settings else settings
        self._session.open_file(session if session.is_file() else image, resumes=True, settings=settings)

    def go_to_next(self) -> None:
        """Go on to the next image about which the user has said nothing."""
        following = find_next_undone(self.rows, self._wanted)
        if following is None:
            self._session.messages.show(tr("No other image is left to do."), category=OPENING_CATEGORY)
        else:
            self.image_wanted.emit(following)

    # States

    def mark(self, state: ImageState) -> None:
        """Mark the open image, and go on to the next one; if it is marked so already, remove the mark and stay.

        If proposals would be lost, only a message says so; asked again, the image is marked. While the next image is
        being opened, a key that was pressed twice changes nothing.
        """
        if self.current is None or self._session.opening_name:
            return
        removed, here = self._here.state == state, self._here
        offered = () if removed else self._undecided_proposals
        asked = self.current, state, offered
        if (offered or (self._awaits_proposals and not removed)) and asked != self._asked:
            self._asked = asked
            text = tr(
                "Proposals that are not accepted: {count}. Accept them, or press the same key again to go on without "
                "them."
            )
            if not offered:
                text = tr("Objects are still being found. Wait, or press the same key again to go on without them.")
            self._session.messages.show(text.format(count=len(offered)), category=EDITING_CATEGORY)
            return
        self._asked = None
        if removed:
            begun = self._has_work or self.current.name in self._content.sessions
            state = "begun" if begun else "untouched"
        self._change(partial(Project.with_image, name=self.current.name, image=replace(here, state=state)))
        if not removed:
            self.go_to_next()

    def toggle_proposing(self) -> None:
        """Have untouched images run with the settings of the open one as soon as they are opened, or no longer."""
        messages = self._session.messages
        messages.clear(RUNNING_CATEGORY)
        if self.proposes:
            self._change(lambda project: replace(project, proposes=False))
            return
        settings = self._read_settings()
        if not _suits_all_images(settings):
            text = tr("Only a run from everywhere suits all images: choose the automatic mode, or start everywhere.")
            messages.show(text, True, RUNNING_CATEGORY)
            return
        self._change(lambda project: replace(project, proposes=True, settings=settings))
        text = tr(
            "Images: {count}. Each is run when you open it: accept its proposals with Enter, then press "
            "{key:image_done}."
        )
        count = sum(row.is_proposed for row in self.rows)
        messages.show(insert_keys(text, count=count), category=RUNNING_CATEGORY)

    # Saving

    def save_and_wait(self) -> bool:
        """Save the work on the open image; return False if that fails, or if it has no place in the project."""
        path = self.session_path
        if path is None:
            return False
        self._timer.stop()
        self._keep_settings()
        return not self._needs_saving or (self.make_folder() and self._file.save_and_wait(path, automatic=True))

    def make_folder(self) -> bool:
        """Create the folder of the project; return False, with an error message shown, if that fails."""
        try:
            if self.folder is not None:
                make_project_folder(self.folder)
        except ValueError as error:
            self._saving_fails = True
            self._session.messages.show(explain_error(error), True, SAVING_CATEGORY)
            return False
        return True

    def write_table(self, path: Path) -> BackgroundTask:
        """Write one table of all objects of all images, in the background."""
        self._session.messages.clear(EXPORTING_CATEGORY)
        self.save_and_wait()
        images = tuple(image for image in self.images if image.name in self._content.sessions)
        empty = sum(row.state == "done" and row.objects == 0 for row in self.rows)
        return self._session.tasks.start_task(
            tr("Writing {name}…", name=path.name),
            partial(write_table, images, empty, path),
            tr("writing {name}", name=path.name),
            partial(CommandFailed, category=EXPORTING_CATEGORY),
        )

    # Internal

    @property
    def _here(self) -> ProjectImage:
        """What the project says of the open image, with the work that is not saved yet."""
        if self.current is None:
            return ProjectImage()
        document, known = self._session.document, self._content.project.images.get(self.current.name, ProjectImage())
        begun = self._has_work or self.current.name in self._content.sessions
        state: ImageState = "begun" if known.state == "untouched" and begun else known.state
        return ProjectImage(state, len(document.objects.items))

    @property
    def _undecided_proposals(self) -> tuple[ItemKey, ...]:
        """Keys of the proposals; none if only doubtful ones are left next to objects: the user has passed over them."""
        rows = [row for row in self._list.rows if row.kind == "proposal"]
        likely = any(is_likely(each.selection) for each in self._session.scene.objects.proposals)
        return tuple(row.key for row in rows) if likely or not self._session.document.objects.items else ()

    @property
    def _awaits_proposals(self) -> bool:
        """Whether a run is about to begin, goes on, or has ended and its proposals are not shown yet."""
        result = self._session.scene.result
        if self._session.status.phase == "running":
            return True
        if self._opened_to_run and self.state == "untouched" and (result is None or not result.stop_reason):
            return True
        return not (self._selection.offer_is_known or self._session.document.objects.items)

    @property
    def _needs_saving(self) -> bool:
        """Whether there is work on the open image that its session in the project lacks."""
        path = self.session_path
        if path is None:
            return False
        return self._file.unsaved if path == self._file.path else self._has_work

    @property
    def _has_work(self) -> bool:
        """Whether there is work on the open image, new or from a session elsewhere."""
        worked = has_own_work(self._session.document) or self._pages.has_unsaved_others
        return worked and (self._file.path is not None or self._file.unsaved)

    def _find_image(self, path: Path) -> Path | None:
        by_path = self._content.by_path
        return by_path.get(path) or (by_path.get(path.resolve()) if by_path else None)

    def _use_folder(self, content: FolderContent) -> None:
        self._preparing.cancel()
        self._content, self.current, self._wanted = content, None, None
        self._prepared, self._prepared_after = {}, None

    def _begin(self, content: FolderContent) -> None:
        self._use_folder(content)
        if content.error:
            self._session.messages.show(content.error, True, PROJECT_CATEGORY)
        self.changed.emit()
        self.image_wanted.emit(find_next_undone(self.rows, None) or content.images[0])

    def _on_image_opened(self, opened: ImageOpened) -> None:
        """Take over an opened image of the project, or end the project if it is none of it."""
        self._timer.stop()
        self._saving_fails = False
        before, self.current = self.current, self._find_image(opened.path)
        if self.current is None:
            if self.folder is not None:
                self._use_folder(FolderContent())
                self._session.messages.clear(PROJECT_CATEGORY)
                self.changed.emit()
            return
        self._wanted = self.current
        if self.current != before:  # and not another page of it
            self._first_settings = self._read_settings()
            self._opened_to_run = self.proposes
            if self.proposes and not (opened.saved and opened.saved.file.runs):
                QTimer.singleShot(0, self, self._run_untouched)
        self.changed.emit()

    def _run_untouched(self) -> None:
        """Run the open image if it is untouched, which ends with proposals."""
        self._preparing.cancel()
        starts_everywhere = any(isinstance(start, Everywhere) for start in self._session.document.starts)
        if self.current is not None and self.state == "untouched" and starts_everywhere:
            self._session.run()

    def _prepare_next(self) -> None:
        """Once there are proposals on the open image, run the one that will be next."""
        project, current = self._content.project, self.current
        settings = project.settings
        if settings is None or not (project.proposes and self._session.scene.objects.proposals):
            return
        if self._prepared_after == current:
            return
        self._prepared_after = current
        following = find_next_undone(self.rows, current)
        row = next((row for row in self.rows if row.path == following and row.is_proposed), None)
        if row is None or row.path in self._prepared or MODES[self._session.document.mode].method != "cpm":
            return

        def keep_prepared(prepared: SessionFile | None) -> None:
            self._prepared = {} if prepared is None else {row.path: (settings, prepared)}

        self._preparing = self._session.tasks.start_task(
            tr("Preparing {name}…", name=row.path.name),
            partial(_prepare_run, row.path, settings),
            tr("preparing {name}", name=row.path.name),
            lambda _: WorkFinished(lambda: None),  # what is wrong is said when it is opened
            on_result=keep_prepared,
        )

    def _announce_state(self) -> None:
        if self.current is not None and self._here != self._shown:
            self._shown = self._here
            self.changed.emit()

    def _read_settings(self) -> SessionFile | None:
        """Return the settings of the open image, with all scales even if it has no room for them."""
        session = self._session
        document = session.document
        if not document.has_volume:
            document = replace(document, parameters=session.parameters_for_next_image)
        return settings_of(document)

    def _keep_settings(self) -> None:
        """Let new images begin with the settings of the open one, if they have been changed in it."""
        settings = self._read_settings()
        if self.proposes and not _suits_all_images(settings):
            return  # what this image needed alone must not end the proposals on the others
        if settings is not None and settings != self._first_settings:
            self._first_settings = settings
            self._change(lambda project: replace(project, settings=settings))

    def _change(self, change: Callable[[Project], Project]) -> None:
        """Change the project here, and on the disk in the background, one change after the other."""
        folder, before = self.folder, self._writing
        after = change(self._content.project)
        if folder is None or after == self._content.project:
            return
        self._content = replace(self._content, project=after)
        self.changed.emit()

        def write_change(_: BackgroundTask) -> None:
            before.wait()
            update_project(folder, change)

        self._writing = self._session.tasks.start_task(
            tr("Saving {name}…", name=folder.name),
            write_change,
            tr("saving {name}", name=folder.name),
            partial(CommandFailed, category=PROJECT_CATEGORY),
            cancellable=False,
            on_result=lambda _: None,
        )

    def _save_soon(self) -> None:
        if not (self._timer.isActive() or self._saving_fails) and self._needs_saving:
            self._timer.start(_SAVE_DELAY)

    def _save(self) -> None:
        path = self.session_path
        if path is not None and self._needs_saving and self.make_folder():
            self._file.save(path, automatic=True)

    def _on_session_written(self, written: SessionWritten) -> None:
        """Note the state of an image whose session has been written, perhaps after it has been left."""
        image = next((image for image in self.images if project_session(image) == written.path), None)
        if image is None:
            return
        self._content = replace(self._content, sessions=self._content.sessions | {image.name})
        known = self._content.project.images.get(image.name, ProjectImage())
        state: ImageState = known.state if known.state in ("done", "doubtful") else "begun"
        after = ProjectImage(state, len(written.file.objects.items))
        self._change(partial(Project.with_image, name=image.name, image=after))

    def _on_command_failed(self, failed: CommandFailed) -> None:
        """Do not try again by itself what has failed and has been reported."""
        if failed.category == SAVING_CATEGORY:
            self._saving_fails = True


def _suits_all_images(settings: SessionFile | None) -> bool:
    """Tell whether any image can be run with settings: from everywhere, and not in a way that needs objects."""
    return settings is not None and settings.mode != "skeleton" and bool(settings.shapes)


def _prepare_run(path: Path, settings: SessionFile, task: BackgroundTask) -> SessionFile | None:
    """Run an image with settings, and return them with its run, so that its contours are there when it is opened.

    None where that would take too long. For use on a thread.
    """
    if sys.platform == "linux":  # elsewhere it would hold for the whole program
        os.setpriority(os.PRIO_PROCESS, 0, _BACKGROUND_NICENESS)
    reading = DEFAULT_READING if settings.image is None else settings.image.reading
    image = load_image(path, check_cancelled=task.check_cancelled, **adapt_reading(path, reading))
    if settings.image is None or math.prod(image.shape) > MAX_OFFERED_PIXELS:
        return None
    parameters = limit_scales(settings.parameters, image.shape)
    document = from_session_file(settings, ImageReference.from_image(path, image), parameters)
    _, runs = run_recorded(image, document, task)
    return replace(settings, image=replace(settings.image, sha256=image.file_sha256), runs=runs)
