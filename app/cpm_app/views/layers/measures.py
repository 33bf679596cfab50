"""The layer of rulers, angles and measuring ellipses, each with what it measures."""

from __future__ import annotations

from cpm_app.model.display.measures import describe_measure
from cpm_app.model.text.language import tr
from cpm_app.model.volume.shape_sections import whole_shape
from cpm_app.session.scene import Scene
from cpm_app.views.items.curves import Curves
from cpm_app.views.items.item import TextLabels
from cpm_app.views.layers.layer import Layer
from cpm_app.views.theme import theme
from cpm_core.shapes import Measure

_MEASURE_Z = 7.4
"""Place of measures in the stack, above starts."""


class MeasureLayer(Layer):
    """Lines of the measures, and a text above each; the selected one is drawn with its handles by the drawing layer."""

    name = "measures"
    title = tr("Measures")
    tip = tr("Rulers, angles, and ellipses with the mean and the standard deviation of their gray values.")
    shortcut = "Alt+Shift+9"
    colors = (theme.MEASURE_COLOR,)

    def create_items(self) -> None:
        """Create the items of the layer."""
        self._lines = Curves(theme.MEASURE_COLOR, _MEASURE_Z, 1.8, 3.6, kind="shapes")
        self.labels = TextLabels(_MEASURE_Z + 0.1)
        self.add_items(self._lines, self.labels)

    def show_scene(self, before: Scene) -> None:
        """Show other measures, or what they measure in another image or channel."""
        scene = self.scene
        now, then = (
            (each.document.shapes, each.full_image, each.document.parameters.channel) for each in (scene, before)
        )
        if now[0] is not then[0] or now[1] is not then[1] or now[2] != then[2]:
            self.show_measures()

    def show_measures(self) -> None:
        """Show all measures."""
        image, channel = self.scene.full_image, self.scene.document.parameters.channel
        if image is None:
            return
        found = [
            (section.outline, whole)
            for section in self.scene.document.shapes
            if isinstance(whole := whole_shape(section), Measure)
        ]
        self._lines.show_paths([outline for outline, _ in found])
        top = min if self.view.yInverted() else max
        self.labels.show_texts([
            (tuple(top(outline.tolist())), describe_measure(whole, image, channel), theme.MEASURE_COLOR)
            for outline, whole in found
        ])  # fmt: skip
