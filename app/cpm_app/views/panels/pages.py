"""Pages of a stack: the line that selects one, and the table of the results of all."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QItemSelection, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from cpm_app.model.display.lengths import preferred_pixel_size
from cpm_app.model.display.page_rows import PageRow
from cpm_app.model.display.plots import PageMetrics, build_page_plots, select_plotted_tracks
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import tr
from cpm_app.session.features.kept_pages import StackSource
from cpm_app.session.features.stack_pages import StackPages
from cpm_app.views.panels.run import Chart
from cpm_app.views.panels.tables import CellIndex, Column, SortableTable, TableModel
from cpm_app.views.widgets.actions import ActionButton
from cpm_app.views.widgets.containers import ENTER_KEYS, create_wrapped_label, fill_layout
from cpm_app.views.widgets.fields import PlaceBar
from cpm_core.contours import Measures
from cpm_core.numerics.types import Integers, Texts


def _page_measure_getter(get: Callable[[Measures], float | None]) -> Callable[[PageRow], float | None]:
    """Return a function from a row to a measure of its contour, or None without a contour."""
    return lambda row: None if row.measures is None else get(row.measures)


PAGE_COLUMNS: tuple[Column[PageRow], ...] = (
    Column("page", tr("Page"), tr("Page of the stack; a click opens it."), lambda row: row.page, "0000",
           number_format=".0f"),
    Column("track", tr("Track"), tr("Number of the object, which it keeps from page to page."),
           lambda row: row.track or None, "0000", number_format=".0f"),
    Column("happens", tr("What happens"), tr("What happens to the object here, or why the page could not be used."),
           lambda row: row.event, "splits off track 12"),
    Column("area", tr("Area [{unit}²]"), tr("Gross area, including contours inside."),
           _page_measure_getter(lambda found: found.area_in_units if found.closed else None), "00,000,000", 2),
    Column("gray", tr("Mean gray"), tr("Mean gray value inside."), lambda row: row.gray, "000.0"),
    Column("time", tr("Time [s]"), tr("Time since the first page, where the file states it."), lambda row: row.time,
           "00,000", number_format=".6g"),
    Column("length", tr("Length [{unit}]"), tr("Length along the contour: the perimeter of a closed one."),
           _page_measure_getter(lambda found: found.length_in_units), "000,000", 1),
    Column("row", tr("Row [px]"), tr("Row of its center of area; of an open contour, that of its length."),
           lambda row: None if row.measures is None else row.row, "0000.0", number_format=".1f"),
    Column("col", tr("Column [px]"), tr("Column of its center of area; of an open contour, that of its length."),
           lambda row: None if row.measures is None else row.col, "0000.0", number_format=".1f"),
    Column("net", tr("Net area [{unit}²]"), tr("Area without the closed contours inside, as in label stacks."),
           _page_measure_getter(lambda found: found.net_area_in_units if found.closed else None), "00,000,000", 2),
    Column("strength", tr("Strength"), tr("Mean edge strength along the contour [gray levels/px]."),
           _page_measure_getter(lambda found: found.strength), "000.0"),
    Column("contrast", tr("Contrast"), tr("Contrast between both sides, 0 to 1."),
           _page_measure_getter(lambda found: found.contrast), "0.00"),
    Column("kind", tr("Kind"), tr("Closed, or open with two ends."),
           lambda row: None if row.measures is None else tr("closed") if row.measures.closed else tr("open"),
           "closed"),
)  # fmt: skip
"""Columns in the order shown."""


class PageTable(SortableTable):
    """Table of all pages; a click or Enter goes to the object or contour of a row that alone is selected."""

    row_requested = Signal(object)
    """The user asks to see the object or contour of a PageRow."""
    selection_changed = Signal()
    """The user has selected other rows."""

    def __init__(self) -> None:
        rows = TableModel[PageRow](PAGE_COLUMNS, key=lambda row: (row.page, row.track, row.row, row.col))
        super().__init__(rows, "happens", tr("Contours on all pages"))
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.clicked.connect(self._request_row)

    @property
    def selected_rows(self) -> tuple[PageRow, ...]:
        """Selected rows."""
        return tuple(self.rows.items[index.row()] for index in self.selectionModel().selectedRows())

    def selectionChanged(self, selected: QItemSelection, deselected: QItemSelection) -> None:
        """Report the selection of other rows."""
        super().selectionChanged(selected, deselected)
        self.selection_changed.emit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Go to the object or contour of the current row on Enter."""
        if event.key() in ENTER_KEYS and self.currentIndex().isValid():
            self._request_row(self.currentIndex())
        else:
            super().keyPressEvent(event)

    def _request_row(self, index: CellIndex) -> None:
        if len(self.selected_rows) < 2:
            self.row_requested.emit(self.rows.items[index.row()])


class PagePanel(QWidget):
    """Table and plots of the results of all pages of a stack; `show` goes to the contour of a row."""

    def __init__(self, pages: StackPages, show: Callable[[PageRow], None]) -> None:
        super().__init__()
        self._pages = pages
        self._plotted: tuple[Integers, Texts] = ((), ())
        self.table, self.summary, self.export = (
            PageTable(),
            create_wrapped_label(dim=True),
            QPushButton(tr("Export all pages…")),
        )
        self.chart = Chart((), tr("Plot over the pages"))
        self.setFocusProxy(self.table)
        parts = self.summary, self.export, self.table, self.chart
        fill_layout(QVBoxLayout(self), *parts, margins=(4, 6, 4, 6), wide=self.table)
        self.table.row_requested.connect(show)
        self.table.selection_changed.connect(self.show_plots)
        self.chart.clicked.connect(self._open_page_at)
        pages.results_changed.connect(self.show_rows)
        pages.changed.connect(self.show_plots)
        self.show_rows()

    def show_rows(self) -> None:
        """Show the results of the pages."""
        found = self._pages.result
        first = None if found is None or not found.results else found.results[0][1]
        size = (
            preferred_pixel_size((1.0, 1.0), None) if first is None else preferred_pixel_size(first.spacing, first.unit)
        )
        self.table.rows.update_items(self._pages.table[1], size)
        self.export.setEnabled(first is not None)
        self.show_plots()
        text = tr("No page of the stack has been run yet: run this page or all pages.")
        if found is not None and found.pages:
            text = tr(
                "{done} of {count} pages finished; tracks: {tracks}.",
                done=len(found.results),
                count=found.count,
                tracks=len(found.tracks),
            )
            if self._pages.offers_objects:
                listed = tr("On each page Enter accepts its objects; until then its contours are listed.")
                text = f"{self._pages.found_objects} {listed}"
            if failed := len(found.pages) - len(found.results):
                text += " " + tr("{failed} could not be used.", failed=failed)
        self.summary.setText(text)

    def show_plots(self) -> None:
        """Plot the selected objects, or the first ones, over the pages."""
        pages, (found, rows), size = self._pages, self._pages.table, self.table.rows
        tracks = select_plotted_tracks(rows, {row.track for row in self.table.selected_rows if row.track})
        area = tr("Area [{unit}²]", unit=size.unit)
        count, interval = (0, None) if found is None else (found.count, found.interval)
        titles = area, tr("Page") if interval is None else tr("Time [s]")
        if (tracks, titles) != self._plotted:
            self._plotted = tracks, titles
            self.chart.show_plots(build_page_plots(tracks, *titles))
        self.chart.setVisible(bool(tracks))
        self.chart.show_metrics(PageMetrics.from_rows(rows, count, pages.number, size.factor, interval))

    def _open_page_at(self, place: float) -> None:
        """Open the page at a place of the plots, which is a page or a time."""
        found = self._pages.result
        interval = None if found is None else found.interval
        self._pages.open_page(round(place if interval is None else place / interval + 1.0))


_KIND_TITLES = {"page": tr("Page"), "channel": tr("Channel"), "time": tr("Time")}
"""Label of the number of a page by what the pages of a file are."""


class PageBar(PlaceBar):
    """Slider and number of the page, time or channel, and buttons that follow objects and run all pages."""

    def __init__(self) -> None:
        super().__init__(tr("Page"), tr("Number of the page"))
        self.slider.setTracking(False)
        self._of_volumes = False
        self.follow, self.run = ActionButton("follow_pages"), ActionButton("run_pages")
        self._title = QLabel()
        fields = (self._title, self.slider, self.number, self.total_label, self.follow, self.run)
        fill_layout(QHBoxLayout(self), *fields, margins=(10, 3, 10, 3), spacing=4, wide=self.slider).insertSpacing(4, 8)

    def show_keys(self) -> None:
        """Name the current keys in the tooltip."""
        tip = insert_keys(tr("Move through the pages: {key:previous_slice} and {key:next_slice}."))
        self.slider.setToolTip("" if self._of_volumes else tip)

    def show_page(self, number: int, count: int, source: StackSource) -> None:
        """Show which page is open; hide the bar unless there are several."""
        self._title.setText(_KIND_TITLES[source.kind])
        self._of_volumes = source.has_volumes
        for button in (self.follow, self.run):
            button.setVisible(not source.has_volumes)
        self.show_keys()
        self.setVisible(count > 1)
        self.show_position(number, max(count, 1))
