"""The contours: their table, their review, and their selection on the canvas."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QMenu

from app.model.document import contours
from app.model.preferences.table import UNIT
from app.model.state.situation import Situation
from app.model.text.language import tr
from app.views.canvas.naming import NameField
from app.views.panels.contour_table import ContourPanel
from app.views.theme.contour_colors import fill_colors
from app.views.widgets.action_spec import STATE, ActionSpec, Submenu
from app.views.window.feature import Feature, FeatureContext, Panel
from cpm_core.contours.review import middle

_ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)
_DELETE = (Qt.Key.Key_Delete, Qt.Key.Key_Backspace)


class ContoursFeature(Feature):
    """Review of the contours."""

    def __init__(self, context: FeatureContext) -> None:
        super().__init__(context)
        session, canvas = context.session, context.canvas_area.canvas
        self._review = context.workspace.review
        self._layer = canvas.layers.contours
        self.panel = ContourPanel(session, self._review, self._fill_colors)
        context.preferences.follow(UNIT, self.panel.table.show_items)
        self.name_field = NameField(canvas, tr("Name of the contour"))
        context.session.image_changed.connect(self.name_field.leave)
        self._keys = _CanvasKeys(self)
        canvas.installEventFilter(self._keys)
        self.panel.table.zoom_wanted.connect(context.canvas_area.zoom_to_selection)
        canvas.pointed.connect(lambda at: self._review.hover(None) if at is None else None)
        self._review.selection_changed.connect(context.refresh)
        self.panel.buttons["keep"].clicked.connect(lambda: self._review.judge("kept"))
        self.panel.buttons["reject"].clicked.connect(lambda: self._review.judge("rejected"))
        self.panel.buttons["name"].clicked.connect(self.panel.table.name_selected)

    def action_specs(self) -> Sequence[ActionSpec | Submenu]:
        """Table, selection, verdicts, names, colors."""
        return (
            ActionSpec(name="contour_table", menu="Contours", text=tr("&Table of contours"),
                       do=lambda: self.context.areas().enter("contours"), shortcuts=("Ctrl+T",),
                       tip=tr("Show the measures and the review of each contour.")),
            ActionSpec(name="next_contour", menu="Contours", text=tr("Select ne&xt contour"), do=self._select_next,
                       shortcuts=("Shift+N",), tip=tr("Select one contour after the other, longest first."), gap=True,
                       when=self._any),
            ActionSpec(name="all_contours", menu="Contours", text=tr("Select &all contours"),
                       do=lambda: self._review.select(item.key for item in self._review.items), shortcuts=("Ctrl+A",),
                       tip=tr("Select all contours."), when=self._any),
            ActionSpec(name="other_contours", menu="Contours", text=tr("&Invert the selection"), do=self._invert,
                       shortcuts=("Ctrl+I",), tip=tr("Select all contours that are not selected."),
                       when=self._any),
            ActionSpec(name="keep", menu="Contours", text=tr("&Keep"), do=lambda: self._review.judge("kept"),
                       shortcuts=("K",), gap=True, when=self._chosen,
                       tip=tr("Keep the selected contours through all sliders and runs; press again to undo.")),
            ActionSpec(name="reject", menu="Contours", text=tr("&Reject"), do=lambda: self._review.judge("rejected"),
                       shortcuts=("X",), tip=tr("Exclude the selected contours from exports; press again to undo."),
                       when=self._chosen),
            ActionSpec(name="name_contour", menu="Contours", text=tr("&Name…"), do=self.ask_name, shortcuts=("F2",),
                       tip=tr("Give the selected contour a name."), when=self._chosen),
            Submenu(name="colors", menu="Contours", text=tr("&Color"), fill=self._fill_colors),
            ActionSpec(
                name="forget_verdicts",
                menu="Contours",
                text=tr("C&lear verdicts, names and colors"),
                do=lambda: self.context.session.edit(tr("clear verdicts, names and colors"), contours.clear_marks),
                tip=tr("Remove all contour reviews."),
                when=lambda situation: bool(situation.document.marks),
            ),
            ActionSpec(name="show_rejected", menu="Contours", text=tr("&Show rejected contours"),
                       do=lambda: self._layer.choose("rejected", not self._layer.chosen["rejected"]),
                       tip=tr("Show rejected contours faint and dashed, or hide them."), group=STATE, checked=True,
                       gap=True, holds=lambda situation: bool(self._layer.chosen["rejected"])),
        )  # fmt: skip

    def panels(self) -> Sequence[Panel]:
        """The table."""
        return (
            Panel(name="contours", title=tr("Contours"), widget=self.panel, area="bottom", tab="below", shown=False,
                  height=250, shortcut="F11"),
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
        tool = self.context.canvas_area.canvas.tool
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


class _CanvasKeys(QObject):
    """Keys of the canvas that act on contours."""

    def __init__(self, feature: ContoursFeature) -> None:
        super().__init__(feature.context.window)
        self._feature = feature

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Handle these keys while contours are selected."""
        if event.type() == QEvent.Type.KeyPress and isinstance(event, QKeyEvent):
            return self._feature.take_key(event.key())
        return False
