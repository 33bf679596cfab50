"""Contours and surfaces of files: opened, dropped or pasted, and used as a start, as objects or as ground truth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from PySide6.QtCore import QMimeData, QUrl
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QApplication

from app.model.document import edits, imported
from app.model.document.imported import Imported
from app.model.state.situation import has_image
from app.model.text.language import from_core, tr
from app.session.features.import_contours import (
    ContoursRead,
    PictureKept,
    PointsRead,
    keep_picture,
    read_file,
    read_pasted,
)
from app.session.signals import OPENING
from app.views.widgets.action_spec import ActionSpec
from app.views.window.dialogs import Button, Question
from app.views.window.feature import Feature, FeatureContext
from app.views.window.file_dialogs import Files, all_files
from cpm_core.formats import CONTOURS_READABLE, FOR_CENTERLINES, READABLE, SURFACES_READABLE

_KINDS = ("image/svg+xml", "application/geo+json", "text/csv")
"""Kinds of contours that programs put on the clipboard, the richest first."""

IN_VOLUMES = frozenset((*SURFACES_READABLE, *FOR_CENTERLINES))
"""Suffixes of files that lie in a volume."""

_FILES_IN_VOLUMES = Files(
    tr("Surfaces, labels and center lines"), (*SURFACES_READABLE, *FOR_CENTERLINES, *READABLE, ".points.csv")
)
_TITLES = {"contours": tr("Use contours"), "surface": tr("Use surface"), "center lines": tr("Use center lines")}


class ImportFeature(Feature):
    """Contours, surfaces and pictures of other programs."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.open_files: Callable[[Sequence[QUrl]], None] = lambda urls: None
        """Opens files that were pasted; set by the window."""
        self.open_picture: Callable[[Path], None] = lambda path: None
        """Opens a picture that was pasted; set by the window."""
        context.session.listen(ContoursRead, self._ask)
        context.session.listen(PointsRead, self._draw_points)
        context.session.listen(PictureKept, lambda kept: self.open_picture(kept.path))

    def action_specs(self) -> Sequence[ActionSpec]:
        """Import contours, and paste."""
        return (
            ActionSpec(name="import_contours", menu="File", text=tr("&Import contours…"), do=self._choose,
                       tip=tr("Read contours of another program, as a start, as objects or as ground truth."),
                       when=has_image),
            ActionSpec(name="paste", menu="Edit", text=tr("&Paste"), do=self.paste, shortcuts=("Ctrl+V",),
                       tip=tr("Open the picture on the clipboard, or use the contours on it.")),
        )  # fmt: skip

    def take(self, path: Path) -> None:
        """Read contours, and ask what they are for."""
        session = self.context.session
        if session.document.image is None:
            message = tr("Open an image first. Then {name} can be drawn.")
            session.say(message.format(name=path.name), True, OPENING)
        elif session.scene.slices is None and path.suffix.lower() in IN_VOLUMES:
            message = tr("{name} lies in a volume, but an image is open.")
            session.say(message.format(name=path.name), True, OPENING)
        else:
            session.attempt(OPENING)
            read_file(session, path)

    def paste(self) -> None:
        """Open the picture or the files on the clipboard, or read the contours on it."""
        data, session = QApplication.clipboard().mimeData(), self.context.session
        session.attempt(OPENING)
        content = _contours_on(data)
        if data.hasUrls():
            self.open_files(data.urls())
        elif content and session.document.image is not None and session.scene.slices is None:
            read_pasted(session, content)
        elif isinstance(picture := data.imageData() if data.hasImage() else None, QImage) and not picture.isNull():
            keep_picture(session, picture)
        elif content and session.scene.slices is not None:
            message = tr("{name} has contours for an image, but a volume is open.")
            session.say(message.format(name=tr("the clipboard")), True, OPENING)
        elif content:
            session.say(tr("Open an image first. Then the contours on the clipboard can be used."), True, OPENING)
        else:
            session.say(tr("There is no picture and there are no contours on the clipboard."), True, OPENING)

    def _choose(self) -> None:
        in_volume = self.context.session.scene.slices is not None
        kinds = (_FILES_IN_VOLUMES if in_volume else Files(tr("Contours"), tuple(CONTOURS_READABLE)), all_files())
        title = tr("Import surface") if in_volume else tr("Import contours")
        chosen = self.context.files.ask_for_file("truth", title, kinds)
        if chosen is not None:
            self.take(chosen)

    def _ask(self, read: ContoursRead) -> None:
        """Ask what contours are for, and use them so."""
        session = self.context.session
        if read.generation != session.image_generation:
            return
        found = read.imported
        of_file = read.path is not None
        words = _TITLES[found.kind], _question(found), _explained(found, of_file)
        answer = Question(self.context.window, *words, _buttons(found, of_file)).ask()
        if answer == "start":
            name = tr("start from {name}").format(name=found.name)
            session.edit(name, lambda document: imported.add_starts(document, found))
        elif answer == "objects":
            name = tr("take objects from {name}").format(name=found.name)
            session.edit(name, lambda document: imported.add_objects(document, found))
        elif answer == "truth" and read.path is not None:
            self.context.reveal("truth")
            self.context.workspace.truth.load(read.path)

    def _draw_points(self, read: PointsRead) -> None:
        name = tr("draw {name}").format(name=read.path.name)
        self.context.session.edit(name, lambda document: edits.add_shape(document, read.points))


def _contours_on(data: QMimeData) -> bytes:
    """What is on the clipboard that may be contours."""
    for kind in _KINDS:
        if data.hasFormat(kind):
            return bytes(data.data(kind).data())
    text = data.text() if data.hasText() and not data.hasImage() else ""
    return text.encode()


def _question(found: Imported) -> str:
    if found.kind == "surface":
        return tr("What is the surface of {name} for?").format(name=found.name)
    if found.kind == "center lines":
        return tr("Use the center lines of {name} as a start?").format(name=found.name)
    if not found.count:
        return tr("Use the points of {name} as a start?").format(name=found.name)
    if found.count == 1:
        return tr("What is the contour of {name} for?").format(name=found.name)
    return tr("What are the {count} contours of {name} for?").format(count=found.count, name=found.name)


def _explained(found: Imported, of_file: bool) -> str:
    sentences = [tr("Particles of a start flow to the edges; objects stay as they are.")]
    if found.kind == "surface" and found.objects:
        sentences.append(tr("A ground truth is what the surface of the run is compared with."))
    elif found.kind == "surface":
        sentences.append(tr("The surface is not closed, so that it encloses no object."))
    elif found.kind == "contours" and found.count and of_file:
        sentences.append(tr("A ground truth is what the contours of the run are compared with."))
    if found.open and found.objects:
        sentences.append(tr("Open contours are no objects."))
    return " ".join([*sentences, *map(from_core, found.notes)])


def _buttons(found: Imported, of_file: bool) -> Sequence[Button]:
    buttons = [Button("start", tr("&Start"), "accept")]
    if found.objects:
        buttons.append(Button("objects", tr("&Objects"), "accept"))
    enclosing = found.kind != "surface" or bool(found.objects)
    if found.count and of_file and found.kind != "center lines" and enclosing:
        buttons.append(Button("truth", tr("Ground &truth"), "accept"))
    return [*buttons, Button("cancel", tr("Cancel"), "cancel")]
