"""The contour table; its selection is shared with the canvas."""

from __future__ import annotations

from collections.abc import Iterable, Set

from app.model.text.language import tr
from app.session.features.contour_review import ContourReview
from app.views.panels.contour_table.model import ContourModel, SortedContours
from app.views.panels.item_table.view import ItemTable


class ContourTable(ItemTable):
    """Shows the contours of a review, selects, names and rejects them."""

    thing = "contour"

    def __init__(self, review: ContourReview) -> None:
        self._review = review
        rows = ContourModel(review)
        self._contours = SortedContours(rows)
        super().__init__(rows, self._contours, tr("Contours"))
        review.changed.connect(self.show_items)
        review.selection_changed.connect(self.show_selection)

    def show_only(self, verdict: str | None) -> None:
        """Show the contours with a verdict (empty for the undecided ones), or all for None."""
        self._showing = True
        self._contours.show_only(verdict)
        self._showing = False
        self.show_selection()

    def hover(self, key: int | None) -> None:
        """Highlight a contour on the canvas."""
        self._review.hover(key)

    def choose(self, keys: Iterable[int]) -> None:
        """Select contours."""
        self._review.select(keys)

    def chosen(self) -> Set[int]:
        """Keys of the selected contours."""
        return self._review.selected

    def remove(self) -> None:
        """Reject the selected contours."""
        self._review.judge("rejected")
