"""Menu Contours: review, edits by hand and skeletons."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QMenu

from app.model.document import contours
from app.model.document.modes import use_skeleton
from app.model.preferences.table import UNIT
from app.model.state.situation import Situation
from app.model.text.language import tr
from app.views.canvas.naming import NameField
from app.views.panels.contours import ContourPanel
from app.views.theme.icons import fill_colors
from app.views.widgets.actions import ActionSpec, Submenu
from app.views.window.docks import Panel
from app.views.window.keyboard import Keys
from app.views.window.window import Feature, MainWindow
from cpm_core import Contour
from cpm_core.contours import middle
from cpm_core.medial_axis import Outlined

_ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)
_DELETE = (Qt.Key.Key_Delete, Qt.Key.Key_Backspace)


class ContoursFeature(Feature):
    """Review of the contours."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        session, canvas = window.session, window.canvas_area.canvas
        self._review = review = window.workspace.review
        layer = canvas.layers.contours
        self.panel = ContourPanel(review, self._fill_colors)
        self.panels = (Panel("contours", "Contours", self.panel, "F11"),)
        window.preferences.follow(UNIT, self.panel.table.show_items)
        self.name_field = NameField(canvas, tr("Name of the contour"))
        session.image_changed.connect(self.name_field.leave)
        Keys(canvas, lambda event: self.take_key(event.key()))
        self.panel.table.zoom_wanted.connect(window.canvas_area.zoom_to_selection)
        canvas.pointed.connect(lambda at: review.hover(None) if at is None else None)
        review.selection_changed.connect(window.refresh)

        def found(_: Situation) -> bool:
            return bool(review.items)

        def selected(_: Situation) -> bool:
            return bool(review.selected)

        self.actions = (
            ActionSpec("contour_table", "Contours", "&Table of contours",
                       "Show the measures and the review of each contour.", lambda: window.docks.enter("contours"),
                       "Ctrl+T"),
            ActionSpec("next_contour", "Contours", "Select ne&xt contour",
                       "Select one contour after the other, longest first.", self.select_next, "Shift+N", gap=True,
                       when=found),
            ActionSpec("all_contours", "Contours", "Select &all contours", "Select all contours.",
                       lambda: review.select(item.key for item in review.items), "Ctrl+A", when=found),
            ActionSpec("other_contours", "Contours", "&Invert the selection",
                       "Select all contours that are not selected.",
                       lambda: review.select({item.key for item in review.items} - review.selected), "Ctrl+I",
                       when=found),
            ActionSpec("keep", "Contours", "&Keep",
                       "Keep the selected contours through all sliders and runs; press again to undo.",
                       partial(review.judge, "kept"), "Shift+K", gap=True, when=selected),
            ActionSpec("reject", "Contours", "&Reject",
                       "Exclude the selected contours from exports; press again to undo.",
                       partial(review.judge, "rejected"), "X", when=selected),
            ActionSpec("name_contour", "Contours", "&Name…", "Give the selected contour a name.", self.ask_name, "F2",
                       when=selected),
            Submenu("colors", "Contours", "&Color", self._fill_colors),
            ActionSpec("forget_verdicts", "Contours", "C&lear verdicts, names and colors",
                       "Remove all contour reviews.",
                       partial(session.edit, tr("clear verdicts, names and colors"), contours.clear_marks),
                       when=lambda situation: bool(situation.document.marks)),
            ActionSpec("show_rejected", "Contours", "&Show rejected contours",
                       "Show rejected contours faint and dashed, or hide them.",
                       lambda: layer.choose("rejected", not layer.chosen["rejected"]), gap=True,
                       holds=lambda _: bool(layer.chosen["rejected"])),
        )  # fmt: skip

    def select_next(self) -> None:
        """Select the contour after the selected ones."""
        keys = [item.key for item in self._review.items]
        at = max((keys.index(key) for key in self._review.selected if key in keys), default=-1)
        if keys:
            self._review.select((keys[(at + 1) % len(keys)],))

    def ask_name(self) -> None:
        """Ask for the name of the selected contour, in the table if it has the focus, else on the canvas."""
        chosen = self._review.chosen
        if self.panel.table.hasFocus():
            self.panel.table.name_selected()
        elif chosen:
            key, contour = chosen[0].key, chosen[0].contour
            self.name_field.ask(middle(contour), contour.name, partial(self._review.rename, key))

    def take_key(self, key: int) -> bool:
        """Name the contour selected on the canvas on Enter, reject it on Delete; return whether the key was handled."""
        tool = self.window.canvas_area.canvas.hold.tool
        if tool is None or tool.name != "contours" or not self._review.selected:
            return False
        if key in _ENTER:
            self.ask_name()
        elif key in _DELETE:
            self._review.judge("rejected")
        return key in _ENTER or key in _DELETE

    def _fill_colors(self, menu: QMenu) -> None:
        fill_colors(menu, self.window, self._review.paint, bool(self._review.selected))


class HandEditingFeature(Feature):
    """Close, join, cut and delete contours by menu and keys."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        editing, review = window.workspace.hand_editing, window.workspace.review

        def delete(event: QKeyEvent) -> bool:
            taken = event.key() == Qt.Key.Key_Delete and len(editing.marked) == 2
            if taken:
                editing.delete_stretch()
            return taken

        Keys(window.canvas_area.canvas, delete)
        self.actions = (
            ActionSpec("close_contours", "Contours", "Clos&e by hand",
                       "Close the selected contour along the edge between its ends; several ones are joined first.",
                       partial(editing.join_selected, closing=True), "Shift+C", gap=True,
                       when=lambda _: any(not item.contour.closed for item in review.chosen)),
            ActionSpec("join_contours", "Contours", "&Join by hand",
                       "Join the selected contours along the edges between their nearest ends.",
                       partial(editing.join_selected, closing=False), "Shift+J",
                       when=lambda _: len(review.selected) > 1),
            ActionSpec("cut_contour", "Contours", "C&ut at the mark",
                       "Cut the contour at the place that was clicked last.", editing.cut_marked, "Shift+X",
                       when=lambda _: bool(editing.marked)),
            ActionSpec("delete_stretch", "Contours", "&Delete between the marks",
                       "Delete the stretch of a contour between two places that were clicked.",
                       editing.delete_stretch, "Shift+Delete", when=lambda _: len(editing.marked) == 2),
            ActionSpec("drop_missed_edits", "Contours", "Remove edits by hand that no longer a&pply",
                       "Remove edits that do not find their contours, with what they drew.",
                       lambda: editing.drop(editing.missed), when=lambda _: bool(editing.missed)),
            ActionSpec("drop_hand_edits", "Contours", "Remove all edits b&y hand",
                       "Show the contours as the run has found them.", editing.drop,
                       when=lambda situation: bool(situation.document.hand_edits)),
        )  # fmt: skip


class SkeletonsFeature(Feature):
    """What has a skeleton: objects, closed contours, or the image."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        objects = window.workspace.object_list
        self.actions = (
            ActionSpec("object_skeleton", "Objects", "S&keleton of the objects",
                       "Find the center lines of the chosen objects and how thick they are.",
                       lambda: self._find(tr("skeleton of objects"), Outlined(objects=tuple(sorted(objects.chosen)))),
                       icon="mode_skeleton", gap=True, when=lambda _: bool(objects.chosen)),
            ActionSpec("contour_skeleton", "Contours", "S&keleton of closed contours",
                       "Find the center lines inside the selected closed contours, or inside all of them.",
                       lambda: self._find(
                           tr("skeleton of contours"),
                           Outlined(contours=tuple(tuple(map(tuple, one.points.tolist())) for one in self._closed())),
                       ),
                       icon="mode_skeleton", gap=True, when=lambda _: bool(self._closed())),
            ActionSpec("image_skeleton", "Run", "Skeleton of the &whole image",
                       "Find center lines in the image again, not only in objects or closed contours.",
                       lambda: self._find(tr("skeleton of the image"), Outlined()),
                       when=lambda now: bool(now.document.outlines or now.document.outlined_surfaces)),
        )  # fmt: skip

    def _find(self, name: str, outlined: Outlined) -> None:
        session = self.window.session
        session.edit(name, lambda document: use_skeleton(document, outlined))
        if session.status.phase != "running":
            session.run()

    def _closed(self) -> list[Contour]:
        """The closed ones of the selected contours, or of all that have not been rejected if none is selected."""
        review = self.window.workspace.review
        items = review.chosen or [item for item in review.items if not item.reviewed.rejected]
        return [item.contour for item in items if item.contour.closed]
