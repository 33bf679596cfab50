"""Going through the window by keys."""

from __future__ import annotations

from collections.abc import Sequence

from app.model.text.language import tr
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature


class KeyboardFeature(Feature):
    """Gives the keyboard to the sliders, and to one area of the window after the other."""

    def action_specs(self) -> Sequence[ActionSpec]:
        """The sliders, and the next and previous area."""
        return (
            ActionSpec(name="go_to_sliders", menu="View", text=tr("&Go to the sliders"),
                       do=lambda: self.context.areas().enter("parameters"), shortcuts=("Q",), gap=True,
                       tip=tr("Give the keyboard to the sliders; Enter or Esc gives it back to the image.")),
            ActionSpec(name="next_area", menu="View", text=tr("Go to the ne&xt area"),
                       do=lambda: self.context.areas().go_on(), shortcuts=("F6",),
                       tip=tr("Give the keyboard to the image, the sliders, the table and the timeline in turn.")),
            ActionSpec(name="previous_area", menu="View", text=tr("Go to the pre&vious area"),
                       do=lambda: self.context.areas().go_on(-1), shortcuts=("Shift+F6",),
                       tip=tr("The same in the other direction.")),
            ActionSpec(name="open_menu", menu="View", text=tr("&Menu of what is chosen"), do=self.context.open_menu,
                       shortcuts=("Shift+F10", "Menu"),
                       tip=tr("Open the menu that a click with the right button opens.")),
        )  # fmt: skip
