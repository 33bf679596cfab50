"""The dialogs that ask for a name, and questions whose buttons are named by what they do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, cast

from PySide6.QtWidgets import QAbstractButton, QInputDialog, QMessageBox, QPushButton, QWidget

from app.model.text.language import tr

Answer = Literal["save", "discard", "cancel"]

_ROLES = {
    "accept": QMessageBox.ButtonRole.AcceptRole,
    "discard": QMessageBox.ButtonRole.DestructiveRole,
    "cancel": QMessageBox.ButtonRole.RejectRole,
}

_LEAST_WIDTH, _BESIDE_TITLE = 360, 180
"""Least width of a dialog, and what its frame needs beside its title, so that the title is not cut off [px]."""


@dataclass(frozen=True, slots=True)
class Button:
    """A button of a question: the answer it gives, its text, and what it does."""

    answer: str
    text: str
    role: Literal["accept", "discard", "cancel"]


class Question(QMessageBox):
    """A question with a sentence that explains it.

    The first button that accepts is the default, or else the one that cancels; Escape is the one that cancels. There is
    no icon: the question is what counts, and the icons of Qt are of another style.
    """

    def __init__(self, parent: QWidget, title: str, text: str, more: str, buttons: Sequence[Button]) -> None:
        super().__init__(QMessageBox.Icon.NoIcon, title, text)
        self.setParent(parent, self.windowFlags())
        self.setInformativeText(more)
        self._answers: dict[QAbstractButton, str] = {}
        for button in buttons:
            made = self.addButton(button.text, _ROLES[button.role])
            self._answers[made] = button.answer
            if button.role == "accept" and self.defaultButton() is None:
                self.setDefaultButton(made)
            elif button.role == "cancel":
                self.setEscapeButton(made)
        if self.defaultButton() is None:
            self.setDefaultButton(cast("QPushButton", self.escapeButton()))

    def given(self) -> str:
        """The answer."""
        return self._answers[self.clickedButton() or self.escapeButton()]

    def ask(self) -> str:
        """Show the question and wait for the answer."""
        self.exec()
        self.deleteLater()
        return self.given()


def would_be_lost(parts: Sequence[str]) -> str:
    """A sentence on what would be lost."""
    listed = ", ".join(parts[:-1])
    named = tr("{parts} and {last}").format(parts=listed, last=parts[-1]) if listed else "".join(parts)
    return tr("This would be lost: {parts}.").format(parts=named)


def ask_about_unsaved(parent: QWidget, name: str, lost: Sequence[str]) -> Answer:
    """What to do with unsaved work called `name`; `lost` tells what would be lost."""
    buttons = (
        Button("save", tr("&Save"), "accept"),
        Button("discard", tr("&Discard changes"), "discard"),
        Button("cancel", tr("&Keep editing"), "cancel"),
    )
    text = tr("Save the work on “{name}”?").format(name=name)
    return cast("Answer", Question(parent, tr("Unsaved work"), text, would_be_lost(lost), buttons).ask())


def ask_to_replace(parent: QWidget, name: str) -> bool:
    """Whether the file of this name may be replaced."""
    buttons = Button("keep", tr("&Keep it"), "cancel"), Button("replace", tr("&Replace"), "discard")
    more = tr("A file of this name exists; what it holds would be lost.")
    return (
        Question(parent, tr("Replace file"), tr("Replace “{name}”?").format(name=name), more, buttons).ask()
        == "replace"
    )


def ask_for_text(parent: QWidget, title: str, label: str, button: str, text: str = "") -> str | None:
    """A text that is typed, None when the user cancels; `button` says what is done with it."""
    dialog = _input(parent, title, label, button)
    dialog.setTextValue(text)
    return _typed(dialog)


def ask_for_one(parent: QWidget, title: str, label: str, button: str, offered: Sequence[str]) -> str | None:
    """One of the texts on offer, None when the user cancels; `button` says what is done with it."""
    dialog = _input(parent, title, label, button)
    dialog.setComboBoxItems(list(offered))
    dialog.setComboBoxEditable(False)
    return _typed(dialog)


def _input(parent: QWidget, title: str, label: str, button: str) -> QInputDialog:
    dialog = QInputDialog(parent)
    dialog.setWindowTitle(title)
    dialog.setLabelText(label)
    dialog.setOkButtonText(button)
    dialog.setCancelButtonText(tr("Cancel"))
    dialog.setMinimumWidth(max(_LEAST_WIDTH, dialog.fontMetrics().horizontalAdvance(title) + _BESIDE_TITLE))
    return dialog


def _typed(dialog: QInputDialog) -> str | None:
    accepted = bool(dialog.exec())
    dialog.deleteLater()
    return dialog.textValue() if accepted else None
