"""The question about unsaved work."""

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
