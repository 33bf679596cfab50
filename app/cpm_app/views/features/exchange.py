"""Exchange with other programs: export, import, clipboard, and the session applied to a folder."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TypeVar

from PySide6.QtCore import QMimeData
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QApplication

from cpm_app.model.document import edits, imported
from cpm_app.model.document.imported import ImportedContent
from cpm_app.model.export import ExportFile, ExportKind, ExportOrder, has_objects_to_export
from cpm_app.model.state.situation import Situation, has_contours, has_image, has_particles, has_volume
from cpm_app.model.text.language import tr, translate_core_text
from cpm_app.session.exchange.messages import ImageOpened
from cpm_app.session.features.image_batch import BatchDone, apply_to_folder, describe_lack_of_start
from cpm_app.session.features.import_contours import (
    ImportedDrawing,
    read_contour_file,
    read_pasted,
    save_pasted_picture,
)
from cpm_app.session.features.session_code import CodeLanguage, write_session_code
from cpm_app.session.session_messages import BATCH_CATEGORY, EXPORTING_CATEGORY, OPENING_CATEGORY
from cpm_app.session.tasks.opening import list_images
from cpm_app.session.tasks.tasks import ENDED_TASK
from cpm_app.views.export.batch_dialog import BatchDialog
from cpm_app.views.export.dialog import CHECKED_FORMATS_KEY, Exportable, ExportDialog
from cpm_app.views.export.frames import AnimationPlan
from cpm_app.views.features.animation import AnimationFeature
from cpm_app.views.features.volumes import SpaceFeature
from cpm_app.views.widgets.actions import ActionSpec
from cpm_app.views.window.dialogs import ALL_FILES, FileKind, QuestionDialog
from cpm_app.views.window.window import Feature
from cpm_core.formats import CENTERLINES_WRITABLE, CONTOURS_READABLE, IMAGES_READABLE, SURFACES_READABLE
from cpm_core.numerics.types import Texts
from cpm_core.shapes import Points, select_measures

Copied = TypeVar("Copied")


class ExportFeature(Feature):
    """Export of results, pictures and animations to files."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        self.dialog: ExportDialog | None = None
        self._last: tuple[ExportOrder, AnimationPlan] | None = None
        self._written: set[Path] = set()
        self.session.store.add_listener(ImageOpened, self._on_image_opened)
        self.actions = (
            ActionSpec("export", "File", "&Export…", "Export objects, contours, surfaces, pictures and animations.",
                       self.open_export_dialog, "Ctrl+E Ctrl+Shift+K Ctrl+Shift+A", short=tr("Export"), icon="export",
                       gap=True, when=_can_export),
            ActionSpec("export_pages", "File", "Export all pages…", "Export what was found on all pages of the stack.",
                       partial(self.open_export_dialog, "pages"),
                       visible_when=lambda _: self.window.workspace.pages.has_images,
                       when=lambda _: self.window.workspace.pages.result is not None),
            ActionSpec("export_again", "File", "Export a&gain", "Export the same files again, without a dialog.",
                       self.export_again, "Ctrl+Shift+E", when=_can_export),
        )  # fmt: skip

    def open_export_dialog(self, only: ExportKind | None = None) -> None:
        """Ask the user what to export: at first of one kind only, if it is given."""
        if self.dialog is None:
            self.dialog = self._create_dialog(only)
            self.dialog.finished.connect(self._on_dialog_finished)
            self.dialog.open()

    def export_again(self) -> None:
        """Write the last files again; for another image, files in the same formats."""
        if self._last is not None:
            self._write_files(*self._last)
        elif self.window.preferences.read_key(CHECKED_FORMATS_KEY, [""]) != [""]:
            self._create_dialog().accept()
        else:
            self.open_export_dialog()

    def _create_dialog(self, only: ExportKind | None = None) -> ExportDialog:
        window, workspace = self.window, self.window.workspace
        navigation, space, pages = workspace.navigation, window.get_feature(SpaceFeature), workspace.pages.result
        exportable = Exportable(
            self.session.scene.objects.selected,
            workspace.contour_selection.selected_indices,
            0 if pages is None else len(pages.results),
            sum(map(has_objects_to_export, workspace.pages.documents.values())) > 1,
            navigation.last_step(navigation.current_step[0]) if has_particles(self.session.situation) else 0,
            space.panel.contents is not None,
            window.get_feature(AnimationFeature).visible_part,
            self._written,
        )
        dialog = ExportDialog(window, self.session, window.preferences, window.files, exportable, only)
        dialog.export_requested.connect(self._write_files)
        return dialog

    def _write_files(self, order: ExportOrder, animation: AnimationPlan) -> None:
        self._last = order, animation
        workspace, space = self.window.workspace, self.window.get_feature(SpaceFeature)
        self.window.files.remember_path("export", order.files[0].path)
        found, paths = list[ExportFile](), list[Path]()
        for file in order.files:
            self._written.add(file.path)
            if file.kind == "run":
                self.window.get_feature(AnimationFeature).export_animation(
                    workspace.navigation.current_step[0], animation, file.path
                )
            elif file.kind in ("space", "turntable"):
                space.write_view(file.path, file.kind == "turntable")
            elif file.kind == "pages":
                paths.append(file.path)
            else:
                found.append(file)
        if paths:
            workspace.pages.export_pages(*paths)
        if found:
            self.session.export_files(replace(order, files=tuple(found)))

    def _on_dialog_finished(self) -> None:
        self.dialog = None

    def _on_image_opened(self, _: ImageOpened) -> None:
        self._last = None
        if self.dialog is not None:
            self.dialog.reject()


def _can_export(situation: Situation) -> bool:
    return (
        has_contours(situation)
        or situation.status.surface is not None
        or has_objects_to_export(situation.document)
        or bool(select_measures(situation.document.shapes))
        or has_particles(situation)
        or has_volume(situation)
    )


_CLIPBOARD_MIME_TYPES = ("image/svg+xml", "application/geo+json", "text/csv")
"""MIME types of contours on the clipboard, the richest first."""


class ClipboardFeature(Feature):
    """Copies for other programs: what was found, in several formats at once, and the view; the newest copy wins."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        self._copying, self._begun = ENDED_TASK, 0
        self.session.tasks.changed.connect(self._on_tasks_changed)
        self.actions = (
            ActionSpec("copy", "Edit", "&Copy", "Copy the selection, or everything, as a drawing and as a table.",
                       self.copy_selection, "Ctrl+C", gap=True,
                       when=lambda now: has_contours(now)
                       or (has_objects_to_export(now.document) and not has_volume(now))),
            ActionSpec("copy_view", "Edit", "Copy &view as image",
                       "Copy the visible part of the image with its overlays to the clipboard.", self.copy_view,
                       "Ctrl+Shift+P", when=has_image),
            ActionSpec("copy_python", "Edit", "Copy as Pyt&hon",
                       "Copy a script that finds the objects of this session.",
                       partial(self._copy_code, "python"), when=_can_repeat),
            ActionSpec("copy_command", "Edit", "Copy as co&mmand",
                       "Copy a command line that finds the objects of this session.",
                       partial(self._copy_code, "command"), when=_can_repeat),
        )  # fmt: skip

    def copy_selection(self) -> None:
        """Copy the selection, else all objects, else all contours; other programs take the format that suits them."""
        session = self.session
        chosen = session.scene.objects.selected
        contours = self.window.workspace.contour_selection.selected_indices
        what: ExportKind = (
            "objects" if chosen or (has_objects_to_export(session.document) and not contours) else "contours"
        )
        suffixes = (".svg", ".geojson", ".table.csv" if what == "objects" else ".measures.csv")
        files = tuple(ExportFile(Path(f"copy{suffix}"), what, suffix) for suffix in suffixes)
        order = ExportOrder(files, chosen or None, contours or None)
        self._copying = session.export_files(order, self._begin_copy(self._put_on_clipboard))

    def copy_view(self) -> None:
        """Copy the view of the canvas as a picture."""
        self._begin_copy(QApplication.clipboard().setImage)(self.canvas.grab().toImage())
        self.session.messages.show(tr("The view was copied."), category=EXPORTING_CATEGORY)

    def _begin_copy(self, put: Callable[[Copied], object]) -> Callable[[Copied], None]:
        """Cancel the previous copy, and let `put` take what is copied unless another copy has begun by then."""
        self._copying.cancel()
        self._copying = ENDED_TASK
        self._begun += 1
        number = self._begun

        def put_newest(copied: Copied) -> None:
            if number == self._begun:
                put(copied)

        return put_newest

    def _on_tasks_changed(self) -> None:
        """No longer announce a copy that the user has canceled."""
        if self._copying.is_cancelled:
            self._copying = ENDED_TASK
            self.session.messages.clear(EXPORTING_CATEGORY)

    def _copy_code(self, language: CodeLanguage) -> None:
        file = self.window.document_file
        saved = file.path if file.saved_document == self.session.document else None
        updater = self.window.workspace.object_selection.partition_updater
        put = self._begin_copy(self._put_code_on_clipboard)
        self._copying = write_session_code(self.session, updater, language, saved, put)
        if not self._copying.is_over:
            words = tr("The clipboard stays as it was until the copy is ready.")
            self.session.messages.show(words, category=EXPORTING_CATEGORY)

    def _put_code_on_clipboard(self, text: str) -> None:
        QApplication.clipboard().setText(text)
        self.session.messages.show(tr("Copied: paste it into a file or a terminal."), category=EXPORTING_CATEGORY)

    def _put_on_clipboard(self, contents: tuple[bytes, ...]) -> None:
        data = QMimeData()
        for kind, content in zip(_CLIPBOARD_MIME_TYPES, contents, strict=True):
            data.setData(kind, content)
        data.setText(contents[-1].decode())  # most programs read only text: the table
        QApplication.clipboard().setMimeData(data)
        self.session.messages.show(tr("Copied as a drawing and a table."), category=EXPORTING_CATEGORY)


def _can_repeat(situation: Situation) -> bool:
    """Tell whether a session can be repeated by a script: not one for skeletons, which have no objects."""
    return has_image(situation) and situation.document.mode != "skeleton"


VOLUME_ONLY_SUFFIXES = frozenset((*SURFACES_READABLE, *CENTERLINES_WRITABLE))
"""Suffixes of files that can be imported only into a volume."""

_VOLUME_IMPORT_FILES = FileKind(
    tr("Surfaces, labels and center lines"),
    (*SURFACES_READABLE, *CENTERLINES_WRITABLE, *IMAGES_READABLE, ".points.csv"),
)
"""Kinds of files that can be imported into a volume."""

_QUESTION_TITLES = {
    "contours": tr("Use contours"),
    "surface": tr("Use surface"),
    "center lines": tr("Use center lines"),
}
"""Title of the question about what is imported."""


class ImportFeature(Feature):
    """Import of contours, surfaces and pictures from other programs."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        self.actions = (
            ActionSpec("import_contours", "File", "&Import contours…",
                       "Import contours from another program as a start, as objects or as ground truth.",
                       self._ask_for_contours, when=has_image),
            ActionSpec("paste", "Edit", "&Paste", "Open the picture on the clipboard, or use the contours on it.",
                       self.paste, "Ctrl+V"),
        )  # fmt: skip

    def import_file(self, path: Path) -> None:
        """Read contours and ask how to use them."""
        session = self.session
        if session.document.image is None:
            message = tr("Open an image first; then {name} can be drawn.")
        elif session.scene.slices is None and path.suffix.lower() in VOLUME_ONLY_SUFFIXES:
            message = tr("{name} belongs to a volume, but an image is open.")
        else:
            session.messages.clear(OPENING_CATEGORY)
            read_contour_file(session, path, partial(self._on_file_read, path))
            return
        session.messages.show(message.format(name=path.name), True, OPENING_CATEGORY)

    def paste(self) -> None:
        """Open the picture or the files on the clipboard, or read the contours on it."""
        data, session = QApplication.clipboard().mimeData(), self.session
        session.messages.clear(OPENING_CATEGORY)
        kind = next(filter(data.hasFormat, _CLIPBOARD_MIME_TYPES), "")
        text = data.text() if data.hasText() and not data.hasImage() else ""
        content = bytes(data.data(kind).data()) if kind else text.encode()
        picture = data.imageData() if data.hasImage() else None
        if data.hasUrls():
            self.window.urls_dropped.emit(data.urls())
        elif content and session.document.image is not None and session.scene.slices is None:
            read_pasted(session, content, partial(self._on_file_read, None))
        elif isinstance(picture, QImage) and not picture.isNull():
            save_pasted_picture(session, picture, self.window.open_image)
        else:
            message = tr("The clipboard contains neither a picture nor contours.")
            if content and session.scene.slices is not None:
                name = tr("the clipboard")
                message = tr("{name} has contours for an image, but a volume is open.", name=name)
            elif content:
                message = tr("Open an image first; then the contours on the clipboard can be used.")
            session.messages.show(message, True, OPENING_CATEGORY)

    def _ask_for_contours(self) -> None:
        in_volume = self.session.scene.slices is not None
        kinds = (_VOLUME_IMPORT_FILES if in_volume else FileKind(tr("Contours"), tuple(CONTOURS_READABLE)), ALL_FILES)
        title = tr("Import surface") if in_volume else tr("Import contours")
        chosen = self.window.files.ask_for_file("truth", title, kinds)
        if chosen is not None:
            self.import_file(chosen)

    def _on_file_read(self, path: Path | None, found: ImportedDrawing) -> None:
        """Draw points, or ask how to use contours; `path` is None if they come from the clipboard."""
        session = self.session
        if isinstance(found, Points):
            name = tr("draw {name}", name="" if path is None else path.name)
            session.edit(name, lambda document: edits.add_shape(document, found))
            return
        whole = found.kind == "center lines" or not found.count
        question = tr("Use {name} as a start?") if whole else tr("What should {name} be used for?")
        text, uses = question.format(name=found.name), _list_uses(found, path is not None)
        answer = QuestionDialog(
            self.window, _QUESTION_TITLES[found.kind], text, _explain_choices(found), uses
        ).wait_for_answer()
        if answer == "start":
            name = tr("start from {name}", name=found.name)
            session.edit(name, lambda document: edits.set_shapes(document, (*document.shapes, *found.starts)))
        elif answer == "objects":
            name = tr("add objects from {name}", name=found.name)
            session.edit(name, lambda document: imported.add_objects(document, found.objects, found.classes))
        elif answer == "truth" and path is not None:
            self.window.docks.reveal_panel("compare")
            self.window.workspace.comparison.load_truth_file(path)


def _explain_choices(found: ImportedContent) -> str:
    sentences = [tr("Particles flow from a start to the edges; objects stay as they are.")]
    if found.kind == "surface" and not found.objects:
        sentences.append(tr("The surface is not closed, so it encloses no object."))
    if found.open_count and found.objects:
        sentences.append(tr("Open contours are left out of the objects."))
    return " ".join([*sentences, *map(translate_core_text, found.notes)])


def _list_uses(found: ImportedContent, of_file: bool) -> Mapping[str, str]:
    """List what an imported drawing can be used for, each with the text of its button."""
    uses = {"start": tr("&Start")}
    if found.objects:
        uses["objects"] = tr("&Objects")
    enclosing = found.kind != "surface" or bool(found.objects)
    if found.count and of_file and found.kind != "center lines" and enclosing:
        uses["truth"] = tr("Ground &truth")
    return {**uses, "cancel": tr("Cancel")}


_MAX_NAMED_IMAGES = 3
"""Largest number of images that are named as unusable."""


class BatchFeature(Feature):
    """Application of the session to all images of a folder, one folder at a time."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        self._task = ENDED_TASK
        self.actions = (
            ActionSpec("apply_to_folder", "File", "Apply this session to a &folder…",
                       "Run every image in a folder with the current starts and settings, and export the objects.",
                       self._apply_session, "Ctrl+Alt+E",
                       when=lambda situation: has_image(situation) and self._task.is_over),
        )  # fmt: skip

    def _apply_session(self) -> None:
        """Ask for the folder and the formats, unless the session cannot be applied."""
        lacking = describe_lack_of_start(self.session)
        if lacking:
            self.session.messages.show(lacking, True, BATCH_CATEGORY)
            return
        chosen = self.window.files.ask_for_folder(tr("Folder of the images"))
        if chosen:
            folder, in_volume = Path(chosen), self.session.scene.slices is not None
            dialog = BatchDialog(self.window, self.window.preferences, folder, list_images(folder), in_volume)
            dialog.accepted.connect(lambda: self._run_folder(folder, dialog.suffixes))
            dialog.open()

    def _run_folder(self, folder: Path, suffixes: Texts) -> None:
        self._task = apply_to_folder(self.session, folder, suffixes, self._on_batch_done)
        self.window.refresh_actions()

    def _on_batch_done(self, done: BatchDone) -> None:
        parts = [tr("{done} of {count} images finished.", done=done.images - len(done.failed), count=done.images)]
        found = {"count": done.objects, "doubtful": done.objects - done.likely, "path": done.folder}
        parts.append(tr("Objects: {count}, {doubtful} of them doubtful, in {path}.", **found))
        if done.failed:
            names = ", ".join(done.failed[:_MAX_NAMED_IMAGES]) + ("…" if len(done.failed) > _MAX_NAMED_IMAGES else "")
            parts.append(tr("Could not be used: {names}.", names=names))
        self.session.messages.show(" ".join(parts), bool(done.failed), BATCH_CATEGORY)
        self.window.refresh_actions()
