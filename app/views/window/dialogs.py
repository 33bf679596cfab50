"""The dialogs that ask for a file, and the question about unsaved work."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from PySide6.QtWidgets import QFileDialog, QMessageBox, QWidget

from app.model.text.language import tr
from cpm_core.formats import READABLE
from cpm_core.formats.sessions.session_file import SUFFIX

Answer = Literal["save", "discard", "cancel"]


def ask_for_file(parent: QWidget, folder: str) -> str:
    """Path of an image or a session to open, empty when the user cancels."""
    images = " ".join(f"*{suffix}" for suffix in READABLE)
    kinds = (
        tr("Images and sessions ({patterns})").format(patterns=f"{images} *{SUFFIX}"),
        tr("Images ({patterns})").format(patterns=images),
        tr("Sessions ({patterns})").format(patterns=f"*{SUFFIX}"),
        tr("All files (*)"),
    )
    chosen, _ = QFileDialog.getOpenFileName(parent, tr("Open"), folder, ";;".join(kinds))
    return chosen


def ask_where_to_save(parent: QWidget, suggestion: str) -> str:
    """Path to save a session to, empty when the user cancels; a missing suffix is added."""
    kind = tr("Sessions ({patterns})").format(patterns=f"*{SUFFIX}")
    chosen, _ = QFileDialog.getSaveFileName(parent, tr("Save session"), suggestion, kind)
    return chosen + SUFFIX if chosen and Path(chosen).suffix.lower() != SUFFIX else chosen


def would_be_lost(parts: Sequence[str]) -> str:
    """A sentence on what would be lost."""
    listed = ", ".join(parts[:-1])
    named = tr("{parts} and {last}").format(parts=listed, last=parts[-1]) if listed else "".join(parts)
    return tr("This would be lost: {parts}.").format(parts=named)


def ask_about_unsaved(parent: QWidget, name: str, lost: Sequence[str]) -> Answer:
    """What to do with unsaved work called `name`; `lost` tells what would be lost."""
    box = QMessageBox(QMessageBox.Icon.Warning, tr("Unsaved work"), tr("Save the work on “{name}”?").format(name=name))
    box.setParent(parent, box.windowFlags())
    box.setInformativeText(would_be_lost(lost))
    standard = QMessageBox.StandardButton
    box.setStandardButtons(standard.Save | standard.Discard | standard.Cancel)
    box.setDefaultButton(standard.Save)
    box.setEscapeButton(standard.Cancel)
    box.button(standard.Save).setText(tr("&Save"))
    box.button(standard.Discard).setText(tr("&Discard"))
    box.button(standard.Cancel).setText(tr("Cancel"))
    chosen = box.exec()
    box.deleteLater()
    if chosen == standard.Save:
        return "save"
    return "discard" if chosen == standard.Discard else "cancel"
