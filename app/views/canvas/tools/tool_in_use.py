"""The tool in use, with which the pointer works in every view of the image or of the slices of a volume."""

from __future__ import annotations

from typing import Protocol

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QWidget

from app.model.volume.slices import Slice
from app.views.canvas.tools.tool import Tool
from cpm_core.numerics.types import Place, Position


class Surface(Protocol):
    """A view in which a tool works."""

    @property
    def here(self) -> Slice | None:
        """The slice that it shows; None for an image."""

    def placed(self, position: Position) -> Place:
        """Place in the image, or in the volume, of a position in what is shown."""

    def reach(self) -> float:
        """Distance at which the pointer takes hold of something [px of the image]."""

    def viewport(self) -> QWidget:
        """What shows the cursor."""


class ToolInUse:
    """Passes what the pointer does to the tool in use, or to `grip`, which moves handles of what is selected."""

    def __init__(self) -> None:
        self.tool: Tool | None = None
        self.grip: Tool | None = None
        self._dragged: Tool | None = None

    @property
    def gesturing(self) -> bool:
        """Whether a tool has an unfinished gesture or draft."""
        return self._dragged is not None or (self.tool is not None and self.tool.drafting)

    @property
    def dragging(self) -> bool:
        """Whether the button is down for a tool."""
        return self._dragged is not None

    def cancel(self) -> None:
        """Cancel the gesture or draft of the tool."""
        tool = self._dragged or (self.tool if self.gesturing else None)
        self._dragged = None
        if tool is not None:
            tool.cancel()

    def take(self, tool: Tool) -> None:
        """Use another tool."""
        if self.dragging or not (self.tool is not None and self.tool.lasting):
            self.cancel()
        if self.tool is not None:
            self.tool.put_away()
            self.tool.set_in_use(False)
        self.tool = tool
        tool.set_in_use(True)

    def press(self, view: Surface, at: Position, reach: float | None = None) -> None:
        """Press the left button over a position; `reach` is the tolerance for hits [px of the image]."""
        if self.tool is not None:
            self._dragged = self.at(view, at)
            self._dragged.press(view.placed(at), view.reach() if reach is None else reach)

    def move(self, view: Surface, at: Position) -> None:
        """Move the pointer to a position."""
        if self._dragged is not None:
            self._dragged.here = view.here
            self._dragged.drag(view.placed(at))
        elif self.tool is not None:
            self.tool.here = view.here
            self.tool.hover(view.placed(at))
            self.show_cursor(view, at)

    def let_go(self) -> None:
        """Release the left button."""
        if self._dragged is not None:
            tool, self._dragged = self._dragged, None
            tool.release()

    def bend(self, modifiers: Qt.KeyboardModifier) -> None:
        """Pass the modifier keys that are held to the tool; they may constrain the shape."""
        tool = self._dragged or self.tool
        if tool is not None:
            tool.bend(modifiers)

    def leave(self) -> None:
        """Take the pointer off the view."""
        if self.tool is not None:
            self.tool.put_away()

    def at(self, view: Surface, at: Position) -> Tool:
        """The tool that receives a press: one that takes hold of a handle has priority over the tool in use."""
        assert self.tool is not None
        self.tool.here = view.here
        if self.grip is not None and not self.tool.drafting:
            self.grip.here = view.here
            if self.grip.grips(view.placed(at), view.reach()):
                return self.grip
        return self.tool

    def show_cursor(self, view: Surface, at: Position) -> None:
        """Show what a press at a position would do."""
        if self.tool is not None:
            view.viewport().setCursor(self.at(view, at).cursor(view.placed(at), view.reach()))
