"""What can be shown over the image that is worked out on the worker thread: one function for each by name.

Adding one is adding a line to `OVERLAYS`; a layer asks for it by its name with `Session.want_overlay`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from app.model import shades
from app.model.iso_lines import iso_lines
from cpm_core.engine import Engine
from cpm_core.parameters import Parameters

OVERLAYS: Mapping[str, Callable[[Engine, Parameters], NDArray[np.generic]]] = MappingProxyType(
    {
        "edge_map": lambda engine, parameters: shades.of_edge_map(engine.edge_map(parameters)),
        "field": lambda engine, parameters: engine.field(parameters),
        "potential": lambda engine, parameters: shades.of_potential(engine.potential(parameters)),
        "iso_lines": lambda engine, parameters: iso_lines(engine.potential(parameters)),
    }
)
"""Shades of the edge map and of the potential, shape (H, W); direction in which edges pull, shape (2, H, W); lines of
equal potential, shape (M, 2), with a row of NaN behind each."""
