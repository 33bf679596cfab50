"""Actions on presets: use, save, rename, delete, import, export."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu, QWidget

from app.model.document import edits
from app.model.document.document import Document
from app.model.parameters.presets import SUFFIX, Preset
from app.model.text.language import reason, tr
from app.session.storage.presets import PresetStore
from app.views.presets.preset_gallery import PresetGallery, picture_of
from app.views.window.dialogs import Button, Files, Question, all_files, ask_for_one, ask_for_text
from app.views.window.feature import FeatureContext
from cpm_core.parameters import PRESETS

_TOPIC = "preset"


class PresetFiles(QObject):
    """Connects the gallery of presets, their files and the session."""

    def __init__(self, context: FeatureContext, store: PresetStore) -> None:
        super().__init__(context.window)
        self._context = context
        self.store = store
        self.save = self._make(tr("&Save as…"), self._save, tr("Save the current parameters under a name."))
        self.rename = self._make(tr("&Rename…"), self._rename, tr("Rename one of your presets."))
        self.delete = self._make(tr("&Delete…"), self._delete, tr("Delete one of your presets."))
        self.import_action = self._make(tr("&Import…"), self._import, tr("Import a preset from a file."))
        self.export_action = self._make(tr("&Export…"), self._export, tr("Export a preset to a file."))
        self.actions = (self.save, self.rename, self.delete, self.import_action, self.export_action)
        self.gallery = PresetGallery(self.actions)
        self._compared: tuple[object, object] | None = None
        self.gallery.chosen.connect(self.use)
        store.changed.connect(self._list)
        context.session.document_changed.connect(self._show)
        self._list()

    def use(self, preset: Preset) -> None:
        """Set the parameters of a preset."""
        name = tr("preset “{name}”").format(name=preset.name)
        self._context.session.edit(name, lambda document: edits.use_preset(document, preset.parameters))

    def fill(self, menu: QMenu) -> None:
        """Fill a menu with the presets and the actions on them."""
        for preset in self.store.presets:
            action = menu.addAction(preset.name.replace("&", "&&"))
            action.setCheckable(True)
            action.setChecked(self.gallery.current is not None and preset.name == self.gallery.current.name)
            action.setStatusTip(preset.about)
            action.triggered.connect(lambda _=False, preset=preset: self.use(preset))
        menu.addSeparator()
        menu.addActions(list(self.actions))

    def _make(self, text: str, do: Callable[[], None], tip: str) -> QAction:
        action = QAction(text, self)
        # Otherwise Qt leaves out the dots, which say that a dialog will open, on tool buttons.
        action.setIconText(text.replace("&", ""))
        action.setToolTip(tip)
        action.setStatusTip(tip)
        action.triggered.connect(lambda _=False: self._try(do))
        return action

    def _try(self, do: Callable[[], None]) -> None:
        session = self._context.session
        session.attempt(_TOPIC)
        try:
            do()
        except (ValueError, OSError) as error:
            session.say(reason(error), True, _TOPIC)

    def _list(self) -> None:
        self.gallery.show_presets(self.store.presets)
        self._compared = None
        own = any(preset.own for preset in self.store.presets)
        self.rename.setEnabled(own)
        self.delete.setEnabled(own)
        self._show(self._context.session.document)

    def _show(self, document: Document) -> None:
        # most changes of a document are of its shapes, and to compare all presets takes milliseconds
        if self._compared == (document.parameters, document.image):
            return
        self._compared = document.parameters, document.image
        used = [edits.use_preset(document, preset.parameters) for preset in self.store.presets]
        same = [preset for preset, after in zip(self.store.presets, used, strict=True) if after == document]
        whole = document.parameters == PRESETS["volume"]  # it suits no image, and is in no gallery
        self.gallery.show_current(same[0] if same else None, tr("Volume") if whole else "")

    def _save(self) -> None:
        session, current = self._context.session, self.gallery.current
        name = ask_for_name(self._context.window, current.name if current is not None and current.own else "")
        if not name:
            return
        picture = picture_of(self._context.canvas_area.canvas.grab().toImage())
        about = tr("Made on {image}.").format(image=session.document.image.name) if session.document.image else ""
        kept = self.store.save(Preset(name, session.document.parameters, about, picture))
        session.say(tr("The parameters are saved as “{name}”.").format(name=kept.name))

    def _rename(self) -> None:
        preset = self._own(tr("Rename which preset?"), tr("Rename…"))
        if preset is not None:
            name = ask_for_name(self._context.window, preset.name)
            if name:
                self.store.rename(preset.name, name)

    def _delete(self) -> None:
        preset = self._own(tr("Delete which preset?"), tr("Delete…"))
        if preset is not None and agrees_to_delete(self._context.window, preset.name):
            self.store.delete(preset.name)

    def import_file(self, path: Path) -> None:
        """Import a preset from a file."""
        self._try(lambda: self._import_file(path))

    def _import_file(self, path: Path) -> None:
        preset = self.store.bring_in(path)
        self._context.session.say(tr("The preset “{name}” has been imported.").format(name=preset.name))

    def _import(self) -> None:
        chosen = self._context.files.ask_for_file("preset", tr("Import preset"), (_presets(), all_files()))
        if chosen is not None:
            self._import_file(chosen)

    def _export(self) -> None:
        current = self.gallery.current
        names = [preset.name for preset in self.store.presets]
        if current is not None:
            names.insert(0, names.pop(names.index(current.name)))
        name = ask_for_preset(self._context.window, names, tr("Export which preset?"), tr("Export…"))
        preset = self.store.called(name)
        if preset is None:
            return
        name = f"{preset.name}{SUFFIX}"
        chosen = self._context.files.ask_where_to_save("preset", tr("Export preset"), name, [_presets()])
        if chosen is not None:
            self.store.hand_out(preset, chosen)
            self._context.session.say(tr("Exported to {path}.").format(path=chosen))

    def _own(self, question: str, button: str) -> Preset | None:
        """The preset in use if it is the user's own, else one of their own that the user chooses."""
        current = self.gallery.current
        if current is not None and current.own:
            return current
        names = [preset.name for preset in self.store.presets if preset.own]
        return self.store.called(ask_for_preset(self._context.window, names, question, button))


def ask_for_name(parent: QWidget, suggestion: str) -> str:
    """Name for a preset, empty when canceled."""
    title, button = tr("Name of the preset"), tr("Use this name")
    return ask_for_text(parent, title, tr("Name:"), button, suggestion) or ""


def ask_for_preset(parent: QWidget, names: list[str], question: str, button: str) -> str:
    """Name of one of these presets, empty when canceled."""
    if len(names) < 2:
        return names[0] if names else ""
    return ask_for_one(parent, tr("Preset"), question, button, names) or ""


def agrees_to_delete(parent: QWidget, name: str) -> bool:
    """Whether the user agrees to delete a preset."""
    text, more = tr("Delete the preset “{name}”?").format(name=name), tr("This cannot be undone.")
    buttons = Button("keep", tr("&Keep"), "cancel"), Button("delete", tr("&Delete"), "discard")
    return Question(parent, tr("Delete preset"), text, more, buttons).ask() == "delete"


def _presets() -> Files:
    return Files(tr("Presets"), (SUFFIX,))
