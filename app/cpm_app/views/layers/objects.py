"""The layer of the objects: accepted objects, proposals, and the preview of a click."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt

from cpm_app.model.text.language import tr
from cpm_app.session.features.object_selection import format_confidence
from cpm_app.session.scene import Scene
from cpm_app.views.items.curves import Curves, FilledArea, Fills
from cpm_app.views.items.item import Markers, TextLabels
from cpm_app.views.layers.layer import Layer, LegendEntry, Option
from cpm_app.views.theme import theme
from cpm_core import Selection
from cpm_core.numerics import Array
from cpm_core.objects.segmented import DEFAULT_CLASSES
from cpm_core.results import is_likely

_PROPOSAL_OPACITY = 0.2
"""Opacity of the area of a proposal."""

_DOUBTFUL_OPACITY = 0.08
"""Opacity of the area of a doubtful proposal."""

_PREVIEW_OPACITY = 0.4
"""Opacity of the area that a click would add."""

_DOUBTFUL_DASHES = (2.5, 5.0)
"""Lengths of dashes and gaps around a doubtful proposal [widths of the line]."""

_MAX_MARKED_PROPOSALS = 12
"""Largest number of proposals for which all doubtful ones are marked with their probability."""


class ObjectLayer(Layer):
    """Shows objects with area and outline in the color of their class; stretches that follow no contour are dashed.

    Proposals are dashed, in one color; doubtful ones are sparse and pale. The area that a click would remove is
    hatched. A dashed ring is around a click until its answer is shown.
    """

    name = "objects"
    title = tr("Objects")
    tip = tr("Accepted objects by class, and proposals, dashed.")
    shortcut = "Alt+5"
    colors = (DEFAULT_CLASSES[0].color, theme.PROPOSAL_COLOR)
    options = (
        Option("fill", tr("Area"), 0.25, tr("Opacity of the areas.")),
        Option("names", tr("Names"), True, tr("Show the names of objects.")),
    )

    def create_items(self) -> None:
        """Create the items of the layer."""
        self.fills = Fills(3.0)
        self._outlines = Curves(theme.SELECTED_COLOR, 4.3)
        self._gaps = Curves(theme.CANVAS_HALO_COLOR, 4.35, halo=0.0, dashed=True)
        self._selected = Curves(theme.SELECTED_COLOR, 4.25, width=5.0, halo=7.0)
        self._hovered = Curves(theme.HOVERED_COLOR, 4.24, width=5.0, halo=0.0)
        self.proposal_fill, self._proposal_outlines = (
            Fills(4.4),
            Curves(theme.PROPOSAL_COLOR, 4.55, width=2.2, halo=4.0, dashed=True),
        )
        self._doubtful = Curves(theme.PROPOSAL_COLOR, 4.5, width=1.4, halo=2.8, dashed=_DOUBTFUL_DASHES)
        self.added, self.removed = Fills(4.6), Fills(4.65, Qt.BrushStyle.BDiagPattern)
        self.points = Markers(6.9, size=9.0, pen=pg.mkPen(theme.CANVAS_HALO_COLOR, width=1.2))
        self.strokes = Curves(theme.RESTING_COLOR, 6.8)
        self.awaited = Markers(6.85, size=22.0, symbol="o", brush=None, pen=theme.PROPOSAL_COLOR)
        self._paths: dict[int, tuple[Array, ...]] = {}
        """Paths of the shown objects by object number."""
        self._names, self._probabilities = TextLabels(5.8), TextLabels(5.85)
        self.add_items(self.fills, self._outlines, self._gaps, self._selected, self._hovered, self.proposal_fill)
        self.add_items(
            self._proposal_outlines, self._doubtful, self.added, self.removed, self.points, self._probabilities
        )
        self.add_items(self.strokes, self.awaited)
        self.add_items(self._names, switch="names")

    def legend_entries(self) -> Sequence[LegendEntry]:
        """Return the entries of accepted objects and proposals, in a slice those of the whole volume."""
        scene = self.scene.whole or self.scene
        offered, objects = _list_proposals(scene), scene.document.objects
        color = objects.color_of(objects.items[0]) if objects.items else theme.PROPOSAL_COLOR
        return (
            LegendEntry(
                len(objects.items), tr("objects"), tr("Objects, in the colors of their classes."), color, "area"
            ),
            LegendEntry(
                len(offered), tr("proposals"), tr("Objects that can be accepted."), theme.PROPOSAL_COLOR, "dashed"
            ),
        )

    def apply_option(self, name: str) -> None:
        """Change the opacity of areas, or show or hide names."""
        if name == "fill":
            self._show_objects()
        else:
            super().apply_option(name)

    def show_scene(self, before: Scene) -> None:
        """Show other objects, another selection, or other proposals."""
        scene, shown, last = self.scene, self.scene.objects, before.objects
        of, last_of = scene.document.objects, before.document.objects
        other = (of.items, of.classes, of.edited) != (last_of.items, last_of.classes, last_of.edited)
        if other:
            self._show_objects()
        other_offer = shown.proposals is not last.proposals
        if other or other_offer or shown.selected != last.selected:
            self._selected.show_paths(self._find_paths(shown.selected))
        if other or other_offer or shown.hovered != last.hovered:
            self._hovered.show_paths(self._find_paths({shown.hovered}))
        if other_offer:
            self._show_proposals()
        if other_offer or (shown.selected, shown.hovered) != (last.selected, last.hovered):
            self._show_probabilities()
        if shown.preview is not last.preview:
            self._show_preview()
        if of.clicks != last_of.clicks:
            self._show_clicks()
        if shown.awaited != last.awaited:
            self._show_awaited_clicks()

    def _show_objects(self) -> None:
        objects = self.scene.document.objects
        seen = [item for item in objects.items if not item.hidden and item.number != objects.edited]
        fill = self.get_amount("fill")
        self._paths = {item.number: item.paths for item in seen}
        areas = [(item.paths, objects.color_of(item), fill * item.opacity) for item in seen if not item.line]
        self.fills.show_areas(areas)
        outlines = [(path, objects.color_of(item)) for item in seen for path in item.paths]
        self._outlines.show_paths([path for path, _ in outlines], [color for _, color in outlines])
        self._gaps.show_paths([np.array(gap) for item in seen for gap in item.gaps])
        self._names.show_texts([
            ((float(item.box[0][0]), item.center[1]), item.name, objects.color_of(item)) for item in seen if item.name
        ])  # fmt: skip

    @property
    def _proposals(self) -> list[tuple[int, Selection]]:
        """Proposals that are drawn, with their keys."""
        return _list_proposals(self.scene)

    def _find_paths(self, numbers: Iterable[int]) -> list[Array]:
        """Find the boundaries of objects by number and of proposals by key, each of shape (K, 2)."""
        wanted = set(numbers)
        proposals = [found for key, found in self._proposals if key and key in wanted]
        own = [path for number, paths in self._paths.items() if number in wanted for path in paths]
        return [*own, *_selection_outlines(proposals)]

    def _show_proposals(self) -> None:
        found = [selection for _, selection in self._proposals]
        sure = [each for each in found if is_likely(each)]
        doubtful = [each for each in found if not is_likely(each)]
        areas = [(_selection_curves(each), theme.PROPOSAL_COLOR, _PROPOSAL_OPACITY) for each in sure]
        self.proposal_fill.show_areas(
            [*areas, *((_selection_curves(each), theme.PROPOSAL_COLOR, _DOUBTFUL_OPACITY) for each in doubtful)]
        )
        self._proposal_outlines.show_paths(_selection_outlines(sure))
        self._doubtful.show_paths(_selection_outlines(doubtful))

    def _show_probabilities(self) -> None:
        """Show the probabilities of proposals; of many, only of the one under the pointer and of selected ones."""
        shown, offered = self.scene.objects, self._proposals
        few = len(offered) <= _MAX_MARKED_PROPOSALS
        marked = [
            found
            for key, found in offered
            if key in {*shown.selected, shown.hovered, 0} or len(offered) == 1 or (few and not is_likely(found))
        ]
        marked = [found for found in marked if format_confidence(found)]  # unknown where a body was clicked
        texts = (f"{'? ' * (not is_likely(found))}{format_confidence(found)}" for found in marked)
        highest = (tuple(min(np.concatenate(_selection_curves(found)).tolist())) for found in marked)
        self._probabilities.show_texts([(place, text, "#ffffff") for place, text in zip(highest, texts, strict=True)])

    def _show_preview(self) -> None:
        """Show the area that a click would add or remove, by the even-odd rule for the old and new boundaries."""
        preview = self.scene.objects.preview
        changed: list[FilledArea] = []
        if preview is not None and isinstance(preview.after, Selection):
            curves = _selection_curves(preview.after)
            if isinstance(preview.before, Selection):
                curves += _selection_curves(preview.before)
            color, opacity = (theme.PROPOSAL_COLOR, _PREVIEW_OPACITY) if preview.adds else (theme.REMOVED_COLOR, 1.0)
            changed = [(curves, color, opacity)] if curves else []  # empty in a slice that misses the object
        adds = preview is not None and preview.adds
        self.added.show_areas(changed if adds else [])
        self.removed.show_areas([] if adds else changed)

    def _show_clicks(self) -> None:
        """Mark each click: a point by a symbol, a stroke by its line."""
        colors = {True: theme.RESTING_COLOR, False: theme.BARRIER_COLOR}
        marks = [(np.array(each.places), each.inside) for each in self.scene.document.objects.clicks]
        drawn, points = ([mark for mark in marks if (len(mark[0]) > 1) is line] for line in (True, False))
        self.strokes.show_paths([path for path, _ in drawn], [colors[inside] for _, inside in drawn])
        self.points.show_markers(
            [place for (place,), _ in points],
            symbol=["o" if inside else "x" for _, inside in points],
            brush=[pg.mkBrush(colors[inside]) for _, inside in points],
        )

    def _show_awaited_clicks(self) -> None:
        """Mark the middle of each click that is being worked on by a dashed ring."""
        pen = pg.mkPen(theme.PROPOSAL_COLOR, width=2.5, style=Qt.PenStyle.DashLine)
        self.awaited.show_markers([each.places[len(each.places) // 2] for each in self.scene.objects.awaited], pen=pen)


def _list_proposals(scene: Scene) -> list[tuple[int, Selection]]:
    """List the proposals of a scene that can be drawn, with their keys."""
    offered = ((each.key, each.selection) for each in scene.objects.proposals)
    return [(key, found) for key, found in offered if isinstance(found, Selection) and found.has_boundary]


def _selection_curves(selection: Selection) -> list[Array]:
    return [contour.points for contour in selection.contours]


def _selection_outlines(selections: Iterable[Selection]) -> list[Array]:
    return [contour.path for selection in selections for contour in selection.contours]
