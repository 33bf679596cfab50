"""The channels of a file, which a composite shows together, each in its color."""

from __future__ import annotations

import re

import numpy as np

from cpm_app.model.display.display_image import DisplayImage
from cpm_app.model.text.language import tr
from cpm_app.model.volume.parts import FileParts
from cpm_core import Image
from cpm_core.image.gray_levels import sample_values
from cpm_core.numerics.types import record

CHANNEL_COLORS: dict[str, str] = {
    "#ff0000": tr("Red"),
    "#00ff00": tr("Green"),
    "#0000ff": tr("Blue"),
    "#ffffff": tr("Gray"),
    "#00ffff": tr("Cyan"),
    "#ff00ff": tr("Magenta"),
    "#ffff00": tr("Yellow"),
}
"""Titles of the usual colors, in the order in which channels without a color of their own get them, as in ImageJ."""

_TRANSMITTED_LIGHT = re.compile(
    r"bright.?field|transmitted|phase.?contrast|(?<!\b[sm].)\bphase$|hoffman|oblique|(?<![a-z])(bf|dic|tl|t.?pmt)(?![a-z])",
    re.IGNORECASE,
)
"""Names of channels of transmitted light, and of methods of contrast with it; the S phase is one of cells."""


@record
class Channel:
    """A channel of the open file.

    Attributes
    ----------
    name : str
        Its number, and its name where the file states it.
    color : str
        Its color in the file, or else the usual one.
    image : Image or None
        What it shows; None for the open channel, and until it is wanted and has been read.
    display : DisplayImage or None
        The image, or a slice of the volume, with its full range of gray values.
    is_bright : bool
        Whether its background is bright, by its name or once it has been read: other channels would drown in it.
    """

    name: str
    color: str
    image: Image | None = None
    display: DisplayImage | None = None
    is_bright: bool = False


def has_bright_background(image: Image) -> bool:
    """Return whether most of an image is brighter than the middle of its range, as with transmitted light."""
    return float(np.median(sample_values(image.stored))) > 0.5 * sum(image.shown_range)


def list_channels(parts: FileParts | None) -> tuple[Channel, ...]:
    """List the channels of a file; none where there is only one, or where they are red, green and blue.

    Colors that are all the same say nothing: programs write white where nobody has chosen any.
    """
    if parts is None or not parts.has_composite:
        return ()
    usual, styles = tuple(CHANNEL_COLORS), parts.channel_styles
    if len(styles) != parts.channels:
        styles = (("", ""),) * parts.channels
    stated = len({color for _, color in styles}) > 1
    return tuple(
        Channel(
            f"{index + 1} {name}".strip(),
            (stated and color) or usual[index % len(usual)],
            is_bright=bool(_TRANSMITTED_LIGHT.search(name)),
        )
        for index, (name, color) in enumerate(styles)
    )
