"""A feature that has one dialog, which may stay open beside the window."""

from __future__ import annotations

from abc import abstractmethod
from typing import Generic, TypeVar

from PySide6.QtWidgets import QDialog

from app.views.window.feature import Feature, FeatureContext

D = TypeVar("D", bound=QDialog)


class DialogFeature(Feature, Generic[D]):
    """Opens its dialog or brings it to the front, and closes it with the window."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.dialog: D | None = None

    @abstractmethod
    def made(self) -> D | None:
        """A new dialog; None where there is nothing to open it on."""

    def open(self) -> None:
        """Open the dialog, or bring it to the front."""
        if self.dialog is None:
            self.dialog = self.made()
            if self.dialog is None:
                return
            self.dialog.finished.connect(self._forget)
        self.dialog.show()
        self.dialog.raise_()
        self.dialog.activateWindow()

    def close(self) -> bool:
        """Close the dialog, which ends what it runs itself."""
        if self.dialog is not None:
            self.dialog.close()
        return True

    def _forget(self, _: int) -> None:
        self.dialog = None
