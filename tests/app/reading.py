"""What tests read from the window, and how they call its work saved."""

from __future__ import annotations

from cpm_app.views.panels.tables import SortableTable
from cpm_app.views.window.window import MainWindow


def column_texts(table: SortableTable, name: str) -> list[str]:
    """The texts of a column, from top to bottom."""
    number = table.column_index(name)
    return [str(table.rows.index(row, number).data()) for row in range(len(table.rows.items))]


def treat_as_saved(window: MainWindow) -> None:
    """Let document and runs count as saved."""
    window.document_file.saved_document = window.session.document
    window.document_file.runs.mark_saved(window.session.scene.timeline.edition)
