"""The tour for new users: five bubbles that point at the widgets that they explain."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QObject, QPoint, QPointF, QRect, QSize, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QPainter, QPaintEvent, QPalette, QPen, QPolygonF
from PySide6.QtWidgets import QHBoxLayout, QLabel, QMainWindow, QPushButton, QToolBar, QToolButton, QVBoxLayout, QWidget

from app.model.text.language import tr

_WIDTH, _ARROW, _GAP, _ROUND = 320, 12, 6, 9
_MARGIN = 8
"""Minimum distance of a bubble from the sides of the window [px]."""


@dataclass(frozen=True, eq=False, slots=True)
class Stop:
    """One bubble: its text and the widget that it points at (None when that is not visible)."""

    title: str
    text: str
    target: Callable[[], QWidget | None]


class Tour(QWidget):
    """Guides from stop to stop, by buttons or keys; the window below stays usable."""

    ended = Signal()
    """The tour has been completed or skipped."""

    def __init__(self, window: QWidget, stops: Sequence[Stop]) -> None:
        super().__init__(window)
        self.setObjectName("tour")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self._window = window
        self._stops = stops
        self._at = 0
        self._arrow: tuple[QPointF, QPointF, QPointF] | None = None
        self._body = QRect()
        self._ring = _Ring(window)
        self._title, self._text, self._count = QLabel(), QLabel(), QLabel()
        self._title.setObjectName("bold")
        self._text.setWordWrap(True)
        self._count.setObjectName("dim")
        self.back, self.next, self.skip = QPushButton(tr("Back")), QPushButton(), QPushButton(tr("Skip"))
        self._lay_out()
        self.back.clicked.connect(lambda: self.go(self._at - 1))
        self.next.clicked.connect(lambda: self.go(self._at + 1))
        self.skip.clicked.connect(self.end)
        window.installEventFilter(self)

    @property
    def at(self) -> int:
        """Number of the stop, from 0."""
        return self._at

    def begin(self) -> None:
        """Show the first stop."""
        self.show()
        self.go(0)

    def go(self, stop: int) -> None:
        """Show a stop; after the last one the tour is over."""
        if stop >= len(self._stops):
            self.end()
            return
        self._at = max(0, stop)
        here = self._stops[self._at]
        self._title.setText(f"<b>{here.title}</b>")
        self._text.setText(here.text)
        self._count.setText(tr("{step} of {steps}").format(step=self._at + 1, steps=len(self._stops)))
        self.back.setEnabled(self._at > 0)
        self.next.setText(tr("Done") if self._at == len(self._stops) - 1 else tr("Next"))
        self.skip.setVisible(self._at < len(self._stops) - 1)
        self._place()
        self.next.setFocus(Qt.FocusReason.OtherFocusReason)

    def end(self) -> None:
        """End the tour."""
        if self.isHidden():
            return
        self.hide()
        self._ring.hide()
        self._window.removeEventFilter(self)
        self.ended.emit()
        self._ring.deleteLater()
        self.deleteLater()

    def event(self, event: QEvent) -> bool:
        """Handle the keys of the tour before they act as shortcuts of the window."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent) and self.action_of(event):
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Go on or back by arrow keys and Enter, end the tour by Esc."""
        act = self.action_of(event)
        if act is None:
            super().keyPressEvent(event)
        else:
            act()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Follow the target when the layout of the window changes."""
        if event.type() in (QEvent.Type.Resize, QEvent.Type.LayoutRequest) and self.isVisible():
            self._place()
        return super().eventFilter(watched, event)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint the bubble with its arrow."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        palette = self.palette()
        painter.setPen(QPen(palette.color(QPalette.ColorRole.Highlight), 1.4))
        painter.setBrush(palette.color(QPalette.ColorRole.Base))
        painter.drawRoundedRect(self._body.adjusted(1, 1, -1, -1), _ROUND, _ROUND)
        if self._arrow is not None:
            one, tip, two = self._arrow
            painter.drawPolyline(QPolygonF([one, tip, two]))
            painter.setPen(QPen(palette.color(QPalette.ColorRole.Base), 2.2))
            painter.drawLine(one, two)
        painter.end()

    def action_of(self, event: QKeyEvent) -> Callable[[], None] | None:
        """The action of a key in the tour, if it has one."""
        match event.key():
            case Qt.Key.Key_Escape:
                return self.end
            case Qt.Key.Key_Left | Qt.Key.Key_Backspace:
                return lambda: self.go(self._at - 1)
            case Qt.Key.Key_Right | Qt.Key.Key_Return | Qt.Key.Key_Enter | Qt.Key.Key_Space:
                focused = self.focusWidget()
                if event.key() != Qt.Key.Key_Right and isinstance(focused, QPushButton) and focused.hasFocus():
                    return focused.click
                return lambda: self.go(self._at + 1)
        return None

    def _lay_out(self) -> None:
        self._layout = QVBoxLayout(self)
        self._layout.setSpacing(6)
        self._layout.addWidget(self._title)
        self._layout.addWidget(self._text)
        buttons = QHBoxLayout()
        buttons.addWidget(self._count)
        buttons.addStretch(1)
        for button in (self.skip, self.back, self.next):
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.setAutoDefault(False)
            button.installEventFilter(_Keys(self))
            buttons.addWidget(button)
        self._layout.addLayout(buttons)

    def _place(self) -> None:
        """Place the bubble beside the target, with its arrow pointing at it."""
        target = self._stops[self._at].target()
        room = self._window.rect()
        self._layout.setContentsMargins(_ARROW + 14, _ARROW + 10, _ARROW + 14, _ARROW + 10)
        size = QSize(_WIDTH + 2 * _ARROW, self._layout.totalHeightForWidth(_WIDTH + 2 * _ARROW))
        self._body = QRect(QPoint(_ARROW, _ARROW), size - QSize(2 * _ARROW, 2 * _ARROW))
        if target is None or not target.isVisible():
            self._arrow = None
            self._ring.hide()
            self.setGeometry(QRect(room.center() - QPoint(size.width() // 2, size.height() // 2), size))
        else:
            seen = QRect(target.mapTo(self._window, QPoint(0, 0)), target.size()).intersected(room)
            self._ring.surround(seen)
            self.setGeometry(_beside(seen, size, room))
            self._arrow = _arrow(self.geometry(), self._body, seen)
        self.raise_()
        self.update()


class _Keys(QObject):
    """Passes keys from the buttons of the tour to the tour."""

    def __init__(self, tour: Tour) -> None:
        super().__init__(tour)
        self._tour = tour

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Pass on the keys that have an action in the tour."""
        if isinstance(event, QKeyEvent) and self._tour.action_of(event) is not None:
            if event.type() == QEvent.Type.ShortcutOverride:
                event.accept()
                return True
            if event.type() == QEvent.Type.KeyPress:
                self._tour.keyPressEvent(event)
                return True
        return super().eventFilter(watched, event)


class _Ring(QWidget):
    """A line around the target."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._window = window
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.hide()

    def surround(self, place: QRect) -> None:
        """Surround a rectangle of the window."""
        self.setGeometry(place.adjusted(-4, -4, 4, 4).intersected(self._window.rect()))
        self.show()
        self.raise_()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint the line."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        glow = QColor(self.palette().color(QPalette.ColorRole.Highlight))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(glow, 2.4))
        painter.drawRoundedRect(self.rect().adjusted(2, 2, -2, -2), 6, 6)
        painter.end()


def _beside(seen: QRect, size: QSize, room: QRect) -> QRect:
    """Position of a bubble of this size: the first of below, right, left and above the target that has room."""
    middle = seen.center()
    places = (
        QPoint(middle.x() - size.width() // 2, seen.bottom() + _GAP),
        QPoint(seen.right() + _GAP, middle.y() - size.height() // 2),
        QPoint(seen.left() - _GAP - size.width(), middle.y() - size.height() // 2),
        QPoint(middle.x() - size.width() // 2, seen.top() - _GAP - size.height()),
    )
    inner = room.adjusted(_MARGIN, _MARGIN, -_MARGIN, -_MARGIN)
    for place in places:
        moved = _moved_into(QRect(place, size), inner)
        if not moved.intersects(seen):
            return moved
    return _moved_into(QRect(places[0], size), inner)


def _moved_into(place: QRect, room: QRect) -> QRect:
    """A rectangle moved into the available area."""
    x = max(room.left(), min(place.left(), room.right() - place.width()))
    y = max(room.top(), min(place.top(), room.bottom() - place.height()))
    return QRect(QPoint(x, y), place.size())


def _arrow(bubble: QRect, body: QRect, seen: QRect) -> tuple[QPointF, QPointF, QPointF]:
    """Corners of the arrow [px of the bubble]: two on its body, and the tip toward the target."""
    aim = QPointF(seen.center() - bubble.topLeft())
    low, high = _ARROW + _ROUND + 8.0, float(_ARROW + _ROUND + 8)
    x = max(low, min(aim.x(), bubble.width() - high))
    y = max(low, min(aim.y(), bubble.height() - high))
    if seen.bottom() <= bubble.top() + _ARROW:
        edge = body.top() + 1.0
        return QPointF(x - 8, edge), QPointF(x, 1.0), QPointF(x + 8, edge)
    if seen.top() >= bubble.bottom() - _ARROW:
        edge = float(body.bottom())
        return QPointF(x - 8, edge), QPointF(x, bubble.height() - 1.0), QPointF(x + 8, edge)
    if seen.right() <= bubble.left() + _ARROW:
        edge = body.left() + 1.0
        return QPointF(edge, y - 8), QPointF(1.0, y), QPointF(edge, y + 8)
    edge = float(body.right())
    return QPointF(edge, y - 8), QPointF(bubble.width() - 1.0, y), QPointF(edge, y + 8)


def stops(window: QMainWindow, reveal: Callable[[str], None]) -> tuple[Stop, ...]:
    """The five stops in a window; `reveal` brings a panel to the front by its name."""

    def button(name: str) -> Callable[[], QWidget | None]:
        def seen() -> QWidget | None:
            found = window.findChild(QToolButton, name)
            # In a narrow window the last buttons are hidden; their actions are also in the menus.
            return found if found is not None and found.isVisible() else window.menuBar()

        return seen

    def parameters() -> QWidget | None:
        reveal("parameters")
        return window.findChild(QWidget, "parameters")

    return (
        Stop(
            tr("Open an image"),
            tr("Open your own image, or drop a file on the window. A sample is already open."),
            button("open"),
        ),
        Stop(
            tr("Draw an initialization"),
            tr("Drag a circle in or around an object, or use strokes or points. “Automatic” above needs no drawing."),
            lambda: window.findChild(QToolBar, "palette"),
        ),
        Stop(
            tr("Run"),
            tr("Press Space. Particles move to the edges and repel each other along them until they come to rest."),
            button("primary"),
        ),
        Stop(
            tr("Steer"),
            tr("Each slider acts at the next step of the run. The illustration below shows its effect."),
            parameters,
        ),
        Stop(
            tr("Export"),
            tr("Export the contours as vector graphics, table or mask. The guide (F1) explains three examples."),
            button("export"),
        ),
    )
