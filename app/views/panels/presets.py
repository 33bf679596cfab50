"""Presets: a button with the name of the one in use, whose menu offers all of them and what can be done with them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject, QPoint, Qt
from PySide6.QtGui import QAction, QKeyEvent
from PySide6.QtWidgets import QMenu, QSizePolicy, QToolButton

from app.model.document import edits
from app.model.document.document import Document
from app.model.parameters.presets import SUFFIX, Preset
from app.model.text.language import reason, tr
from app.session.storage.presets import PresetStore
from app.views.window.dialogs import ALL_FILES, Button, Files, Question, ask_for_text
from app.views.window.window import MainWindow
from cpm_core import PRESETS

_TOPIC = "preset"


class PresetButton(QToolButton):
    """Shows the name of the preset in use; it is opened by a click, Enter or the arrow key."""

    def __init__(self, fill: Callable[[QMenu], None]) -> None:
        super().__init__()
        self.setObjectName("preset")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.setAccessibleName(tr("Preset"))
        self.setToolTip(tr("Parameters that suit a kind of image, and your own presets."))
        self.popup = QMenu(self)
        self.popup.setToolTipsVisible(True)
        self._fill = fill
        self.clicked.connect(self.open)

    def open(self) -> None:
        """Open the menu below the button."""
        self.popup.clear()
        self._fill(self.popup)
        self.popup.popup(self.mapToGlobal(QPoint(0, self.height() + 2)))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Open on the arrow key as well."""
        if event.key() == Qt.Key.Key_Down:
            self.open()
        else:
            super().keyPressEvent(event)


class Presets(QObject):
    """Uses, saves, renames, deletes, imports and exports presets; the last four concern the preset in use."""

    def __init__(self, window: MainWindow, store: PresetStore) -> None:
        super().__init__(window)
        self._window = window
        self.store = store
        self.current: Preset | None = None
        """The preset whose parameters are in use."""
        self.save = self._make(tr("&Save as…"), self._save, tr("Save the current parameters under a name."))
        self.rename = self._make(tr("&Rename…"), self._rename, tr("Rename the preset in use, if it is your own."))
        self.delete = self._make(tr("&Delete…"), self._delete, tr("Delete the preset in use, if it is your own."))
        self.import_action = self._make(tr("&Import…"), self._import, tr("Import a preset from a file."))
        self.export_action = self._make(tr("&Export…"), self._export, tr("Export the preset in use to a file."))
        self.button = PresetButton(self.fill)
        self._compared: tuple[object, object] | None = None
        store.changed.connect(self._list)
        window.session.document_changed.connect(self._show)
        self._list()

    def use(self, preset: Preset) -> None:
        """Set the parameters of a preset."""
        name = tr("preset “{name}”").format(name=preset.name)
        self._window.session.edit(name, lambda document: edits.use_preset(document, preset.parameters))

    def fill(self, menu: QMenu) -> None:
        """Fill a menu with the presets and the actions on them."""
        for preset in self.store.presets:
            action = menu.addAction(preset.name.replace("&", "&&"))
            action.setCheckable(True)
            action.setChecked(self.current is not None and preset.name == self.current.name)
            action.setStatusTip(preset.about)
            action.setToolTip(preset.about)
            action.triggered.connect(lambda _=False, preset=preset: self.use(preset))
        menu.addSeparator()
        menu.addActions([self.save, self.rename, self.delete, self.import_action, self.export_action])

    def import_file(self, path: Path) -> None:
        """Import a preset from a file."""

        def add() -> None:
            preset = self.store.import_from(path)
            self._window.session.say(tr("The preset “{name}” has been imported.").format(name=preset.name))

        self._try(add)

    def _make(self, text: str, do: Callable[[], None], tip: str) -> QAction:
        action = QAction(text, self)
        action.setToolTip(tip)
        action.setStatusTip(tip)
        action.triggered.connect(lambda _=False: self._try(do))
        return action

    def _try(self, do: Callable[[], None]) -> None:
        session = self._window.session
        session.attempt(_TOPIC)
        try:
            do()
        except (ValueError, OSError) as error:
            session.say(reason(error), True, _TOPIC)

    def _list(self) -> None:
        self._compared = None
        self._show(self._window.session.document)

    def _show(self, document: Document) -> None:
        # most changes of a document are of its shapes, and to compare all presets takes milliseconds
        if self._compared == (document.parameters, document.image):
            return
        self._compared = document.parameters, document.image
        same = (one for one in self.store.presets if edits.use_preset(document, one.parameters) == document)
        self.current = next(same, None)
        own = self.current is not None and self.current.own
        self.rename.setEnabled(own)
        self.delete.setEnabled(own)
        self.export_action.setEnabled(self.current is not None)
        whole = document.parameters == PRESETS["volume"]  # it suits no image, and is in no menu
        otherwise = tr("Volume") if whole else tr("Custom parameters")
        name = otherwise if self.current is None else self.current.name.replace("&", "&&")
        self.button.setText(f"{name}  ▾")

    def _save(self) -> None:
        session = self._window.session
        name = self._ask_name(self.current.name if self.current is not None and self.current.own else "")
        if name:
            about = tr("Made on {image}.").format(image=session.document.image.name) if session.document.image else ""
            kept = self.store.save(Preset(name, session.document.parameters, about))
            session.say(tr("The parameters are saved as “{name}”.").format(name=kept.name))

    def _rename(self) -> None:
        assert self.current is not None
        name = self._ask_name(self.current.name)
        if name:
            self.store.rename(self.current.name, name)

    def _delete(self) -> None:
        assert self.current is not None
        text = tr("Delete the preset “{name}”?").format(name=self.current.name)
        buttons = Button("keep", tr("&Keep"), "cancel"), Button("delete", tr("&Delete"), "discard")
        question = Question(self._window, tr("Delete preset"), text, tr("This cannot be undone."), buttons)
        if question.ask() == "delete":
            self.store.delete(self.current.name)

    def _import(self) -> None:
        chosen = self._window.files.ask_for_file("preset", tr("Import preset"), (_presets(), ALL_FILES))
        if chosen is not None:
            self.import_file(chosen)

    def _export(self) -> None:
        preset = self.current
        assert preset is not None
        name = f"{preset.name}{SUFFIX}"
        chosen = self._window.files.ask_where_to_save("preset", tr("Export preset"), name, [_presets()])
        if chosen is not None:
            self.store.export_to(preset, chosen)
            self._window.session.say(tr("Exported to {path}.").format(path=chosen))

    def _ask_name(self, suggestion: str) -> str | None:
        title, button = tr("Name of the preset"), tr("Use this name")
        return ask_for_text(self._window, title, tr("Name:"), button, suggestion)


def _presets() -> Files:
    return Files(tr("Presets"), (SUFFIX,))
