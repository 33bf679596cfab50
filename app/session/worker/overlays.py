"""What can be shown over the image that is worked out on the worker thread: one function for each by name.

Adding one is adding a line to `OVERLAYS`; a layer asks for it by its name with `Session.want_overlay`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from app.model.display.display_image import display_of_edge_map, display_of_potential
from app.model.display.iso_lines import iso_lines
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.parameters import Parameters
from cpm_core.segmentation.engine import Engine

Overlay = Callable[[Engine, Parameters, Sequence[PlacedCharge]], NDArray[np.generic]]

OVERLAYS: Mapping[str, Overlay] = MappingProxyType(
    {
        "edge_map": lambda engine, parameters, _: display_of_edge_map(engine.edge_map(parameters)),
        "field": lambda engine, parameters, charges: engine.field(parameters, 0, charges),
        "potential": lambda engine, parameters, charges: display_of_potential(engine.potential(parameters, charges)),
        "iso_lines": lambda engine, parameters, charges: iso_lines(engine.potential(parameters, charges)),
    }
)
"""Shades of the edge map and of the potential, shape (H, W); direction in which edges and placed charges pull, shape
(2, H, W); lines of equal potential, shape (M, 2), with a row of NaN behind each."""
