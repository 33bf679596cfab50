"""Prompts: parts of images, varied, with what a user might do there, as the maps that the network gets.

`cpm_core/objects/prior/object_predictor.py` makes the same maps of what a user does.
"""

from __future__ import annotations

import random
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.types import Array, Mask, Single
from cpm_core.objects.prior.crops import CROP_SIDE, NETWORK_LUMINANCE_WEIGHTS
from tests.benchmarks.prior.pictures import Example
from tests.benchmarks.prior.textures import blurred, noise

MAPS = 9
"""Input maps of the network."""

_CUT_SHARE, _LEAST_LEFT = 0.12, 0.15
"""How often an image ends within the object, and the least share of the object that is left then."""

_MIN_VISIBLE, _MIN_HIT = 12, 4
"""Pixels of the object that a window must hold, and of where it may be pointed at."""

_DETAIL, _MIN_DETAIL, _MIN_DETAIL_SIDE = (0.01, 0.12), 1.5, 24.0
"""Half the width of a detail, in extents of its object; the least, and the least side of a window around it [px]."""

_WHOLE_SHARE = 0.4
"""How often a detail is corrected in a window around its whole object, as `ObjectPredictor` first does."""


class Chance:
    """Random numbers, each kind from a generator of its own.

    Attributes
    ----------
    plain : random.Random
        Choices and single numbers.
    arrays : numpy.random.Generator
        Noise.
    turns : numpy.random.RandomState
        Directions of strokes.
    """

    def __init__(self, seed: int) -> None:
        self.plain = random.Random(seed)
        self.arrays = np.random.default_rng(seed)
        self.turns = np.random.RandomState(seed)

    def log_uniform(self, low: float, high: float) -> float:
        """A number whose logarithm is uniformly distributed."""
        return np.exp(self.plain.uniform(np.log(low), np.log(high)))


class View(NamedTuple):
    """A window of an image, with the object in it.

    Attributes
    ----------
    values : ndarray of float32, shape (SIDE, SIDE, 3)
        Brightness and two differences of colors.
    mask, hit : ndarray of bool, shape (SIDE, SIDE)
        The object, and where it may be pointed at.
    area : float
        Area of the whole object [px of the window]: more than that of the mask where the window cuts it.
    on_click : bool
        Whether the middle of the window is a place where the object has been pointed at.
    """

    values: Single
    mask: Mask
    hit: Mask
    area: float
    on_click: bool


@dataclass(eq=False)
class Prompt:
    """What is known about an object, as maps of the window.

    Attributes
    ----------
    inside, outside : ndarray of bool, shape (SIDE, SIDE)
        Pixels that lie in it, and that do not.
    drawn : ndarray of float32, shape (SIDE, SIDE)
        1 where something has been drawn in it, or across its boundary; −1 in a box around it.
    former : ndarray of float32, shape (SIDE, SIDE)
        The answer that is corrected.
    """

    inside: Mask = field(default_factory=lambda: np.zeros((CROP_SIDE, CROP_SIDE), np.bool_))
    outside: Mask = field(default_factory=lambda: np.zeros((CROP_SIDE, CROP_SIDE), np.bool_))
    drawn: Single = field(default_factory=lambda: np.zeros((CROP_SIDE, CROP_SIDE), np.float32))
    former: Single = field(default_factory=lambda: np.zeros((CROP_SIDE, CROP_SIDE), np.float32))

    def correct(self, answer: Mask, truth: Mask, chance: Chance) -> None:
        """Click as a user would: where most is missing from an answer, or where most is too much."""
        missing, surplus = truth & ~answer, answer & ~truth
        if missing.sum() > surplus.sum():
            self.inside[click(missing, chance)] = True
        elif surplus.any():
            self.outside[click(surplus, chance)] = True

    def maps(self, values: Single) -> Single:
        """Input of the network, shape (MAPS, SIDE, SIDE)."""
        gray = values[..., 0]
        across, down = cv2.Sobel(gray, cv2.CV_32F, 1, 0), cv2.Sobel(gray, cv2.CV_32F, 0, 1)
        slope = np.sqrt(across * across + down * down) / 2
        sure = self.inside if self.inside.any() else self.drawn > 0
        like = np.zeros(gray.shape, np.float32)
        if sure.any():
            like = np.exp(-np.abs(values - np.median(values[sure], axis=0)).sum(-1))
        near = (_nearness(self.inside), _nearness(self.outside))
        maps = [*np.moveaxis(values, -1, 0), slope, like, *near, self.drawn, self.former]
        return np.stack(maps).astype(np.float32)


def view(example: Example, chance: Chance) -> View | None:
    """An example through a window of random place, size, turn and look; None if too little of it is left."""
    plain = chance.plain
    left = _cut(example, plain) if plain.random() < _CUT_SHARE else example
    on_click = plain.random() < 0.35
    pointed_at = left.mask if left.hit is None else left.hit
    middle, side = _placed(left.mask, click(pointed_at, chance) if on_click else None, chance)
    seen = _seen_through(left, middle, side, on_click, chance)
    return None if seen is None else seen[0]


def close_correction(example: Example, chance: Chance) -> tuple[View, Prompt] | None:
    """A window around a detail that a former answer lacks or has too much, and a click in it; None without one.

    A detail is a process or a bay that is narrow for the object, which `ObjectPredictor` corrects in such a window.
    """
    plain, mask = chance.plain, example.mask
    extent = max(np.ptp(line) for line in np.nonzero(mask)) + 1
    radius = max(extent * chance.log_uniform(*_DETAIL), _MIN_DETAIL)
    is_bay = plain.random() < 0.5
    ground = ~mask if is_bay else mask
    deep = cv2.distanceTransform(ground.astype(np.uint8), cv2.DIST_L2, 5) > radius
    if not deep.any():
        return None
    narrow = ground & (cv2.distanceTransform((~deep).astype(np.uint8), cv2.DIST_L2, 5) > radius)
    count, numbers, boxes, _ = cv2.connectedComponentsWithStats(narrow.astype(np.uint8), connectivity=4)
    least = max(_MIN_VISIBLE, radius * radius)
    chosen = [k for k in range(1, count) if boxes[k, cv2.CC_STAT_AREA] >= least]
    if not chosen:
        return None
    number = plain.choice(chosen)
    left, top, width, height, _ = boxes[number]
    wrong = numbers == number
    former = mask ^ (wrong if plain.random() < 0.7 else narrow)
    if plain.random() < _WHOLE_SHARE:
        side = max(extent * chance.log_uniform(1.0, 3.0), _MIN_DETAIL_SIDE)
        middle, slack = tuple((line.min() + line.max() + 1) / 2 for line in np.nonzero(mask)), 0.5 * (side - extent)
    else:
        side = max(max(width, height) * chance.log_uniform(1.0, 3.0), _MIN_DETAIL_SIDE)
        middle, slack = (top + height / 2, left + width / 2), 0.25 * side
    row, col = (at + plain.uniform(-slack, slack) for at in middle)
    found = _seen_through(example._replace(hit=None), (row, col), side, False, chance)
    if found is None:
        return None
    seen, matrix = found
    shown = _warped(wrong, matrix)
    if shown.sum() < _MIN_HIT:
        return None
    prompt = Prompt(former=_warped(former, matrix).astype(np.float32))
    (prompt.outside if is_bay else prompt.inside)[click(shown, chance)] = True
    return seen, prompt


def _seen_through(
    example: Example, middle: tuple[float, float], side: float, on_click: bool, chance: Chance
) -> tuple[View, Array] | None:
    """An example through a window of a place and size, of random turn and look, and the matrix of the window."""
    image, mask, hit = example
    if image.shape[2] == 1:
        image = np.repeat(image, 3, axis=2)
    scale = CROP_SIDE / side
    matrix = _matrix(middle, scale, chance)
    if scale < 0.6:
        image = blurred(image, 0.4 / scale)
    size = (CROP_SIDE, CROP_SIDE)
    colors = cv2.warpAffine(image, matrix, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    visible = _warped(mask, matrix)
    hit = visible if hit is None else _warped(hit, matrix)
    area = max(mask.sum() * scale * scale, visible.sum())
    values = _varied(_in_another_light(colors.astype(np.float32), chance), chance)
    if visible.sum() < _MIN_VISIBLE or hit.sum() < _MIN_HIT:
        return None
    return View(values, visible, hit, area, on_click), matrix


def _cut(example: Example, plain: random.Random) -> Example:
    """An example whose image ends within the object, at one side."""
    axis, first = plain.randrange(2), plain.random() < 0.5
    lines = np.flatnonzero(example.mask.any(axis=1 - axis))
    at = plain.randint(int(lines[0]), int(lines[-1]))
    part = (slice(None),) * axis + (slice(at, None) if first else slice(at + 1),)
    left = Example(*(None if each is None else each[part] for each in example))
    return left if left.mask.sum() > max(_LEAST_LEFT * example.mask.sum(), _MIN_VISIBLE) else example


def _placed(mask: Mask, clicked: tuple[Any, ...] | None, chance: Chance) -> tuple[tuple[float, float], float]:
    """Middle (row, col) and side of a window around an object, or around where it has been clicked [px]."""
    plain = chance.plain
    rows, cols = np.nonzero(mask)
    extent = max(np.ptp(rows), np.ptp(cols)) + 1
    if clicked is None:
        row, col = (rows.min() + rows.max()) / 2, (cols.min() + cols.max()) / 2
        factors = (1.05, 8) if plain.random() < 0.85 else (0.5, 1.05)
    else:
        row, col = clicked
        factors = (0.45, 8)
    largest = max(max(mask.shape) * 1.15, extent * 1.1)
    side = max(min(extent * chance.log_uniform(*factors), largest), 12)
    if clicked is None:
        slack = abs(side - extent) / 2
        row += plain.uniform(-slack, slack)
        col += plain.uniform(-slack, slack)
    return (row, col), side


def _matrix(middle: tuple[float, float], scale: float, chance: Chance) -> Array:
    """From the image to the window: turned, stretched and mirrored."""
    plain = chance.plain
    turn = 0.0
    if plain.random() < 0.5:
        turn = plain.uniform(-0.5, 0.5)
    elif plain.random() < 0.2:
        turn = plain.uniform(-3.2, 3.2)
    stretch = np.exp(plain.uniform(-0.2, 0.2))
    cosine, sine = np.cos(turn), scale * np.sin(turn)
    matrix = np.array([[scale * stretch * cosine, -sine, 0], [sine, scale / stretch * cosine, 0]])
    matrix[:, 2] = CROP_SIDE / 2 - matrix[:, :2] @ [middle[1], middle[0]]
    if plain.random() < 0.5:
        matrix[0] = [-matrix[0, 0], -matrix[0, 1], CROP_SIDE - 1 - matrix[0, 2]]
    return matrix


def _warped(mask: Mask, matrix: Array) -> Mask:
    return cv2.warpAffine(mask.astype(np.uint8) * 255, matrix, (CROP_SIDE, CROP_SIDE), flags=cv2.INTER_LINEAR) > 127


def _in_another_light(colors: Single, chance: Chance) -> Single:
    """Colors without hue, or with channels exchanged, as the network sees them."""
    plain = chance.plain
    if plain.random() < 0.5:
        colors = np.repeat((colors @ NETWORK_LUMINANCE_WEIGHTS)[..., None], 3, axis=2)
    elif plain.random() < 0.4:
        colors = colors[..., plain.sample(range(3), 3)]
    gray = colors @ NETWORK_LUMINANCE_WEIGHTS
    deviation = gray.std() + 8
    red, green, blue = (colors[..., channel] for channel in range(3))
    values = [(gray - gray.mean()) / deviation, (red - green) / deviation, ((red + green) / 2 - blue) / deviation]
    return np.stack(values, -1).astype(np.float32)


def _varied(values: Single, chance: Chance) -> Single:
    """Brightness inverted, of another contrast, with noise, with uneven light, or blurred."""
    plain = chance.plain
    gray = values[..., 0]
    if plain.random() < 0.5:
        gray[:] = -gray
    if plain.random() < 0.3:
        gray[:] = np.sign(gray) * np.abs(gray) ** np.exp(plain.uniform(-0.3, 0.3))
    if plain.random() < 0.4:
        gray += chance.arrays.standard_normal((CROP_SIDE, CROP_SIDE), dtype=np.float32) * plain.uniform(0, 0.5)
    if plain.random() < 0.15:
        gray += noise(CROP_SIDE, CROP_SIDE / 2, chance.arrays) * plain.uniform(0, 0.7)
    if plain.random() < 0.25:
        values = blurred(values, plain.uniform(0.5, 1.8))
    return values


def first_prompt(seen: View, chance: Chance) -> Prompt:
    """What a user does first: a click, a circle, a stroke, a box, or a correction of a former answer."""
    prompt = Prompt()
    kind = chance.plain.random()
    half = CROP_SIDE // 2
    if seen.on_click and kind < 0.8 and seen.hit[half - 1 : half + 1, half - 1 : half + 1].any():
        prompt.inside[half, half] = True
    elif kind < 0.45:
        prompt.inside[click(seen.hit, chance)] = True
    elif kind < 0.64:
        prompt.drawn = _disk(seen.hit, chance)
    elif kind < 0.75:
        prompt.inside = _stroke(seen.hit, chance)
    elif kind < 0.88:
        prompt.drawn = _box(seen.mask, chance)
    else:
        answer = _former_answer(seen.mask, chance)
        prompt.former = answer.astype(np.float32)
        if chance.plain.random() < 0.85:
            prompt.correct(answer, seen.mask, chance)
    return prompt


def click(region: Mask, chance: Chance) -> tuple[Any, ...]:
    """A pixel of a region, not near its boundary."""
    depth = _depth(region)
    return tuple(chance.plain.choice(np.argwhere(depth >= max(depth.max() * chance.plain.uniform(0.3, 1), 0.5))))


def _disk(region: Mask, chance: Chance) -> Single:
    """A disk in a region, or across its boundary."""
    depth = _depth(region)
    middle = chance.plain.choice(np.argwhere(depth >= depth.max() * chance.plain.uniform(0.4, 1)))
    radius = max(depth[tuple(middle)] * chance.plain.uniform(0.3, 1.25), 1.5)
    disk = np.zeros(region.shape, np.uint8)
    cv2.circle(disk, _pixel(middle), round(radius), 1, -1)
    return disk.astype(np.float32)


def _stroke(region: Mask, chance: Chance) -> Mask:
    """A winding line in a region."""
    depth = _depth(region)
    first = chance.plain.choice(np.argwhere(depth >= depth.max() * chance.plain.uniform(0.2, 0.6)))
    line = np.zeros(region.shape, np.uint8)
    place = first.astype(float)
    direction = _unit(chance.turns.randn(2))
    for _ in range(chance.plain.randrange(4, 30)):
        ahead = place + direction * 2
        if not region[tuple(np.clip(np.round(ahead).astype(int), 0, CROP_SIDE - 1))]:
            direction = np.array([-direction[1], direction[0]]) * chance.plain.choice((-1, 1))
            continue
        cv2.line(line, _pixel(place), _pixel(ahead), 1, 1)
        place = ahead
        direction = _unit(direction + chance.turns.randn(2) * 0.3)
    line[tuple(first)] = 1
    return line > 0


def _box(mask: Mask, chance: Chance) -> Single:
    """A box around a mask, up to three pixels wrong at each side."""
    rows, cols = np.nonzero(mask)

    def wrong() -> int:
        return chance.plain.randint(-3, 3)

    box = np.zeros(mask.shape, np.float32)
    top, bottom = max(rows.min() + wrong(), 0), max(rows.max() + 1 + wrong(), 2)
    left, right = max(cols.min() + wrong(), 0), max(cols.max() + 1 + wrong(), 2)
    box[top:bottom, left:right] = -1
    return box


def _former_answer(mask: Mask, chance: Chance) -> Mask:
    """An answer that is about right."""
    signed = _depth(mask) - _depth(~mask)
    size = max(signed.max(), 2)
    waves = noise(CROP_SIDE, chance.plain.choice((8, 16, 32)), chance.arrays) * size * chance.plain.uniform(0.1, 0.8)
    return signed + waves + chance.plain.gauss(0, 0.15) * size > 0


def _depth(mask: Mask) -> Single:
    """Distance of each pixel of a mask from what does not belong to it, the border included."""
    return cv2.distanceTransform(np.pad(mask, 1).astype(np.uint8), cv2.DIST_L2, 3)[1:-1, 1:-1]


def _nearness(on: Mask) -> Single:
    """How near each pixel is to those that are on, 0 to 1."""
    if not on.any():
        return np.zeros(on.shape, np.float32)
    return np.exp(-cv2.distanceTransform((~on).astype(np.uint8), cv2.DIST_L2, 3) / 6)


def _unit(vector: Array) -> Array:
    return vector / (np.hypot(*vector) + 1e-6)


def _pixel(place: NDArray[Any]) -> tuple[int, int]:
    """A place (row, col) as OpenCV wants it."""
    return int(place[1]), int(place[0])
