"""The comparison with other methods."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtWidgets import QWidget

from app.model.state.situation import has_image
from app.model.text.language import tr
from app.session.features.side_by_side.method_comparison import ComparisonWritten
from app.views.mosaic.methods import CompareDialog
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature, FeatureContext
from app.views.window.file_dialogs import Files


class MethodsFeature(Feature):
    """Classical methods beside the charged particles."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.dialog: CompareDialog | None = None
        context.session.listen(ComparisonWritten, self._tell)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Open it."""
        return (
            ActionSpec(name="compare_methods", menu="Run", text=tr("Compare m&ethods…"), do=self.open,
                       shortcuts=("Ctrl+Shift+M",), when=has_image,
                       tip=tr("Run snakes, level sets and others beside the particles, from the same start.")),
        )  # fmt: skip

    def open(self) -> None:
        """Open the dialog, or bring it to the front."""
        session, display = self.context.session, self.context.session.scene.display
        if self.dialog is None and display is not None:
            self.dialog = CompareDialog(
                self.context.window, session, self.context.workspace.comparison, display, self._ask
            )
            self.dialog.finished.connect(self._forget)
        if self.dialog is not None:
            self.dialog.show()
            self.dialog.raise_()
            self.dialog.activateWindow()

    def close(self) -> bool:
        """Close the dialog and end its runs."""
        if self.dialog is not None:
            self.dialog.close()
        return True

    def _ask(self, parent: QWidget) -> Path | None:
        kinds = (Files(tr("Table"), (".csv",)), Files(tr("Picture"), (".png",)))
        name = f"{Path(self.context.session.scene.image.source).stem if self.context.session.scene.image else ''}"
        return self.context.files.ask_where_to_save(
            "export", tr("Export the comparison"), f"{name}.methods.csv", kinds, parent=parent
        )

    def _tell(self, report: ComparisonWritten) -> None:
        names = ", ".join(file.name for file in report.files)
        self.context.session.say(tr("Wrote {name}.").format(name=names))

    def _forget(self, _: int) -> None:
        self.dialog = None
