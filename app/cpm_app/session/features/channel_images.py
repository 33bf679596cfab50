"""The images of the channels that a composite shows with the open one, read in the background."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import replace
from functools import partial

import numpy as np
from PySide6.QtCore import QObject

from cpm_app.model.display.channels import Channel
from cpm_app.model.display.display_image import DisplayImage, build_display_image
from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import ImageOpened
from cpm_app.session.session import Session
from cpm_app.session.tasks.tasks import ENDED_TASK, BackgroundTask
from cpm_core import Image
from cpm_core.formats.images.readers import load_channel
from cpm_core.numerics.types import copy_with


class ChannelImages(QObject):
    """Reads the wanted channels, each only once while the same part of the file is open."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._opened: ImageOpened | None = None
        self._known: dict[int, tuple[Image, DisplayImage | None]] = {}
        self._wanted: Set[int] | None = None
        self._task = ENDED_TASK
        session.store.add_listener(ImageOpened, self._on_image_opened)

    def show(self, wanted: Set[int]) -> None:
        """Show these channels, by their indices; those that are not known yet are read first."""
        opened = self._opened
        if opened is None or wanted == self._wanted:
            return
        self._wanted = wanted
        self._task.cancel()
        self._update_scene()
        missing = sorted(wanted - self._known.keys())
        if missing:
            title, activity = tr("Reading {name}…", name=opened.path.name), tr("reading {name}", name=opened.path.name)

            def read_channels(task: BackgroundTask) -> None:
                for channel in missing:
                    image = _read_channel(opened, channel)
                    task.check_cancelled()
                    display = build_display_image(image) if image.ndim == 2 else None
                    self._session.tasks.call_in_window(partial(self._use, opened, channel, image, display))

            self._task = self._session.tasks.start_task(title, read_channels, activity, on_result=lambda _: None)

    def _on_image_opened(self, opened: ImageOpened) -> None:
        """Forget the channels unless another one of the same part of the file is open now."""
        self._task.cancel()
        if self._opened is None or _part_of(opened) != _part_of(self._opened):
            self._known = {}
        self._opened, self._wanted = opened, None
        self._known[(opened.reading.channel or 1) - 1] = opened.image, opened.display
        self._update_scene()

    def _use(self, opened: ImageOpened, channel: int, image: Image, display: DisplayImage | None) -> None:
        if opened is self._opened:
            self._known[channel] = image, display
            self._update_scene()

    def _update_scene(self) -> None:
        """Show the channels that are known, all of them until it is known which ones are wanted."""
        scene, opened = self._session.scene, self._opened
        assert opened is not None
        here = (opened.reading.channel or 1) - 1

        def fill_channel(index: int, channel: Channel) -> Channel:
            shown = index != here and (self._wanted is None or index in self._wanted)
            image, display = self._known.get(index, (None, None)) if shown else (None, None)
            return channel if channel.image is image else replace(channel, image=image, display=display)

        channels = tuple(fill_channel(*one) for one in enumerate(scene.channels))
        if channels != scene.channels:
            self._session.store.set_scene(replace(scene, channels=channels))


def _part_of(opened: ImageOpened) -> tuple[object, ...]:
    """Return what tells the open part of a file from others, apart from its channel."""
    return opened.path, opened.sha256, replace(opened.reading, channel=None), opened.image.shape


def _read_channel(opened: ImageOpened, channel: int) -> Image:
    """Read another channel of the open part; half of the memory of a volume is enough to show it."""
    image = load_channel(
        opened.path, replace(opened.reading, channel=channel + 1), opened.image.ndim == 3, opened.sha256
    )
    image.shown_range  # noqa: B018 - cached here, because the window needs it
    if image.ndim == 2:
        return image
    values = image.stored.astype(np.float32)
    return copy_with(image, stored=values, values=values)
