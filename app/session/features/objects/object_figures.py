"""Figures of objects that take a while: gray values, and what the surfaces of objects in a volume measure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from app.model.volume.surface_section import prepare
from cpm_core.contours.surface import Surface
from cpm_core.image.image import Image
from cpm_core.objects.segmented.segmented_object import SegmentedObject


@dataclass(frozen=True, slots=True)
class Figures:
    """Figures of an object.

    Attributes
    ----------
    gray : float
        Mean gray value; NaN where it has no pixel.
    volume, area : float
        Of an object in a volume, in the unit of the image; 0 in an image, as the rest.
    parts, euler : int
        Parts of its surface that do not hang together, and its Euler characteristic.
    """

    gray: float
    volume: float = 0.0
    area: float = 0.0
    parts: int = 0
    euler: int = 0


@dataclass(frozen=True, eq=False, slots=True)
class AllFigures:
    """Figures of objects in an image by their numbers, each with the boundary that it had."""

    image: Image
    known: Mapping[int, tuple[object, Figures]]

    def of(self, item: SegmentedObject) -> Figures | None:
        """Those of an object; None if they are not known, or it has another boundary by now."""
        boundary, figures = self.known.get(item.number, (None, None))
        return figures if boundary is _boundary(item) else None

    def with_all(self, items: Iterable[SegmentedObject]) -> AllFigures:
        """Those of all these objects."""
        found = ((item, self.of(item)) for item in items)
        return AllFigures(
            self.image,
            {item.number: (_boundary(item), known or _measured(item, self.image)) for item, known in found},
        )


def _boundary(item: SegmentedObject) -> object:
    return item.surface or item.boundary


def _measured(item: SegmentedObject, image: Image) -> Figures:
    inside = item.mask(image.shape)
    gray = float(image.values[inside].mean()) if inside.any() else float("nan")
    if item.body is None:
        return Figures(gray)
    prepare(item.body)  # slices are cut on the window's thread, and limits made of it
    assert all(len(packed.shell.mask) for packed in item.surface)
    surface: Surface = replace(item.body, spacing=image.spacing, unit=image.unit)
    return Figures(gray, surface.volume, surface.area, surface.components, surface.euler)
