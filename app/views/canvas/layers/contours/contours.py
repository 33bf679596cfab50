"""The layer of the contours: closed and open ones in two colours or in their own, with names, junctions and bridges.

What has been rejected is faint and dashed, or hidden; what is selected has a bright rim.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtWidgets import QCheckBox, QVBoxLayout, QWidget

from app.model.display.display_image import DisplayImage
from app.model.text.language import tr
from app.session.features.contour_review import Item
from app.session.session import Session
from app.views.canvas.coordinates import to_xy
from app.views.canvas.items.curves import Curves
from app.views.canvas.items.markers import Markers
from app.views.canvas.items.names import Names
from app.views.canvas.layers.layer import Layer
from app.views.theme import theme
from cpm_core.contours.review import middle
from cpm_core.image.image import Image


class ContourLayer(Layer):
    """Shows contours, as far as a person lets them count."""

    name = "contours"
    title = tr("Contours")
    tip = tr("Closed, and open.")
    shortcut = "Ctrl+2"
    colours = (theme.CLOSED, theme.OPEN)

    def __init__(self, view: pg.ViewBox, session: Session) -> None:
        super().__init__(view, session)
        self._review = session.review
        self._shape: tuple[int, ...] = (1, 1)
        self._hovered = Curves(theme.HOVERED, 3.7, width=7.0, halo=0.0)
        self._chosen = Curves(theme.CHOSEN, 3.8, width=6.5, halo=8.5)
        self._rejected = Curves(theme.REJECTED, 3.9, width=1.8, halo=2.8, dashed=True)
        self._curves = {True: Curves(theme.CLOSED, 4.0), False: Curves(theme.OPEN, 4.1)}
        self._own: dict[str, Curves] = {}
        self._bridges = Curves(theme.BRIDGE, 4.2, dashed=True)
        self._names = Names(5.7)
        self._junctions = Markers(size=8.0, symbol="d", pen=pg.mkPen(theme.HALO), brush=pg.mkBrush(theme.JUNCTION))
        self._junctions.setZValue(5.5)
        self._lines = [self._hovered, self._chosen, self._rejected, *self._curves.values(), self._bridges]
        self.show_rejected = True
        self.show_names = True
        self.add(*self._lines, self._names, self._junctions)
        session.image_changed.connect(self._use_image)
        self._review.changed.connect(self._show)
        self._review.selection_changed.connect(self._show_chosen)
        self._review.hover_changed.connect(self._show_hovered)

    @property
    def counts(self) -> tuple[int, int]:
        """Closed and open contours shown that have not been rejected."""
        counted = [item.contour.closed for item in self._review.items if not item.reviewed.rejected]
        return sum(counted), len(counted) - sum(counted)

    @property
    def rejected(self) -> int:
        """Rejected contours shown."""
        return self._rejected.count

    @property
    def bridged(self) -> int:
        """Bridged gaps shown."""
        return self._bridges.count

    def show_or_hide(self) -> None:
        """Show or hide them all."""
        for item in self._lines:
            item.set_wanted(self.shown)
        self._names.set_wanted(self.shown and self.show_names)
        self._junctions.setVisible(self.shown)

    def set_show_rejected(self, shown: bool) -> None:
        """Show what has been rejected, or hide it."""
        if shown != self.show_rejected:
            self.show_rejected = self._review.rejected_seen = shown
            self._show()
            self.changed.emit()

    def set_show_names(self, shown: bool) -> None:
        """Show names, or hide them."""
        if shown != self.show_names:
            self.show_names = shown
            self.show_or_hide()
            self.changed.emit()

    def settings(self) -> QWidget:
        """Whether rejected contours and names are shown."""
        made = QWidget()
        layout = QVBoxLayout(made)
        layout.setContentsMargins(0, 0, 0, 0)
        rejected, names = QCheckBox(tr("Rejected ones, dashed")), QCheckBox(tr("Names"))
        for box, shown, show in (
            (rejected, self.show_rejected, self.set_show_rejected),
            (names, self.show_names, self.set_show_names),
        ):
            box.setChecked(shown)
            box.toggled.connect(show)
            layout.addWidget(box)
        return made

    def view_state(self) -> dict[str, object]:
        """What a session file keeps of it."""
        return super().view_state() | {"rejected": self.show_rejected, "names": self.show_names}

    def use_view_state(self, state: dict[str, object]) -> None:
        """Look as a session file says."""
        super().use_view_state(state)
        rejected, names = state.get("rejected"), state.get("names")
        if isinstance(rejected, bool):
            self.set_show_rejected(rejected)
        if isinstance(names, bool):
            self.set_show_names(names)

    def _use_image(self, _: Image, shades: DisplayImage) -> None:
        self._shape = shades.shape
        self._names.use_shape(self._shape)
        for item in self._lines:
            item.use_shape(self._shape)

    def _show(self) -> None:
        items = self._review.items
        counting = [item for item in items if not item.reviewed.rejected]
        for closed, curves in self._curves.items():
            curves.show(_paths([i for i in counting if i.contour.closed == closed and not i.contour.colour]))
        self._show_own([item for item in counting if item.contour.colour])
        self._rejected.show(_paths([i for i in items if i.reviewed.rejected]) if self.show_rejected else [])
        result = self._review.result
        self._bridges.show([bridge.points for bridge in result.bridges] if result is not None else [])
        named = [item.contour for item in counting if item.contour.name]
        self._names.show([(middle(c), c.name, c.colour or "#ffffff") for c in named])
        ends = [item.contour.points[end] for item in items for end in (0, -1) if item.contour.junctions[end]]
        x, y = to_xy(np.unique(np.array(ends, dtype=float).reshape(-1, 2), axis=0))
        self._junctions.setData(x=x, y=y)
        self._show_chosen()
        self._show_hovered()

    def _show_own(self, items: Sequence[Item]) -> None:
        """Draw each of the colours that people have chosen by one item."""
        for colour in {item.contour.colour for item in items} - self._own.keys():
            curves = self._own[colour] = Curves(colour, 4.15)
            curves.use_shape(self._shape)
            curves.set_wanted(self.shown)
            curves.setOpacity(self.opacity)
            self.add(curves)
            self._lines.append(curves)
        for colour, curves in self._own.items():
            curves.show(_paths([item for item in items if item.contour.colour == colour]))

    def _show_chosen(self) -> None:
        self._chosen.show(_paths(self._review.chosen))

    def _show_hovered(self) -> None:
        key = self._review.hovered
        self._hovered.show(_paths([self._review[key]] if key is not None and key in self._review else []))


def _paths(items: Sequence[Item]) -> list[np.ndarray]:
    return [item.contour.path for item in items]
