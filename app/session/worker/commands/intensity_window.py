"""Display images for other intensity windows, made on the worker thread."""

from __future__ import annotations

from dataclasses import dataclass

from app.model.display.display_image import DisplayImage, IntensityWindow, apply_window, percentile_window
from app.model.text.language import tr
from app.session.exchange.messages import Report
from app.session.worker.commands.run import Command, CommandContext
from cpm_core.image.image import Image


@dataclass(frozen=True, eq=False, slots=True)
class WindowFound(Report):
    """The range of gray values of an image without `percent` per cent of its pixels at either end."""

    image: Image
    percent: float
    low: float
    high: float


@dataclass(frozen=True, eq=False, slots=True)
class Shaded(Report):
    """An image in an intensity window."""

    image: Image
    window: IntensityWindow
    display: DisplayImage
    channel: str = "luminance"


@dataclass(frozen=True, eq=False, slots=True)
class FindWindow(Command):
    """Find the range of gray values of an image without `percent` per cent of its pixels at either end."""

    image: Image
    percent: float

    latest_only = True
    activity = tr("looking for the range of gray values")

    def execute(self, context: CommandContext) -> None:
        """Find the range."""
        low, high = percentile_window(self.image.values, self.percent)
        context.report(WindowFound(self.image, self.percent, low, high))


@dataclass(frozen=True, eq=False, slots=True)
class Shade(Command):
    """Make the display image of a channel for an intensity window."""

    image: Image
    window: IntensityWindow
    channel: str = "luminance"

    latest_only = True
    activity = tr("changing the levels")

    def execute(self, context: CommandContext) -> None:
        """Make the display image."""
        display = DisplayImage.of(apply_window(self.image.gray(self.channel), self.window))
        context.report(Shaded(self.image, self.window, display, self.channel))
