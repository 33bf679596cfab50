"""The canvas with the line below it; it follows the session."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QEvent, QObject, QPoint, QPointF, Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QGridLayout, QVBoxLayout, QWidget

from cpm_app.model.display.display_image import DisplayImage, measure_area_share
from cpm_app.model.document import edits
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import localize_number, tr, translate_core_text
from cpm_app.session.exchange.messages import OverlayData
from cpm_app.session.features.comparison import CURRENT_KEY
from cpm_app.session.features.outcome import describe_outcome
from cpm_app.session.features.workspace import Workspace
from cpm_app.session.session_messages import EDITING_CATEGORY, OPENING_CATEGORY, PROGRAM_CATEGORIES
from cpm_app.session.worker.prepared_methods import AREA_OVERLAY
from cpm_app.views.canvas.canvas import Canvas, ToolDispatcher
from cpm_app.views.canvas.crosshair import Crosshair
from cpm_app.views.canvas.flow import ParticleFlow
from cpm_app.views.canvas.image_view import ImageView
from cpm_app.views.canvas.legend import CanvasStrip
from cpm_app.views.canvas.selected_places import rectangle_around, selected_places
from cpm_app.views.layers.image_layer import LevelDrag
from cpm_app.views.tools import TOOLS
from cpm_app.views.tools.select import SelectTool
from cpm_app.views.widgets.containers import ENTER_KEYS, OfferBar, fill_layout
from cpm_core.numerics import Place
from cpm_core.shapes import Charge

_WIDE_AREA_TEXT = tr(
    "No edge encloses this start: its area is {percent} of the image. Start inside an object, or limit the run by a "
    "region of interest ({key:region})."
)
"""Sentence on an area of a start that covers most of the image."""

_OTHER_VALUES_TEXT = tr(
    "This step was computed with other values than the sliders show; the button next to its number sets them."
)
"""Sentence on a step that was computed with other parameters than those of the document."""

_TYPING_TEXT = tr("Enter keeps what is typed, {key:escape} restores what was there.")
"""Sentence on the keys of a field, while on the image Enter would accept something."""

FIRST_TOOL = "circle"
"""Tool in use when the window opens."""

_ARROW_DIRECTIONS = {
    Qt.Key.Key_Up: (-1.0, 0.0),
    Qt.Key.Key_Down: (1.0, 0.0),
    Qt.Key.Key_Left: (0.0, -1.0),
    Qt.Key.Key_Right: (0.0, 1.0),
}
"""Directions (down, right) of the arrow keys."""

_RESIZE_KEYS = {Qt.Key.Key_BracketLeft: -1.0, Qt.Key.Key_BracketRight: 1.0}
"""Keys that make the selected shape or the tool smaller and larger."""

_PAN_STEP = 40.0
"""Distance that one press of an arrow key pans [px of the screen]."""

_WIDE_AREA_SHARE = 0.5
"""Share of the image above which the area of a start is said to cover most of it."""


class CanvasArea(QWidget):
    """Shows the scene of a session on the canvas, and lets the tools edit its document and select."""

    tool_changed = Signal()
    """Another tool is in use."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._workspace = workspace
        self._session = session = workspace.session
        self._selection = workspace.object_selection
        self.canvas, self.flow = Canvas(session), ParticleFlow(session, self)
        self.strip = CanvasStrip(self.canvas.layers.collect_legend_entries)
        self.messages, self.hint = self.strip.messages, self.strip.hint
        self.offers, self.controls, self.views = OfferBar(), QVBoxLayout(), QGridLayout()
        """Bar above the canvas, bars below it, and views next to it; features add their contents."""
        self.views.setSpacing(2)
        self.views.addWidget(self.canvas, 0, 0)
        column = fill_layout(QVBoxLayout(self), self.offers, self.views, self.controls, self.strip, spacing=0)
        column.setStretchFactor(self.views, 1)
        self.crosshair = Crosshair(self.canvas, self.update_hint)
        tool_arguments = workspace, self.canvas.layers.drawing, self.update_hint
        self._tools = {kind.name: kind(*tool_arguments) for kind in TOOLS}
        self._select_tool = SelectTool(*tool_arguments)
        self.canvas.dispatcher = ToolDispatcher(self._tools[FIRST_TOOL], self._select_tool)
        self._is_typing = self._has_offers = False
        self._was_running = self._tells_outcome = False
        self._area: OverlayData | None = None
        self.canvas.installEventFilter(self)
        self.level_drag = LevelDrag(self.canvas.layers.image, self.canvas.viewport())
        self.use_tool(FIRST_TOOL)
        session.messages.shown.connect(self.messages.show_message)
        session.messages.cleared.connect(self.messages.clear_category)
        session.image_changed.connect(lambda: self.messages.keep_categories(OPENING_CATEGORY, *PROGRAM_CATEGORIES))

        for layer in self.canvas.layers:
            layer.changed.connect(self.strip.legend.schedule_update)
        session.store.status_changed.connect(self.update_hint)
        self.flow.changed.connect(self._draw_scene)
        self._selection.changed.connect(self._on_proposals_changed)
        workspace.navigation.changed.connect(self._on_step_changed)
        workspace.object_list.selection_changed.connect(self.update_hint)
        self._draw_scene()

    def use_tool(self, name: str) -> None:
        """Change the tool, and give the keyboard to the canvas.

        A drawing tool deselects the shape, whose handles would be in the way.
        """
        changed = self.canvas.dispatcher.tool.name != name
        self.canvas.use_tool(self._tools[name])
        if name != "select":
            self._session.select_shape(None)
        if changed:
            self.crosshair.hide_crosshair()
            self.messages.clear_category(EDITING_CATEGORY)
        self.canvas.setFocus()
        self._tells_outcome = False
        self.update_hint()
        if changed:
            self.tool_changed.emit()

    def menu_at(self, point: QPoint | None) -> tuple[str, QPoint]:
        """Select the item at a point or at the cross-hair, and name the selection; see `MenuOwner`."""
        keyed, view = self.crosshair.position, self.canvas
        if point is not None:
            found = self.childAt(point)
            while found is not None and not isinstance(found, ImageView):
                found = found.parentWidget()
            view = found or view
            point_in_view = QPointF(view.mapFrom(self, point))
        elif keyed is not None:
            point_in_view = view.map_from_image(keyed)
        else:
            return self._selected_kind, self.rect().center()
        position, kind = view.map_to_image(point_in_view), self._selected_kind
        if not self._selection.selecting:
            self.canvas.dispatcher.find_receiver(view, position)
            kind = self._selected_kind if self._select_tool.select_item_at(view.place_at(position)) else "image"
        return kind, view.mapTo(self, point_in_view.toPoint())

    @property
    def _selected_kind(self) -> str:
        """Kind of the selection: "charge", "shape", "object" or "image"."""
        shapes, selected = self._session.document.shapes, self._session.selected_shape
        if selected is not None and selected < len(shapes):
            return "charge" if isinstance(shapes[selected], Charge) else "shape"
        return "object" if self._workspace.object_list.selected_keys or self._selection.selecting else "image"

    def cancel_or_deselect(self) -> None:
        """Cancel the draft or hide the cross-hair; otherwise dismiss the message and deselect everything."""
        if self.canvas.dispatcher.is_gesturing:
            self.canvas.dispatcher.cancel_gesture()
        elif self.crosshair.position is not None:
            self.crosshair.hide_crosshair()
        elif self._workspace.comparison.selected:
            self._workspace.comparison.select_row(CURRENT_KEY)
        else:
            self.messages.dismiss_message()
            self._session.select_shape(None)
            self._workspace.contour_selection.select()

    def press_enter(self, waits: bool = True) -> bool:
        """Finish the draft, or accept what is proposed or selected; return whether there was anything.

        If it `waits`, what is being found is accepted, too.
        """
        tool = self.canvas.dispatcher.tool
        if tool.has_draft:
            tool.finish()
        elif self._workspace.object_commands.can_accept or (
            self._selection.can_accept and (waits or self._selection.selecting)
        ):
            self._selection.accept()
        else:
            return False
        return True

    def set_typing(self, is_typing: bool) -> None:
        """Set whether the keyboard is in a field, which keeps Enter."""
        if is_typing != self._is_typing:
            self._is_typing = is_typing
            self.update_hint()

    def update_hint(self) -> None:
        """Show below the canvas what was found and what to do next.

        The end of a run speaks before the tool, until another one is chosen; gestures and selections speak first.
        """
        session, tool = self._session, self.canvas.dispatcher.tool
        status, text = session.status, session.resolved.hint
        running = status.phase == "running"
        self._tells_outcome = not running and (self._tells_outcome or self._was_running)
        self._was_running = running
        share = measure_area_share(self._area) if isinstance(self._area, DisplayImage) else 0.0
        if status.phase == "ready" and share > _WIDE_AREA_SHARE:
            text = insert_keys(_WIDE_AREA_TEXT, percent=localize_number(f"{100.0 * share:.0f} %"))
        chosen = self._workspace.object_list.selected_numbers or session.scene.selected_contours
        if session.document.image is not None:
            found = (text if status.stale or status.steered else "") or describe_outcome(self._workspace)
            if status.phase == "paused" and self._workspace.navigation.differing_parameters is not None:
                found = _OTHER_VALUES_TEXT
            engaged = self.canvas.dispatcher.is_gesturing or chosen or session.scene.objects.awaited
            first, then = (found, tool.advice) if self._tells_outcome and not engaged else (tool.advice, found)
            text = self.crosshair.advice or first or then or text
            if self._is_typing and self._selection.can_accept:
                text = insert_keys(_TYPING_TEXT)
            if self._selection.has_waiting_keys:
                text = f"{tr('What you pressed waits for the answer.')} {text}"
        self.strip.show_hint(text)

    def zoom_to_selection(self) -> None:
        """Zoom to the selection; in a volume, in the slices through its middle."""
        places = selected_places(self._workspace)
        if places:
            self.canvas.show_part(rectangle_around(np.concatenate(places), self.canvas, self._workspace.slices))

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Handle the keys of the draft and of the selection, including some that are shortcuts of the window."""
        if isinstance(event, QKeyEvent) and event.type() == QEvent.Type.ShortcutOverride:
            key, tool = event.key(), self.canvas.dispatcher.tool
            sized = tool.is_resizable or self._session.selected_shape is not None
            if (key in _RESIZE_KEYS and sized) or (key == Qt.Key.Key_Backspace and tool.has_draft):
                event.accept()
                return True
        if isinstance(event, QKeyEvent) and event.type() == QEvent.Type.KeyPress and self._handle_key(event):
            return True
        return super().eventFilter(watched, event)

    def _on_proposals_changed(self) -> None:
        """Hide the cross-hair once a run offers objects, so that Enter accepts them, unless it is drawing."""
        had, self._has_offers = self._has_offers, any(each.key for each in self._selection.proposals)
        if self._has_offers and not had and not self.canvas.dispatcher.is_gesturing:
            self.crosshair.hide_crosshair()
        self.update_hint()

    def _on_step_changed(self) -> None:
        """Update the hint for another step of the timeline; during a run the status does."""
        if self._session.status.phase != "running":
            self.update_hint()

    def _draw_scene(self) -> None:
        area = self._session.scene.overlays.get(AREA_OVERLAY)
        if area is not self._area:
            self._area = area
            self.update_hint()
        self.canvas.draw_scene(self.flow.scene)
        self.strip.legend.schedule_update()

    def _handle_key(self, event: QKeyEvent) -> bool:
        key, held, index = Qt.Key(event.key()), event.modifiers(), self._session.selected_shape
        tool, keyed, objects = (
            self.canvas.dispatcher.tool,
            self.crosshair.position is not None,
            self._workspace.object_list,
        )
        if key == Qt.Key.Key_Backspace and tool.has_draft:
            tool.remove_last_part()
        elif key in ENTER_KEYS:
            if keyed and tool.has_draft and held & Qt.KeyboardModifier.ControlModifier:
                tool.finish()
            elif keyed or not (self.press_enter() or objects.selected_keys):  # selected objects are accepted already
                self.messages.clear_category(EDITING_CATEGORY)  # which would hide the keys of the cross-hair
                self.canvas.dispatcher.set_modifiers(held)
                (self.crosshair.press_enter if keyed else self.crosshair.show_crosshair)()
        elif key in _ARROW_DIRECTIONS:
            factor = 10.0 if held & Qt.KeyboardModifier.ShiftModifier else 1.0
            row, col = _ARROW_DIRECTIONS[key]
            by: Place = self.canvas.image_displacement(factor * row, factor * col)
            if keyed:
                self.crosshair.move_by(*by)
            elif index is None:
                self.canvas.pan_by(_PAN_STEP * col, _PAN_STEP * row)
            else:
                slices = self._session.scene.slices
                by = by if slices is None else slices.current.lift_offset(by)
                name = tr("move {shape}", shape=translate_core_text(self._session.document.shapes[index].title))
                self._session.edit(name, lambda document: edits.move_shape(document, index, by), f"nudge {index}")
        elif key in _RESIZE_KEYS and (index is not None or tool.is_resizable):
            self.resize_selection(_RESIZE_KEYS[key])
        else:
            return False
        return True

    def resize_selection(self, by: float) -> None:
        """Enlarge the selected shape, or the size of the tool; negative values of `by` make it smaller."""
        index = self._session.selected_shape
        if index is None:
            self.canvas.dispatcher.tool.resize_by(by)
            return
        shape = self._session.document.shapes[index]
        verb = tr("resize {shape}") if shape.outline.size else tr("change {shape}")
        name, resized = verb.format(shape=translate_core_text(shape.title)), shape.resized_by(by)
        self._session.edit(name, lambda document: edits.replace_shape(document, index, resized), f"grow {index}")
