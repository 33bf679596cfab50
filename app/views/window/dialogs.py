"""The questions before work or a file is lost."""

from __future__ import annotations

from typing import Literal

from PySide6.QtWidgets import QMessageBox, QWidget

from app.model.text.language import tr

Answer = Literal["save", "discard", "cancel"]


def ask_about_unsaved(parent: QWidget, name: str) -> Answer:
    """What to do with unsaved work called `name`."""
    box = QMessageBox(QMessageBox.Icon.Warning, tr("Unsaved work"), tr("Save the work on “{name}”?").format(name=name))
    box.setParent(parent, box.windowFlags())
    box.setInformativeText(tr("The drawing, the parameters and the review of the contours would be lost."))
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


def ask_to_replace(parent: QWidget, name: str) -> bool:
    """Whether the file of this name may be replaced."""
    standard = QMessageBox.StandardButton
    box = QMessageBox(QMessageBox.Icon.Warning, tr("Replace file"), tr("Replace “{name}”?").format(name=name))
    box.setParent(parent, box.windowFlags())
    box.setInformativeText(tr("A file of this name exists; what it holds would be lost."))
    box.setStandardButtons(standard.Yes | standard.Cancel)
    box.setDefaultButton(standard.Cancel)
    box.button(standard.Yes).setText(tr("&Replace"))
    box.button(standard.Cancel).setText(tr("Cancel"))
    chosen = box.exec()
    box.deleteLater()
    return bool(chosen == standard.Yes)
