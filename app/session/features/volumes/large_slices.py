"""Display images of large slices: a preview at once, and all pixels on a thread of their own."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from PySide6.QtCore import QObject, Signal

from app.model.display.display_image import DisplayImage, IntensityWindow, apply_window
from app.model.text.language import tr
from app.session.features.latest import Latest
from app.session.signals import SessionSignals
from cpm_core.image.image import Image

AT_ONCE = 1 << 21
"""Largest number of pixels of a slice that is made at once: three of them take a third of a frame of 50 ms."""


@dataclass(frozen=True, eq=False, slots=True)
class _Made:
    """The display image of an image in a window."""

    image: Image
    window: IntensityWindow
    display: DisplayImage
    whole: bool

    def fits(self, image: Image, window: IntensityWindow) -> bool:
        """Whether it shows this image in this window."""
        return self.image is image and self.window == window


class LargeSlices(QObject):
    """Gives the newest display image of the slice of one view."""

    completed = Signal()
    """The slice that was asked for last is no preview any more."""

    def __init__(self, session: SessionSignals) -> None:
        super().__init__(session)
        self._newest: _Made | None = None
        self._latest = Latest(session, "cpm-slices", tr("drawing a slice"))
        self._latest.done.connect(self._take)

    def of(self, image: Image, window: IntensityWindow) -> DisplayImage:
        """The display image, or a preview of it that is soon completed."""
        if self._newest is None or not self._newest.fits(image, window):
            self._newest = _Made(image, window, DisplayImage.preview(image.values, window), False)
            self._latest.ask(partial(_made, image, window))
        return self._newest.display

    def close(self) -> None:
        """End the thread."""
        self._latest.close()

    def _take(self, made: _Made) -> None:
        if self._newest is not None and not self._newest.whole and self._newest.fits(made.image, made.window):
            self._newest = made
            self.completed.emit()


def shaded(image: Image, window: IntensityWindow) -> DisplayImage:
    """The display image of an image in a window."""
    return DisplayImage.of(apply_window(image.values, window))


def _made(image: Image, window: IntensityWindow) -> _Made:
    return _Made(image, window, shaded(image, window), True)
