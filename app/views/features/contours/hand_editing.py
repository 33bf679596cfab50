"""Editing of contours by hand: actions beside the tools."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent

from app.model.state.situation import Situation
from app.model.text.language import tr
from app.views.widgets.action_spec import ActionSpec
from app.views.window.feature import Feature, FeatureContext


class HandEditingFeature(Feature):
    """Close, join, cut and delete contours by menu and keys."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self._editing, self._review = context.workspace.hand_editing, context.workspace.review
        self._keys = _StretchKeys(self)
        context.canvas_area.canvas.installEventFilter(self._keys)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Close, join, cut, delete, and remove edits."""
        return (
            ActionSpec(name="close_contours", menu="Contours", text=tr("Clos&e by hand"),
                       do=lambda: self._editing.join_selected(closing=True), shortcuts=("Shift+C",), gap=True,
                       tip=tr("Close the selected contour along the edge between its ends; several ones are joined "
                              "first."),
                       when=self._chosen),
            ActionSpec(name="join_contours", menu="Contours", text=tr("&Join by hand"),
                       do=lambda: self._editing.join_selected(closing=False), shortcuts=("Shift+J",),
                       tip=tr("Join the selected contours along the edges between their nearest ends."),
                       when=lambda situation: len(self._review.selected) > 1),
            ActionSpec(name="cut_contour", menu="Contours", text=tr("C&ut at the mark"), do=self._editing.cut_marked,
                       shortcuts=("Shift+X",), tip=tr("Cut the contour at the place that was clicked last."),
                       when=lambda situation: bool(self._editing.marked)),
            ActionSpec(name="delete_stretch", menu="Contours", text=tr("&Delete between the marks"),
                       do=self._editing.delete_stretch, shortcuts=("Shift+Delete",),
                       tip=tr("Delete the stretch of a contour between two places that were clicked."),
                       when=lambda situation: len(self._editing.marked) == 2),
            ActionSpec(name="drop_missed_edits", menu="Contours", text=tr("Remove edits by hand that no longer a&pply"),
                       do=lambda: self._editing.drop(self._editing.missed),
                       tip=tr("Remove edits that do not find their contours, with what they drew."),
                       when=lambda situation: bool(self._editing.missed)),
            ActionSpec(name="drop_hand_edits", menu="Contours", text=tr("Remove all edits b&y hand"),
                       do=self._editing.drop, tip=tr("Show the contours as the run has found them."),
                       when=lambda situation: bool(situation.document.hand_edits)),
        )  # fmt: skip

    def delete_stretch(self) -> bool:
        """Delete the marked stretch; return whether there is one."""
        there = len(self._editing.marked) == 2
        self._editing.delete_stretch()
        return there

    def _chosen(self, situation: Situation) -> bool:
        return any(not item.contour.closed for item in self._review.chosen)


class _StretchKeys(QObject):
    """The key of the canvas that deletes a marked stretch."""

    def __init__(self, feature: HandEditingFeature) -> None:
        super().__init__(feature.context.window)
        self._feature = feature

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Delete the stretch between two marks."""
        if event.type() == QEvent.Type.KeyPress and isinstance(event, QKeyEvent):
            return event.key() == Qt.Key.Key_Delete and self._feature.delete_stretch()
        return False
