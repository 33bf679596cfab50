"""The panel of the contours: the table, with thresholds and review buttons next to it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from PySide6.QtCore import QRectF, QSize, Signal
from PySide6.QtGui import QColor, QFont, QGuiApplication, QPainter, QPaintEvent, QPalette
from PySide6.QtWidgets import QComboBox, QGridLayout, QLabel, QMenu, QSizePolicy, QWidget

from app.model.display.filter_counts import Distribution
from app.model.display.lengths import shown_in
from app.model.document import edits
from app.model.document.document import Document
from app.model.parameters.controls import Control, controls
from app.model.text.language import tr, written
from app.session.features.contour_review import ContourReview
from app.session.scene import Item
from app.session.session import Session
from app.views.panels.tables import (
    Column,
    ItemTable,
    Role,
    Selection,
    TableModel,
    TablePanel,
    button_grid,
    wide_button,
)
from app.views.theme import theme
from app.views.theme.icons import swatch
from app.views.widgets.fields import MarkedSlider
from cpm_core.contours import Reached

VERDICTS = {"kept": tr("✓ kept"), "rejected": tr("✗ rejected"), "": "–"}
_ORDER = {"kept": 0.0, "": 1.0, "rejected": 3.0}

REACHED: Mapping[Reached, str] = {
    "flight": tr("in free flight"), "weak": tr("beyond a weak edge"), "junction": tr("over a junction"),
    "launched": tr("inserted elsewhere"), "": "–",
}  # fmt: skip
"""Words for the ways in which particles come to a contour, the nearest first."""


def _by_hand(item: Item) -> float | None:
    """Length drawn by hand, in the unit of the image."""
    measures = item.measures
    in_units = measures.length_in_units / measures.length if measures.length else 1.0
    return measures.by_hand * in_units if item.contour.by_hand else None


COLUMNS: tuple[Column[Item], ...] = (
    Column("number", tr("#"), tr("Number; it stays with the contour through sliders and runs."),
           lambda item: item.measures.number, "0000", form=".0f"),
    Column("name", tr("Name"), tr("Name and color; double-click or press {key:name_contour} to rename."),
           lambda item: item.contour.name, "left ventricle"),
    Column("verdict", tr("Verdict"),
           tr("{key:keep} keeps, {key:reject} rejects. Kept contours stay through sliders and runs; rejected "
              "ones are not exported."),
           lambda item: VERDICTS[item.reviewed.verdict], "✗ rejected", key=lambda item: _ORDER[item.reviewed.verdict]),
    Column("kind", tr("Kind"), tr("Closed, or open with two ends."),
           lambda item: tr("closed") if item.contour.closed else tr("open"), "closed"),
    Column("length", tr("Length [{unit}]"), tr("Length along the contour."),
           lambda item: item.measures.length_in_units, "000,000", 1),
    Column("area", tr("Area [{unit}²]"), tr("Gross area: all that it encloses, including contours inside."),
           lambda item: item.measures.area_in_units if item.contour.closed else None, "00,000,000", 2),
    Column("strength", tr("Strength"), tr("Mean edge strength along the contour [gray levels/px]."),
           lambda item: item.measures.strength, "000.0"),
    Column("inside", tr("Inside"), tr("Number of the closed contour that encloses it."),
           lambda item: item.measures.inside or None, "0000", form=".0f"),
    Column("junctions", tr("Junctions"), tr("Number of ends at which it meets other contours."),
           lambda item: None if item.contour.closed else item.measures.junctions, "0", form=".0f"),
    Column("contrast", tr("Contrast"), tr("Contrast between both sides, 0 to 1; measured at rest."),
           lambda item: item.measures.contrast, "0.00", form=".2f"),
    Column("by_hand", tr("By hand [{unit}]"), tr("Length that was drawn by hand."), _by_hand, "000.0", 1),
    Column("reached", tr("Reached"), tr("How particles came to it: in free flight from the start, beyond a weak edge, "
           "along edges over a junction, or by being inserted elsewhere."), lambda item: REACHED[item.contour.reached],
           "beyond a weak edge", key=lambda item: float(list(REACHED).index(item.contour.reached))),
)  # fmt: skip
"""All columns in the order shown."""


class ContourTable(ItemTable):
    """Shows the contours of a review, selects, names and rejects them."""

    def __init__(self, review: ContourReview) -> None:
        self._review = review
        self._verdict: str | None = None
        rows = TableModel[Item](COLUMNS, lambda item: item.key, _look, review.rename)
        selection = Selection(
            "contour",
            self._refresh,
            review.hover,
            review.select,
            lambda: review.selected,
            partial(review.judge, "rejected"),
        )
        super().__init__(rows, selection, tr("Contours"))
        review.changed.connect(self.show_items)
        review.selection_changed.connect(self.show_selection)

    def show_only(self, verdict: str | None) -> None:
        """Show the contours with a verdict (empty for the undecided ones), or all for None."""
        self._verdict = verdict
        self.show_items()

    def _refresh(self) -> None:
        items, result = self._review.items, self._review.result
        shown = (item for item in items if self._verdict in (None, item.reviewed.verdict))
        self.rows.update(shown, None if result is None else shown_in(result.spacing, result.unit))


def _look(item: Item, role: int, of_name: bool) -> Any:
    """The color of a contour next to its name; rejected ones are pale, their names struck out."""
    match role:
        case Role.DecorationRole if of_name:
            return swatch(item.contour.color or (theme.CLOSED if item.contour.closed else theme.OPEN))
        case Role.ForegroundRole if item.reviewed.rejected:
            return QColor(QGuiApplication.palette().color(QPalette.ColorRole.PlaceholderText))
        case Role.FontRole if item.reviewed.rejected:
            font = QFont()
            font.setStrikeOut(of_name)
            return font
    return None


_BINS = 40
_STEP = 1 / 200
_LEAST = 10.0


class Histogram(QWidget):
    """A histogram; bars below the threshold are pale."""

    def __init__(self) -> None:
        super().__init__()
        self._counts = np.zeros(_BINS, int)
        self._threshold = 0.0
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def sizeHint(self) -> QSize:
        """About two lines of text high."""
        return QSize(160, 30)

    def show(self, shares: np.ndarray, threshold: float) -> None:  # type: ignore[override]  # shows values, not itself
        """Show values, each as its position along the slider from 0 to 1."""
        self._counts = np.histogram(shares, _BINS, (0.0, 1.0))[0]
        self._threshold = threshold
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw a bar for each bin that is not empty."""
        painter = QPainter(self)
        palette = self.palette()
        # The groove of the slider below starts and ends half a handle from its sides.
        inset = 6.0
        width, height = (self.width() - 2 * inset) / _BINS, self.height() - 1.0
        most = max(1, int(self._counts.max()))
        for index, count in enumerate(self._counts.tolist()):
            if count:
                role = QPalette.ColorRole.Highlight if (index + 1) / _BINS > self._threshold else QPalette.ColorRole.Mid
                # the root keeps a single value visible next to hundreds
                tall = max(3.0, height * math.sqrt(count / most))
                painter.fillRect(
                    QRectF(inset + index * width, height - tall, max(1.5, width - 1), tall), palette.color(role)
                )
        painter.setPen(palette.color(QPalette.ColorRole.Mid))
        painter.drawLine(int(inset), self.height() - 1, self.width() - int(inset), self.height() - 1)
        painter.end()


class Threshold(QWidget):
    """Lower limit of a measure of contours, set by a slider that is finer for small values."""

    moved_to = Signal(float)
    """The user has moved the slider to a value."""
    released = Signal()
    """The user has released the slider."""

    def __init__(self, control: Control) -> None:
        super().__init__()
        self.title, self._unit = control.title, control.unit
        self._top = _LEAST
        self._value = 0.0
        self._distribution = Distribution()
        self.histogram = Histogram()
        self.slider = MarkedSlider(0.0, 1.0, _STEP, None)
        self.slider.setAccessibleName(self.title)
        self.label = QLabel()
        self.setToolTip(f"{control.meaning} {control.acts}")
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setVerticalSpacing(0)
        grid.addWidget(QLabel(self.title), 0, 0)
        grid.addWidget(self.label, 0, 1)
        grid.addWidget(self.histogram, 1, 0, 1, 2)
        grid.addWidget(self.slider, 2, 0, 1, 2)
        grid.setColumnStretch(0, 1)
        self.slider.moved_to.connect(lambda share: self._report(self._top * share**2))
        self.slider.restored.connect(lambda: self._report(0.0))
        self.slider.sliderReleased.connect(self.released)
        self._show()

    def show_values(self, moment: object, values: Sequence[float]) -> None:
        """Show the values of the present contours.

        `moment` identifies the state that the contours were reconstructed from. While it stays the same, values that
        the threshold has excluded are remembered, so that the user sees the whole distribution.
        """
        self._distribution.update(moment, self._value, values)
        self._show()

    def show_value(self, value: float) -> None:
        """Show the present threshold."""
        if value != self._value:
            self._value = value
            self._show()

    def _report(self, value: float) -> None:
        self.moved_to.emit(float(f"{value:.3g}"))

    def _show(self) -> None:
        values = self._distribution.values
        self._top = _nice(max([_LEAST, self._value, *values[-1:].tolist()]))
        share = math.sqrt(self._value / self._top)
        if not self.slider.isSliderDown():
            self.slider.show_value(share)
        self.histogram.show(np.sqrt(values / self._top), share)
        self.label.setText(written(f"{self._value:.3g} {self._unit}"))


def _nice(value: float) -> float:
    """Round up to the next of 1, 2, 5, 10, 20, …, so that the range rarely changes."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= value)


_SHOWN: tuple[tuple[str, str | None], ...] = (
    (tr("All contours"), None),
    (tr("Kept"), "kept"),
    (tr("Rejected"), "rejected"),
    (tr("Undecided"), ""),
)
"""What the table can be limited to: texts and verdicts."""


class ContourPanel(TablePanel[ContourTable]):
    """Shows the contours and their review; `fill_colors` fills a menu with the colors on offer."""

    def __init__(self, session: Session, review: ContourReview, fill_colors: Callable[[QMenu], None]) -> None:
        table = ContourTable(review)
        super().__init__(table)
        self._session = session
        self._review = review
        filters = [control for control in controls() if control.name in ("min_strength", "min_length")]
        self.thresholds = {control.name: Threshold(control) for control in filters}
        self.shown = QComboBox()
        self.shown.setAccessibleName(tr("Contours in the table"))
        self.shown.setToolTip(tr("Which contours the table shows."))
        for text, verdict in _SHOWN:
            self.shown.addItem(text, verdict)
        self.shown.currentIndexChanged.connect(lambda _: table.show_only(self.shown.currentData()))
        colors = QMenu(self)
        colors.aboutToShow.connect(colors.clear)
        colors.aboutToShow.connect(lambda: fill_colors(colors))
        self.buttons = {
            "keep": wide_button(tr("✓ Keep")),
            "reject": wide_button(tr("✗ Reject")),
            "name": wide_button(tr("Name…")),
            "colour": wide_button(tr("Color"), colors),
        }
        self.buttons["keep"].clicked.connect(lambda: review.judge("kept"))
        self.buttons["reject"].clicked.connect(lambda: review.judge("rejected"))
        self.buttons["name"].clicked.connect(table.name_selected)
        self.add(self.shown, *self.thresholds.values(), button_grid(self.buttons.values()))
        for name, threshold in self.thresholds.items():
            threshold.moved_to.connect(partial(self._set, name))
            threshold.released.connect(session.seal)
        review.changed.connect(self._show)
        review.selection_changed.connect(self._enable)
        session.document_changed.connect(self._use_document)
        self._show()

    def _set(self, name: str, value: float) -> None:
        change = tr("change of {parameter}").format(parameter=self.thresholds[name].title.lower())
        self._session.edit(change, lambda document: edits.set_parameter(document, name, value), f"threshold {name}")

    def _use_document(self, document: Document) -> None:
        for name, threshold in self.thresholds.items():
            threshold.show_value(getattr(document.parameters, name))
        self._enable()

    def _show(self) -> None:
        items, result = self._review.items, self._review.result
        moment = (self._session.generation, result.steps) if result is not None else None
        self.thresholds["min_strength"].show_values(moment, [item.measures.strength for item in items])
        self.thresholds["min_length"].show_values(moment, [item.measures.length for item in items])
        self.summary.setText(self._summary())
        self._enable()

    def _summary(self) -> str:
        items = self._review.items
        if not items:
            return tr("No contours yet. Start the run.")
        closed = sum(item.contour.closed for item in items)
        rejected = sum(item.reviewed.verdict == "rejected" for item in items)
        kept = sum(item.reviewed.verdict == "kept" for item in items)
        summary = tr("{closed} closed, {open} open; {kept} kept, {rejected} rejected, {undecided} undecided.")
        return summary.format(
            closed=closed,
            open=len(items) - closed,
            kept=kept,
            rejected=rejected,
            undecided=len(items) - kept - rejected,
        )

    def _enable(self) -> None:
        for button in self.buttons.values():
            button.setEnabled(bool(self._review.selected))
