"""The dialogs about presets."""

from __future__ import annotations

from PySide6.QtWidgets import QFileDialog, QInputDialog, QMessageBox, QWidget

from app.model.parameters.presets import SUFFIX
from app.model.text.language import tr


def ask_for_name(parent: QWidget, suggestion: str) -> str:
    """Name for a preset, empty when the user has thought better of it."""
    name, agreed = QInputDialog.getText(parent, tr("Name of the preset"), tr("Name:"), text=suggestion)
    return name if agreed else ""


def ask_for_preset(parent: QWidget, names: list[str], question: str) -> str:
    """One of these presets, empty when the user has thought better of it."""
    if len(names) < 2:
        return names[0] if names else ""
    name, agreed = QInputDialog.getItem(parent, tr("Preset"), question, names, 0, False)
    return name if agreed else ""


def agrees_to_delete(parent: QWidget, name: str) -> bool:
    """Whether a preset is to go for good."""
    asked = tr("Delete the preset “{name}”? This cannot be undone.").format(name=name)
    buttons = QMessageBox.StandardButton.Yes | QMessageBox.StandardButton.No
    return QMessageBox.question(parent, tr("Delete preset"), asked, buttons) == QMessageBox.StandardButton.Yes


def ask_for_preset_file(parent: QWidget, folder: str) -> str:
    """File of a preset to bring in, empty when the user has thought better of it."""
    filters = tr("Presets ({pattern})").format(pattern=f"*{SUFFIX}")
    return QFileDialog.getOpenFileName(parent, tr("Import preset"), folder, filters)[0]


def ask_where_to(parent: QWidget, suggestion: str) -> str:
    """File to write a preset to, empty when the user has thought better of it; a suffix left out is added."""
    filters = tr("Presets ({pattern})").format(pattern=f"*{SUFFIX}")
    chosen = QFileDialog.getSaveFileName(parent, tr("Export preset"), suggestion, filters)[0]
    return chosen + SUFFIX if chosen and not chosen.endswith(SUFFIX) else chosen
