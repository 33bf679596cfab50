"""The preferences."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.text.language import tr
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature
from app.views.window.preferences_dialog import PreferencesDialog


class PreferencesFeature(Feature):
    """Opens the dialog of the preferences."""

    def action_specs(self) -> Sequence[ActionSpec]:
        """The dialog."""
        return (
            ActionSpec(name="preferences", menu="Edit", text=tr("&Preferences…"), do=self.show, shortcuts=("Ctrl+,",),
                       tip=tr("Change the settings of the program."), gap=True),
        )  # fmt: skip

    def show(self) -> PreferencesDialog:
        """Open the dialog; the window stays usable."""
        dialog = PreferencesDialog(self.context.window, self.context.preference_rows())
        dialog.finished.connect(dialog.deleteLater)
        dialog.open()
        return dialog
