"""How many clicks until an object is right: a robot for a user, on a folder of your images; prints a table.

    python -m tests.benchmarks.prior.clicks FOLDER ... [--images 10] [--color]

Next to an image ``a.png`` is its truth: ``a_mask.png``, not black where the object is, or ``a_labels.png``, a number
for each object, of which three are taken. The robot sees the truth. It clicks at the middle of the largest wrong place,
twenty times at most: what is missing as inside, what is too much as outside.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import PIL.Image

import cpm_core as cpm
from cpm_core.numerics.grids import measure_depth
from cpm_core.numerics.types import Array, Mask

MOST, GOALS, AFTER = 20, (0.85, 0.90), (1, 3, 5, 10)
"""Clicks at most, overlaps to be reached, and clicks after which the overlap is printed."""

_LEAST, _PER_IMAGE = 150, 3
"""Pixels of the smallest object of a label image that is taken, and objects of each such image."""


def objects(folder: Path, images: int, color: bool) -> Iterator[tuple[cpm.Image, Mask]]:
    """The image and the mask of each object."""
    truths = sorted([*folder.glob("*_mask.png"), *folder.glob("*_labels.png")])
    for truth in truths[:: max(1, len(truths) // images)][:images]:
        stem, kind = truth.stem.rsplit("_", 1)
        (path,) = (file for file in folder.glob(f"{stem}.*") if file.suffix in (".png", ".jpg", ".tif"))
        image = cpm.load_image(path)
        image = image if color else cpm.Image(image.values)
        labels = np.asarray(PIL.Image.open(truth)).reshape(*image.shape, -1)[..., 0].astype(int)
        if kind == "mask":
            yield image, labels > labels.max() / 2
            continue
        large = np.flatnonzero(np.bincount(labels.ravel())[1:] >= _LEAST) + 1
        for number in large[:: max(1, len(large) // _PER_IMAGE)][:_PER_IMAGE]:
            yield image, labels == number


def overlaps(image: cpm.Image, truth: Mask) -> Array:
    """Intersection over union after each click."""
    cut, answer, found = cpm.partition(image), None, np.zeros_like(truth)
    clicks: dict[bool, list[tuple[int, ...]]] = {True: [], False: []}
    reached: list[float] = []
    while len(reached) < MOST and found.tobytes() != truth.tobytes():
        depths = {}
        for inside in clicks:
            depths[inside] = measure_depth((truth != found) & (truth == inside))
            depths[inside][tuple(np.array(clicks[True] + clicks[False], int).reshape(-1, 2).T)] = 0.0
        inside = bool(depths[True].max() >= depths[False].max())
        clicks[inside].append(np.unravel_index(depths[inside].argmax(), truth.shape))
        answer = cut.select(clicks[True], clicks[False], previous=answer)
        found = answer.mask
        reached.append(np.count_nonzero(found & truth) / np.count_nonzero(found | truth))
    return np.array(reached + [1.0] * (MOST - len(reached)))


def main() -> None:
    """Print a line for each folder."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--images", type=int, default=10, help="of each folder, evenly spread")
    parser.add_argument("--color", action="store_true", help="in their colors, where they have any")
    given = parser.parse_args()
    print(f"{'kind':16}{'objects':>8}" + "".join(f"{f'to {goal}':>9}" for goal in GOALS), "  overlap after", *AFTER)
    for folder in given.folders:
        rows = np.array([overlaps(*each) for each in objects(folder, given.images, given.color)])
        clicks = [np.where((rows >= goal).any(axis=1), (rows >= goal).argmax(axis=1) + 1, MOST) for goal in GOALS]
        means = "".join(f"{each.mean():9.1f}" for each in clicks)
        print(f"{folder.name:16}{len(rows):8d}{means}   ", *(f"{rows[:, k - 1].mean():.2f}" for k in AFTER), flush=True)


if __name__ == "__main__":
    main()
