"""The panel of all pages: the table, with how many there are and what can be done with them beside it."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QSize
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from app.model.display.lengths import shown_in
from app.model.display.page_rows import PageRow
from app.model.text.language import tr
from app.session.features.stack_pages import StackPages
from app.views.panels.item_table.row_table import LEAST
from app.views.panels.pages.table import PageTable
from app.views.widgets.scrolled import Scrolled

_BESIDE = 236


class PagePanel(QWidget):
    """Shows what was found on all pages of a stack; `show` goes to the contour of a row."""

    def __init__(self, pages: StackPages, show: Callable[[PageRow], None]) -> None:
        super().__init__()
        self._pages = pages
        self.table = PageTable()
        self.setFocusProxy(self.table)
        self.summary = QLabel()
        self.summary.setWordWrap(True)
        self.summary.setObjectName("dim")
        self.export = QPushButton(tr("Export all pages…"))
        beside = QWidget()
        beside.setMaximumWidth(_BESIDE)
        column = QVBoxLayout(beside)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(6)
        column.addWidget(self.summary)
        column.addWidget(self.export)
        column.addStretch(1)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(12, 6, 12, 6)
        layout.setSpacing(12)
        layout.addWidget(Scrolled(beside, LEAST))
        layout.addWidget(self.table, 1)
        self.table.wanted.connect(show)
        pages.found.connect(self.show_rows)
        self.show_rows()

    def sizeHint(self) -> QSize:
        """Wide and low."""
        return QSize(900, 230)

    def show_rows(self) -> None:
        """Show what is known of the pages."""
        found = self._pages.result
        first = None if found is None or not found.results else found.results[0][1]
        size = shown_in((1.0, 1.0), None) if first is None else shown_in(first.spacing, first.unit)
        self.table.rows.show_rows(self._pages.rows, size)
        self.export.setEnabled(first is not None)
        self.summary.setText(self._in_words())

    def _in_words(self) -> str:
        found = self._pages.result
        if found is None or not found.pages:
            return tr("Nothing has been found on the pages of a stack yet: run this page, or all of them.")
        failed = len(found.pages) - len(found.results)
        text = tr("{done} of {count} pages are done; tracks: {tracks}.").format(
            done=len(found.results), count=found.count, tracks=len(found.tracks)
        )
        more = tr("{failed} could not be used.").format(failed=failed)
        return f"{text} {more}" if failed else text
