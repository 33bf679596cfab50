"""Shades of an image for another window of grey values, made on the worker thread where that takes long."""

from __future__ import annotations

from dataclasses import dataclass

from app.model.display import shades
from app.model.display.shades import Shades, Window
from app.session.exchange.messages import Report
from app.session.worker.command_context import Workshop
from app.session.worker.commands.run import Command
from cpm_core.image.image import Image


@dataclass(frozen=True, eq=False, slots=True)
class WindowFound(Report):
    """The range of an image without so many per cent of its pixels at either end."""

    image: Image
    percent: float
    low: float
    high: float


@dataclass(frozen=True, eq=False, slots=True)
class Shaded(Report):
    """An image as it looks in a window of grey values."""

    image: Image
    window: Window
    shades: Shades


@dataclass(frozen=True, eq=False, slots=True)
class FindWindow(Command):
    """Find the range of an image without so many per cent of its pixels at either end."""

    image: Image
    percent: float

    latest_only = True
    doing = "looking for the range of grey values"

    def obey(self, shop: Workshop) -> None:
        """Find it."""
        low, high = shades.window_without(self.image.values, self.percent)
        shop.report(WindowFound(self.image, self.percent, low, high))


@dataclass(frozen=True, eq=False, slots=True)
class Shade(Command):
    """Make the shades of an image in a window."""

    image: Image
    window: Window

    latest_only = True
    doing = "changing the levels"

    def obey(self, shop: Workshop) -> None:
        """Make them."""
        shop.report(Shaded(self.image, self.window, shades.windowed(self.image.values, self.window)))
