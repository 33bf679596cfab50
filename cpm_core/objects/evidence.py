"""Evidence: how much speaks for a face being inside or outside, before any boundary is looked at."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.types import Array, Mask
from cpm_core.objects.faces.face_graph import FaceGraph

RIM, RIM_WITH_OUTSIDE = 2.0, 2.0
"""Price of an object that touches the border of the image, for each pixel of it: while nothing has been said to be
outside, and afterwards."""


def evidence(graph: FaceGraph, inside: Mask, outside: Mask) -> tuple[Array, Array]:
    """Price of each face being outside, and of its being inside, two arrays of shape (F,), infinite for what is sure.

    `inside` and `outside`, shape (F,), are the faces that have been clicked.
    """
    rim = graph.rim * (RIM_WITH_OUTSIDE if outside.any() else RIM)
    return np.where(inside, np.inf, 0.0), np.where(outside, np.inf, np.where(inside, 0.0, rim))
