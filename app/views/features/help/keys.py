"""The cheat sheet of keys."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.text.language import tr
from app.views.help.cheat_sheet import CheatSheet
from app.views.widgets.entry import Entry
from app.views.window.part import Part


class KeysPart(Part):
    """What shows all keys."""

    def entries(self) -> Sequence[Entry]:
        """The cheat sheet."""
        return (
            Entry(
                name="keys",
                menu="Help",
                text=tr("&Keys"),
                do=self._show,
                shortcuts=("?",),
                tip=tr("All keys at a glance."),
            ),
        )

    def _show(self) -> None:
        open_ones = [sheet for sheet in self.desk.window.findChildren(CheatSheet) if sheet.isVisible()]
        for sheet in open_ones:
            sheet.close()
        if not open_ones:
            sheet = CheatSheet(self.desk.window, self.desk.entries())
            sheet.show()
            sheet.activateWindow()
