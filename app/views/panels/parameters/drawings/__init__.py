"""One small animated drawing a control: what it does, as simple as it can be drawn, at the value that it has.

Each is a function of a sketch, the value and the time from 0 to 1 of a loop. Some follow a law of motion, others only
show a rule; none is the model itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from app.views.panels.parameters.illustrations import contours, image, particles
from app.views.panels.parameters.illustrations.sketch import Sketch

Drawing = Callable[[Sketch, float, float], None]

ILLUSTRATIONS: Mapping[str, Drawing] = MappingProxyType(
    {
        "beta": moving.damping,
        "ratio": moving.ratio,
        "w2": moving.pull,
        "annealing": moving.annealing,
        "time_step": moving.time_step,
        "d_min": moving.d_min,
        "d_max": moving.d_max,
        "smoothing": looking.smoothing,
        "scales": looking.scales,
        "edge_floor": looking.edge_floor,
        "max_border": looking.max_border,
        "max_gap": choosing.max_gap,
        "min_strength": choosing.min_strength,
        "sure_edge": choosing.sure_edge,
        "min_contrast": choosing.min_contrast,
        "min_length": choosing.min_length,
    }
)
"""By the names of the controls."""
