"""The preferences."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.text.language import tr
from app.session.signals import PREFERENCES
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature, FeatureContext
from app.views.window.preferences.dialog import PreferencesDialog
from app.views.window.preferences.shortcuts import ShortcutsPage


class PreferencesFeature(Feature):
    """Opens the dialog of the preferences, and says what of those that are stored cannot be used."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        context.preferences.troubled.connect(self._say)
        if context.preferences.troubles:
            self._say()

    def action_specs(self) -> Sequence[ActionSpec]:
        """The dialog."""
        return (
            ActionSpec(name="preferences", menu="Edit", text=tr("&Preferences…"), do=self.show, shortcuts=("Ctrl+,",),
                       tip=tr("Change the settings of the program."), gap=True),
        )  # fmt: skip

    def show(self) -> PreferencesDialog:
        """Open the dialog; the window stays usable."""
        context = self.context
        page = ShortcutsPage(context.shortcuts())
        dialog = PreferencesDialog(context.window, context.preferences, context.preference_rows(), page)
        dialog.finished.connect(dialog.deleteLater)
        dialog.open()
        return dialog

    def _say(self, _: str = "") -> None:
        self.context.session.say(" ".join(self.context.preferences.troubles), True, PREFERENCES)
