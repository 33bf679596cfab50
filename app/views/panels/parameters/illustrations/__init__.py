"""One small animated illustration per control: its effect at its value, drawn as simply as possible.

Each is a function of a sketch, the value and the time of the loop from 0 to 1. Some follow a law of motion, others
only show a rule; none of them runs the model itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from app.views.panels.parameters.illustrations import contours, image, particles, skeletons
from app.views.panels.parameters.illustrations.sketch import Sketch

Illustrate = Callable[[Sketch, float, float], None]

ILLUSTRATIONS: Mapping[str, Illustrate] = MappingProxyType(
    {
        "reach": contours.reach,
        "weakest_edge": contours.weakest_edge,
        "beta": particles.damping,
        "ratio": particles.ratio,
        "w2": particles.pull,
        "annealing": particles.annealing,
        "time_step": particles.time_step,
        "d_min": particles.d_min,
        "d_max": particles.d_max,
        "smoothing": image.smoothing,
        "gamma": image.gamma,
        "scales": image.scales,
        "edge_floor": image.edge_floor,
        "exponent": image.exponent,
        "max_border": image.max_border,
        "max_gap": contours.max_gap,
        "min_strength": contours.min_strength,
        "sure_edge": contours.sure_edge,
        "min_contrast": contours.min_contrast,
        "min_length": contours.min_length,
        "polarity": skeletons.polarity,
        "max_width": skeletons.max_width,
        "pruning": skeletons.pruning,
    }
)
"""Illustrations by the names of their controls."""
