"""The drawn shapes as input of a run: starts, regions of interest and barriers, placed charges."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.image.image import Image
from cpm_core.image.region import Region
from cpm_core.image.regions import Regions
from cpm_core.image.volume_regions import AnyRegions, VolumeRegions
from cpm_core.numerics.types import NO_POINTS, Array, Extent, Line
from cpm_core.shapes.charge import Charge
from cpm_core.shapes.ellipse import Circle, Ellipse
from cpm_core.shapes.everywhere import Everywhere
from cpm_core.shapes.image_starts import NO_SEEDS, ImageSeeds, ImageStart, SeedCache
from cpm_core.shapes.lines import Barrier, Points, PolygonRegion
from cpm_core.shapes.measures import Oval
from cpm_core.shapes.shape import Shape, Start
from cpm_core.shapes.solids import BoxRegion, Cuboid, Sphere
from cpm_core.shapes.volume_limits import Enclosed, EnclosedRegion, EnclosingWall, Extruded, PrismRegion, Wall

_IMAGE_KINDS = {2: "images", 3: "volumes"}
"""Number of axes -> kind of image, plural."""

_ONE_IMAGE = {2: "an image", 3: "a volume"}
"""Number of axes -> kind of image, with its article."""

_IMAGE_ELEMENTS = {2: "pixels", 3: "voxels"}
"""Number of axes -> word for the elements."""


def count_axes(shape: Shape) -> int | None:
    """Count the axes of the images that a shape is for: 2, or 3 for a volume; None where any image will do."""
    match shape:
        case Everywhere():
            return None
        case Sphere() | Cuboid() | Extruded() | Enclosed():
            return 3
        case Circle() | Ellipse():
            return 2
        case Points():
            return len(shape.positions[0])
        case Charge():
            return len(shape.position)
        case Oval():
            return len(shape.center)
        case _:
            return len(shape.points[0])


def check_axes(shapes: Iterable[Shape], size: Extent = (), image: str = "the image") -> None:
    """Raise ValueError when shapes are not all for one kind of image, or not for an image of this size.

    An empty `size` says that the image is not known; `image` is its name.
    """
    axes, first = len(size), ""
    for number, shape in enumerate(shapes, 1):
        own, this = count_axes(shape), f"shape {number} ({shape.title})"
        if own is None:
            continue
        if size and own != axes:
            raise ValueError(
                f"{this} is for {_IMAGE_KINDS[own]}, but {image} is taken as {_ONE_IMAGE[axes]} of "
                f"{' x '.join(map(str, size))} {_IMAGE_ELEMENTS[axes]}: choose an image of the kind that "
                "the shapes were drawn in."
            )
        if axes and own != axes:
            raise ValueError(
                f"{this} is for {_IMAGE_KINDS[own]}, but {first} is for {_IMAGE_KINDS[axes]}: keep those of one kind."
            )
        axes, first = own, first or this


def select_starts(shapes: Iterable[Shape]) -> tuple[Start, ...]:
    """Select the shapes that give particles."""
    return tuple(shape for shape in shapes if isinstance(shape, Start))


def collect_regions(shapes: Iterable[Shape], barriers: tuple[Line | Region, ...] = ()) -> AnyRegions | None:
    """Collect regions of interest and barriers, with further given barriers; None when there are none."""
    drawn = tuple(shapes)
    inside = tuple(shape.limit for shape in drawn if isinstance(shape, BoxRegion | PrismRegion | EnclosedRegion))
    painted = [barrier for barrier in barriers if isinstance(barrier, Region)]
    walls = (*(shape.limit for shape in drawn if isinstance(shape, Wall | EnclosingWall)), *painted)
    if inside or walls:
        return VolumeRegions(inside, walls)
    interest = tuple(shape.points for shape in drawn if isinstance(shape, PolygonRegion))
    given = (barrier for barrier in barriers if not isinstance(barrier, Region))
    lines = (*(shape.points for shape in drawn if isinstance(shape, Barrier)), *given)
    return Regions(interest, lines) if interest or lines else None


def collect_charges(shapes: Iterable[Shape]) -> tuple[PlacedCharge, ...]:
    """Collect the placed charges."""
    return tuple(shape.placed_charge for shape in shapes if isinstance(shape, Charge))


def collect_seeds(shapes: Iterable[Shape], image_seeds: ImageSeeds = NO_SEEDS) -> Array:
    """Collect the positions of the particles of shapes, shape (N, 2), or (N, 3) in a volume, in their order.

    For starts that depend on the image the positions are taken from `image_seeds`.
    """
    found = [image_seeds[start] if isinstance(start, ImageStart) else start.seeds() for start in select_starts(shapes)]
    return np.concatenate(found) if found else NO_POINTS


def compute_seeds(image: Image, shapes: Iterable[Shape], smoothing: float | str, channel: str = "luminance") -> Array:
    """Compute the positions of the particles of shapes on an image, shape (N, 2), or (N, 3) in a volume.

    `smoothing` is the sigma of the Gaussian before the gradient [px], or "auto", for starts that depend on it.
    `channel` says what gives the gray levels of a color image.
    """
    drawn = tuple(shapes)
    check_axes(drawn, image.shape, image.source)
    dependent = [shape for shape in drawn if isinstance(shape, ImageStart)]
    return collect_seeds(drawn, SeedCache(image).seeds_for(dependent, smoothing, collect_regions(drawn), channel))
