"""Presets: a button with the name of the current one, whose menu selects, saves and deletes presets."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QAction, QKeyEvent
from PySide6.QtWidgets import QMenu, QSizePolicy, QToolButton

from cpm_app.model.document import edits
from cpm_app.model.document.document import Document
from cpm_app.model.parameters.presets import Preset
from cpm_app.model.text.language import explain_error, tr
from cpm_app.session.storage.presets import PresetStore
from cpm_app.views.widgets.actions import add_menu_action
from cpm_app.views.window.dialogs import QuestionDialog, ask_for_text
from cpm_app.views.window.window import MainWindow
from cpm_core import PRESETS
from cpm_core.numerics.types import Callback

_PRESET_CATEGORY = "preset"
"""Category of messages about presets."""


class PresetButton(QToolButton):
    """Button that shows the current preset; a click, Enter or the arrow key opens the menu of the presets."""

    def __init__(self, window: MainWindow, store: PresetStore) -> None:
        super().__init__()
        self._window, self._session = window, window.session
        self.store = store
        self.current: Preset | None = None
        """Preset whose parameters are in use, if any."""
        self._shown_for: tuple[object, object] | None = None
        self.setObjectName("preset")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.setAccessibleName(tr("Preset"))
        self.setToolTip(tr("Parameters that suit a kind of image, and your own presets."))
        self.popup = QMenu(self, toolTipsVisible=True)
        self.clicked.connect(self.open_menu)
        self.save = self._create_action(
            tr("&Save as…"), self._save_preset, tr("Save the current parameters under a name.")
        )
        self.delete = self._create_action(
            tr("&Delete…"), self._delete_preset, tr("Delete the preset in use, if it is your own.")
        )
        store.changed.connect(self._on_store_changed)
        window.session.document_changed.connect(self._on_document_changed)
        self._on_store_changed()

    def open_menu(self) -> None:
        """Open the menu below the button."""
        self.popup.clear()
        self.fill_menu(self.popup)
        self.popup.popup(self.mapToGlobal(QPoint(0, self.height() + 2)))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Open the menu on the arrow key as well."""
        if event.key() == Qt.Key.Key_Down:
            self.open_menu()
        else:
            super().keyPressEvent(event)

    def use_preset(self, preset: Preset) -> None:
        """Set the parameters of a preset."""
        name = tr("preset “{name}”", name=preset.name)
        self._session.edit(name, lambda document: edits.apply_preset(document, preset.parameters))

    def fill_menu(self, menu: QMenu) -> None:
        """Fill a menu with the presets and the actions on them."""
        for preset in self.store.presets:
            current = self.current is not None and preset.name == self.current.name
            add_menu_action(
                menu, preset.name.replace("&", "&&"), partial(self.use_preset, preset), preset.about, current
            )
        menu.addSeparator()
        menu.addActions([self.save, self.delete])

    def _create_action(self, text: str, do: Callback, tip: str) -> QAction:
        action = QAction(text, self, toolTip=tip, statusTip=tip)

        def run_action() -> None:
            self._session.messages.clear(_PRESET_CATEGORY)
            try:
                do()
            except (ValueError, OSError) as error:
                self._session.messages.show(explain_error(error), True, _PRESET_CATEGORY)

        action.triggered.connect(run_action)
        return action

    def _on_store_changed(self) -> None:
        self._shown_for = None
        self._on_document_changed(self._session.document)

    def _on_document_changed(self, document: Document) -> None:
        # most edits change only shapes, and comparing all presets takes milliseconds
        if self._shown_for == (document.parameters, document.image):
            return
        self._shown_for = document.parameters, document.image
        same = (one for one in self.store.presets if edits.apply_preset(document, one.parameters) == document)
        self.current = next(same, None)
        self.delete.setEnabled(self.current is not None and self.current.is_own)
        whole = document.parameters == PRESETS["volume"]  # it suits no image, and is in no menu
        otherwise = tr("Volume") if whole else tr("Custom parameters")
        name = otherwise if self.current is None else self.current.name.replace("&", "&&")
        self.setText(f"{name}  ▾")

    def _save_preset(self) -> None:
        session, suggested = (
            self._session,
            self.current.name if self.current is not None and self.current.is_own else "",
        )
        name = ask_for_text(self._window, tr("Name of the preset"), tr("Name:"), tr("Use this name"), suggested)
        if name:
            about = tr("Created for {image}.", image=session.document.image.name) if session.document.image else ""
            kept = self.store.save(Preset(name, session.document.parameters, about))
            session.messages.show(tr("The parameters were saved as “{name}”.", name=kept.name))

    def _delete_preset(self) -> None:
        assert self.current is not None
        text = tr("Delete the preset “{name}”?", name=self.current.name)
        answers, more = {"delete": tr("&Delete"), "keep": tr("&Keep")}, tr("This cannot be undone.")
        question = QuestionDialog(self._window, tr("Delete preset"), text, more, answers, ("delete",))
        if question.wait_for_answer() == "delete":
            self.store.delete(self.current.name)
