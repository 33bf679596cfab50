"""The model of the contour table: one row per contour, which stays in place as long as the contour is found again."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QObject
from PySide6.QtGui import QColor, QFont, QGuiApplication, QPalette

from app.model.display.lengths import shown_in
from app.session.features.contour_review import ContourReview
from app.session.scene import Item
from app.views.panels.contour_table.columns import COLUMNS
from app.views.panels.item_table.model import Index, ItemModel, Role, Sorted
from app.views.theme import theme
from app.views.theme.icons import swatch


class ContourModel(ItemModel[Item]):
    """Contours of a review as a table; names that are typed go back to the review."""

    def __init__(self, review: ContourReview, parent: QObject | None = None) -> None:
        super().__init__(COLUMNS, parent)
        self._review = review

    def refresh(self) -> None:
        """Show the present contours."""
        self.update(self._review.items)
        result = self._review.result
        if result is not None:
            self.use_unit(shown_in(result.spacing, result.unit))

    def key_of(self, item: Item) -> int:
        """Key of a contour."""
        return item.key

    def name_of(self, item: Item) -> str:
        """Name of a contour."""
        return item.contour.name

    def rename(self, key: int, name: str) -> None:
        """Name a contour."""
        self._review.rename(key, name)

    def look(self, item: Item, role: int, of_name: bool) -> Any:
        """The color of a contour beside its name; rejected ones are pale, their names struck out."""
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


class SortedContours(Sorted):
    """Contours in the order of a column; only those of a verdict, if one is chosen."""

    def __init__(self, model: ContourModel, parent: QObject | None = None) -> None:
        super().__init__(model, parent)
        self._contours = model
        self._verdict: str | None = None

    def show_only(self, verdict: str | None) -> None:
        """Show the contours with a verdict (empty for the undecided ones), or all for None."""
        self._verdict = verdict
        self.invalidate()

    def filterAcceptsRow(self, row: int, parent: Index) -> bool:
        """Whether a row is shown."""
        return self._verdict is None or self._contours.item(row).reviewed.verdict == self._verdict
