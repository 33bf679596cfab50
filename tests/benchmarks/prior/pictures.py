"""Pictures to learn from: those that people have outlined, and drawings whose outline is where they end."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import skimage
from numpy.typing import NDArray
from PIL import Image

from cpm_core.numerics.types import Array, Index, Mask, Pixels

HELD_OUT = 5
"""The outlines of the first of so many images of a kind, and of every one so many later, are for measuring alone."""

LEARNED = (
    "axons_sem",
    "cakes_kuih",
    "cats",
    "cells_phase_t98g",
    "chloroplasts_em",
    "circuit_boards",
    "coating_layers",
    "cutouts3d_animals",
    "cutouts3d_food_plants",
    "cutouts3d_objects",
    "cutouts3d_vehicles_buildings",
    "cutouts_freedoom",
    "desk_objects",
    "electronic_parts",
    "embryos",
    "facades",
    "flakes_2d_materials",
    "granular_ore",
    "lab_bottles",
    "maize_kernels",
    "melt_pools",
    "ms_lesions_mr",
    "mushrooms_crop",
    "nanocrystals_sem",
    "nuclei",
    "photo_objects_coco",
    "plant_cells_confocal",
    "plant_nuclei_3d",
    "plants_pots",
    "sand_gravel_grains",
    "spinal_cord_mr",
    "strawberries",
    "strawberry_plant_parts",
    "superalloy_precipitates",
    "tomato_leaves",
    "tree_limbs",
)
"""Kinds that the network has learned from; of all others, every image is for measuring."""

SAMPLES = (
    "astronaut",
    "coffee",
    "chelsea",
    "camera",
    "rocket",
    "retina",
    "ihc",
    "coins",
    "moon",
    "brick",
    "grass",
    "gravel",
    "hubble_deep_field",
    "cell",
    "microaneurysms",
    "page",
    "text",
)
"""Files of scikit-image that are looked at."""

OBJECTS_OF_AN_IMAGE, _OBJECTS_OF_A_KIND = 4, 200
"""Objects of an image at most; more where a kind has so few images that it would give less than the second number."""

_LEAST_OF_A_LOOK = 20
"""Images in color and in gray, of each of which a kind must have so many for these to be two kinds."""

_MIN_TINT = 5
"""Mean range of the channels of a pixel in an image that is in color [gray levels]."""

_AROUND = 160
"""Pixels to each side of the middle of an object that are kept of its image."""

_MIN_AREA = 60
"""The smallest objects [px]."""

_MOST_SHARE = 0.5
"""Share of the image above which a labeled region is what lies behind the objects."""

_LABELS = "_labels.png"


class Example(NamedTuple):
    """An object in an image.

    Attributes
    ----------
    image : ndarray of uint8, shape (H, W, 3) or (H, W, 1)
        The image; one channel where it is gray, to save memory.
    mask : ndarray of bool, shape (H, W)
        The object.
    hit : ndarray of bool, shape (H, W), optional
        Where a user may point at it; anywhere in it if None.
    """

    image: Pixels
    mask: Mask
    hit: Mask | None = None


def in_color(image: NDArray[np.uint8]) -> Pixels:
    """An image with three channels, whatever it had before."""
    if image.ndim == 2:
        image = np.repeat(image[..., None], 3, axis=2)
    return np.ascontiguousarray(image[..., :3].astype(np.uint8))


def outlined(folders: Sequence[Path], chance: random.Random) -> dict[str, list[Example]]:
    """Objects of each labeled image, without those held out, by the names of the folders.

    A kind of which many images are in color and many in gray, such as nuclei in stained tissue and in fluorescence, is
    two kinds.

    Parameters
    ----------
    folders : sequence of Path
        One for each kind, with images ``NAME.png`` or ``NAME.jpg`` and labels ``NAME_labels.png``.
    chance : random.Random
        Chooses the objects.
    """
    kinds = {}
    for folder in folders:
        labeled = sorted(folder.glob("*" + _LABELS))
        kept = [path for number, path in enumerate(labeled) if number % HELD_OUT]
        tinted = [path for path in kept if np.ptp(labeled_image(path).astype(int), axis=-1).mean() > _MIN_TINT]
        looks = {folder.name: kept}
        if min(len(tinted), len(kept) - len(tinted)) >= _LEAST_OF_A_LOOK:
            in_gray = [path for path in kept if path not in tinted]
            looks = {folder.name + " in gray": in_gray, folder.name + " in color": tinted}
        for name, paths in looks.items():
            most = max(OBJECTS_OF_AN_IMAGE, _OBJECTS_OF_A_KIND // max(len(paths), 1))
            kinds[name] = [example for path in paths for example in objects_of(path, most, chance)]
    return kinds


def held_out_labels(folder: Path) -> list[Path]:
    """Files of labels of a folder that the network has not learned from."""
    return sorted(folder.glob("*" + _LABELS))[:: HELD_OUT if folder.name in LEARNED else 1]


def overlaps(mask: Mask, labels: Index) -> Array:
    """Overlap (intersection over union) of an object with each of those that are labeled, from number 1 on."""
    areas = np.bincount(labels.ravel())
    common = np.bincount(labels[mask], minlength=len(areas))
    return (common / (np.count_nonzero(mask) + areas - common))[1:]


def objects_of(path: Path, most: int, chance: random.Random) -> Iterator[Example]:
    """Some objects of the image that belongs to a file of labels, with what lies around them."""
    image, labels = labeled(path)
    areas = np.bincount(labels.ravel())
    fitting = [label for label in range(1, len(areas)) if _MIN_AREA <= areas[label] < _MOST_SHARE * labels.size]
    for label in chance.sample(fitting, min(most, len(fitting))):
        middle = (int(pixels.mean()) for pixels in np.nonzero(labels == label))
        part = tuple(slice(max(at - _AROUND, 0), at + _AROUND) for at in middle)
        yield Example(image[part], labels[part] == label)


def labeled(path: Path) -> tuple[Pixels, NDArray[np.uint8]]:
    """The image that belongs to a file of labels, and these."""
    labels = skimage.io.imread(path)
    return labeled_image(path), labels[..., 0] if labels.ndim == 3 else labels


def labeled_image(path: Path) -> Pixels:
    """The image that belongs to a file of labels."""
    stem = path.name.removesuffix(_LABELS)
    paths = (path.with_name(stem + ending) for ending in (".png", ".jpg"))
    return in_color(skimage.io.imread(next(each for each in paths if each.exists())))


def photographs(folders: Sequence[Path]) -> list[Pixels]:
    """All images of folders, without what is known about their objects."""
    paths = (path for folder in folders for path in sorted(folder.iterdir()))
    return [
        in_color(skimage.io.imread(path))
        for path in paths
        if path.suffix in {".png", ".jpg"} and not path.name.endswith(_LABELS)
    ]


def samples() -> list[Pixels]:
    """Images that come with scikit-image."""
    folder = Path(skimage.__file__).parent / "data"
    return [in_color(skimage.io.imread(next(folder.glob(name + ".*")))) for name in SAMPLES]


def drawings(folder: Path, chance: random.Random) -> list[Example]:
    """Drawings on transparent ground, each cut out along its outline.

    Of those that show horses none is taken, as horses are what the prior is measured on; of those of computers and
    their icons two fifths, as there are so many.

    Parameters
    ----------
    folder : Path
        Where the PNG files lie, in folders by what they show.
    chance : random.Random
        Chooses among the computers.
    """
    found = []
    # in the order of the whole names: that of the parts differs where a name begins with another
    for name in sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*.png")):
        if "horse" in name.lower():
            continue
        drawing = _drawing(folder / name)
        if drawing is None:
            continue
        if name.startswith("computer") and chance.random() < 0.6:
            continue
        found.append(_reduced(drawing, 128))
    return found


def _drawing(path: Path) -> Example | None:
    """A drawing without the ground, or None if it is no single object."""
    try:
        with Image.open(path) as file:
            if file.size[0] * file.size[1] > 4e7:
                return None
            picture = file.convert("RGBA")
    except (Image.DecompressionBombError, OSError, SyntaxError, ValueError):  # huge, or damaged
        return None
    picture.thumbnail((256, 256))
    values = np.asarray(picture)
    opaque = values[..., 3] > 127
    if not opaque.any() or opaque.all():
        return None
    main = largest_part(opaque, connectivity=8)
    if main.sum() < 0.85 * opaque.sum():
        return None
    mask, outlines = filled(main)
    if main.sum() / mask.sum() < 0.55:
        return None
    perimeter = sum(cv2.arcLength(outline, closed=True) for outline in outlines)
    roundness = 4 * math.pi * mask.sum() / perimeter**2
    rows, cols = np.nonzero(mask)
    box = np.s_[rows.min() : rows.max() + 1, cols.min() : cols.max() + 1]
    if min(mask[box].shape) < 40 or roundness < 0.06:
        return None
    if mask[box].mean() > 0.93:  # rectangles: flags and signs
        return None
    # small transparent parts inside the outline become white
    colors = np.where(values[..., 3:] / 255 > 0.5, values[..., :3], 255)
    return Example(colors[box].astype(np.uint8), mask[box])


def _reduced(drawing: Example, side: int) -> Example:
    """A drawing of at most so many pixels along its longer side."""
    image, mask, _ = drawing
    scale = side / max(mask.shape)
    if scale >= 1:
        return drawing
    image = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    size = (image.shape[1], image.shape[0])
    return Example(image, cv2.resize(mask.astype(np.uint8), size, interpolation=cv2.INTER_AREA) > 0)


def largest_part(mask: Mask, connectivity: int = 4) -> Mask:
    """The largest connected part of a mask; empty if the mask is."""
    if not mask.any():
        return mask
    _, parts, sizes, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=connectivity)
    return parts == 1 + sizes[1:, cv2.CC_STAT_AREA].argmax()


def filled(mask: Mask) -> tuple[Mask, Sequence[NDArray[np.int32]]]:
    """A mask without holes, and its outlines."""
    outlines, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    whole = np.zeros(mask.shape, np.uint8)
    cv2.drawContours(whole, outlines, -1, 1, -1)
    return whole > 0, outlines
