"""The brush that paints objects by hand."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import Qt

from app.model.text.language import tr
from app.session.features.object_list import ObjectBrush
from app.views.canvas.tools.ringed import RingTool
from app.views.canvas.tools.tool import TAKING_AWAY, ToolContext
from app.views.theme import theme
from cpm_core.numerics.types import Place, Position
from cpm_core.objects.segmented.segmented_object import SegmentedObjects


class BrushTool(RingTool):
    """Adds what the ring goes over to an object; with Shift takes it away."""

    name = "brush"
    tip = tr("Drag to paint an object, Shift-drag to erase it; < and > change the brush.")
    color: str = theme.RESTING
    guidance = tr("Drag from an object to add to it, Shift-drag to erase it, elsewhere for a new one; < and > resize.")
    by_keys = tr("Enter begins to paint, Shift+Enter to erase, arrow keys continue, Enter ends; < and > resize.")

    def __init__(self, context: ToolContext) -> None:
        super().__init__(context)
        self._brush = ObjectBrush(context.session, context.object_list)
        self._adds = True
        self._objects: SegmentedObjects | None = None

    def bend(self, modifiers: Qt.KeyboardModifier) -> None:
        """With Shift, the next stroke takes away."""
        if self._brush.painting:
            return
        self._adds = not modifiers & TAKING_AWAY
        self.color = theme.RESTING if self._adds else theme.BARRIER
        if self._at is not None:
            self.hover(self._at)

    def press(self, at: Place, reach: float) -> None:
        """Begin a stroke."""
        self._begin()
        self.used = True
        self._objects = self._session.document.objects
        self.hover(at)
        self._brush.begin(_flat(at), self.radius, self._adds, self._gesture)

    def drag(self, at: Place) -> None:
        """Paint on."""
        self.hover(at)
        self._brush.paint(_flat(at))

    def release(self) -> None:
        """End the stroke."""
        self._brush.end()
        self._objects = None
        super().release()

    def cancel(self) -> None:
        """Restore the objects from before the stroke."""
        before = self._objects
        if self._brush.painting and before is not None:
            self._session.edit("", lambda document: replace(document, objects=before), self._gesture)
        self.release()


def _flat(at: Place) -> Position:
    row, col = at[-2:]
    return row, col
