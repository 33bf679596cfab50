"""Table of the rulers, angles and measuring ellipses, and of what they measure."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import Qt

from cpm_app.model.display.lengths import preferred_pixel_size
from cpm_app.model.display.measures import measure_in_image
from cpm_app.model.text.language import tr, translate_core_text
from cpm_app.session.features.slices import SliceNavigation
from cpm_app.session.session import Session
from cpm_app.views.panels.tables import Column, ItemTable, TableModel
from cpm_core.numerics.types import frozen
from cpm_core.shapes import Measure, MeasuredValues


@frozen
class MeasureRow:
    """A row: index of the shape in the document, its title, and what it measures."""

    index: int
    title: str
    values: MeasuredValues


def _build_columns(gray_unit: str = "") -> tuple[Column[MeasureRow], ...]:
    def value(name: str) -> Callable[[MeasureRow], float | None]:
        return lambda row: getattr(row.values, name)

    return (
        Column("name", tr("Measure"), tr("The measures, in the order drawn."), lambda row: row.title, "measuring",
               sort_by=lambda row: row.index),
        Column("length", tr("Length [{unit}]"), tr("Length of a ruler."), value("length"), "0,000", 1,
               number_format=",.4g"),
        Column("angle", tr("Angle"), tr("Angle at the middle of three points."), value("angle"), "000.0°",
               number_format=".1f", suffix="°"),
        Column("mean", tr("Mean"), tr("Mean gray value inside."), value("mean"), "-0000.0", number_format=".1f",
               suffix=gray_unit),
        Column("deviation", tr("Deviation"), tr("Standard deviation of the gray values inside."), value("deviation"),
               "000.0", number_format=".1f", suffix=gray_unit),
        Column("area", tr("Area [{unit}²]"), tr("Area of an ellipse."), value("area"), "00,000", 2),
        Column("pixels", tr("Pixels"), tr("Number of pixels whose centers lie inside."), value("pixels"), "00,000",
               number_format=".0f"),
    )  # fmt: skip


class MeasureTable(ItemTable):
    """Table of the measures; one of them is selected, as on the canvas."""

    menu_name = "shape"

    def __init__(self, session: Session, slices: SliceNavigation) -> None:
        self._session, self._slices = session, slices
        super().__init__(TableModel[MeasureRow](_build_columns(), lambda row: row.index), tr("Measures"))
        self.setSelectionMode(self.SelectionMode.SingleSelection)
        self.sortByColumn(-1, Qt.SortOrder.AscendingOrder)
        self.clicked.connect(self._show_slices)
        session.document_changed.connect(lambda *_: self.show_items())
        session.image_changed.connect(self.show_items)

    @property
    def selected_keys(self) -> set[int]:
        """Index of the selected measure."""
        index, shapes = self._session.selected_shape, self._session.document.shapes
        return {index} if index is not None and isinstance(shapes[index], Measure) else set()

    def select_keys(self, keys: Sequence[int]) -> None:
        """Select a measure, in a volume with the slices through it, or none."""
        self._session.select_shape(next(iter(keys), None))
        self._show_slices()

    def _show_slices(self) -> None:
        """Show the slices through the selected measure."""
        for index in self.selected_keys if self._slices.current is not None else ():
            outline = self._session.document.shapes[index].outline
            self._slices.go_through(tuple((0.5 * (outline.min(axis=0) + outline.max(axis=0))).tolist()))

    def remove_selected(self) -> None:
        """Delete the selected measure."""
        if self.selected_keys:
            self._session.delete_selected_shape()

    def update_rows(self) -> None:
        """Show the measures with lengths in the preferred unit."""
        document, image = self._session.document, self._session.image
        if image is None:
            return
        rows = (
            MeasureRow(
                index,
                translate_core_text(shape.title),
                measure_in_image(shape, image, document.parameters.channel),
            )
            for index, shape in enumerate(document.shapes)
            if isinstance(shape, Measure)
        )
        size = preferred_pixel_size(image.spacing, image.unit)
        self.rows.update_items(rows, size, _build_columns(" HU" if image.is_ct else ""))
