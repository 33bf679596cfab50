"""The layers of the scale bar and of the letters at the edges that give the orientation."""

from __future__ import annotations

from cpm_app.model.display.lengths import find_scale_bar, preferred_pixel_size
from cpm_app.model.text.language import tr
from cpm_app.model.volume.slices import find_edge_labels
from cpm_app.session.scene import Scene
from cpm_app.views.items.item import TEXT_COLOR, PinnedText
from cpm_app.views.layers.layer import Layer
from cpm_core.image import ScaleBar

MAX_SCALE_BAR_LENGTH = 160.0
"""Maximum length of the bar [px of the screen]; the bar is at least 2/5 as long."""

_MIN_SCALE_BAR_LENGTH = 40.0
"""Lower limit of the maximum length in narrow views [px of the screen]."""

_CENTER_LETTER_ROOM = 70.0
"""Room for the letter in the middle, in half the width of a narrow view [px of the screen]."""

_LETTER_GAP = 4.0
"""Distance of the letters from the edge [px of the screen]."""

_SCALE_BAR_HTML = (
    "<div align='center'>{label}</div><table align='center' cellspacing='0' cellpadding='0'><tr>"
    f"<td width='{{length}}' bgcolor='{TEXT_COLOR}' style='font-size:2px'>&nbsp;</td></tr></table>"
)
"""Template of the scale bar: label above a bar of some length."""


class ScaleBarLayer(Layer):
    """A bar of round length in the unit of the image, if there is one."""

    name = "scale_bar"
    title = tr("Scale bar")
    tip = tr("A bar of round length, if the pixel size is known.")
    shortcut = "Alt+Shift+0"

    def create_items(self) -> None:
        """Create the items of the layer."""
        self.item = PinnedText(self.view, (0.0, 1.0))
        self.add_items(self.item)
        self.bar: ScaleBar | None = None
        """Bar that is shown."""
        self.view.sigRangeChanged.connect(self._update_bar)
        self.view.sigResized.connect(self._update_bar)

    def apply_visibility(self) -> None:
        """Show the bar if the pixel size is known."""
        self._update_bar()

    def show_scene(self, before: Scene) -> None:
        """Fit the bar to another image."""
        if self.scene.image is not before.image:
            self._update_bar()

    def _update_bar(self, *_: object) -> None:
        image = self.scene.image
        shown = self.shown and image is not None and image.unit is not None
        self.item.setVisible(shown)
        if shown and image is not None:
            pixel = float(self.view.viewPixelSize()[0])
            size = preferred_pixel_size(image.spacing, image.unit)
            longest = min(
                MAX_SCALE_BAR_LENGTH,
                max(0.5 * self.view.boundingRect().width() - _CENTER_LETTER_ROOM, _MIN_SCALE_BAR_LENGTH),
            )
            self.bar = find_scale_bar(longest * pixel, size.spacing[1], size.unit)
            self.item.show_html(_SCALE_BAR_HTML.format(label=self.bar.label, length=round(self.bar.pixels / pixel)))


class OrientationLayer(Layer):
    """A letter in the middle of each edge: R, L, A, P, S or I where the file states how the image lies."""

    name = "orientation"
    title = tr("Orientation")
    tip = tr("Directions at the edges: right, left, anterior, posterior, superior, inferior; or the axes.")

    _EDGES = ((0.5, 0.0), (0.5, 1.0), (0.0, 0.5), (1.0, 0.5))
    """Top, bottom, left and right, as fractions of width and height."""

    def create_items(self) -> None:
        """Create the items of the layer."""
        self.letters = [PinnedText(self.view, edge, _LETTER_GAP) for edge in self._EDGES]
        self.add_items(*self.letters)
        self._draw_letters()

    def apply_visibility(self) -> None:
        """Show the letters of the known directions."""
        self._draw_letters()

    def show_scene(self, before: Scene) -> None:
        """Show the orientation of another image or slice."""
        if self.scene.view_source != before.view_source:
            self._draw_letters()

    def _draw_letters(self) -> None:
        whole = self.scene.full_image
        edges = None if whole is None or not self.shown else find_edge_labels(whole, self.scene.slices)
        texts = ("",) * 4 if edges is None else (*edges[0], *edges[1])
        for item, text in zip(self.letters, texts, strict=True):
            item.setVisible(bool(text))
            item.show_html(text)
