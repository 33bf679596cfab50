"""The second image of the document: read and resampled in the background, and shown while the document names it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QObject

from cpm_app.model.display.second_image import SecondImage, build_second_image
from cpm_app.model.document.document import Document
from cpm_app.model.text.language import tr, translate_core_text
from cpm_app.session.session import Session
from cpm_app.session.tasks.tasks import ENDED_TASK, BackgroundTask
from cpm_core import Image, load_image, load_volume
from cpm_core.formats import ImageFile
from cpm_core.image.resampling import is_label_map


class SecondImages(QObject):
    """Puts a second image over the one that is open."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._known: tuple[ImageFile | None, Image | None] = None, None
        """The second image of the document, and the image that it lies over."""
        self._task = ENDED_TASK
        session.document_changed.connect(self._on_document_changed)

    def open_file(self, path: Path) -> None:
        """Read a file and make it the second image if it can be."""
        if self._session.image is not None:
            self._read(ImageFile(str(path.absolute())), self._session.image, self._use)

    def remove(self) -> None:
        """Show no second image."""
        self._session.edit(tr("remove the second image"), lambda document: replace(document, second=None))

    def _use(self, file: ImageFile) -> None:
        """Make what has been read the second image of the document."""
        self._known = file, self._session.image
        name = tr("show {name} as the second image", name=Path(file.path).name)
        self._session.edit(name, lambda document: replace(document, second=file))

    def _on_document_changed(self, document: Document) -> None:
        wanted = document.second, self._session.image
        if wanted == self._known:
            return
        self._known = wanted
        self._task.cancel()
        self._show(None)
        if document.second and wanted[1] is not None:
            self._read(document.second, wanted[1])

    def _read(self, file: ImageFile, target: Image, use: Callable[[ImageFile], object] = lambda _: None) -> None:
        """Start to read a file, and `use` it before it is shown; what is shown stays until then."""
        self._task.cancel()
        name = Path(file.path).name

        def read_and_resample(task: BackgroundTask) -> tuple[SecondImage, str]:
            load = load_volume if target.ndim == 3 else load_image
            image = load(file.path, check_cancelled=task.check_cancelled, **file.reading.arguments)
            return build_second_image(image, target, is_label_map(image), task.advance), " ".join(
                map(translate_core_text, image.notes)
            )

        def show_if_current(found: tuple[SecondImage, str]) -> None:
            if self._session.image is not target:
                return
            second, notes = found
            use(file)
            self._show(second)
            if notes:
                self._session.messages.show(notes)

        title, activity = tr("Reading {name}…", name=name), tr("reading {name}", name=name)
        self._task = self._session.tasks.start_task(title, read_and_resample, activity, on_result=show_if_current)

    def _show(self, second: SecondImage | None) -> None:
        self._session.store.set_scene(replace(self._session.scene, second=second))
