"""The start screen with recent work, and the pictures of it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import QDateTime, QLocale
from PySide6.QtGui import QImage

from app.model.document.samples import sample_at, samples
from app.model.text.language import tr
from app.session.exchange.messages import ImageReady, NotOpened, Opened
from app.session.storage.pictures import SIZE, Pictures, folder_of_pictures, middle
from app.session.storage.session_file import Written
from app.views.features.file.open_save import OpenSaveFeature
from app.views.files.start_screen import Entry, StartScreen
from app.views.theme.theme import Theme
from app.views.widgets.action_spec import ActionSpec
from app.views.widgets.offer_bar import OfferBar
from app.views.window.feature import Feature, FeatureContext


class StartFeature(Feature):
    """Shows the start screen, and keeps a picture of each image and session that has been open."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.pictures = Pictures(folder_of_pictures())
        self.screen = StartScreen(context.canvas_area)
        self._files: OpenSaveFeature | None = None
        self.screen.chosen.connect(lambda path: self.context.open_file(path, False))
        self.screen.left.connect(self.leave)
        context.session.image_changed.connect(self.leave)
        context.session.listen(ImageReady, lambda _: self._keep_picture())
        context.session.listen(Written, lambda _: self._keep_picture())
        context.session.listen(NotOpened, self._stay)

    def keep(self, files: OpenSaveFeature) -> None:
        """Show the files that have been open, and open others."""
        self._files = files
        self.screen.asked.connect(files.ask_for_file)
        files.recent.cleared.append(self.pictures.clear)

    def action_specs(self) -> Sequence[ActionSpec]:
        """The start screen."""
        return (
            ActionSpec(name="start", menu="File", text=tr("S&tart screen"), short=tr("Start"), do=self.toggle,
                       shortcuts=("Alt+Home",), tip=tr("Show recent work and samples as pictures."), icon="home"),
        )  # fmt: skip

    def use_theme(self, theme: Theme) -> None:
        """Color the background."""
        self.screen.use_theme(theme)

    def close(self) -> bool:
        """Keep a picture of what is open."""
        self._keep_picture()
        return True

    def show(self) -> None:
        """Show the start screen in place of the image."""
        files = self._files.recent.paths if self._files is not None else []
        recent = [self._entry(path) for path in files if path.is_file()]
        self.screen.show_entries(recent, _samples(), leaves=self.context.session.document.image is not None)

    def leave(self) -> None:
        """Show the image, if there is one."""
        if self.screen.isVisible() and self.context.session.document.image is not None:
            self.screen.hide()
            self.context.canvas_area.canvas.setFocus()

    def toggle(self) -> None:
        """Show the start screen, or the image again."""
        if self.screen.isVisible():
            self.leave()
        else:
            self.show()

    def welcome(self, bar: OfferBar) -> None:
        """Offer the newest work when the program begins with a sample."""
        session = self.context.session

        def offer(opened: Opened) -> None:
            session.stop_listening(Opened, offer)
            newest = next((path for path in self._files.recent.paths if path.is_file()), None) if self._files else None
            if newest is not None and opened.saved is None:
                bar.offer(
                    tr("Continue with {name}?").format(name=newest.name),
                    (tr("Open {name}").format(name=newest.name), lambda: self.context.open_file(newest, True)),
                    (tr("Recent work"), self.show),
                )

        session.listen(Opened, offer)

    def _stay(self, refused: NotOpened) -> None:
        """With nothing open and nothing else to open, show what could be opened."""
        if refused.otherwise is None and self.context.session.document.image is None:
            self.show()

    def _entry(self, path: Path) -> Entry:
        changed = QDateTime.fromSecsSinceEpoch(int(path.stat().st_mtime)).date()
        when = QLocale().toString(changed, QLocale.FormatType.ShortFormat)
        return Entry(path, self.pictures.get(path), path.name, f"{path.parent.name} · {when}", str(path))

    def _keep_picture(self) -> None:
        """Keep what the canvas shows as the picture of the image, and of its session if there is one."""
        image = self.context.session.document.image
        if image is None or self._files is None:
            return
        session = self._files.document_file.path
        canvas = self.context.canvas_area.canvas
        picture = canvas.grab().toImage()
        for path in (Path(image.path), session):
            if path is not None and sample_at(path) is None:
                self.pictures.put(path, picture)


def _samples() -> list[Entry]:
    return [
        Entry(sample.path, middle(QImage(str(sample.picture)), SIZE), sample.title, "", sample.about)
        for sample in samples()
    ]
