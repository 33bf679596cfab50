"""The images of a folder, one after another."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from app.model.document.samples import sample_at
from app.model.preferences.table import SAVE_IN_FOLDER
from app.model.state.situation import Situation
from app.model.text.language import tr
from app.session.exchange.messages import NotOpened, Opened
from app.session.storage.session_file import DocumentFile
from app.views.files.folder_bar import FolderBar
from app.views.theme.theme import Theme
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature, FeatureContext
from cpm_core.formats.sessions.session_file import SUFFIX


class FolderFeature(Feature):
    """Opens the previous and the next image of a folder, each with the session beside it."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.bar = FolderBar()
        self.bar.asked.connect(self.go)
        context.window.statusBar().addPermanentWidget(self.bar)
        self._images: tuple[Path, ...] = ()
        self._here = self._ahead = 0
        self._document_file: DocumentFile | None = None
        context.session.listen(Opened, self._take)
        context.session.listen(NotOpened, self._stay)

    def keep(self, document_file: DocumentFile) -> None:
        """Save the open document to its file, where the user wants that."""
        self._document_file = document_file

    def action_specs(self) -> Sequence[ActionSpec]:
        """Previous and next."""
        return (
            ActionSpec(name="previous_image", menu="File", text=tr("Pre&vious image of the folder"),
                       do=partial(self.go, -1), shortcuts=("Alt+Left",), gap=True, when=partial(self._leads, -1),
                       tip=tr("Open the previous image of the folder, with the session beside it.")),
            ActionSpec(name="next_image", menu="File", text=tr("Ne&xt image of the folder"),
                       do=partial(self.go, 1), shortcuts=("Alt+Right",), when=partial(self._leads, 1),
                       tip=tr("Open the next image of the folder, with the session beside it.")),
        )  # fmt: skip

    def use_theme(self, theme: Theme) -> None:
        """Tint the buttons."""
        self.bar.use_theme(theme)

    def go(self, by: int) -> None:
        """Open the next image (1) or the previous one (-1) that is still there."""
        begin = self._ahead if self.context.session.opening else self._here
        ahead = range(begin + by, len(self._images) if by > 0 else -1, by)
        place = next((place for place in ahead if self._images[place].is_file()), None)
        if place is not None and self._saved():
            self._ahead = place
            self.context.open_file(self._images[place], True)

    def _saved(self) -> bool:
        """Save without a question, where the user wants that and nothing is overwritten; False when it fails."""
        file, image = self._document_file, self.context.session.document.image
        if file is None or image is None or not file.unsaved or not self.context.preferences.value(SAVE_IN_FOLDER):
            return True
        beside = Path(image.path).with_suffix(SUFFIX)
        if file.path is None and beside.exists():
            return True  # the usual question follows
        return file.save_at_once(file.path or beside)

    def _leads(self, by: int, situation: Situation) -> bool:
        return 0 <= self._here + by < len(self._images)

    def _take(self, opened: Opened) -> None:
        known = opened.path in opened.folder and sample_at(opened.path) is None
        self._images = opened.folder if known else ()
        self._here = self._ahead = opened.folder.index(opened.path) if known else 0
        self.bar.show_place(self._here, len(self._images), opened.path.parent.name)
        self.context.refresh()

    def _stay(self, _: NotOpened) -> None:
        self._ahead = self._here
