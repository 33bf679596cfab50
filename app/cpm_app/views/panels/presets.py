"""Presets: a box that selects one, and what saves and deletes the user's own."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import QComboBox, QSizePolicy

from cpm_app.model.document import edits
from cpm_app.model.document.document import Document
from cpm_app.model.parameters.presets import Preset
from cpm_app.model.text.language import explain_error, tr
from cpm_app.session.storage.presets import PresetStore
from cpm_app.views.widgets.fields import WheelWithFocus
from cpm_app.views.window.dialogs import QuestionDialog, ask_for_text
from cpm_app.views.window.window import MainWindow
from cpm_core import PRESETS

_PRESET_CATEGORY = "preset"
"""Category of messages about presets."""


class PresetBox(WheelWithFocus, QComboBox):
    """Box that shows the preset whose parameters are in use, and selects others."""

    def __init__(self, window: MainWindow, store: PresetStore) -> None:
        super().__init__()
        self._window, self._session = window, window.session
        self.store = store
        self.current: Preset | None = None
        """Preset whose parameters are in use, if any."""
        self._shown_for: tuple[object, object] | None = None
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.setAccessibleName(tr("Preset"))
        self.activated.connect(lambda index: self.use_preset(self.itemData(index)))
        store.changed.connect(self._on_store_changed)
        store.changed.connect(window.refresh_actions)
        window.session.document_changed.connect(self._on_document_changed)
        self._on_store_changed()

    def use_preset(self, name: str) -> None:
        """Set the parameters of a preset."""
        preset = next(preset for preset in self.store.presets if preset.name == name)
        words = tr("preset “{name}”", name=name)
        self._session.edit(words, lambda document: edits.apply_preset(document, preset.parameters))

    def save_preset(self) -> None:
        """Ask for a name, and save the parameters under it."""
        session, suggested = self._session, self.current.name if self.current and self.current.is_own else ""
        session.messages.clear(_PRESET_CATEGORY)
        name = ask_for_text(self._window, tr("Name of the preset"), tr("Name:"), tr("Use this name"), suggested)
        if name:
            about = tr("Created for {image}.", image=session.document.image.name) if session.document.image else ""
            try:
                kept = self.store.save(Preset(name, session.document.parameters, about))
            except (ValueError, OSError) as error:
                session.messages.show(explain_error(error), True, _PRESET_CATEGORY)
            else:
                session.messages.show(tr("The parameters were saved as “{name}”.", name=kept.name))

    def delete_preset(self) -> None:
        """Delete the preset in use, after a question."""
        assert self.current is not None
        self._session.messages.clear(_PRESET_CATEGORY)
        text = tr("Delete the preset “{name}”?", name=self.current.name)
        answers, more = {"delete": tr("&Delete"), "keep": tr("&Keep")}, tr("This cannot be undone.")
        question = QuestionDialog(self._window, tr("Delete preset"), text, more, answers, ("delete",))
        if question.wait_for_answer() == "delete":
            try:
                self.store.delete(self.current.name)
            except OSError as error:
                self._session.messages.show(explain_error(error), True, _PRESET_CATEGORY)

    def _on_store_changed(self) -> None:
        with QSignalBlocker(self):
            self.clear()
            for index, preset in enumerate(self.store.presets):
                self.addItem(preset.name, preset.name)
                self.setItemData(index, preset.about, Qt.ItemDataRole.ToolTipRole)
            self.view().setMinimumWidth(self.view().sizeHintForColumn(0))  # the box may be narrower than a name
        self._shown_for = None
        self._on_document_changed(self._session.document)

    def _on_document_changed(self, document: Document) -> None:
        # most edits change only shapes, and comparing all presets takes milliseconds
        if self._shown_for == (document.parameters, document.image):
            return
        self._shown_for = document.parameters, document.image
        same = (one for one in self.store.presets if edits.apply_preset(document, one.parameters) == document)
        self.current = next(same, None)
        whole = document.parameters == PRESETS["volume"]  # it suits no image, and is not in the box
        self.setPlaceholderText(tr("Volume") if whole else tr("Custom parameters"))
        self.setCurrentIndex(-1 if self.current is None else self.findData(self.current.name))
        name = self.currentText() or self.placeholderText()  # the box may be too narrow for it
        self.setToolTip(f"{name}\n{tr('Parameters that suit a kind of image, and your own presets.')}")
