"""A second image over the first: opened by the menu, or dropped with Shift; and removed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import QUrl

from cpm_app.model.state.situation import has_image
from cpm_app.model.text.language import tr
from cpm_app.views.widgets.actions import ActionSpec
from cpm_app.views.window.dialogs import ALL_FILES, FileKind
from cpm_app.views.window.window import Feature
from cpm_core.formats import IMAGES_READABLE


class SecondImageFeature(Feature):
    """Opening and removal of the second image."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        self._images = self.window.workspace.second_images
        self.window.second_dropped.connect(self._on_dropped)
        self.actions = (
            ActionSpec("second_image", "File", "Show a second &image…",
                       "Show a label map or another image over this one, by its place in space; or drop it with Shift.",
                       self._ask_for_file, when=has_image),
            ActionSpec("remove_second_image", "File", "Remove the second ima&ge", "Show the image alone again.",
                       self._images.remove, when=lambda now: bool(now.document.second)),
        )  # fmt: skip

    def _ask_for_file(self) -> None:
        kinds = (FileKind(tr("Images"), tuple(IMAGES_READABLE)), ALL_FILES)
        chosen = self.window.files.ask_for_file("open", tr("Show a second image"), kinds)
        if chosen is not None:
            self._images.open_file(chosen)

    def _on_dropped(self, urls: Sequence[QUrl]) -> None:
        """Show the first dropped file as the second image; without an image, open it."""
        if self.session.image is None or not urls[0].isLocalFile():
            self.window.urls_dropped.emit(urls)
        else:
            self._images.open_file(Path(urls[0].toLocalFile()))
