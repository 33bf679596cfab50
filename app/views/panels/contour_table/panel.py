"""The panel of the contours: the table with thresholds and review buttons beside it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import QSize
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QBoxLayout, QComboBox, QHBoxLayout, QLabel, QMenu, QToolButton, QVBoxLayout, QWidget

from app.model.document import edits
from app.model.document.document import Document
from app.model.parameters.controls import controls
from app.model.text.language import tr
from app.session.features.contour_review import ContourReview
from app.session.session import Session
from app.views.panels.contour_table.threshold import Threshold
from app.views.panels.contour_table.view import ContourTable
from app.views.panels.item_table.row_table import LEAST
from app.views.widgets.scrolled import Scrolled

_NARROW = 640
"""Width below which thresholds and buttons are placed above the table instead of beside it [px]."""

_NARROWEST, _LEAST_WIDTH = 460, 260
"""Width below which each of them has a row of its own, and the least width of the panel [px]."""

_BESIDE = 236

_SHOWN: tuple[tuple[str, str | None], ...] = (
    (tr("All contours"), None),
    (tr("Kept"), "kept"),
    (tr("Rejected"), "rejected"),
    (tr("Undecided"), ""),
)
"""What the table can be limited to: texts and verdicts."""


class ContourPanel(QWidget):
    """Shows the contours and their review; `fill_colors` fills a menu with the colors on offer."""

    def __init__(self, session: Session, review: ContourReview, fill_colors: Callable[[QMenu], None]) -> None:
        super().__init__()
        self._session = session
        self._review = review
        self.table = ContourTable(review)
        self.setFocusProxy(self.table)
        self.summary = QLabel()
        self.summary.setWordWrap(True)
        self.summary.setObjectName("dim")
        self.thresholds = {
            control.name: Threshold(control) for control in controls() if control.name in ("min_strength", "min_length")
        }
        self.shown = QComboBox()
        self.shown.setAccessibleName(tr("Contours in the table"))
        self.shown.setToolTip(tr("Which contours the table shows."))
        for text, verdict in _SHOWN:
            self.shown.addItem(text, verdict)
        self.shown.currentIndexChanged.connect(lambda _: self.table.show_only(self.shown.currentData()))
        self.buttons: dict[str, QToolButton] = {}
        self._colors = QMenu(self)
        self._colors.aboutToShow.connect(self._colors.clear)
        self._colors.aboutToShow.connect(lambda: fill_colors(self._colors))
        self._boxes = (QBoxLayout(QBoxLayout.Direction.TopToBottom), QBoxLayout(QBoxLayout.Direction.TopToBottom))
        self._beside = Scrolled(self._make_beside(), LEAST)
        self._layout = QBoxLayout(QBoxLayout.Direction.LeftToRight, self)
        self._layout.setContentsMargins(12, 6, 12, 6)
        self._layout.setSpacing(12)
        self._layout.addWidget(self._beside)
        self._layout.addWidget(self.table, 1)
        for name, threshold in self.thresholds.items():
            threshold.moved_to.connect(partial(self._set, name))
            threshold.released.connect(session.seal)
        review.changed.connect(self._show)
        review.selection_changed.connect(self._enable)
        session.document_changed.connect(self._use_document)
        self._show()

    def sizeHint(self) -> QSize:
        """Wide and low."""
        return QSize(900, 230)

    def minimumSizeHint(self) -> QSize:
        """The least width of any arrangement."""
        return QSize(_LEAST_WIDTH, super().minimumSizeHint().height())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Arrange the parts vertically in a narrow panel."""
        narrow = event.size().width() < _NARROW
        along, across = QBoxLayout.Direction.LeftToRight, QBoxLayout.Direction.TopToBottom
        self._layout.setDirection(across if narrow else along)
        for box in self._boxes:
            box.setDirection(along if _NARROWEST < event.size().width() < _NARROW else across)
        self._beside.setMaximumWidth(16_777_215 if narrow else _BESIDE)
        super().resizeEvent(event)

    def _make_beside(self) -> QWidget:
        beside = QWidget()
        column = QVBoxLayout(beside)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(6)
        column.addWidget(self.summary)
        column.addWidget(self.shown)
        sliders, rows = self._boxes
        for threshold in self.thresholds.values():
            sliders.addWidget(threshold)
        column.addLayout(sliders)
        pairs = (QHBoxLayout(), QHBoxLayout())
        rows.setSpacing(4)
        names = (
            ("keep", tr("✓ Keep")),
            ("reject", tr("✗ Reject")),
            ("name", tr("Name…")),
            ("colour", tr("Color")),
        )
        for place, (name, text) in enumerate(names):
            button = self.buttons[name] = QToolButton()
            button.setText(text)
            button.setSizePolicy(button.sizePolicy().Policy.Expanding, button.sizePolicy().Policy.Fixed)
            pairs[place // 2].addWidget(button)
        for pair in pairs:
            pair.setSpacing(4)
            rows.addLayout(pair)
        self.buttons["colour"].setMenu(self._colors)
        self.buttons["colour"].setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.buttons["colour"].setToolTip(tr("Set the color of the selected contours."))
        column.addLayout(rows)
        column.addStretch(1)
        return beside

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
