"""The canvas: the image with everything that is drawn over it, and the pointer's way into the tools."""

from __future__ import annotations

import pyqtgraph as pg
from PySide6.QtCore import QEvent, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QResizeEvent, QWheelEvent

from app.model.text.language import tr
from app.session.session import Session
from app.views.canvas.coordinates import image_rectangle, to_position
from app.views.canvas.layers import Layers
from app.views.canvas.tools.tool import Grip, Tool
from app.views.theme import theme
from cpm_core.image.image import Image
from cpm_core.numerics.types import Position

REACH = 8.0
"""How far off a line or handle the pointer still takes hold of it [px of the screen]."""

ZOOM = 1.2
_MARGIN = 0.04


class Canvas(pg.GraphicsView):  # type: ignore[misc]  # pyqtgraph has no type hints
    """Shows the layers, pans and zooms, and hands the left button to the tool in use.

    Parameters
    ----------
    session : Session
        What the layers follow.
    """

    pointed = Signal(object)
    """Position (row, col) under the pointer, or None when it has left."""

    taken = Signal()
    """A button of the pointer has been pressed."""

    def __init__(self, session: Session) -> None:
        super().__init__(background=theme.CANVAS)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAcceptDrops(False)
        self.setMinimumSize(320, 240)
        self.setAccessibleName(tr("Image"))
        self.view = pg.ViewBox(enableMenu=False, invertY=True, lockAspect=True, enableMouse=False, defaultPadding=0.0)
        self.view.disableAutoRange()
        self.setCentralItem(self.view)
        self.layers = Layers(self.view, session)
        self.tool: Tool | None = None
        self.grip: Grip | None = None
        self.led_by_keys = False
        self._dragged: Tool | None = None
        self._pointer: Position | None = None
        self._shape: tuple[int, ...] | None = None
        self._panned_from: QPointF | None = None
        self._fitted = True
        session.image_changed.connect(lambda image, _: self._use_image(image))

    @property
    def gesturing(self) -> bool:
        """Whether a tool is in the middle of something."""
        return self._dragged is not None or (self.tool is not None and self.tool.drafting)

    @property
    def dragging(self) -> bool:
        """Whether the button is down for a tool."""
        return self._dragged is not None

    @property
    def shape(self) -> tuple[int, ...] | None:
        """Shape of the image; None while there is none."""
        return self._shape

    def fit(self) -> None:
        """Show the whole image."""
        if self._shape is not None:
            self.view.setRange(image_rectangle(self._shape), padding=_MARGIN)
            self._fitted = True

    def zoom(self, factor: float, around: QPointF | None = None) -> None:
        """Enlarge by `factor` around a point of the widget, its middle unless given."""
        point = around if around is not None else QPointF(self.rect().center())
        self.view.scaleBy(
            (1.0 / factor, 1.0 / factor), center=self.view.mapSceneToView(self.mapToScene(point.toPoint()))
        )
        self._fitted = False

    def pan(self, right: float, down: float) -> None:
        """Move what is seen by pixels of the screen."""
        width, height = self.view.viewPixelSize()
        self.view.translateBy(x=right * width, y=down * height)
        self._fitted = False

    def look_at(self, place: Position, span: float) -> None:
        """Show a square of `span` px of the image around a place (row, col)."""
        self.view.setRange(QRectF(place[1] - span / 2, place[0] - span / 2, span, span), padding=0.0)
        self._fitted = False

    def view_state(self) -> dict[str, object]:
        """What a session file keeps of where one looks: nothing while the whole image is in sight."""
        if self._fitted:
            return {}
        seen = self.view.viewRect()
        return {"center": [seen.center().y(), seen.center().x()], "rows": seen.height()}

    def use_view_state(self, state: dict[str, object]) -> None:
        """Look where a session file says; where it says nothing, or nonsense, at the whole image."""
        self.fit()
        center, rows = state.get("center"), state.get("rows")
        if not isinstance(center, list) or not isinstance(rows, int | float) or not 0.01 <= rows <= 1e6:
            return
        if len(center) == 2 and all(isinstance(place, int | float) and abs(place) <= 1e6 for place in center):
            seen = self.view.viewRect()
            cols = rows * seen.width() / seen.height()
            self.view.setRange(QRectF(center[1] - 0.5 * cols, center[0] - 0.5 * rows, cols, rows), padding=0.0)
            self._fitted = False

    def position(self, point: QPointF) -> Position:
        """Position (row, col) under a point of the widget."""
        return to_position(self.view.mapSceneToView(self.mapToScene(point.toPoint())))

    def point(self, position: Position) -> QPointF:
        """Point of the widget over a position (row, col)."""
        return QPointF(self.mapFromScene(self.view.mapViewToScene(QPointF(position[1], position[0]))))

    def cancel(self) -> None:
        """Give up what a tool is in the middle of."""
        tool = self._dragged or (self.tool if self.gesturing else None)
        self._dragged = None
        if tool is not None:
            tool.cancel()

    def use(self, tool: Tool) -> None:
        """Hand the left button to another tool."""
        self.cancel()
        if self.tool is not None:
            self.tool.put_away()
        self.tool = tool
        if self._pointer is not None:
            tool.hover(self._pointer)
        self.viewport().setCursor(tool.cursor((-1e9, -1e9), 0.0))

    # What pointer and keys do alike

    def press_at(self, at: Position, reach: float | None = None) -> None:
        """The left button goes down over a position; `reach` is how far off still counts [px of the image]."""
        if self.tool is not None and self._shape is not None:
            self._dragged = self._tool_at(at)
            self._dragged.press(at, self._reach() if reach is None else reach)

    def lead_to(self, at: Position) -> None:
        """The pointer has come to a position."""
        self._pointer = at
        if self._dragged is not None:
            self._dragged.drag(at)
        elif self.tool is not None:
            self.tool.hover(at)
            self.viewport().setCursor(self._tool_at(at).cursor(at, self._reach()))
        self.pointed.emit(at)

    def let_go(self) -> None:
        """The left button comes up."""
        if self._dragged is not None:
            tool, self._dragged = self._dragged, None
            tool.release()

    def bend(self, modifiers: Qt.KeyboardModifier) -> None:
        """Keys are held that may bend what is drawn to a rule."""
        tool = self._dragged or self.tool
        if tool is not None:
            tool.bend(modifiers)

    def leave(self) -> None:
        """Nothing lies under the pointer any more."""
        self._pointer = None
        if self.tool is not None:
            self.tool.put_away()
        self.pointed.emit(None)

    def grips(self, at: Position) -> bool:
        """Whether a handle lies at a position that comes before the tool in use."""
        return self._tool_at(at) is not self.tool

    # What Qt calls

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Begin a gesture or a pan."""
        event.accept()
        self.taken.emit()
        if event.button() == Qt.MouseButton.LeftButton:
            self.bend(event.modifiers())
            self.press_at(self.position(event.position()))
        elif event.button() in (Qt.MouseButton.MiddleButton, Qt.MouseButton.RightButton):
            self._panned_from = event.position()
            self.viewport().setCursor(Qt.CursorShape.ClosedHandCursor)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Go on with it, or tell what is under the pointer."""
        event.accept()
        at = self.position(event.position())
        if self._panned_from is not None:
            moved = self._panned_from - event.position()
            self._panned_from = event.position()
            self.pan(moved.x(), moved.y())
            self.pointed.emit(at)
        elif not self.led_by_keys:
            self.bend(event.modifiers())
            self.lead_to(at)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End it."""
        event.accept()
        if event.button() == Qt.MouseButton.LeftButton and self._dragged is not None:
            self.let_go()
        elif self._panned_from is not None:
            self._panned_from = None
            if self.tool is not None:
                at = self.position(event.position())
                self.viewport().setCursor(self._tool_at(at).cursor(at, self._reach()))

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """A second click is a click like any other."""
        self.mousePressEvent(event)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom around the pointer."""
        event.accept()
        self.zoom(ZOOM ** (event.angleDelta().y() / 120.0), event.position())

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Keys are left to whoever listens."""
        event.ignore()

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        """Not ours."""
        event.ignore()

    def leaveEvent(self, event: QEvent) -> None:
        """Tell that the pointer is gone."""
        if not self.led_by_keys:
            self.leave()
        super().leaveEvent(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """A drag does not outlive the focus."""
        if self._dragged is not None and event.reason() == Qt.FocusReason.ActiveWindowFocusReason:
            self.cancel()
        super().focusOutEvent(event)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Keep the whole image in sight for as long as the user has not zoomed."""
        super().resizeEvent(event)
        if getattr(self, "_fitted", False):
            self.fit()

    def _use_image(self, image: Image) -> None:
        self.cancel()
        self._shape = image.shape
        self.fit()

    def _tool_at(self, at: Position) -> Tool:
        """The tool that a press would go to: what takes hold of a handle comes before the tool in use."""
        assert self.tool is not None
        if self.grip is not None and not self.tool.drafting and self.grip.grips(at, self._reach()):
            return self.grip
        return self.tool

    def _reach(self) -> float:
        return REACH * float(self.view.viewPixelSize()[0])
