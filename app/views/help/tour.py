"""The tour for those who are here for the first time: five bubbles that point at what they speak of."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QObject, QPoint, QPointF, QRect, QSize, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QPainter, QPaintEvent, QPalette, QPen, QPolygonF
from PySide6.QtWidgets import QHBoxLayout, QLabel, QMainWindow, QPushButton, QToolBar, QToolButton, QVBoxLayout, QWidget

from app.model.text.language import tr

_WIDTH, _BEAK, _GAP, _ROUND = 320, 12, 6, 9
_MARGIN = 8
"""Least distance of a bubble from the rim of the window [px]."""


@dataclass(frozen=True, eq=False, slots=True)
class Stop:
    """One bubble: its text and the widget that it points at (None when that is not visible)."""

    title: str
    text: str
    target: Callable[[], QWidget | None]


class Tour(QWidget):
    """Guides from stop to stop, by buttons or keys; the window below stays usable."""

    ended = Signal()
    """It is over, be it at its end or before."""

    def __init__(self, window: QWidget, stops: Sequence[Stop]) -> None:
        super().__init__(window)
        self.setObjectName("tour")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self._window = window
        self._stops = stops
        self._at = 0
        self._beak: tuple[QPointF, QPointF, QPointF] | None = None
        self._body = QRect()
        self._ring = _Ring(window)
        self._title, self._text, self._count = QLabel(), QLabel(), QLabel()
        self._title.setObjectName("bold")
        self._text.setWordWrap(True)
        self._count.setObjectName("dim")
        self.back, self.onward, self.skip = QPushButton(tr("Back")), QPushButton(), QPushButton(tr("Skip"))
        self._lay_out()
        self.back.clicked.connect(lambda: self.go(self._at - 1))
        self.onward.clicked.connect(lambda: self.go(self._at + 1))
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
        self.onward.setText(tr("Done") if self._at == len(self._stops) - 1 else tr("Next"))
        self.skip.setVisible(self._at < len(self._stops) - 1)
        self._place()
        self.onward.setFocus(Qt.FocusReason.OtherFocusReason)

    def end(self) -> None:
        """Go away."""
        if self.isHidden():
            return
        self.hide()
        self._ring.hide()
        self._window.removeEventFilter(self)
        self.ended.emit()
        self._ring.deleteLater()
        self.deleteLater()

    def event(self, event: QEvent) -> bool:
        """Take the keys of the tour before they are shortcuts of the window."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent) and self._means(event):
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Arrow keys and Enter lead on and back, Esc ends the tour."""
        act = self._means(event)
        if act is None:
            super().keyPressEvent(event)
        else:
            act()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Stay with what is pointed at when the window changes its size."""
        if event.type() in (QEvent.Type.Resize, QEvent.Type.LayoutRequest) and self.isVisible():
            self._place()
        return super().eventFilter(watched, event)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the bubble with its beak."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        palette = self.palette()
        painter.setPen(QPen(palette.color(QPalette.ColorRole.Highlight), 1.4))
        painter.setBrush(palette.color(QPalette.ColorRole.Base))
        painter.drawRoundedRect(self._body.adjusted(1, 1, -1, -1), _ROUND, _ROUND)
        if self._beak is not None:
            one, tip, two = self._beak
            painter.drawPolyline(QPolygonF([one, tip, two]))
            painter.setPen(QPen(palette.color(QPalette.ColorRole.Base), 2.2))
            painter.drawLine(one, two)
        painter.end()

    def _means(self, event: QKeyEvent) -> Callable[[], None] | None:
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
        for button in (self.skip, self.back, self.onward):
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.setAutoDefault(False)
            button.installEventFilter(_Keys(self))
            buttons.addWidget(button)
        self._layout.addLayout(buttons)

    def _place(self) -> None:
        """Lie beside the target, on the side where there is most room, with the beak at it."""
        target = self._stops[self._at].target()
        room = self._window.rect()
        self._layout.setContentsMargins(_BEAK + 14, _BEAK + 10, _BEAK + 14, _BEAK + 10)
        size = QSize(_WIDTH + 2 * _BEAK, self._layout.totalHeightForWidth(_WIDTH + 2 * _BEAK))
        self._body = QRect(QPoint(_BEAK, _BEAK), size - QSize(2 * _BEAK, 2 * _BEAK))
        if target is None or not target.isVisible():
            self._beak = None
            self._ring.hide()
            self.setGeometry(QRect(room.center() - QPoint(size.width() // 2, size.height() // 2), size))
        else:
            seen = QRect(target.mapTo(self._window, QPoint(0, 0)), target.size()).intersected(room)
            self._ring.surround(seen)
            self.setGeometry(_beside(seen, size, room))
            self._beak = _beak(self.geometry(), self._body, seen)
        self.raise_()
        self.update()


class _Keys(QObject):
    """Gives the keys of the tour's buttons to the tour."""

    def __init__(self, tour: Tour) -> None:
        super().__init__(tour)
        self._tour = tour

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Keys that mean something to the tour go there."""
        if isinstance(event, QKeyEvent) and self._tour._means(event) is not None:
            if event.type() == QEvent.Type.ShortcutOverride:
                event.accept()
                return True
            if event.type() == QEvent.Type.KeyPress:
                self._tour.keyPressEvent(event)
                return True
        return super().eventFilter(watched, event)


class _Ring(QWidget):
    """A line around what is pointed at."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._window = window
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.hide()

    def surround(self, place: QRect) -> None:
        """Lie around a place of the window."""
        self.setGeometry(place.adjusted(-4, -4, 4, 4).intersected(self._window.rect()))
        self.show()
        self.raise_()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the line."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        glow = QColor(self.palette().color(QPalette.ColorRole.Highlight))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(glow, 2.4))
        painter.drawRoundedRect(self.rect().adjusted(2, 2, -2, -2), 6, 6)
        painter.end()


def _beside(seen: QRect, size: QSize, room: QRect) -> QRect:
    """Place for a bubble of this size: below, right, left or above what is seen, where it has room first."""
    middle = seen.center()
    places = (
        QPoint(middle.x() - size.width() // 2, seen.bottom() + _GAP),
        QPoint(seen.right() + _GAP, middle.y() - size.height() // 2),
        QPoint(seen.left() - _GAP - size.width(), middle.y() - size.height() // 2),
        QPoint(middle.x() - size.width() // 2, seen.top() - _GAP - size.height()),
    )
    inner = room.adjusted(_MARGIN, _MARGIN, -_MARGIN, -_MARGIN)
    for place in places:
        held = _held(QRect(place, size), inner)
        if not held.intersects(seen):
            return held
    return _held(QRect(places[0], size), inner)


def _held(place: QRect, room: QRect) -> QRect:
    """A place moved into the room."""
    x = max(room.left(), min(place.left(), room.right() - place.width()))
    y = max(room.top(), min(place.top(), room.bottom() - place.height()))
    return QRect(QPoint(x, y), place.size())


def _beak(bubble: QRect, body: QRect, seen: QRect) -> tuple[QPointF, QPointF, QPointF]:
    """Corners of the beak, in px of the bubble: two on its body, and the tip towards what is seen."""
    aim = QPointF(seen.center() - bubble.topLeft())
    low, high = _BEAK + _ROUND + 8.0, float(_BEAK + _ROUND + 8)
    x = max(low, min(aim.x(), bubble.width() - high))
    y = max(low, min(aim.y(), bubble.height() - high))
    if seen.bottom() <= bubble.top() + _BEAK:
        edge = body.top() + 1.0
        return QPointF(x - 8, edge), QPointF(x, 1.0), QPointF(x + 8, edge)
    if seen.top() >= bubble.bottom() - _BEAK:
        edge = float(body.bottom())
        return QPointF(x - 8, edge), QPointF(x, bubble.height() - 1.0), QPointF(x + 8, edge)
    if seen.right() <= bubble.left() + _BEAK:
        edge = body.left() + 1.0
        return QPointF(edge, y - 8), QPointF(1.0, y), QPointF(edge, y + 8)
    edge = float(body.right())
    return QPointF(edge, y - 8), QPointF(bubble.width() - 1.0, y), QPointF(edge, y + 8)


def stops(window: QMainWindow, reveal: Callable[[str], None]) -> tuple[Stop, ...]:
    """The five stops in a window; `reveal` brings a panel to the front by its name."""

    def button(name: str) -> Callable[[], QWidget | None]:
        def seen() -> QWidget | None:
            found = window.findChild(QToolButton, name)
            # In a narrow window the last buttons have no room; what they do stands in the menus, too.
            return found if found is not None and found.isVisible() else window.menuBar()

        return seen

    def parameters() -> QWidget | None:
        reveal("parameters")
        return window.findChild(QWidget, "parameters")

    return (
        Stop(
            tr("Open an image"),
            tr("Open one of your own, or drop a file on the window. A sample is open already, ready to be tried."),
            button("open"),
        ),
        Stop(
            tr("Draw where to start"),
            tr("Drag a circle in or around an object. Strokes and points do as well; “Automatic” above needs none."),
            lambda: window.findChild(QToolBar, "palette"),
        ),
        Stop(
            tr("Run"),
            tr("Press Space. Particles flow to the edges and push each other along them, until they rest."),
            button("primary"),
        ),
        Stop(
            tr("Steer"),
            tr("Each slider acts at the very next step, while it runs. The drawing below shows what it does."),
            parameters,
        ),
        Stop(
            tr("Export"),
            tr("Write the contours as drawing, table or mask. The guide (F1) leads through three real tasks."),
            button("export"),
        ),
    )
