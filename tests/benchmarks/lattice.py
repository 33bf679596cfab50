"""Objects of known outline on a lattice, in files larger than memory: how these are made, and what was found is judged.

`large_image` and `large_volume` say which objects there are.
"""

import time
from itertools import product

import numpy as np

from cpm_core.formats.images.ome_zarr import create_multiscale, halve_window, write_window
from cpm_core.numerics.grids import first_pixel, split_into_tiles, window_shape

REACH = 40
"""Distance from its center within which an object changes gray levels [px]."""

NOISE = 4.0


def count_along(side, pitch):
    """Number of objects along a side."""
    return int(side / pitch)


def draw_part(window, side, pitch, ground, paint):
    """Gray levels in a window; `paint` gives center, level, and share at positions from there of the object of a place.

    Positions are those along each axis, to be broadcast.
    """
    corner, last = first_pixel(window), count_along(side, pitch) - 1
    rng = np.random.default_rng([7, *corner.tolist()])
    values = rng.standard_normal(window_shape(window), np.float32) * NOISE + ground
    near = [
        range(max(int((at.start - REACH) / pitch) - 1, 0), min(int((at.stop + REACH) / pitch), last) + 1)
        for at in window
    ]
    for place in product(*near):
        center, level, cover = paint(place)
        low = np.maximum(np.floor(center - corner - REACH), 0).astype(int)
        high = np.minimum(np.ceil(center - corner + REACH), values.shape).astype(int)
        if (low < high).all():
            box = tuple(map(slice, low, high))
            values[box] += level * cover([at + a - b for at, a, b in zip(np.ogrid[box], corner, center, strict=True)])
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)


def make(path, shape, tile, size, draw):
    """Write what `draw` gives for each window, in levels of resolution; pixels have this size [µm]."""
    began = time.perf_counter()
    levels = create_multiscale(path, shape, np.uint8, tile, (size,) * len(shape), "µm")
    for window in split_into_tiles(shape, tile):
        write_window(path, window, draw(window))
    for level in range(1, levels):
        for window in split_into_tiles(tuple(-(-n // 2**level) for n in shape), tile):
            halve_window(path, level, window)
    print(f"made in {time.perf_counter() - began:.0f} s")


def print_verdict(title, found, away, back, tolerance, unit):
    """Print how often each object was found, and how far boundaries are apart, there and back."""
    found = np.array(found)
    precision, recall = (away <= tolerance).mean(), (back <= tolerance).mean()
    print(f"{len(found)} {title}: {(found == 1).sum()} found once, {(found == 0).sum()} missed, "
          f"{(found > 1).sum()} more than once; F {2 * precision * recall / (precision + recall):.5f} within "
          f"{tolerance:g} {unit}, {away.mean():.3f} {unit} apart on average, "
          f"{np.percentile(away, 99):.3f} for 99 %")  # fmt: skip
