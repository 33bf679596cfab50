"""Bodies in volumes that nobody has drawn: blobs, tori, tubes and pairs, with gaps, noise, shading and neighbors."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.random import Generator

from cpm_core.numerics.types import Array, Extent, Mask

KINDS = ("blob", "torus", "tube", "pair", "textured", "gap", "hollow")
"""The kinds of bodies that `body` makes."""

INNER_KINDS = ("organs", "textures", "folds", "shades", "vessels", "layers", "hollow", "specks", "scan")
"""The kinds of bodies with parts that `body_with_parts` makes."""

CONTRAST, GROUND, BLUR = 100.0, 60.0, 0.8


def body(kind: str, side: int, rng: Generator) -> tuple[Array, Mask]:
    """A volume of so many voxels along each axis, and the body that is meant in it."""
    middle = side * rng.uniform(0.42, 0.58, 3)
    size = side * rng.uniform(0.2, 0.28)
    others = np.zeros((side,) * 3, np.bool_)
    if kind == "torus":
        inside = _torus(side, middle, size, rng)
    elif kind == "tube":
        inside = _tube(side, middle, size, rng)
    elif kind == "pair":
        turn = _direction(rng)
        inside = _blob(side, middle - 0.75 * size * turn, 0.75 * size, rng)
        others = _blob(side, middle + 0.8 * size * turn, 0.7 * size, rng) & ~inside
        thin = scipy.ndimage.distance_transform_edt(~inside) < 1.5
        others &= ~(thin & (rng.random(inside.shape) < 0.5))
    else:
        inside = _blob(side, middle, size, rng)
    values = np.where(others, 0.9, 0.0)
    within = np.ones(inside.shape)
    if kind == "textured":
        within = 0.75 + 0.35 * _smooth(side, 0.05 * side, rng)
    elif kind == "hollow":
        inside &= ~_blob(side, middle, 0.55 * size, rng)
    values[inside] = within[inside]
    if kind == "gap":  # a neighbor of the same gray level
        outward = _direction(rng)
        neighbor = _blob(side, middle + 1.4 * size * outward, 0.55 * size, rng)
        values[neighbor & ~inside] = 1.0
    for _ in range(3):
        far = _blob(side, rng.uniform(0.05, 0.95, 3) * side, rng.uniform(0.06, 0.13) * side, rng)
        free = scipy.ndimage.binary_dilation(inside | others, iterations=3)
        values[far & ~free & (values == 0.0)] = rng.uniform(0.4, 1.2)
    seen = scipy.ndimage.gaussian_filter(values, BLUR)
    shade = 1.0 + 0.15 * _smooth(side, 0.3 * side, rng)
    sign = 1.0 if rng.random() < 0.7 else -1.0
    seen = GROUND + (CONTRAST * (sign < 0)) + sign * CONTRAST * seen * shade
    return seen + rng.normal(0.0, rng.uniform(3.0, 25.0), seen.shape), inside


def _direction(rng: Generator) -> Array:
    way = rng.normal(size=3)
    return way / np.linalg.norm(way)


def _smooth(side: int, width: float, rng: Generator) -> Array:
    """Smooth noise of unit deviation."""
    coarse = max(int(2 * side / width), 4)
    field = scipy.ndimage.zoom(rng.normal(size=(coarse,) * 3), side / coarse, order=3)
    return field / field.std()


def _blob(side: int, middle: Array, size: float, rng: Generator) -> Mask:
    """A ball whose axes differ, with bumps."""
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    places = np.moveaxis(np.indices((side,) * 3), 0, -1) - middle
    away = np.linalg.norm(places @ turn / (size * np.exp(rng.uniform(-0.25, 0.25, 3))), axis=-1)
    return away + rng.uniform(0.0, 0.12) * _smooth(side, 1.2 * size, rng) < 1.0


def _torus(side: int, middle: Array, size: float, rng: Generator) -> Mask:
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    along, row, col = np.moveaxis((np.moveaxis(np.indices((side,) * 3), 0, -1) - middle) @ turn, -1, 0)
    return np.hypot(np.hypot(row, col) - 1.1 * size, along) < rng.uniform(0.3, 0.5) * size


def _tube(side: int, middle: Array, size: float, rng: Generator) -> Mask:
    """A bent tube."""
    steps = np.linspace(-1.0, 1.0, 60)[:, None]
    bend, way, wave = _direction(rng), _direction(rng), _direction(rng)
    line = middle + size * (1.5 * steps * way + 0.6 * steps**2 * bend + 0.3 * np.sin(4.0 * steps) * wave)
    tree = scipy.spatial.KDTree(line)
    places = np.moveaxis(np.indices((side,) * 3), 0, -1).reshape(-1, 3)
    return np.asarray(tree.query(places)[0] < rng.uniform(0.18, 0.3) * size).reshape((side,) * 3)


def scan(seed: int, shape: Extent, noise: float) -> tuple[Array, dict[str, Mask]]:
    """A made-up CT [HU]: in air a body, in it an organ and a clump of three balls that touch; and where each lies."""
    rng, sides = np.random.default_rng(seed), np.array(shape)
    places = np.moveaxis(np.indices(shape), 0, -1) - sides / 2.0 + 0.5 - rng.uniform(-2.0, 2.0, 3)
    radius = min(shape) * rng.uniform(0.075, 0.095)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    around = 2.0 * np.pi * np.arange(3)[:, None] / 3.0
    centers = 1.12 * radius * (np.cos(around) * turn[0] + np.sin(around) * turn[1]) + [0.0, 0.0, 0.2 * sides[2]]
    away = np.array([np.linalg.norm(places - center, axis=-1) for center in centers])
    organ = (places - sides * [rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.1), -0.2]) / min(shape)
    found = {
        "body": np.linalg.norm(places / (sides * [0.4, 0.42, 0.44]), axis=-1) < 1.0,
        "organ": np.linalg.norm(organ / rng.uniform(0.12, 0.17, 3), axis=-1) < 1.0,
        **{f"ball {at + 1}": (away[at] < radius) & (away.argmin(axis=0) == at) for at in range(3)},
    }
    values = np.full(shape, -1000.0)
    for inside, level in zip(found.values(), (40.0, 130.0, 300.0, 300.0, 300.0), strict=True):
        values[inside] = level
    found["body"] &= ~np.any(list(found.values())[1:], axis=0)
    return scipy.ndimage.gaussian_filter(values, 0.7) + rng.normal(0.0, noise, shape), found


def body_with_parts(kind: str, rng: Generator) -> tuple[Array, Mask, list[Mask]]:
    """A volume with a body, the body with all that lies in it, and each of its parts."""
    if kind == "scan":
        sides = rng.integers(40, 54, 3).tolist()
        values, found = scan(int(rng.integers(2**30)), tuple(sides), rng.uniform(8.0, 60.0))
        masks = list(found.values())
        return values, np.any(masks, axis=0), [*masks[1:], np.any(masks[2:], axis=0)]
    side = int(rng.integers(40, 50))
    middle = side * rng.uniform(0.46, 0.54, 3)
    inside = _blob(side, middle, side * rng.uniform(0.34, 0.42), rng)
    values, parts = np.where(inside, CONTRAST, 0.0), list[Mask]()
    noise, depth = np.exp(rng.uniform(np.log(2.0), np.log(30.0))), scipy.ndimage.distance_transform_edt(inside)

    def rise() -> float:
        return float(rng.choice([-1.0, 1.0]) * np.exp(rng.uniform(np.log(15.0), np.log(90.0))))

    def add(mask: Mask) -> None:
        part = mask & (depth > 2.0)
        near = scipy.ndimage.binary_dilation(part, iterations=2)
        if np.count_nonzero(part) >= 60 and not any((near & other).any() for other in parts):
            values[part] += rise()
            parts.append(part)

    def blob(low: float, high: float, within: Array = depth) -> Mask:
        deep = np.argwhere(within > 0.35 * within.max())
        return _blob(side, deep[rng.integers(len(deep))].astype(float), side * rng.uniform(low, high), rng)

    if kind == "textures":
        values += inside * np.exp(rng.uniform(np.log(4.0), np.log(30.0))) * _smooth(side, rng.uniform(2.0, 9.0), rng)
    elif kind == "folds":
        folded = inside & (_smooth(side, rng.uniform(4.0, 12.0), rng) > rng.uniform(0.2, 0.8))
        values[folded] += rng.choice([-1.0, 1.0]) * rng.uniform(10.0, 40.0)
    elif kind == "shades":
        across = np.moveaxis(np.indices(inside.shape), 0, -1) @ _direction(rng) / side
        values += inside * (across - across[inside].mean()) * rng.uniform(20.0, 90.0)
    elif kind == "vessels":
        for _ in range(int(rng.integers(1, 3))):
            add(_tube(side, side * rng.uniform(0.4, 0.6, 3), side * rng.uniform(0.15, 0.22), rng) & inside)
    elif kind == "layers":
        core = depth > rng.uniform(3.0, 7.0)
        values[core] += rise()
        parts.append(core)
        organ = blob(0.08, 0.16, np.where(core, depth, 0.0)) & scipy.ndimage.binary_erosion(core)
        if np.count_nonzero(organ) >= 60:
            values[organ] += rise()
            parts += [organ, core & ~organ]
    elif kind == "hollow":
        hollow = _blob(side, middle + rng.uniform(-3.0, 3.0, 3), side * rng.uniform(0.1, 0.26), rng) & (depth > 2.0)
        values[hollow] = rng.choice([0.0, rng.uniform(0.0, 60.0)])
        parts.append(hollow)
    if kind != "layers":
        most, low, high = {"organs": (6, 0.07, 0.16), "specks": (14, 0.045, 0.085)}.get(kind, (3, 0.08, 0.2))
        for _ in range(int(rng.integers(most // 3, most))):
            add(blob(low, high))
    seen = scipy.ndimage.gaussian_filter(values, rng.uniform(0.5, 1.2))
    sign = 1.0 if rng.random() < 0.7 else -1.0
    return sign * seen + rng.normal(0.0, noise, seen.shape), inside, parts
