"""Overlays of the image that are computed on the worker thread: one function for each name.

To add one, add a line to `OVERLAYS`; a layer requests it by its name with `Session.want_overlay`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from app.model.display.display_image import (
    DisplayImage,
    display_of_edge_map,
    display_of_potential,
    volume_of_edge_map,
    volume_of_potential,
)
from app.model.display.iso_lines import iso_lines
from app.model.text.language import tr
from app.model.volume.sampled_volumes import SampledForce, SampledValues
from app.session.exchange.error_messages import sentence
from app.session.exchange.mailbox import Mailbox
from app.session.exchange.messages import Drawn, Overlays
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.parameters import Parameters, invalidating
from cpm_core.segmentation.method import Method

_MOST_VOXELS = 1 << 26
"""Largest volume whose field is worked out, for which it takes 800 MB at a time."""

Overlay = Callable[[Method[Any], Parameters, Sequence[PlacedCharge]], Drawn]


def _edge_map(method: Method[Any], parameters: Parameters, charges: Sequence[PlacedCharge]) -> Drawn:
    found = method.edge_map(parameters)
    return volume_of_edge_map(found) if found.ndim == 3 else DisplayImage.of(display_of_edge_map(found))


def _potential(method: Method[Any], parameters: Parameters, charges: Sequence[PlacedCharge]) -> Drawn:
    found = method.potential(parameters, charges)
    return volume_of_potential(found) if found.ndim == 3 else DisplayImage.of(display_of_potential(found))


def _iso_lines(method: Method[Any], parameters: Parameters, charges: Sequence[PlacedCharge]) -> Drawn:
    """Lines of equal potential; the values of a volume, in whose slices they are found."""
    found = method.potential(parameters, charges)
    return SampledValues.of(found) if found.ndim == 3 else iso_lines(found)


def _field(method: Method[Any], parameters: Parameters, charges: Sequence[PlacedCharge]) -> Drawn:
    image = method.image
    if math.prod(image.shape) > _MOST_VOXELS:
        raise ValueError(tr("The volume is too large for arrows of the field: open a part of it, or reduce its size."))
    found = method.field(parameters, 0, charges)
    return SampledForce.of(found, image.spacing) if image.ndim == 3 else found


OVERLAYS: Mapping[str, Overlay] = MappingProxyType(
    {
        "edge_map": _edge_map,
        "field": _field,
        "potential": _potential,
        "iso_lines": _iso_lines,
    }
)
"""Display images of the edge map and of the potential, shape (H, W), or (P, R, C) of a volume; electric field of edges
and placed charges, shape (2, H, W); lines of equal potential, shape (M, 2), with a row of NaN after each. Of a volume
the last two are what their slices are made from."""


class OverlayMaker:
    """Computes the requested overlays again when what they depend on has changed."""

    def __init__(self, made: Mailbox[Overlays]) -> None:
        self._made = made
        self._wanted: frozenset[str] = frozenset()
        self._shown: tuple[object, ...] = ()

    def want(self, names: frozenset[str]) -> None:
        """Keep only these up to date."""
        self._wanted, self._shown = names, ()

    def refresh(
        self,
        image_generation: int,
        method: Method[Any] | None,
        parameters: Parameters,
        charges: Sequence[PlacedCharge],
    ) -> None:
        """Compute the requested overlays if they would differ from the last ones; without a method there are none."""
        if method is None or not self._wanted:
            return
        made_of = [getattr(parameters, name) for name in invalidating("field")]
        key = (method, self._wanted, charges, *made_of)
        if key == self._shown:
            return
        arrays, trouble = {}, ""
        for name in self._wanted:
            try:
                arrays[name] = OVERLAYS[name](method, parameters, charges)
            except Exception as error:  # the run does not depend on what is shown over the image
                trouble = sentence(error, tr("preparing what lies over the image"))
        self._made.put(Overlays(image_generation, arrays, trouble))
        self._shown = key
