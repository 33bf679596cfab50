"""The dialog that shows a workflow as a script, to be copied or saved."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtGui import QFontDatabase, QGuiApplication
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QLabel,
    QPlainTextEdit,
    QPushButton,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from app.model.export.script import Script
from app.model.text.language import tr


class ScriptDialog(QDialog):
    """Shows both forms of a script.

    Parameters
    ----------
    parent : QWidget
        The window.
    script : Script
        What is shown.
    note : str
        What is said above it.
    save : callable
        Asks where to save a text, given a suffix.
    """

    def __init__(self, parent: QWidget, script: Script, note: str, save: Callable[[str, str], Path | None]) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("Workflow as a script"))
        self._save = save
        self.python = _Text(script.python, tr("Program in Python"))
        self.command = _Text(script.command + "\n" if script.command else "", tr("Command line"))
        self.tabs = QTabWidget()
        self.tabs.addTab(self.python, tr("Python"))
        if script.command:
            self.tabs.addTab(self.command, tr("Command line"))
        self.note = QLabel(note)
        self.note.setWordWrap(True)
        self.note.setObjectName("dim")
        self.copy = QPushButton(tr("&Copy"))
        self.save = QPushButton(tr("&Save…"))
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        for button, act in ((self.copy, self._copy), (self.save, self._write)):
            button.setAutoDefault(False)
            button.clicked.connect(act)
            buttons.addButton(button, QDialogButtonBox.ButtonRole.ActionRole)
        buttons.rejected.connect(self.reject)
        layout = QVBoxLayout(self)
        layout.setSpacing(10)
        layout.addWidget(self.note)
        layout.addWidget(self.tabs, 1)
        layout.addWidget(buttons)
        self.resize(760, 560)

    @property
    def text(self) -> str:
        """The text of the form that is shown."""
        shown = self.tabs.currentWidget()
        return shown.toPlainText() if isinstance(shown, _Text) else ""

    def _copy(self) -> None:
        QGuiApplication.clipboard().setText(self.text)

    def _write(self) -> None:
        self._save(self.text, ".py" if self.tabs.currentWidget() is self.python else ".sh")


class _Text(QPlainTextEdit):
    """Code that is read and copied."""

    def __init__(self, text: str, name: str) -> None:
        super().__init__(text)
        self.setReadOnly(True)
        self.setAccessibleName(name)
        self.setFont(QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont))
        self.setLineWrapMode(QPlainTextEdit.LineWrapMode.WidgetWidth)
