"""The images whose edges are taken, at all scales: gray levels in their tone or a vessel measure, cleaned if asked.

Each is made on first use. None of them depends on the regions.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, field
from threading import RLock
from typing import NamedTuple

from cpm_core.field.edge_map import automatic_smoothing, prepared
from cpm_core.image.colors import Colors, channel_of
from cpm_core.image.denoising import Cleaned
from cpm_core.image.gray_levels.tone import toned
from cpm_core.image.pyramid import pyramid
from cpm_core.image.vesselness import vesselness
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters

_KEPT = 2
"""Images that are kept beside the original, so that a return to the last one costs nothing."""


class Source(NamedTuple):
    r"""What the edges of a scale are taken from.

    Attributes
    ----------
    values : ndarray, shape (\*shape)
        Image at the scale.
    smoothing : float
        Gaussian before the gradient [px].
    floor : float
        Edge floor that the noise left by the cleaning needs, as a fraction of the largest edge strength.
    """

    values: Array
    smoothing: float
    floor: float


@dataclass(eq=False, slots=True)
class _Images:
    """One image at all scales, and what the automatic smoothing has made of it."""

    images: tuple[Array, ...]
    cleaned: tuple[tuple[Array, ...], Cleaned] | None = None
    sigmas: dict[int, float] = field(default_factory=dict)


class SourceImages:
    r"""The images of an image of shape (\*shape) at `scales` scales, for any parameters; threads may share it.

    `image` is its luminance where it has `colors`, whose channels are taken if asked.
    """

    def __init__(self, image: Array, scales: int, colors: Colors | None = None) -> None:
        self._original = _Images(pyramid(image, scales))
        self._colors = colors
        self._kept: OrderedDict[tuple[str, str, float | str], _Images] = OrderedDict()
        self._lock = RLock()

    def __len__(self) -> int:
        return len(self._original.images)

    def shape(self, scale: int) -> tuple[int, ...]:
        """Shape of the image at a scale."""
        return self._original.images[scale].shape

    def at(self, scale: int, parameters: Parameters) -> Source:
        """Source of a scale, for `channel`, `edges`, `gamma` and `smoothing`."""
        with self._lock:
            made = self._of(parameters)
            if parameters.smoothing != "auto":
                return Source(made.images[scale], parameters.smoothing, 0.0)
            images, cleaned = self._cleaned(made)
            return Source(images[scale], self._smoothing(made, scale), cleaned.floor)

    def _of(self, parameters: Parameters) -> _Images:
        channel = "luminance" if self._colors is None else parameters.channel
        key = channel, parameters.edges, parameters.gamma
        if key not in self._kept:
            values = toned(self._channel(channel), parameters.gamma)
            if parameters.edges == "vessels":
                values = vesselness(values)
            made = self._original if values is self._original.images[0] else _Images(pyramid(values, len(self)))
            self._kept[key] = made
        self._kept.move_to_end(key)
        while len(self._kept) > _KEPT:
            self._kept.popitem(last=False)
        return self._kept[key]

    def _channel(self, name: str) -> Array:
        """Gray levels of a channel; ValueError when they are the same everywhere."""
        values = channel_of(self._original.images[0], self._colors, name)
        if values is not self._original.images[0] and values.min() == values.max():
            raise ValueError(f"The channel {name} is the same everywhere and has no edges: choose another channel.")
        return values

    def _cleaned(self, made: _Images) -> tuple[tuple[Array, ...], Cleaned]:
        """The image as the automatic smoothing prepares it, at all scales."""
        if made.cleaned is None:
            ready = prepared(made.images[0])
            same = ready.image is made.images[0]
            made.cleaned = (made.images if same else pyramid(ready.image, len(self)), ready)
        return made.cleaned

    def _smoothing(self, made: _Images, scale: int) -> float:
        """Sigma of the automatic smoothing at a scale [px]."""
        images, ready = self._cleaned(made)
        if scale == 0 or images is not made.images:  # a cleaned image needs the same smoothing at all scales
            return ready.sigma
        if scale not in made.sigmas:
            made.sigmas[scale] = automatic_smoothing(images[scale])
        return made.sigmas[scale]
