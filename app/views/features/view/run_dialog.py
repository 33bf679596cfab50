"""A feature that has a dialog with runs of its own."""

from __future__ import annotations

from abc import abstractmethod
from typing import Generic, TypeVar

from app.model.display.display_image import DisplayImage
from app.views.mosaic.run_dialog import RunDialog
from app.views.window.feature import Feature, FeatureContext

D = TypeVar("D", bound=RunDialog)


class RunDialogFeature(Feature, Generic[D]):
    """Opens one dialog on the image that is open, and closes it with the window."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.dialog: D | None = None

    @abstractmethod
    def made(self, display: DisplayImage) -> D:
        """The dialog, on the image as it is shown."""

    def open(self) -> None:
        """Open the dialog, or bring it to the front."""
        display = self.context.session.scene.display
        if self.dialog is None and display is not None:
            self.dialog = self.made(display)
            self.dialog.finished.connect(self._forget)
        if self.dialog is not None:
            self.dialog.show()
            self.dialog.raise_()
            self.dialog.activateWindow()

    def close(self) -> bool:
        """Close the dialog, which ends its runs."""
        if self.dialog is not None:
            self.dialog.close()
        return True

    def _forget(self, _: int) -> None:
        self.dialog = None
