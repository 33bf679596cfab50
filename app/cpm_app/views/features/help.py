"""Menu Help, and the preferences."""

from __future__ import annotations

import html

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QMessageBox

from cpm_app.model.document.samples import find_sample_named
from cpm_app.model.text.about import LICENSE_SENTENCE, PAPER_CITATION, PROGRAM_PURPOSE, list_versions
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import ImageOpened
from cpm_app.views.widgets.actions import ActionSpec
from cpm_app.views.window.guide import KEYS_PAGE, Guide
from cpm_app.views.window.preferences import PreferencesDialog
from cpm_app.views.window.window import Feature
from cpm_core import __version__

GUIDE_SEEN_KEY = "guide/seen"
"""Preference: whether the guide has been shown."""


class HelpFeature(Feature):
    """Guide, list of keys, and information about the program."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        self.guide: Guide | None = None
        """The guide, while it is open."""
        self.actions = (
            ActionSpec(KEYS_PAGE, "Help", "&Keys", "Show all keys.", self._show_keys, "?"),
            ActionSpec("guide", "Help", "&Guide", "First steps, examples step by step, and the use of the canvas.",
                       self.show_guide, "F1", icon="guide"),
            ActionSpec("about", "Help", "&About CPM",
                       "Version, license, the paper, and the libraries in use.",
                       self._show_about, gap=True),
        )  # fmt: skip

    def offer_guide(self) -> None:
        """Offer the guide with the first image, when the program is started for the first time."""
        if self.window.preferences.read_key(GUIDE_SEEN_KEY, False):
            return
        self.window.preferences.store_key(GUIDE_SEEN_KEY, True)
        session = self.session

        def on_opened(_: ImageOpened) -> None:
            session.store.remove_listener(ImageOpened, on_opened)
            question = tr("New here? The guide ({key:guide}) has four examples, step by step.")
            self.window.offers.add_offer(insert_keys(question), (tr("&Guide"), self.show_guide))

        session.store.add_listener(ImageOpened, on_opened)

    def show_guide(self, page: str = "") -> None:
        """Open the guide, at a named page if given, or bring it to the front."""
        if self.guide is None:
            self.guide = Guide(self.window, self.window.shortcuts, self._open_sample)
            self.guide.finished.connect(lambda: setattr(self, "guide", None))
        self.guide.show()
        self.guide.raise_()
        self.guide.activateWindow()
        if page:
            self.guide.turn_to(page)

    def close(self) -> bool:
        """Close the guide."""
        if self.guide is not None:
            self.guide.close()
        return True

    def _show_keys(self) -> None:
        if self.guide is not None and self.guide.page == KEYS_PAGE:
            self.guide.close()
        else:
            self.show_guide(KEYS_PAGE)

    def _show_about(self) -> None:
        """Show versions, license and paper; a button copies them."""
        rows = "".join(f"<tr><td>{name} </td><td>{version}</td></tr>" for name, version in list_versions()[1:])
        text = "".join(f"<p>{html.escape(text)}</p>" for text in (PROGRAM_PURPOSE, PAPER_CITATION, LICENSE_SENTENCE))
        box = QMessageBox(
            self.window,
            iconPixmap=self.window.windowIcon().pixmap(64, 64),
            text=" ".join(list_versions()[0]),
            informativeText=f"{text}<table>{rows}</table>",
            textInteractionFlags=Qt.TextInteractionFlag.TextBrowserInteraction,
        )
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setWindowTitle(tr("About CPM"))
        copy = box.addButton(tr("&Copy this text"), QMessageBox.ButtonRole.ActionRole)
        copy.setToolTip(tr("Copy it to the clipboard, for example for a bug report."))
        copy.clicked.disconnect()  # copying must not close the box
        listed = "\n".join(f"{name}: {version}" for name, version in list_versions())
        # ready for a bug report
        plain = f"CPM {__version__}\n{PROGRAM_PURPOSE}\n\n{PAPER_CITATION}\n\n{LICENSE_SENTENCE}\n\n{listed}\n"
        copy.clicked.connect(lambda: QApplication.clipboard().setText(plain))
        box.addButton(QMessageBox.StandardButton.Close)
        box.open()

    def _open_sample(self, file: str) -> None:
        sample = find_sample_named(file)
        if sample is not None:
            self.window.open_image(sample.path)


class PreferencesFeature(Feature):
    """Dialog of the preferences."""

    def set_up(self) -> None:
        """Create the actions and connect them to what they depend on."""
        self.actions = (
            ActionSpec("preferences", "Edit", "&Preferences…", "Change the settings of the program.",
                       self.open_preferences, "Ctrl+,", gap=True),
        )  # fmt: skip

    def open_preferences(self) -> PreferencesDialog:
        """Open the dialog, and leave the window usable."""
        window = self.window
        dialog = PreferencesDialog(window, window.preferences, window.shortcuts)
        dialog.finished.connect(dialog.deleteLater)
        dialog.open()
        return dialog
