"""The table of what has been measured; it is there while there is any."""

from __future__ import annotations

from cpm_app.model.preferences.table import UNIT_PREFERENCE
from cpm_app.views.features.volumes import SlicesFeature
from cpm_app.views.panels.measures import MeasureTable
from cpm_app.views.window.docks import Panel
from cpm_app.views.window.window import Feature
from cpm_core.shapes import select_measures


class MeasuresFeature(Feature):
    """Panel of the measures."""

    def set_up(self) -> None:
        """Create the panel and connect it to what it depends on."""
        window = self.window
        self.table = MeasureTable(self.session, window.workspace.slices)
        self._has_measures = False
        self.panels = (Panel("measures", "Measures", self.table, "Ctrl+Shift+M", shown_at_start=False),)
        self.table.zoom_wanted.connect(window.canvas_area.zoom_to_selection)
        window.preferences.call_on_change(UNIT_PREFERENCE, self._on_unit_changed)
        self.session.document_changed.connect(self._on_document_changed)

    def _on_document_changed(self) -> None:
        had, self._has_measures = self._has_measures, bool(select_measures(self.session.document.shapes))
        self.window.docks.set_tab_available("measures", self._has_measures)
        if self._has_measures and not had and self.canvas.dispatcher.tool.panel == "measures":
            self.window.docks.bring_to_front("measures")

    def _on_unit_changed(self) -> None:
        self.table.show_items()
        for view in (self.window.canvas_area.canvas, *self.window.get_feature(SlicesFeature).sides):
            view.layers.measures.show_measures()
