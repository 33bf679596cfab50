"""The layer of the objects: those selected, by class, the one that is offered, and what a click would take."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import pyqtgraph as pg

from app.model.text.language import tr
from app.session.scene import Scene
from app.views.canvas.items.curves import Area, Curves, Fills
from app.views.canvas.items.item import Markers, Names
from app.views.canvas.layers.layer import Amount, Layer, Switch
from app.views.theme import theme
from cpm_core import Selection
from cpm_core.numerics import Array
from cpm_core.objects.segmented import Line, SegmentedObject

_OFFERED, _PREVIEW = 0.4, 0.3
"""Opacity of the area of what is offered, and of what a click would take."""

_MOST_MARKS = 60
"""Largest number of places of one click that are marked."""


class ObjectLayer(Layer):
    """Shows objects with area and outline in the color of their class; stretches that follow no contour are dashed."""

    name = "objects"
    title = tr("Objects")
    tip = tr("Objects that have been selected, and the one that is being selected.")
    shortcut = "Alt+5"
    in_slices = True
    colors = (theme.CLOSED, theme.CHOSEN)
    options = (
        Amount("fill", tr("Area"), 0.0, 1.0, 0.05, 0.25, tr("Opacity of the areas.")),
        Switch("names", tr("Names"), True, tr("Show the names of objects.")),
    )

    def make(self) -> None:
        """Make its items."""
        self.fills = Fills(3.0)
        self._outlines = Curves(theme.CLOSED, 4.3)
        self._gaps = Curves(theme.HALO, 4.35, halo=0.0, dashed=True)
        self._chosen = Curves(theme.CHOSEN, 4.25, width=5.0, halo=7.0)
        self._hovered = Curves(theme.HOVERED, 4.24, width=5.0, halo=0.0)
        self.preview_fill, self._preview = Fills(4.4), Curves(theme.CHOSEN, 4.45, width=1.2, halo=2.4)
        self.offered_fill, self._offered = Fills(4.5), Curves(theme.CHOSEN, 4.55, width=2.2, halo=4.0)
        self._offered_gaps = Curves(theme.HALO, 4.6, halo=0.0, dashed=True)
        self._clicks = Markers(6.9, size=9.0, pen=pg.mkPen(theme.HALO, width=1.2))
        self._names = Names(5.8)
        self.add(self.fills, self._outlines, self._gaps, self._chosen, self._hovered)
        self.add(self.preview_fill, self._preview, self.offered_fill, self._offered, self._offered_gaps)
        self.add(self._clicks)
        self.add(self._names, switch="names")

    def follow_choice(self, name: str) -> None:
        """Show areas in another opacity, or show or hide names."""
        if name == "fill":
            self._show_objects()
        else:
            super().follow_choice(name)

    def follow(self, before: Scene) -> None:
        """Show other objects, another selection, or another proposal."""
        scene, shown, last = self.scene, self.scene.objects, before.objects
        of, last_of = scene.document.objects, before.document.objects
        other = (of.items, of.classes, of.edited) != (last_of.items, last_of.classes, last_of.edited)
        if other:
            self._show_objects()
        if other or shown.chosen != last.chosen:
            self._chosen.show(_paths(item for item in self._seen() if item.number in shown.chosen))
        if other or shown.hovered != last.hovered:
            self._hovered.show(_paths(item for item in self._seen() if item.number == shown.hovered))
        if shown.proposals is not last.proposals or of.category != last_of.category or other:
            self._show_proposals()
        if shown.preview is not last.preview:
            found = [shown.preview] if isinstance(shown.preview, Selection) and shown.preview.found else []
            self.preview_fill.show([_area(each, theme.CHOSEN, _PREVIEW) for each in found])
            self._preview.show([contour.path for each in found for contour in each.contours])
        if of.clicks != last_of.clicks:
            self._show_clicks()

    def _seen(self) -> list[SegmentedObject]:
        """The objects that are shown: neither hidden ones nor the one that is being changed."""
        objects = self.scene.document.objects
        return [item for item in objects.items if not item.hidden and item.number != objects.edited]

    def _show_objects(self) -> None:
        objects, seen = self.scene.document.objects, self._seen()
        fill = self.number("fill")
        self.fills.show([(_curves(item.boundary), objects.color(item), fill) for item in seen])
        outlines = [(path, objects.color(item)) for item in seen for path in _paths((item,))]
        self._outlines.show([path for path, _ in outlines], [color for _, color in outlines])
        self._gaps.show([gap for item in seen for gap in _curves(item.gaps)])
        self._names.show([(item.center, item.name, objects.color(item)) for item in seen if item.name])

    def _show_proposals(self) -> None:
        objects, offered = self.scene.document.objects, self.scene.objects.proposals
        color = objects.classes[objects.category - 1].color
        selections = [
            each.selection for each in offered if isinstance(each.selection, Selection) and each.selection.found
        ]
        self.offered_fill.show([_area(selection, color, _OFFERED) for selection in selections])
        self._offered.show([contour.path for selection in selections for contour in selection.contours])
        self._offered_gaps.show([gap for selection in selections for gap in selection.gaps])

    def _show_clicks(self) -> None:
        """Mark the places of all clicks, of a long stroke only some."""
        clicks = self.scene.document.objects.clicks
        marks = [(at, each.inside) for each in clicks for at in each.places[:: 1 + len(each.places) // _MOST_MARKS]]
        brushes = {True: pg.mkBrush(theme.RESTING), False: pg.mkBrush(theme.BARRIER)}
        self._clicks.show(
            [at for at, _ in marks],
            symbol=["o" if inside else "x" for _, inside in marks],
            brush=[brushes[inside] for _, inside in marks],
        )


def _area(selection: Selection, color: str, opacity: float) -> Area:
    return [contour.points for contour in selection.contours], color, opacity


def _curves(lines: Sequence[Line]) -> list[Array]:
    return [np.array(line) for line in lines]


def _paths(items: Iterable[SegmentedObject]) -> list[Array]:
    return [np.array((*curve, curve[0])) for item in items for curve in item.boundary]
