"""Draw the sample images and the starts that go with them; everything here is made up by formulas.

Run ``python assets/samples/make_samples.py`` to write them anew beside this file, or name another folder.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import PIL.Image
from numpy.typing import NDArray

Grid = NDArray[np.float64]
Shape = Callable[[Grid, Grid], NDArray[np.bool_]]
Circle = tuple[float, float, float]

SIDE = 256
OVERSAMPLING = 8


def coverage(shape: Shape, side: int = SIDE) -> Grid:
    """Share of each pixel that a shape covers, from 8 x 8 points in it; `shape` tells which (row, col) lie inside."""
    offsets = (np.arange(OVERSAMPLING) + 0.5) / OVERSAMPLING - 0.5
    pixels = np.arange(side, dtype=np.float64)
    total = np.zeros((side, side))
    for down in offsets:
        for right in offsets:
            total += shape((pixels + down)[:, np.newaxis], (pixels + right)[np.newaxis, :])
    return total / OVERSAMPLING**2


def disk(center: tuple[float, float], radius: float) -> Shape:
    """Disk about (row, col)."""
    return lambda row, col: np.hypot(row - center[0], col - center[1]) <= radius


def ellipse(center: tuple[float, float], half_height: float, half_width: float) -> Shape:
    """Upright ellipse about (row, col)."""
    return lambda row, col: np.hypot((row - center[0]) / half_height, (col - center[1]) / half_width) <= 1


def rectangle(top: float, left: float, bottom: float, right: float) -> Shape:
    """Upright rectangle between two corners."""
    return lambda row, col: (row >= top) & (row <= bottom) & (col >= left) & (col <= right)


def cell(center: tuple[float, float], radius: float, dents: Grid, turns: Grid) -> Shape:
    """Disk about (row, col) whose radius rises and falls twice and three times around by the shares `dents`."""

    def inside(row: Grid, col: Grid) -> NDArray[np.bool_]:
        angle = np.arctan2(row - center[0], col - center[1])
        rim = 1 + dents[0] * np.cos(2 * angle + turns[0]) + dents[1] * np.cos(3 * angle + turns[1])
        return np.hypot(row - center[0], col - center[1]) <= radius * rim

    return inside


def blur(values: Grid, sigma: float) -> Grid:
    """Gaussian blur, borders continued by their last value."""
    reach = int(4 * sigma + 1)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    weights /= weights.sum()
    for axis in (0, 1):
        values = np.apply_along_axis(
            lambda line: np.convolve(np.pad(line, reach, mode="edge"), weights, mode="valid"), axis, values
        )
    return values


def noise(seed: int, side: int = SIDE) -> Grid:
    """Normal noise of unit spread; the old generator, whose numbers are promised never to change."""
    return np.random.RandomState(seed).standard_normal((side, side))


def u_shape() -> tuple[Grid, list[Circle]]:
    """A thick white U, open at the top, on black."""

    def inside(row: Grid, col: Grid) -> NDArray[np.bool_]:
        outer = rectangle(44, 48, 132, 208)(row, col) | disk((132, 128), 80)(row, col)
        inner = rectangle(0, 98, 132, 158)(row, col) | disk((132, 128), 30)(row, col)
        return outer & ~inner

    return 255 * coverage(inside), [(100, 73, 38)]


def rings() -> tuple[Grid, list[Circle]]:
    """Objects in objects, each of another grey level."""
    values = np.full((SIDE, SIDE), 25.0)
    for shape, level in (
        (ellipse((128, 128), 100, 112), 110.0),
        (disk((112, 84), 48), 200.0),
        (disk((112, 84), 24), 40.0),
        (rectangle(100, 152, 176, 208), 235.0),
        (rectangle(122, 168, 154, 192), 140.0),
    ):
        share = coverage(shape)
        values = values * (1 - share) + level * share
    return values, [(120, 128, 80)]


def noisy() -> tuple[Grid, list[Circle]]:
    """An ellipse with a hole under heavy noise."""
    inside = coverage(ellipse((128, 128), 78, 100)) - coverage(ellipse((120, 140), 30, 38))
    return 80 + 95 * inside + 30 * noise(20), [(128, 70, 44)]


def cells() -> tuple[Grid, list[Circle]]:
    """Bright cells that do not touch, a little out of focus, on a background that is brighter to one side."""
    random = np.random.RandomState(7)
    side, wanted, gap, margin, reach = 320, 16, 12.0, 24.0, 32
    placed: list[Circle] = []
    while len(placed) < wanted:
        row, col = random.uniform(margin, side - margin, 2)
        radius = random.uniform(13, 21)
        if all(np.hypot(row - r, col - c) > 1.2 * (radius + other) + gap for r, c, other in placed):
            placed.append((row, col, radius))
    light = np.zeros((side + 2 * reach, side + 2 * reach))
    for row, col, radius in placed:
        dents, turns, level = random.uniform(0.03, 0.13, 2), random.uniform(0, 2 * np.pi, 2), random.uniform(95, 150)
        top, left = int(row), int(col)
        outline = cell((row - top + reach, col - left + reach), radius, dents, turns)
        light[top : top + 2 * reach, left : left + 2 * reach] += level * coverage(outline, 2 * reach)
    down, right = np.mgrid[:side, :side] / side
    background = 28 + 34 * down + 18 * np.sin(2.2 * right)
    values = blur(light[reach:-reach, reach:-reach], 1.3) + background + 4 * noise(5, side)
    return values, [(round(row), round(col), round(0.8 * radius)) for row, col, radius in placed]


SAMPLES = (
    ("u_shape.png", "U shape", u_shape, "shape", "A circle over one arm finds the whole U."),
    ("cells.png", "Cells", cells, "shape", "One circle in each cell; the background is uneven."),
    ("rings.png", "Objects in objects", rings, "shape", "Contours inside contours, all found from one circle."),
    (
        "noisy.png",
        "Noise",
        noisy,
        "noisy",
        "An ellipse with a hole under heavy noise; smoothing is chosen from the noise.",
    ),
)


def write(folder: Path) -> None:
    """Write every image and ``samples.json``, the list of them, into `folder`."""
    entries = []
    for file, title, draw, preset, about in SAMPLES:
        values, circles = draw()
        grey = np.clip(np.rint(values), 0, 255).astype(np.uint8)
        PIL.Image.fromarray(grey).save(folder / file, optimize=True)
        entries.append({"title": title, "file": file, "about": about, "preset": preset, "circles": circles})
    lines = ",\n".join("  " + json.dumps(entry) for entry in entries)
    (folder / "samples.json").write_text(f"[\n{lines}\n]\n", encoding="utf-8")


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
