"""Array types of the whole program; shapes and units are given where the types are used."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Positions, forces, images: values in double precision."""

Single = NDArray[np.float32]
"""Values in single precision, where that is enough and faster."""

Index = NDArray[np.int64]
"""Indices and counts."""

Mask = NDArray[np.bool_]
"""Which of some things are chosen, or which pixels."""

Pixels = NDArray[np.uint8]
"""Pixels for the screen, (H, W) or (H, W, 3)."""

Position = Annotated[tuple[float, ...], 2]
"""A position (row, col) [px]; the annotation is how many numbers it has in files."""

Place = Annotated[tuple[float, ...], 2, 3]
"""A position (row, col) in an image or (plane, row, col) in a volume [px, voxels]."""

Voxel = Annotated[tuple[float, ...], 3]
"""A position (plane, row, col) [voxels]."""

Extent = tuple[int, ...]
"""How many pixels or voxels there are along each axis."""

Sides = tuple[float, ...]
"""Side of a pixel or voxel along each axis."""
