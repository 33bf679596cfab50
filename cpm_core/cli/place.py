"""Where an image or volume lies and how large its voxels are, as lines for a person and as plain JSON."""

from __future__ import annotations

from cpm_core.image.image import Image

_AXES = ("planes", "rows", "columns")
_ENDS = {"L": "left", "R": "right", "P": "back", "A": "front", "S": "head", "I": "feet"}
_OBLIQUE = 0.05
"""Angle from which axes are called oblique [degrees]."""


def lines_on(image: Image) -> list[str]:
    """Size of a pixel or voxel, and orientation and position where they are known."""
    what = "pixel" if image.ndim == 2 else "voxel"
    if image.unit:
        sides = " x ".join(f"{side:g}" for side in image.spacing)
        order = " x ".join(("plane", "row", "column")[-image.ndim :])
        lines = [f"Size of a {what}: {sides} {image.unit} ({order})"]
    else:
        lines = [f"Size of a {what}: not given in the file"]
    geometry = image.geometry
    if geometry is None:
        return lines
    x, y, z = geometry.origin
    ways = [f"{axis} to the {_ENDS[letter]}" for axis, letter in zip(_AXES, geometry.letters, strict=True)]
    turned = f", up to {geometry.oblique:.1f}° oblique" if geometry.oblique >= _OBLIQUE else ""
    return [
        *lines,
        f"Orientation: {', '.join(ways[-image.ndim :])}{turned}",
        f"First {what}: at ({x:g}, {y:g}, {z:g}) {image.unit or 'voxels'}, {geometry.convention}",
    ]


def facts_on(image: Image) -> dict[str, object]:
    """The same as values by name."""
    geometry = image.geometry
    place = geometry and {
        "origin": list(geometry.origin),
        "directions": [list(direction) for direction in geometry.directions],
        "convention": geometry.convention,
        "letters": "".join(geometry.letters),
        "affine": geometry.affine(image.spacing).tolist(),
    }
    return {"spacing": list(image.spacing) if image.unit else None, "unit": image.unit, "geometry": place}
