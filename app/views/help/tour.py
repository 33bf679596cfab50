"""The tour for new users: a bubble that stays in its place, and a ring around what it explains."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from PySide6.QtCore import QEvent, QObject, QPoint, QRect, Qt, QTimer, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent
from PySide6.QtWidgets import (
    QApplication,
    QFrame,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QMainWindow,
    QPushButton,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from app.model.text.keys import with_keys
from app.model.text.language import tr
from app.session.session import Session
from app.views.export.dialog import ExportDialog
from app.views.widgets.containers import keep_escape

_WIDTH, _MARGIN = 344, 12
"""Width of the bubble, and distance from the sides of its area [px]."""

_BUBBLE = "QFrame#tour { background: palette(base); border: 1px solid palette(highlight); border-radius: 9px; }"
_RING = "border: 2px solid palette(highlight); border-radius: 6px;"

_LOOK, _PRAISE = 120, 700
"""Time between two looks at whether the thing is done, and before the tour goes on when it is [ms]."""


def _never() -> bool:
    return False


@dataclass(frozen=True, eq=False, slots=True)
class Stop:
    """One stop of the tour.

    Attributes
    ----------
    title, text : str
        What the bubble says; the text may name keys of actions (see `with_keys`).
    target : callable
        Returns the widget that it explains, None when that is not visible.
    watch : callable
        Called when the stop is reached; returns a function that tells whether the person has done the thing since.
    do : callable
        What "Next" does for a person who has not done it.
    """

    title: str
    text: str
    target: Callable[[], QWidget | None]
    watch: Callable[[], Callable[[], bool]]
    do: Callable[[], None] = lambda: None


class Tour(QFrame):
    """Guides from stop to stop; the window below stays usable.

    It goes on when the person has done what a stop asks for, or by its buttons. The bubble lies in the lower left
    corner of `area`, with its buttons always at the same place.
    """

    ended = Signal()
    """The tour has been completed or skipped."""

    def __init__(self, window: QWidget, area: QWidget, stops: Sequence[Stop]) -> None:
        super().__init__(window)
        self.setObjectName("tour")
        self.setStyleSheet(_BUBBLE)
        self._window, self._area = window, area
        self._stops = stops
        self._at = 0
        self._over = False
        self._done: Callable[[], bool] = _never
        self.ring = Ring(window)
        self.title, self.text, self._count = QLabel(), QLabel(), QLabel()
        self.title.setObjectName("bold")
        self.title.setTextFormat(Qt.TextFormat.RichText)
        self.text.setWordWrap(True)
        self.text.setAlignment(Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft)
        self._count.setObjectName("dim")
        self.back, self.next, self.skip = QPushButton(tr("Back")), QPushButton(), QPushButton(tr("Skip"))
        keep_escape(self)
        self._lay_out()
        self.back.clicked.connect(lambda: self.go(self._at - 1))
        self.next.clicked.connect(self._go_on)
        self.skip.clicked.connect(self.end)
        self._looking = QTimer(self, interval=_LOOK)
        self._looking.timeout.connect(self._look)
        self._praising = QTimer(self, interval=_PRAISE, singleShot=True)
        self._praising.timeout.connect(lambda: self.go(self._at + 1))
        window.installEventFilter(self)

    @property
    def at(self) -> int:
        """Number of the stop, from 0."""
        return self._at

    def begin(self) -> None:
        """Show the first stop."""
        self.show()
        self.go(0)
        self._looking.start()
        self.next.setFocus(Qt.FocusReason.OtherFocusReason)

    def go(self, stop: int) -> None:
        """Show a stop; after the last one the tour is over."""
        if self._over:
            return
        if stop >= len(self._stops):
            self.end()
            return
        self._praising.stop()
        self._at = max(0, stop)
        here = self._stops[self._at]
        self.title.setText(f"<b>{here.title}</b>")
        self.show_keys()
        self._count.setText(tr("{step} of {steps}").format(step=self._at + 1, steps=len(self._stops)))
        self.back.setEnabled(self._at > 0)
        last = self._at == len(self._stops) - 1
        self.next.setText(tr("Done") if last else tr("Next"))
        self.skip.setEnabled(not last)
        self._done = here.watch()
        self._place()

    def show_keys(self) -> None:
        """Name the keys as they are now."""
        self.text.setText(with_keys(self._stops[self._at].text))

    def end(self) -> None:
        """End the tour; for a moment its place takes clicks, so that a double click does not draw on the image."""
        if self._over:
            return
        self._over = True
        self._looking.stop()
        self._praising.stop()
        for child in self.findChildren(QWidget):
            child.hide()
        self.setStyleSheet("")
        self.ring.deleteLater()
        self._window.removeEventFilter(self)
        QTimer.singleShot(QApplication.doubleClickInterval(), self, self.deleteLater)
        self.ended.emit()

    # Qt interface

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """End the tour by Esc."""
        if event.key() == Qt.Key.Key_Escape:
            self.end()
        else:
            super().keyPressEvent(event)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Keep clicks from what is below."""
        event.accept()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Follow the layout of the window."""
        if event.type() in (QEvent.Type.Resize, QEvent.Type.LayoutRequest) and self.isVisible():
            self._place()
        return super().eventFilter(watched, event)

    # Internal

    def _go_on(self) -> None:
        if not self._done():
            self._stops[self._at].do()
        self.go(self._at + 1)

    def _look(self) -> None:
        """Say that the thing is done and go on after a moment; follow panels that have moved."""
        if self._done() and not self._praising.isActive():
            self.title.setText(f"<b>✓ {self._stops[self._at].title}</b>")
            self._praising.start()
        self._place()

    def _lay_out(self) -> None:
        layout = QVBoxLayout(self)
        layout.setContentsMargins(16, 12, 16, 12)
        layout.setSpacing(6)
        layout.addWidget(self.title)
        layout.addWidget(self.text, 1)
        buttons = QHBoxLayout()
        buttons.addWidget(self._count)
        buttons.addStretch(1)
        for button in (self.skip, self.back, self.next):
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.setAutoDefault(False)
            buttons.addWidget(button)
        layout.addLayout(buttons)
        heights = []
        for stop in self._stops:  # as high as the longest one, so that the buttons stay where they are
            self.title.setText(f"<b>✓ {stop.title}</b>")
            self.text.setText(with_keys(stop.text))
            layout.invalidate()
            heights.append(layout.totalHeightForWidth(_WIDTH))
        self.setFixedSize(_WIDTH, max(heights))

    def _place(self) -> None:
        corner = self._area.mapTo(self._window, self._area.rect().bottomLeft())
        place = corner + QPoint(_MARGIN, -_MARGIN - self.height())
        if self.pos() != place:
            self.move(place)
        self.ring.surround(self._stops[self._at].target())
        self.raise_()


class Ring(QFrame):
    """A line around the target."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._window = window
        self.setStyleSheet(_RING)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.hide()

    def surround(self, target: QWidget | None) -> None:
        """Surround a widget of the window; nothing if there is none to be seen."""
        if target is None or not target.isVisible():
            self.hide()
            return
        seen = QRect(target.mapTo(self._window, QPoint(0, 0)), target.size())
        place = seen.adjusted(-4, -4, 4, 4).intersected(self._window.rect())
        if self.geometry() != place or self.isHidden():
            self.setGeometry(place)
            self.show()
            self.raise_()


def stops(window: QMainWindow, session: Session, reveal: Callable[[str], None]) -> tuple[Stop, ...]:
    """The five stops in a window; `reveal` brings a panel to the front by its name."""

    def button(name: str) -> QWidget | None:
        found = window.findChild(QToolButton, name)
        # In a narrow window the last buttons are hidden; their actions are also in the menus.
        return found if found is not None and found.isVisible() else window.menuBar()

    def another_image() -> Callable[[], bool]:
        # The first image, which the program itself opens, does not count.
        opened = [] if session.document.image is None else [session.image_generation]

        def is_opened() -> bool:
            if not opened and session.document.image is not None:
                opened.append(session.image_generation)
            return bool(opened) and session.image_generation != opened[0]

        return is_opened

    def more_objects() -> Callable[[], bool]:
        before = len(session.document.objects.items)
        return lambda: len(session.document.objects.items) > before and not isinstance(window.focusWidget(), QLineEdit)

    def other_parameters() -> Callable[[], bool]:
        reveal("parameters")
        before = session.document.parameters
        return lambda: session.document.parameters != before

    def run() -> None:
        if session.document.starts and not session.status.started:
            session.run()

    return (
        Stop(
            tr("Open an image"),
            tr("Open your own image, or drop a file on the window. Or continue with the image that is open."),
            partial(button, "open"),
            another_image,
        ),
        Stop(
            tr("Select an object"),
            tr("Choose the tool Objects ({key:objects}) and click in an object. Click to add, Shift-click to remove. "
               "Enter accepts it and asks for its name; Enter again leaves it without one."),
            partial(button, "objects"),
            more_objects,
        ),
        Stop(
            tr("Or draw and run"),
            tr("Drag a circle ({key:circle}) in or around an object, unless there is one, and press {key:run}. "
               "Particles find the edges and follow them until they come to rest."),
            partial(button, "primary"),
            lambda: lambda: session.status.started,
            run,
        ),
        Stop(
            tr("Steer"),
            tr("Move a slider: it acts at the next step of the run. The text below the sliders explains it."),
            lambda: window.findChild(QWidget, "parameters"),
            other_parameters,
        ),
        Stop(
            tr("Export"),
            tr("When the run has found contours, export them as vector graphics, table or mask. "
               "The guide ({key:guide}) explains four examples."),
            partial(button, "export"),
            lambda: lambda: window.findChild(ExportDialog) is not None,
        ),
    )  # fmt: skip
