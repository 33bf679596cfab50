"""The comparison of runs."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from PySide6.QtWidgets import QWidget

from app.model.export.formats import formats
from app.model.state.situation import has_image
from app.model.text.language import from_core, tr
from app.session.features.comparison import ComparisonWritten
from app.views.canvas.coordinates import image_rectangle
from app.views.comparison import CompareDialog
from app.views.widgets.action_spec import ActionSpec
from app.views.window.dialog_feature import DialogFeature
from app.views.window.feature import FeatureContext
from app.views.window.file_dialogs import Files
from cpm_core.formats.animations.comparison import PICTURE, TABLE

_LEAST_SEEN = 0.02
"""Fraction of the image that must be visible for the tiles to show only the visible part."""


class ComparisonFeature(DialogFeature[CompareDialog]):
    """Runs with other parameters, and classical methods, next to one another."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        context.session.listen(ComparisonWritten, self._report)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Open it with the choice of parameters, or with that of methods."""
        return (
            ActionSpec(name="mosaic", menu="Run", text=tr("&Mosaic of two parameters…"),
                       do=partial(self._open_at, 0), shortcuts=("Ctrl+M",),
                       tip=tr("Compare runs with several values of two parameters and choose the best."),
                       gap=True, when=has_image),
            ActionSpec(name="compare_methods", menu="Run", text=tr("Compare m&ethods…"),
                       do=partial(self._open_at, 1), shortcuts=("Ctrl+Shift+M",), when=has_image,
                       tip=tr("Run snakes, level sets and others beside the particles, from the same start.")),
        )  # fmt: skip

    def made(self) -> CompareDialog | None:
        """The dialog; tiles show the visible part of the image as it is shown."""
        context, display = self.context, self.context.session.scene.display
        if display is None:
            return None
        whole = image_rectangle(display.shape)
        seen = context.canvas_area.canvas.view.viewRect().intersected(whole)
        crop = seen if seen.width() * seen.height() > _LEAST_SEEN * whole.width() * whole.height() else whole
        comparison = context.workspace.comparison
        return CompareDialog(context.window, context.session, comparison, display, crop, self._ask)

    def _open_at(self, choice: int) -> None:
        self.open()
        if self.dialog is not None:
            self.dialog.choices.setCurrentIndex(choice)

    def _ask(self, parent: QWidget) -> Path | None:
        together = (Files(tr("Table of all methods"), (TABLE,)), Files(tr("Picture of all methods"), (PICTURE,)))
        apart = (one for one in formats() if one.suffix not in (TABLE, PICTURE))
        each = tr("Contours of each method: {format}")
        kinds = (*together, *(Files(each.format(format=one.name), (one.suffix,)) for one in apart))
        image = self.context.session.scene.image
        name = f"{Path(image.source).stem if image else ''}.methods.csv"
        return self.context.files.ask_where_to_save("export", tr("Export the comparison"), name, kinds, parent=parent)

    def _report(self, report: ComparisonWritten) -> None:
        names = ", ".join(file.name for file in report.files)
        wrote = tr("Wrote {name}.").format(name=names)
        self.context.session.say(" ".join((*((wrote,) if names else ()), *map(from_core, report.notes))))
