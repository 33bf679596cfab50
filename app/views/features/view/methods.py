"""The comparison with other methods."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtWidgets import QWidget

from app.model.export.formats import formats
from app.model.state.situation import has_image
from app.model.text.language import from_core, tr
from app.session.features.side_by_side.method_comparison import ComparisonWritten
from app.views.mosaic.methods import CompareDialog
from app.views.widgets.action_spec import ActionSpec
from app.views.window.dialog_feature import DialogFeature
from app.views.window.feature import FeatureContext
from app.views.window.file_dialogs import Files
from cpm_core.formats.animations.comparison import PICTURE, TABLE


class MethodsFeature(DialogFeature[CompareDialog]):
    """Classical methods beside the charged particles."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        context.session.listen(ComparisonWritten, self._tell)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Open it."""
        return (
            ActionSpec(name="compare_methods", menu="Run", text=tr("Compare m&ethods…"), do=self.open,
                       shortcuts=("Ctrl+Shift+M",), when=has_image,
                       tip=tr("Run snakes, level sets and others beside the particles, from the same start.")),
        )  # fmt: skip

    def made(self) -> CompareDialog | None:
        """The dialog, on the image as it is shown."""
        context, display = self.context, self.context.session.scene.display
        if display is None:
            return None
        return CompareDialog(context.window, context.session, context.workspace.comparison, display, self._ask)

    def _ask(self, parent: QWidget) -> Path | None:
        together = (Files(tr("Table of all methods"), (TABLE,)), Files(tr("Picture of all methods"), (PICTURE,)))
        apart = (one for one in formats() if one.suffix not in (TABLE, PICTURE))
        each = tr("Contours of each method: {format}")
        kinds = (*together, *(Files(each.format(format=one.name), (one.suffix,)) for one in apart))
        name = f"{Path(self.context.session.scene.image.source).stem if self.context.session.scene.image else ''}"
        return self.context.files.ask_where_to_save(
            "export", tr("Export the comparison"), f"{name}.methods.csv", kinds, parent=parent
        )

    def _tell(self, report: ComparisonWritten) -> None:
        names = ", ".join(file.name for file in report.files)
        wrote = tr("Wrote {name}.").format(name=names)
        self.context.session.say(" ".join((*((wrote,) if names else ()), *map(from_core, report.notes))))
