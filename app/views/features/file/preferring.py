"""The preferences."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.text.language import tr
from app.views.widgets.entry import Entry
from app.views.window.part import Part
from app.views.window.preferences_dialog import PreferencesDialog


class PreferringPart(Part):
    """Opens the dialog of the preferences."""

    def entries(self) -> Sequence[Entry]:
        """The dialog."""
        return (
            Entry(
                name="preferences",
                menu="Edit",
                text=tr("&Preferences…"),
                do=self.show,
                shortcuts=("Ctrl+,",),
                tip=tr("What the program remembers about how you like it."),
                gap=True,
            ),
        )

    def show(self) -> PreferencesDialog:
        """Open the dialog; the window stays usable beside it."""
        dialog = PreferencesDialog(self.desk.window, self.desk.preference_rows())
        dialog.finished.connect(dialog.deleteLater)
        dialog.open()
        return dialog
