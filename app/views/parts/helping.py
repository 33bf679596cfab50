"""Help."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.language import tr
from app.views.entry import Entry
from app.views.help import show_about, show_help
from app.views.part import Part


class HelpingPart(Part):
    """What explains the program."""

    def entries(self) -> Sequence[Entry]:
        """Short help and about."""
        window = self.desk.window
        return (
            Entry(
                name="help",
                menu="Help",
                text=tr("&Short help"),
                do=lambda: show_help(window, self.desk.entries()),
                shortcuts=("F1",),
                tip=tr("What to do, and all keys."),
            ),
            Entry(
                name="about", menu="Help", text=tr("&About CPM"), do=lambda: show_about(window), tip=tr("What this is.")
            ),
        )
