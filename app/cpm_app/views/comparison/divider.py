"""Divider on the canvas, with one result on its left and another one on its right."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QLabel, QWidget

from cpm_app.model.text.language import tr
from cpm_app.session.scene import Scene
from cpm_app.views.canvas.image_view import ImageView
from cpm_app.views.theme import theme
from cpm_app.views.widgets.containers import claim_key, mark_own_escape

_GRAB_HALF_WIDTH = 9
"""Half the width in which the divider can be grabbed [px]."""

_GRIP_RADIUS = 15.0
"""Radius of the grip [px]."""

_KEY_STEP = 0.05
"""Fraction of the width by which an arrow key moves the divider."""

_FINE_KEY_STEP = 0.005
"""Fraction of the width by which an arrow key with Shift moves the divider."""

_NAME_TOP_OFFSET = 10
"""Distance of the names from the upper edge of the canvas [px]."""

_NAME_SIDE_OFFSET = 14
"""Distance of the names from the divider [px]."""


class Wipe(QObject):
    """View of another scene to the right of a divider; `canvas` shows the scene on the left."""

    ended = Signal()
    """Esc was pressed on the divider."""

    def __init__(self, canvas: ImageView) -> None:
        super().__init__(canvas)
        self._canvas = canvas
        self._right_area = QWidget(canvas)
        self._right_area.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.mirror: ImageView | None = None
        """View on the right; None unless the divider is shown."""
        self.divider = Divider(canvas)
        self.names = (_create_name_label(canvas), _create_name_label(canvas))
        self.share = 0.5
        """Position of the divider, from 0 on the left to 1 on the right."""
        self.divider.moved_to.connect(self.move_divider)
        self.divider.ended.connect(self.ended)
        canvas.installEventFilter(self)
        canvas.view.sigRangeChanged.connect(self._mirror_visible_range)
        self._set_parts_visible(False)

    def start_comparison(self, left_name: str, right_name: str) -> None:
        """Show the divider and the names of the results on either side."""
        for label, name in zip(self.names, (left_name, right_name), strict=True):
            label.setText(name)
            label.adjustSize()
        if self.mirror is None:
            self.mirror = ImageView(original=self._canvas)
            self.mirror.setParent(self._right_area)
            self.mirror.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            self.mirror.show()
            if self._canvas.hasFocus():
                self.divider.setFocus()
        self._lay_out_parts()
        self._set_parts_visible(True)

    def end_comparison(self) -> None:
        """Show the canvas alone."""
        if self.mirror is not None:
            had = self.divider.hasFocus()
            self._set_parts_visible(False)
            self.mirror.deleteLater()
            self.mirror = None
            if had:
                self._canvas.setFocus()

    def draw_right_scene(self, scene: Scene) -> None:
        """Draw the scene on the right."""
        if self.mirror is not None:
            self.mirror.draw_scene(scene)
            self._mirror_visible_range()

    def move_divider(self, share: float) -> None:
        """Move the divider."""
        self.share = min(max(share, 0.0), 1.0)
        self._lay_out_parts()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Adapt to the size of the canvas."""
        if event.type() == QEvent.Type.Resize and self.mirror is not None:
            self._lay_out_parts()
        return False

    def _set_parts_visible(self, shown: bool) -> None:
        for widget in (self._right_area, self.divider, *self.names):
            widget.setVisible(shown)
            widget.raise_()

    def _lay_out_parts(self) -> None:
        width, height = self._canvas.width(), self._canvas.height()
        at = round(self.share * width)
        self._right_area.setGeometry(at, 0, width - at, height)
        if self.mirror is not None:
            self.mirror.setGeometry(-at, 0, width, height)
        self.divider.setGeometry(at - _GRAB_HALF_WIDTH, 0, 2 * _GRAB_HALF_WIDTH, height)
        near, far = self.names
        near.move(at - _NAME_SIDE_OFFSET - near.width(), _NAME_TOP_OFFSET)
        far.move(at + _NAME_SIDE_OFFSET, _NAME_TOP_OFFSET)
        self._mirror_visible_range()

    def _mirror_visible_range(self, *_: object) -> None:
        if self.mirror is not None:
            self.mirror.view.setRange(self._canvas.view.viewRect(), padding=0.0)


class Divider(QWidget):
    """Line that is dragged, or moved by arrow keys."""

    moved_to = Signal(float)
    """The user moves it to a fraction of the width of its parent."""
    ended = Signal()
    """Esc was pressed."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self._divided = parent
        self.setCursor(Qt.CursorShape.SplitHCursor)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        mark_own_escape(self)
        self.setAccessibleName(tr("Divider between two results"))
        self.setToolTip(
            tr("Drag it, or move it with the arrow keys, with Shift in small steps; Esc ends the comparison.")
        )

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Grab the divider."""
        event.accept()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Drag the divider."""
        event.accept()
        if event.buttons() & Qt.MouseButton.LeftButton:
            self.moved_to.emit(self.mapToParent(event.position()).x() / max(self._divided.width(), 1))

    def event(self, event: QEvent) -> bool:
        """Claim the keys of the divider before they act as shortcuts of the window."""
        return claim_key(event, _KEY_DIRECTIONS) or super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Move the divider, or end the comparison."""
        key = Qt.Key(event.key())
        if key == Qt.Key.Key_Escape:
            self.ended.emit()
        elif key in _KEY_DIRECTIONS:
            width = max(self._divided.width(), 1)
            now = self.geometry().center().x() / width
            step = _FINE_KEY_STEP if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else _KEY_STEP
            self.moved_to.emit({Qt.Key.Key_Home: 0.0, Qt.Key.Key_End: 1.0}.get(key, now + _KEY_DIRECTIONS[key] * step))
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the line and its grip."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle = QPointF(self.width() / 2, self.height() / 2)
        top, bottom = QPointF(middle.x(), 0.0), QPointF(middle.x(), float(self.height()))
        for color, width in ((theme.CANVAS_HALO_COLOR, 4.0), (theme.SELECTED_COLOR, 2.0)):
            painter.setPen(QPen(QColor(color), width))
            painter.drawLine(top, bottom)
        painter.setPen(QPen(QColor(theme.CANVAS_HALO_COLOR), 1.0))
        painter.setBrush(QColor(theme.PROPOSAL_COLOR if self.hasFocus() else theme.SELECTED_COLOR))
        painter.drawRoundedRect(QRectF(0.5, middle.y() - _GRIP_RADIUS, self.width() - 1.0, 2 * _GRIP_RADIUS), 6.0, 6.0)
        painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, "↔")
        painter.end()


_KEY_DIRECTIONS = {
    Qt.Key.Key_Left: -1.0,
    Qt.Key.Key_Right: 1.0,
    Qt.Key.Key_Home: 0.0,
    Qt.Key.Key_End: 0.0,
    Qt.Key.Key_Escape: 0.0,
}
"""Direction in which each key moves the divider; 0 for keys that do something else."""


def _create_name_label(parent: QWidget) -> QLabel:
    label = QLabel(parent)
    label.setObjectName("over_image")
    label.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
    return label
