"""The cheat sheet of keys."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.text.language import tr
from app.views.help.cheat_sheet import CheatSheet
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature


class KeysFeature(Feature):
    """What shows all keys."""

    def action_specs(self) -> Sequence[ActionSpec]:
        """The cheat sheet."""
        return (
            ActionSpec(
                name="keys",
                menu="Help",
                text=tr("&Keys"),
                do=self._show,
                shortcuts=("?",),
                tip=tr("All keys at a glance."),
            ),
        )

    def _show(self) -> None:
        open_ones = [sheet for sheet in self.context.window.findChildren(CheatSheet) if sheet.isVisible()]
        for sheet in open_ones:
            sheet.close()
        if not open_ones:
            sheet = CheatSheet(self.context.window, self.context.action_specs())
            sheet.show()
            sheet.activateWindow()
