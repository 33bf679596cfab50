"""A dialog with runs of its own."""

from __future__ import annotations

from abc import abstractmethod

from PySide6.QtCore import Qt
from PySide6.QtGui import QCloseEvent, QKeyEvent
from PySide6.QtWidgets import QDialog, QWidget


class RunDialog(QDialog):
    """Ends its runs when it is closed, which Esc does as well, and is deleted then."""

    def __init__(self, parent: QWidget, title: str) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(title)

    @abstractmethod
    def end_runs(self) -> None:
        """End all runs that are left."""

    def closeEvent(self, event: QCloseEvent) -> None:
        """End the runs."""
        self.end_runs()
        super().closeEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Close on Esc."""
        if event.key() == Qt.Key.Key_Escape:
            self.close()
        else:
            super().keyPressEvent(event)
