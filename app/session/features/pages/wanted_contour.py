"""The contour of another page that the user wants to see: its page is opened, and then it is selected."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QObject

from app.model.display.page_rows import PageRow
from app.session.features.contour_review import ContourReview
from app.session.features.pages.stack_pages import StackPages
from app.session.scene import Item
from cpm_core.contours.measurements import centroid

_NEAR, _ALIKE = 1.0, 0.02
"""How far the center of a contour may lie from where it was [px], and by how much its length may differ, of 1."""


class WantedContour(QObject):
    """Opens the page of a contour, and selects the contour as soon as it is shown there."""

    def __init__(self, pages: StackPages, review: ContourReview) -> None:
        super().__init__(pages)
        self._pages, self._review = pages, review
        self._wanted: PageRow | None = None
        review.changed.connect(self._look)
        pages.changed.connect(self._look)

    def show(self, row: PageRow) -> None:
        """Go to the contour of a row, or to the page of a row that has none."""
        self._wanted = row if row.measures is not None else None
        self._pages.open(row.page)
        self._look()

    def _look(self) -> None:
        """Select the contour if it is there; forget it when another page is wanted meanwhile."""
        row = self._wanted
        if row is None:
            return
        if self._pages.ahead != row.page:
            self._wanted = None
        elif self._pages.number == row.page:
            near = min(self._review.items, key=lambda item: _away(item, row), default=None)
            if near is not None and _is_meant(near, row):
                self._wanted = None
                self._review.select((near.key,))


def _away(item: Item, row: PageRow) -> float:
    return float(np.hypot(*np.subtract(centroid(item.contour), (row.row, row.col))))


def _is_meant(item: Item, row: PageRow) -> bool:
    length = 0.0 if row.measures is None else row.measures.length
    return _away(item, row) <= _NEAR and abs(item.measures.length - length) <= _ALIKE * length
