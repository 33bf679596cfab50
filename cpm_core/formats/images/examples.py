"""Small synthetic images for trying things out."""

from __future__ import annotations

import numpy as np

from cpm_core.image.image import Image
from cpm_core.numerics.types import Array, Numbers
from cpm_core.parameters.formatting import quote_value

_BRIGHT_LEVEL = 200.0
"""Gray level of the drawn objects."""


def example(name: str = "disk") -> Image:
    """Draw a small image for trying things out.

    Parameters
    ----------
    name : {"disk", "ring", "disks", "gap", "colors", "ball"}
        Image to draw, with smooth edges: a disk of radius 20 around (32, 32), a ring of radii 10 and 24 there, two
        disks of radius 10 around (32, 18) and (32, 46), a disk with fog over its right edge, a red disk on a green
        background; and a volume with a ball of radius 9 around (15, 15, 15).

    Returns
    -------
    Image
        Of 64 x 64 px, each 0.5 µm wide, or of 31 x 31 x 31 voxels of 1 mm.

    Raises
    ------
    ValueError
        When there is no such example.

    Examples
    --------
    >>> cpm.example("disk")
    <Image disk, 64 x 64 px, 0.5 µm a pixel>
    >>> cpm.example("ball").shape
    (31, 31, 31)
    """
    disk, fog = _draw_disk(32, 20.0), np.exp(-0.5 * (_distance_from(32, 52) / 6.0) ** 2)
    red = disk / _BRIGHT_LEVEL
    drawn: dict[str, Numbers] = {
        "disk": disk,
        "ring": _draw_disk(32, 24.0) - _draw_disk(32, 10.0),
        "disks": _draw_disk(18, 10.0) + _draw_disk(46, 10.0),
        "gap": disk * (1.0 - fog) + 0.5 * _BRIGHT_LEVEL * fog,
        "colors": np.stack([40 + 180 * red, 140 - 90 * red, 60 + 0 * red], axis=-1).astype(np.uint8),
        "ball": _BRIGHT_LEVEL * _smooth_step(np.linalg.norm(np.indices((31, 31, 31)) - 15.0, axis=0), 9.0),
    }
    if not isinstance(name, str) or name not in drawn:
        raise ValueError(f"there is no example {quote_value(name)}: choose one of {', '.join(drawn)}.")
    if name == "ball":
        return Image(drawn[name], (1.0, 1.0, 1.0), "mm", name)
    return Image(drawn[name], (0.5, 0.5), "µm", name)


def _smooth_step(distance: Array, radius: float) -> Array:
    """Return 1 inside a radius and 0 outside, with a ramp one pixel wide, by distances of any shape."""
    return np.clip(radius + 0.5 - distance, 0.0, 1.0)


def _distance_from(row: float, col: float) -> Array:
    """Return the distance of each pixel from a position, shape (64, 64)."""
    return np.hypot(*(np.indices((64, 64)) - np.array([row, col])[:, None, None]))


def _draw_disk(col: float, radius: float) -> Array:
    """Draw a disk halfway down, shape (64, 64)."""
    return _BRIGHT_LEVEL * _smooth_step(_distance_from(32, col), radius)
