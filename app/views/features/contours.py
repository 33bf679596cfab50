"""Menu Contours: review, edits by hand, ground truth and skeletons."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMenu

from app.model.display.differences import Difference
from app.model.document import contours
from app.model.document.modes import use_skeleton
from app.model.preferences.table import UNIT
from app.model.state.situation import Situation, has_image
from app.model.text.language import tr
from app.views.canvas.naming import NameField
from app.views.panels.contours import ContourPanel
from app.views.panels.truth import TruthPanel
from app.views.theme.icons import fill_colors
from app.views.widgets.actions import ActionSpec, Submenu
from app.views.window.dialogs import Files, all_files
from app.views.window.feature import Feature, FeatureContext, Panel
from app.views.window.keyboard import Keys
from cpm_core import Contour
from cpm_core.contours import middle
from cpm_core.formats import CONTOURS_READABLE, READABLE, SURFACES_READABLE
from cpm_core.medial_axis import Outlined

_ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)
_DELETE = (Qt.Key.Key_Delete, Qt.Key.Key_Backspace)


class ContoursFeature(Feature):
    """Review of the contours."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        canvas = context.canvas_area.canvas
        self._review = context.workspace.review
        self._layer = canvas.layers.contours
        self.panel = ContourPanel(self._review, self._fill_colors)
        context.preferences.follow(UNIT, self.panel.table.show_items)
        self.name_field = NameField(canvas, tr("Name of the contour"))
        context.session.image_changed.connect(self.name_field.leave)
        Keys(canvas, lambda event: self.take_key(event.key()))
        self.panel.table.zoom_wanted.connect(context.canvas_area.zoom_to_selection)
        canvas.pointed.connect(lambda at: self._review.hover(None) if at is None else None)
        self._review.selection_changed.connect(context.refresh)

    def action_specs(self) -> Sequence[ActionSpec | Submenu]:
        """Table, selection, verdicts, names, colors."""
        return (
            ActionSpec("contour_table", "Contours", tr("&Table of contours"),
                       tr("Show the measures and the review of each contour."),
                       lambda: self.context.areas().enter("contours"), "Ctrl+T"),
            ActionSpec("next_contour", "Contours", tr("Select ne&xt contour"),
                       tr("Select one contour after the other, longest first."), self._select_next, "Shift+N", gap=True,
                       when=self._any),
            ActionSpec("all_contours", "Contours", tr("Select &all contours"), tr("Select all contours."),
                       lambda: self._review.select(item.key for item in self._review.items), "Ctrl+A", when=self._any),
            ActionSpec("other_contours", "Contours", tr("&Invert the selection"),
                       tr("Select all contours that are not selected."), self._invert, "Ctrl+I", when=self._any),
            ActionSpec("keep", "Contours", tr("&Keep"),
                       tr("Keep the selected contours through all sliders and runs; press again to undo."),
                       lambda: self._review.judge("kept"), "K", gap=True, when=self._chosen),
            ActionSpec("reject", "Contours", tr("&Reject"),
                       tr("Exclude the selected contours from exports; press again to undo."),
                       lambda: self._review.judge("rejected"), "X", when=self._chosen),
            ActionSpec("name_contour", "Contours", tr("&Name…"), tr("Give the selected contour a name."), self.ask_name,
                       "F2", when=self._chosen),
            Submenu(name="colors", menu="Contours", text=tr("&Color"), fill=self._fill_colors),
            ActionSpec("forget_verdicts", "Contours", tr("C&lear verdicts, names and colors"),
                       tr("Remove all contour reviews."),
                       lambda: self.context.session.edit(tr("clear verdicts, names and colors"), contours.clear_marks),
                       when=lambda situation: bool(situation.document.marks)),
            ActionSpec("show_rejected", "Contours", tr("&Show rejected contours"),
                       tr("Show rejected contours faint and dashed, or hide them."),
                       lambda: self._layer.choose("rejected", not self._layer.chosen["rejected"]), gap=True,
                       holds=lambda situation: bool(self._layer.chosen["rejected"])),
        )  # fmt: skip

    def panels(self) -> Sequence[Panel]:
        """The table."""
        return (
            Panel(name="contours", title=tr("Contours"), widget=self.panel, area="bottom", tab="below", shown=False,
                  height=160, shortcut="F11"),
        )  # fmt: skip

    def ask_name(self) -> None:
        """Ask for the name of the selected contour, in the table if it has the focus, else on the canvas."""
        chosen = self._review.chosen
        if self.panel.table.hasFocus():
            self.panel.table.name_selected()
        elif chosen:
            key, contour = chosen[0].key, chosen[0].contour
            self.name_field.ask(middle(contour), contour.name, lambda name: self._review.rename(key, name))

    def take_key(self, key: int) -> bool:
        """Name the contour selected on the canvas on Enter, reject it on Delete; return whether the key was handled."""
        if not self._selecting:
            return False
        if key in _ENTER:
            self.ask_name()
        elif key in _DELETE:
            self._review.judge("rejected")
        return key in _ENTER or key in _DELETE

    @property
    def _selecting(self) -> bool:
        tool = self.context.canvas_area.canvas.hold.tool
        return tool is not None and tool.name == "contours" and bool(self._review.selected)

    def _any(self, situation: Situation) -> bool:
        return bool(self._review.items)

    def _chosen(self, situation: Situation) -> bool:
        return bool(self._review.selected)

    def _select_next(self) -> None:
        keys = [item.key for item in self._review.items]
        at = max((keys.index(key) for key in self._review.selected if key in keys), default=-1)
        if keys:
            self._review.select((keys[(at + 1) % len(keys)],))

    def _invert(self) -> None:
        self._review.select({item.key for item in self._review.items} - self._review.selected)

    def _fill_colors(self, menu: QMenu) -> None:
        fill_colors(menu, self.context.window, self._review.paint)
        menu.setEnabled(True)
        for action in menu.actions():
            action.setEnabled(bool(self._review.selected))


class HandEditingFeature(Feature):
    """Close, join, cut and delete contours by menu and keys."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self._editing, self._review = context.workspace.hand_editing, context.workspace.review
        Keys(context.canvas_area.canvas, lambda event: event.key() == Qt.Key.Key_Delete and self.delete_stretch())

    def action_specs(self) -> Sequence[ActionSpec]:
        """Close, join, cut, delete, and remove edits."""
        return (
            ActionSpec("close_contours", "Contours", tr("Clos&e by hand"),
                       tr("Close the selected contour along the edge between its ends; several ones are joined "
                       "first."), lambda: self._editing.join_selected(closing=True), "Shift+C", gap=True,
                       when=self._chosen),
            ActionSpec("join_contours", "Contours", tr("&Join by hand"),
                       tr("Join the selected contours along the edges between their nearest ends."),
                       lambda: self._editing.join_selected(closing=False), "Shift+J",
                       when=lambda situation: len(self._review.selected) > 1),
            ActionSpec("cut_contour", "Contours", tr("C&ut at the mark"),
                       tr("Cut the contour at the place that was clicked last."), self._editing.cut_marked, "Shift+X",
                       when=lambda situation: bool(self._editing.marked)),
            ActionSpec("delete_stretch", "Contours", tr("&Delete between the marks"),
                       tr("Delete the stretch of a contour between two places that were clicked."),
                       self._editing.delete_stretch, "Shift+Delete",
                       when=lambda situation: len(self._editing.marked) == 2),
            ActionSpec("drop_missed_edits", "Contours", tr("Remove edits by hand that no longer a&pply"),
                       tr("Remove edits that do not find their contours, with what they drew."),
                       lambda: self._editing.drop(self._editing.missed),
                       when=lambda situation: bool(self._editing.missed)),
            ActionSpec("drop_hand_edits", "Contours", tr("Remove all edits b&y hand"),
                       tr("Show the contours as the run has found them."), self._editing.drop,
                       when=lambda situation: bool(situation.document.hand_edits)),
        )  # fmt: skip

    def delete_stretch(self) -> bool:
        """Delete the marked stretch; return whether there is one."""
        there = len(self._editing.marked) == 2
        self._editing.delete_stretch()
        return there

    def _chosen(self, situation: Situation) -> bool:
        return any(not item.contour.closed for item in self._review.chosen)


_SPAN = 48.0
"""Minimum side of the part of the image that is shown around a difference [px]."""


class TruthFeature(Feature):
    """Comparison of the contours with a ground truth."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        self.truth = context.workspace.truth
        self.panel = TruthPanel(self.truth, self._load, self._jump)
        self.truth.changed.connect(context.refresh)
        self.truth.compared.connect(context.refresh)

    def action_specs(self) -> Sequence[ActionSpec]:
        """Load, show differences, remove."""
        return (
            ActionSpec("load_truth", "Contours", tr("Compare with ground &truth…"),
                       tr("Load a mask or contours as ground truth, and measure the agreement."), self._load,
                       "Ctrl+Shift+T", gap=True, when=has_image),
            ActionSpec("worst_place", "Contours", tr("Sho&w largest difference"),
                       tr("Show where contours and ground truth are farthest apart."), self.panel.jump_to_worst,
                       when=self._differs),
            ActionSpec("next_place", "Contours", tr("Show next differen&ce"),
                       tr("Show the next difference between contours and ground truth."), self.panel.jump_to_next,
                       "Shift+W", when=self._differs),
            ActionSpec("forget_truth", "Contours", tr("Remo&ve ground truth"), tr("Remove the ground truth."),
                       self.truth.forget, when=lambda situation: self.truth.truth is not None),
        )  # fmt: skip

    def panels(self) -> Sequence[Panel]:
        """The measures."""
        return (
            Panel(name="truth", title=tr("Ground truth"), widget=self.panel, tab="settings", shown=False,
                  shortcut="F12"),
        )  # fmt: skip

    def close(self) -> bool:
        """Stop the thread of comparisons."""
        self.truth.close()
        return True

    def _differs(self, situation: Situation) -> bool:
        return self.truth.verified is not None and bool(self.truth.verified.differences)

    def _load(self) -> None:
        self.context.reveal("truth")
        kinds = (
            (Files(tr("Label volumes and surfaces"), (*READABLE, *SURFACES_READABLE)), all_files())
            if self.truth.in_volume
            else (
                Files(tr("Masks and contours"), tuple(dict.fromkeys((*READABLE, *CONTOURS_READABLE)))),
                Files(tr("Masks"), tuple(READABLE)),
                Files(tr("Contours"), tuple(CONTOURS_READABLE)),
                all_files(),
            )
        )
        chosen = self.context.files.ask_for_file("truth", tr("Compare with ground truth"), kinds)
        if chosen is not None:
            self.truth.load(str(chosen))

    def _jump(self, difference: Difference) -> None:
        slices = self.context.workspace.slices
        slices.through(difference.place)
        points = difference.points if slices.now is None else slices.now.current.flattened(difference.points)
        low, high = points.min(axis=0), points.max(axis=0)
        span = max(_SPAN, 1.4 * float((high - low).max()))
        row, col = (0.5 * (low + high)).tolist()
        if slices.now is not None:
            row, col = slices.now.current.within(difference.place)
        self.context.canvas_area.canvas.look_at((row, col), span)


class SkeletonsFeature(Feature):
    """What has a skeleton: objects, closed contours, or the image."""

    def action_specs(self) -> Sequence[ActionSpec]:
        """One action each."""
        return (
            ActionSpec("object_skeleton", "Objects", tr("S&keleton of the objects"),
                       tr("Find the center lines of the chosen objects and how thick they are."), self._of_objects,
                       icon="mode_skeleton", gap=True,
                       when=lambda situation: bool(self.context.workspace.object_list.chosen)),
            ActionSpec("contour_skeleton", "Contours", tr("S&keleton of closed contours"),
                       tr("Find the center lines inside the selected closed contours, or inside all of them."),
                       self._of_contours, icon="mode_skeleton", gap=True, when=lambda _: bool(self._closed())),
            ActionSpec("image_skeleton", "Run", tr("Skeleton of the &whole image"),
                       tr("Find center lines in the image again, not only in objects or closed contours."),
                       self._of_image, when=_is_outlined),
        )  # fmt: skip

    def _of_objects(self) -> None:
        chosen = sorted(self.context.workspace.object_list.chosen)
        self._find(tr("skeleton of objects"), Outlined(objects=tuple(chosen)))

    def _of_contours(self) -> None:
        lines = tuple(tuple((float(row), float(col)) for row, col in contour.points) for contour in self._closed())
        self._find(tr("skeleton of contours"), Outlined(contours=lines))

    def _of_image(self) -> None:
        self._find(tr("skeleton of the image"), Outlined())

    def _find(self, name: str, outlined: Outlined) -> None:
        session = self.context.session
        session.edit(name, lambda document: use_skeleton(document, outlined))
        if session.status.phase != "running":
            session.run()

    def _closed(self) -> list[Contour]:
        """The closed ones of the selected contours, or of all that have not been rejected if none is selected."""
        review = self.context.workspace.review
        items = review.chosen or [item for item in review.items if not item.reviewed.rejected]
        return [item.contour for item in items if item.contour.closed]


def _is_outlined(situation: Situation) -> bool:
    return bool(situation.document.outlines or situation.document.outlined_surfaces)
