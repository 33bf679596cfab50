"""One place of the comparison: which method runs there, the image with what it has found, and its figures."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QObject, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QComboBox, QFrame, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from app.model.display.display_image import DisplayImage
from app.model.text.language import from_core, tr
from app.model.text.numbers import written
from app.session.features.side_by_side.method_run import Frame
from app.views.canvas.coordinates import image_rectangle, to_xy
from app.views.canvas.items.curves import Curves
from app.views.canvas.items.item import Markers
from app.views.theme import theme
from app.views.widgets.elided_label import ElidedLabel
from cpm_core.contours.ground_truth import Truth
from cpm_core.numerics.types import Array
from cpm_core.objects.methods import CONTOUR_METHODS, Facts

_ABOVE = 10.0
_DOT = 3.5
_LEAST = 160
_LINES = 3
"""Lines of words below a picture."""


class Pane(QFrame):
    """A method, its picture and its figures; several panes zoom and move together."""

    chosen = Signal()
    """Another method has been chosen."""
    focused = Signal()
    """The keyboard or the mouse has come here."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.setFrameShape(QFrame.Shape.StyledPanel)
        self.choice = QComboBox()
        self.choice.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.choice.setAccessibleName(tr("Method {number}").format(number=number))
        for name, method in CONTOUR_METHODS.items():
            self.choice.addItem(from_core(method.title), name)
            last = self.choice.count() - 1
            words = "\n".join(filter(None, (from_core(method.about), method.reference, from_core(method.missing))))
            self.choice.setItemData(last, words, Qt.ItemDataRole.ToolTipRole)
        self.choice.addItem(tr("None"), "")
        self.picture = pg.GraphicsView(background=theme.CANVAS)
        self.picture.setMinimumSize(_LEAST, _LEAST)
        self.picture.setToolTip(
            tr("The wheel zooms all places, dragging moves them, a double click shows the whole image.")
        )
        self.view = pg.ViewBox(enableMenu=False, invertY=True, lockAspect=True, defaultPadding=0.0)
        self.view.disableAutoRange()
        self.picture.setCentralItem(self.view)
        self._whole = QRectF()
        self._image = pg.ImageItem(axisOrder="row-major")
        self.start = Curves(theme.MOVING, _ABOVE, width=1.4, halo=0.0, dashed=True)
        self.truth = Curves(theme.TRUTH, _ABOVE + 0.5, width=1.6, halo=0.0)
        self._closed = Curves(theme.CLOSED, _ABOVE + 1.0)
        self._open = Curves(theme.OPEN, _ABOVE + 1.0)
        self._dots = Markers(size=_DOT, pen=None, brush=QColor(theme.MOVING))
        self._dots.setZValue(_ABOVE + 2.0)
        for item in (self._image, self.start, self.truth, self._closed, self._open, self._dots):
            self.view.addItem(item)
        self.progress, self.words = ElidedLabel(), QLabel()
        self.words.setWordWrap(True)
        self.progress.setToolTip(
            tr("The methods share the processor here; cpm compare runs one after the other, for times that compare.")
        )
        self.words.setFixedHeight(_LINES * self.words.fontMetrics().lineSpacing() + 4)  # so all pictures are as large
        self.words.setAlignment(Qt.AlignmentFlag.AlignTop)
        head, layout = QHBoxLayout(), QVBoxLayout(self)
        head.addWidget(self.choice, 1)
        head.addWidget(self.progress)
        layout.setContentsMargins(4, 4, 4, 4)
        layout.addLayout(head)
        layout.addWidget(self.picture, 1)
        layout.addWidget(self.words)
        self.choice.currentIndexChanged.connect(self.chosen)
        self._watch(self.choice, self.picture, self.picture.viewport())

    @property
    def method(self) -> str:
        """Name of the chosen method; empty for none."""
        return str(self.choice.currentData())

    def choose(self, method: str) -> None:
        """Choose a method by name without telling."""
        self.choice.blockSignals(True)
        self.choice.setCurrentIndex(self.choice.findData(method))
        self.choice.blockSignals(False)

    def show_image(self, display: DisplayImage) -> None:
        """Show an image."""
        self._image.setImage(display.shades, autoLevels=False, levels=(0, 255))
        self._image.setRect(image_rectangle(display.shape))
        for item in (self.start, self.truth, self._closed, self._open):
            item.use_shape(display.shape)
        self._whole = image_rectangle(display.shape)
        self.show_whole()

    def show_whole(self) -> None:
        """Show the whole image, in this place and in those that are linked with it."""
        self.view.setRange(self._whole, padding=0.02)

    def show_start(self, outlines: Sequence[Array]) -> None:
        """Show the outlines that all methods start from."""
        self.start.show([np.concatenate([outline, outline[:1]]) for outline in outlines])

    def show_truth(self, truth: Truth | None) -> None:
        """Show the boundaries of the ground truth, where one is known."""
        self.truth.show([] if truth is None else [contour.path for contour in truth.contours])

    def show_frame(self, frame: Frame | None) -> None:
        """Show a state of the run, or nothing."""
        contours = () if frame is None else frame.contours
        self._closed.show([contour.path for contour in contours if contour.closed])
        self._open.show([contour.path for contour in contours if not contour.closed])
        moving = np.empty((0, 2)) if frame is None or frame.over else frame.points
        self._dots.setData(*to_xy(moving))
        self.progress.setText("" if frame is None or frame.trouble else _progress(frame))
        self.words.setText("" if frame is None else frame.trouble or _words(frame))
        self.words.setToolTip(self.words.text())

    def mark(self, chosen: bool) -> None:
        """Frame the pane whose parameters are shown."""
        palette = self.palette()
        role = QPalette.ColorRole.Highlight if chosen else QPalette.ColorRole.Mid
        self.setStyleSheet(f"Pane {{ border: 2px solid {palette.color(role).name()}; }}")

    def link(self, other: Pane) -> None:
        """Zoom and move together with another pane."""
        self.view.setXLink(other.view)
        self.view.setYLink(other.view)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Notice the keyboard and the mouse."""
        if event.type() in (QEvent.Type.FocusIn, QEvent.Type.MouseButtonPress):
            self.focused.emit()
        elif event.type() == QEvent.Type.MouseButtonDblClick and watched is self.picture.viewport():
            self.show_whole()
        return False

    def _watch(self, *widgets: QWidget) -> None:
        for widget in widgets:
            widget.installEventFilter(self)


def _progress(frame: Frame) -> str:
    """Steps and time of a run."""
    facts = frame.facts
    if facts is None:
        return tr("Preparing…")
    counted = tr("1 step, {seconds} s") if facts.steps == 1 else tr("{steps} steps, {seconds} s")
    return counted.format(steps=facts.steps, seconds=written(f"{facts.seconds:.2f}"))


def _words(frame: Frame) -> str:
    """Agreement and contours of a run that has ended, and why."""
    facts = frame.facts
    if facts is None or not frame.over:
        return ""
    found = tr("contours: {count}, closed: {closed}").format(count=facts.contours, closed=facts.closed)
    return "\n".join([*_agreement(facts), f"{found}; {from_core(facts.stop_reason)}"])


def _agreement(facts: Facts) -> list[str]:
    if facts.dice is None or facts.f is None or facts.hausdorff is None or facts.mean_distance is None:
        return []
    known = np.isfinite(facts.hausdorff)
    distances = (written(f"{facts.hausdorff:.1f}"), written(f"{facts.mean_distance:.2f}")) if known else ("–", "–")
    return [
        tr("Dice {dice}, F {f}, Hausdorff {largest} px, mean distance {mean} px").format(
            dice=written(f"{facts.dice:.3f}"), f=written(f"{facts.f:.3f}"), largest=distances[0], mean=distances[1]
        )
    ]
