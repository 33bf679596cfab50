"""The images of the channels that a composite shows with the open one, read in the background."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import replace
from functools import partial

import numpy as np
from PySide6.QtCore import QObject

from cpm_app.model.display.channels import Channel, has_bright_background
from cpm_app.model.display.display_image import build_display_image
from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import ImageOpened, WorkFinished
from cpm_app.session.session import Session
from cpm_app.session.session_messages import OPENING_CATEGORY
from cpm_app.session.tasks.tasks import ENDED_TASK, BackgroundTask
from cpm_core import Image
from cpm_core.formats.images.readers import load_channel
from cpm_core.numerics.types import copy_with


class ChannelImages(QObject):
    """Reads the wanted channels, one by one, and each only once while the same part of the file is open."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._part: tuple[object, ...] = ()
        """The part of the file that is open, apart from its channel."""
        self._open_channel = 0
        self._listed: tuple[Channel, ...] = ()
        """The channels of the file, without images."""
        self._known: dict[int, Channel] = {}
        """The channels that have been read, or could not be, by their indices."""
        self._wanted: Set[int] = frozenset()
        self._task = ENDED_TASK
        session.store.add_listener(ImageOpened, self._on_image_opened)

    def show(self, wanted: Set[int]) -> None:
        """Show these channels of the open file, by their indices; those that are not known yet are read first."""
        self._wanted, scene, others = wanted, self._session.scene, wanted - {self._open_channel}
        shown = (self._known.get(index, one) if index in others else one for index, one in enumerate(self._listed))
        if (channels := tuple(shown)) != scene.channels:
            self._session.store.set_scene(replace(scene, channels=channels))
        missing = wanted - self._known.keys()
        if missing and self._task.is_over:
            index, name = min(missing), self._opened.path.name
            self._known[index] = self._listed[index]  # a channel that cannot be read is read only once
            title, activity = tr("Reading {name}…", name=name), tr("reading {name}", name=name)
            use, fail = partial(self._use, self._part, index), partial(self._on_failure, self._part, index)
            read = partial(_read_channel, self._opened, self._listed[index], index)
            self._task = self._session.tasks.start_task(
                title, read, activity, lambda reason: WorkFinished(partial(fail, reason)), on_result=use
            )

    def _on_image_opened(self, opened: ImageOpened) -> None:
        """Forget the channels, unless another one of the same part of the file is open now."""
        self._opened, self._listed = opened, self._session.scene.channels
        self._open_channel = here = (opened.reading.channel or 1) - 1
        part = opened.path, opened.sha256, replace(opened.reading, channel=None), opened.image.shape
        if part != self._part:
            self._task.cancel()
            self._part, self._known, self._task = part, {}, ENDED_TASK
        if self._listed:
            channel = _judge_background(self._listed[here], opened.image)
            self._known[here] = replace(channel, image=opened.image, display=opened.display)
            for each in tuple(self._known.items()):
                self._keep(*each)
            self.show(self._known.keys())

    def _use(self, part: tuple[object, ...], index: int, channel: Channel) -> None:
        if part == self._part:
            self._task = ENDED_TASK
            self._keep(index, channel)
            self.show(self._wanted)

    def _keep(self, index: int, channel: Channel) -> None:
        """Keep a channel, and whether it is bright, also while it is not shown."""
        self._known[index] = channel
        listed = replace(self._listed[index], is_bright=channel.is_bright)
        self._listed = (*self._listed[:index], listed, *self._listed[index + 1 :])

    def _on_failure(self, part: tuple[object, ...], index: int, reason: str) -> None:
        """Say why a channel is not shown, and read the others."""
        if part == self._part:
            text = tr("Channel {name} is not shown: {reason}", name=self._listed[index].name, reason=reason)
            self._session.messages.show(text, True, OPENING_CATEGORY)
            self._use(part, index, self._listed[index])


def _judge_background(channel: Channel, image: Image) -> Channel:
    return replace(channel, is_bright=channel.is_bright or has_bright_background(image))


def _read_channel(opened: ImageOpened, channel: Channel, index: int, _: BackgroundTask) -> Channel:
    """Read another channel of the open part; half of the memory of a volume is enough to show it."""
    reading, in_volume = replace(opened.reading, channel=index + 1), opened.image.ndim == 3
    image = load_channel(opened.path, reading, in_volume, opened.sha256)
    channel = _judge_background(channel, image)  # which also caches the range that is shown
    if not in_volume:
        return replace(channel, image=image, display=build_display_image(image))
    values = image.stored.astype(np.float32)
    return replace(channel, image=copy_with(image, stored=values, values=values))
