"""Draw the sample images and the starts that go with them; everything here is made up by formulas.

Run ``python assets/samples/make_samples.py`` to write them anew beside this file, or name another folder.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import PIL.Image
import tifffile
from numpy.typing import NDArray

Grid = NDArray[np.float64]
Shape = Callable[[Grid, Grid], NDArray[np.bool_]]
Circle = tuple[float, float, float]
Line = list[tuple[float, float]]
Way = list[tuple[float, float, float]]
Drawn = dict[str, object]
"""A shape as ``samples.json`` keeps it: the name of its kind, and its fields."""

SIDE = 256
OVERSAMPLING = 8
VOLUME = (56, 96, 96)
"""Planes, rows and columns of the volumes."""
VOXELS = {"vessels.tif": (0.6, 0.4, 0.4), "head.tif": (3.0, 2.0, 2.0)}
"""Size of a voxel [mm], by file."""
PICTURED = {"head.tif": 31}
"""Plane that the picture of a volume shows, by file; else the brightest voxels from plane to plane."""


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
    for axis in range(values.ndim):
        values = np.apply_along_axis(
            lambda line: np.convolve(np.pad(line, reach, mode="edge"), weights, mode="valid"), axis, values
        )
    return values


def noise(seed: int, side: int = SIDE) -> Grid:
    """Draw normal noise of unit spread, by the old generator, whose numbers are promised never to change."""
    return np.random.RandomState(seed).standard_normal((side, side))


def circles(*wanted: Circle) -> list[Drawn]:
    """Circles (row, col, radius) to start from."""
    return [{"shape": "circle", "center": [row, col], "radius": radius} for row, col, radius in wanted]


def curve(corners: Line | Way, count: int = 160) -> Grid:
    """Points on a smooth line through corners: a Catmull-Rom spline; each is (row, col), or (plane, row, col)."""
    given = np.array([corners[0], *corners, corners[-1]], dtype=np.float64)
    places = np.linspace(0, len(corners) - 1, count, endpoint=False)
    whole = places.astype(int)
    t = (places - whole)[:, np.newaxis]
    a, b, c, d = (given[whole + shift] for shift in range(4))
    return 0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3)


def tube(points: Grid, radii: Grid, side: int) -> Grid:
    """Length of the way that a ray from the viewer takes within a tube of round section, at every pixel [px]."""
    row, col = np.indices((side, side), dtype=np.float64)
    depth = np.zeros((side, side))
    for (r, c), radius in zip(points, radii, strict=True):
        depth = np.maximum(depth, radius**2 - (row - r) ** 2 - (col - c) ** 2)
    return 2 * np.sqrt(depth)


def vessel(inside: Grid, points: Grid, radii: Grid) -> None:
    """Raise `inside`, how far each voxel lies within vessels [columns], by one along points (plane, row, col)."""
    places = [np.arange(count) * side for count, side in zip(VOLUME, (1.5, 1.0, 1.0), strict=True)]
    for point, radius in zip(points, radii, strict=True):
        near = [np.abs(along - at) <= radius + 2 for along, at in zip(places, point, strict=True)]
        plane, row, col = np.ix_(*(along[part] - at for along, part, at in zip(places, near, point, strict=True)))
        part = np.ix_(*near)
        inside[part] = np.maximum(inside[part], radius - np.sqrt(plane**2 + row**2 + col**2))


def u_shape() -> tuple[Grid, list[Drawn]]:
    """Draw a thick white U, open at the top, on black."""

    def inside(row: Grid, col: Grid) -> NDArray[np.bool_]:
        outer = rectangle(44, 48, 132, 208)(row, col) | disk((132, 128), 80)(row, col)
        inner = rectangle(0, 98, 132, 158)(row, col) | disk((132, 128), 30)(row, col)
        return outer & ~inner

    return 255 * coverage(inside), circles((100, 73, 38))


def rings() -> tuple[Grid, list[Drawn]]:
    """Objects in objects, each of another gray level."""
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
    return values, circles((120, 128, 80))


def noisy() -> tuple[Grid, list[Drawn]]:
    """Draw an ellipse with a hole under heavy noise."""
    inside = coverage(ellipse((128, 128), 78, 100)) - coverage(ellipse((120, 140), 30, 38))
    return 80 + 95 * inside + 30 * noise(20), circles((128, 70, 44))


def cells() -> tuple[Grid, list[Drawn]]:
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
    return values, circles(*((round(row), round(col), round(0.8 * radius)) for row, col, radius in placed))


def artery() -> tuple[Grid, list[Drawn]]:
    """Draw a branching artery filled with contrast medium, narrowed at one place, dark as in an X-ray angiogram."""
    side = 320
    trunk = curve([(-20, 92), (40, 112), (100, 118), (160, 146), (220, 190), (275, 214), (345, 226)], 260)
    along = np.linspace(0, 1, len(trunk))
    width = 12.5 - 3.5 * along - 5.2 * np.exp(-(((along - 0.68) / 0.03) ** 2))
    first = curve([(160, 146), (178, 120), (205, 96), (245, 82), (290, 62), (345, 52)], 200)
    second = curve([(100, 118), (98, 160), (82, 205), (86, 250), (66, 345)], 200)
    third = curve([(86, 250), (112, 274), (140, 288), (170, 345)], 140)
    depth = np.maximum(tube(trunk, width, side), tube(first, np.linspace(8.5, 5.5, len(first)), side))
    depth = np.maximum(depth, tube(second, np.linspace(8.0, 5.0, len(second)), side))
    depth = np.maximum(depth, tube(third, np.linspace(5.0, 4.0, len(third)), side))
    row, col = np.indices((side, side)) / side
    ribs = sum(np.exp(-(((row - 0.55 * col**2 - shift) / 0.06) ** 2)) for shift in (-0.1, 0.25, 0.6, 0.95))
    tissue = 186 + 26 * np.sin(2.6 * col + 0.4) - 22 * row - 9 * blur(ribs, 6.0) + 6 * blur(noise(31, side), 7.0) * 12
    values = tissue * np.exp(-0.052 * blur(depth, 0.8)) + 4.5 * blur(noise(32, side), 0.6)
    line = [(round(float(r), 1), round(float(c), 1)) for r, c in trunk[(along > 0.14) & (along < 0.26)][::6]]
    return values, [{"shape": "stroke", "points": line}]


def nuclei() -> tuple[Grid, list[Drawn]]:
    """Stained nuclei in a fluorescence microscope: uneven within and among each other, and two pairs that touch."""
    random = np.random.RandomState(12)
    side, reach, wanted, gap = 320, 40, 15, 9.0
    pairs = [((96.0, 92.0), 17.0), ((96.0, 126.0), 16.0), ((214.0, 206.0), 18.0), ((238.0, 230.0), 16.5)]
    placed = list(pairs)
    while len(placed) < wanted:
        center, radius = tuple(random.uniform(30, side - 30, 2)), random.uniform(13, 19)
        if all(np.hypot(*np.subtract(center, other)) > 1.25 * (radius + size) + gap for other, size in placed):
            placed.append((center, radius))
    light = np.zeros((side + 2 * reach, side + 2 * reach))
    grain = blur(random.standard_normal(light.shape), 2.5) * 8
    for (row, col), radius in placed:
        dents, turns, level = random.uniform(0.02, 0.09, 2), random.uniform(0, 2 * np.pi, 2), random.uniform(85, 165)
        top, left = int(row), int(col)
        here = (slice(top, top + 2 * reach), slice(left, left + 2 * reach))
        share = coverage(cell((row - top + reach, col - left + reach), radius, dents, turns), 2 * reach)
        light[here] = np.maximum(light[here], share * level * (1 + 0.11 * grain[here]))
    down, right = np.mgrid[:side, :side] / side
    haze = blur(light, 14.0)[reach:-reach, reach:-reach]
    values = blur(light[reach:-reach, reach:-reach], 1.4) + 0.16 * haze + 16 + 14 * right + 9 * down
    return values + np.sqrt(values) * 0.35 * noise(6, side), [{"shape": "everywhere", "kind": "centers"}]


def hand() -> tuple[Grid, list[Drawn]]:
    """Draw a hand as a radiograph shows it: soft tissue, and in it the brighter bones of fingers and palm."""
    side = 384
    fingers = (
        ([(352, 172), (270, 118), (218, 92), (168, 60), (128, 38)], (17.0, 14.0, 12.0)),
        ([(352, 180), (232, 152), (158, 134), (102, 124), (60, 118)], (16.0, 13.0, 10.5)),
        ([(352, 192), (226, 190), (142, 186), (80, 184), (30, 183)], (16.0, 13.0, 10.5)),
        ([(352, 204), (234, 226), (160, 236), (104, 244), (56, 250)], (16.0, 12.5, 10.0)),
        ([(352, 214), (250, 260), (194, 284), (152, 302), (116, 317)], (15.0, 11.5, 9.5)),
    )
    tissue = tube(curve([(430, 196), (390, 194), (350, 194)], 90), np.full(90, 44.0), side)
    tissue = np.maximum(tissue, tube(curve([(335, 194), (300, 196), (262, 200)], 90), np.linspace(56, 62, 90), side))
    bones = np.zeros((side, side))
    for corners, (root, middle, tip) in fingers:
        points = curve([(float(r), float(c)) for r, c in corners])
        t = np.linspace(0, 1, len(points))
        tissue = np.maximum(tissue, tube(points, np.interp(t, [0, 0.3, 0.6, 1], [26, root + 5, middle + 2, tip]), side))
        for first, second in pairwise(corners):
            start, end = np.array(first, dtype=float), np.array(second, dtype=float)
            step = (end - start) / np.hypot(*(end - start))
            shaft = np.linspace(start + 9 * step, end - (5 if second == corners[-1] else 2) * step, 80)
            waist = np.interp(np.linspace(-1, 1, 80) ** 2, [0, 1], [0.30, 0.47]) * np.interp(
                np.linspace(0, 1, 80), [0, 1], [1.0, 0.9]
            )
            width = waist * (root if first == corners[0] else middle if first == corners[1] else tip)
            bones = np.maximum(bones, tube(shaft, width, side))
    for center, radius in (((360, 170), 9.0), ((366, 190), 10.0), ((362, 212), 9.0)):
        bones = np.maximum(bones, tube(np.array([center], dtype=float), np.array([radius]), side))
    flesh = np.sqrt(np.minimum(tissue, 40) / 60)
    values = 18 + 105 * blur(flesh, 1.2) + 62 * blur(np.sqrt(bones / 14), 1.0) + 5 * blur(noise(41, side), 5.0) * 6
    return values + 2.5 * noise(42, side), circles((285, 200, 30))


def vessels() -> tuple[Grid, list[Drawn]]:
    """Draw a tree of vessels filled with contrast medium, as magnetic resonance shows it: bright, with noise."""
    trunk: Way = [(12, -12, 48), (17, 7, 46), (26, 27, 50), (38, 45, 46)]
    branches: tuple[tuple[Way, float, float], ...] = (
        (trunk, 6.8, 5.6),
        ([(38, 45, 46), (48, 57, 57), (57, 72, 65), (63, 89, 72), (67, 108, 75)], 4.7, 3.6),
        ([(38, 45, 46), (41, 57, 34), (38, 70, 26), (31, 86, 21), (27, 108, 17)], 4.5, 3.4),
        ([(57, 72, 65), (53, 79, 77), (45, 82, 87), (38, 86, 108)], 3.2, 2.7),
        ([(38, 70, 26), (50, 75, 31), (62, 81, 36), (72, 87, 38)], 3.1, 2.5),
        ([(21, 17, 48), (17, 26, 63), (22, 34, 77), (29, 38, 87), (31, 39, 108)], 4.0, 2.9),
        ([(22, 34, 77), (34, 31, 84), (50, 29, 86), (69, 26, 84), (94, 24, 84)], 2.9, 2.5),
        ([(21, 17, 48), (31, 19, 34), (39, 26, 21), (45, 31, 7), (46, 33, -12)], 3.8, 2.9),
        ([(39, 26, 21), (51, 22, 19), (63, 17, 22), (94, 12, 26)], 2.7, 2.4),
    )
    inside = np.full(VOLUME, -1.0)
    for corners, first, last in branches:
        points = curve(corners)
        vessel(inside, points, np.linspace(first, last, len(points)))
    plane, row, col = np.indices(VOLUME) / VOLUME[1]
    tissue = 60 + 14 * np.sin(3 * row + col) + 10 * plane
    grain = np.random.RandomState(51).standard_normal(VOLUME)
    values = tissue + 120 * blur(np.clip(inside + 0.5, 0, 1), 0.7) + 9 * grain
    # few gray levels pack well, and the noise hides the steps between them
    return 16 * np.rint(values / 16), [{"shape": "sphere", "center": [16, 21, 49], "radius": 3}]


def head() -> tuple[Grid, list[Drawn]]:
    """Draw a head in magnetic resonance: scalp, dark skull, gray and white matter, ventricles, and a lesion."""
    sides = zip(VOLUME, VOXELS["head.tif"], strict=True)
    z, y, x = np.ix_(*(side * (np.arange(count) - (count - 1) / 2) for count, side in sides))
    size = np.sqrt((z / 76) ** 2 + (y / 90) ** 2 + (x / 72) ** 2)
    around, above = np.arctan2(y, x), np.arctan2(z, np.hypot(y, x))
    folds = 0.035 * np.cos(13 * around + 3 * np.sin(4 * above)) * np.cos(9 * above) * np.cos(above)
    white = 0.68 + 0.8 * folds - 0.02 * np.cos(6 * around)
    cleft = np.where(z > 12, np.exp(-((x / 2.2) ** 2)) * (size > 0.5), 0.0)
    values = np.zeros(VOLUME)
    around_brain = ((1.0, 165.0), (0.95, 110.0), (0.91, 14.0), (0.85, 45.0))
    for limit, level in (*around_brain, (0.82 + folds, 105.0), (white, 150.0)):
        values += (level - values) * np.clip((limit - size) * 36 + 0.5, 0, 1)
    values += (45.0 - values) * cleft * (size < 0.85)
    inside = np.full(VOLUME, -1.0)
    for turn in (-1, 1):
        corners: Way = [(40, 73, 47.5 + 12 * turn), (49, 66, 47.5 + 9 * turn), (51, 50, 47.5 + 5 * turn),
                        (49, 36, 47.5 + 5 * turn), (45, 27, 47.5 + 8 * turn)]  # fmt: skip
        points = curve(corners)
        vessel(inside, points, np.linspace(3.2, 4.2, len(points)))
    values += (32.0 - values) * np.clip(inside + 0.5, 0, 1)
    lump = np.sqrt(((z - 4) / 15) ** 2 + ((y + 5) / 16) ** 2 + ((x + 32) / 10) ** 2) + 0.05 * np.cos(5 * around + z / 6)
    values += (205.0 - values) * np.clip((1 - lump) * 8 + 0.5, 0, 1)
    values = blur(values * (1 + 0.06 * y / 90), 0.6) + 5 * np.random.RandomState(77).standard_normal(VOLUME)
    return 8 * np.rint(values / 8), [{"shape": "sphere", "center": [29, 45, 31], "radius": 3}]


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
    (
        "artery.png",
        "An artery",
        artery,
        "shape",
        "An angiogram of an artery that is narrowed at one place; a short stroke in it finds all branches.",
    ),
    (
        "nuclei.png",
        "Nuclei",
        nuclei,
        "automatic",
        "Stained nuclei, some of which touch; particles start at their centers and nothing has to be drawn.",
    ),
    (
        "hand.png",
        "A hand",
        hand,
        "shape",
        "A radiograph of a hand; a circle in the palm finds its outline.",
    ),
    (
        "vessels.tif",
        "Vessels",
        vessels,
        "volume",
        "A volume with a tree of vessels under noise; a small sphere in the trunk finds all branches.",
    ),
    (
        "head.tif",
        "A head",
        head,
        "volume",
        "A volume with a brain, its ventricles and a lesion; click them with the tool Objects.",
    ),
)
CHANGED = {
    "rings.png": {"reach": 300.0, "weakest_edge": 0.0},
    "artery.png": {"reach": 300.0, "weakest_edge": 0.0},
    "hand.png": {"reach": 300.0, "weakest_edge": 0.0, "smoothing": 1.5, "sure_edge": 0.25, "min_length": 25.0},
}
"""What is set otherwise than in the preset, by file."""


def write_image(gray: NDArray[np.uint8], path: Path) -> None:
    """Write an image, or a volume with a picture of it next to it."""
    if gray.ndim == 2:
        PIL.Image.fromarray(gray).save(path, optimize=True)
        return
    plane, row, col = VOXELS[path.name]
    about = {"axes": "ZYX", "spacing": plane, "unit": "mm"}
    tifffile.imwrite(
        path, gray, imagej=True, compression="zlib", compressionargs={"level": 9}, predictor=False,
        resolution=(1 / col, 1 / row), metadata=about,
    )  # fmt: skip
    picture = gray[PICTURED[path.name]] if path.name in PICTURED else gray.max(axis=0)
    PIL.Image.fromarray(picture).save(path.with_suffix(".png"), optimize=True)


def write(folder: Path) -> None:
    """Write every image and ``samples.json``, the list of them, into `folder`."""
    entries = []
    for file, title, draw, preset, about in SAMPLES:
        values, shapes = draw()
        gray = np.clip(np.rint(values), 0, 255).astype(np.uint8)
        write_image(gray, folder / file)
        entry = {"title": title, "file": file, "about": about, "preset": preset, "shapes": shapes}
        entry |= {"mode": preset} if preset == "automatic" else {}
        entries.append(entry | ({"parameters": CHANGED[file]} if file in CHANGED else {}))
    lines = ",\n".join("  " + json.dumps(entry) for entry in entries)
    (folder / "samples.json").write_text(f"[\n{lines}\n]\n", encoding="utf-8")


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
