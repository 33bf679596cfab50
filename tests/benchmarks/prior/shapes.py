"""Shapes of objects that nobody has drawn: masks of random outlines, and bodies with parts in them."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.random import Generator

from cpm_core.numerics.types import Array, Mask, Pixels
from tests.benchmarks.prior.pictures import Example

FULL_TURN = 6.3


def shape(side: int, rng: Generator) -> Mask:
    """A blob, a polygon, a body with limbs or an ellipse, sometimes with a hole of the same shape."""
    mask = np.zeros((side, side), np.uint8)
    middle = rng.uniform(0.25, 0.75, 2) * side
    radius = side * rng.uniform(0.08, 0.32)
    kind = rng.random()
    if kind < 0.4:
        _draw_blob(mask, middle, radius, rng)
    elif kind < 0.6:
        _draw_polygon(mask, middle, radius, rng)
    elif kind < 0.85:
        _draw_ellipse(mask, middle, radius, (0.5, 1.3), (0.3, 0.9), rng)
        _draw_limbs(mask, middle, radius, rng)
    else:
        _draw_ellipse(mask, middle, radius, (0.5, 1.5), (0.5, 1.2), rng)
    if rng.random() < 0.12 and mask.sum() > 400:
        scale = rng.uniform(0.3, 0.6)
        inward = np.array([[scale, 0, middle[1] * (1 - scale)], [0, scale, middle[0] * (1 - scale)]])
        mask[cv2.warpAffine(mask, inward, (side, side)) > 0] = 0
    return mask > 0


def _draw_blob(mask: Pixels, middle: Array, radius: float, rng: Generator) -> None:
    angles = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    radii = _waves(angles, 9, 0.5, (0.7, 1.5), rng)
    radii = radius * np.clip(radii, 0.15, 2.5)
    stretch = np.exp(rng.uniform(-0.5, 0.5))
    cols, rows = middle[1] + radii * np.cos(angles) * stretch, middle[0] + radii * np.sin(angles) / stretch
    _fill(mask, np.c_[cols, rows])


def _draw_polygon(mask: Pixels, middle: Array, radius: float, rng: Generator) -> None:
    corners = rng.integers(3, 9)
    angles = np.sort(rng.uniform(0, 2 * np.pi, corners))
    radii = radius * rng.uniform(0.4, 1.6, corners)
    _fill(mask, np.c_[middle[1] + radii * np.cos(angles), middle[0] + radii * np.sin(angles)])


def _draw_ellipse(
    mask: Pixels,
    middle: Array,
    radius: float,
    longer: tuple[float, float],
    shorter: tuple[float, float],
    rng: Generator,
) -> None:
    """An ellipse with semiaxes between multiples of the radius."""
    axes = (int(radius * rng.uniform(*longer)) + 2, int(radius * rng.uniform(*shorter)) + 2)
    cv2.ellipse(mask, _pixel(middle), axes, rng.uniform(0, 180), 0, 360, 1, -1)


def _draw_limbs(mask: Pixels, middle: Array, radius: float, rng: Generator) -> None:
    """Up to five limbs of up to three straight pieces each."""
    for _ in range(rng.integers(1, 6)):
        joint = middle + rng.normal(0, radius * 0.4, 2)
        angle = rng.uniform(0, FULL_TURN)
        width = max(2, int(radius * rng.uniform(0.08, 0.4)))
        for _ in range(rng.integers(1, 4)):
            end = joint + direction(angle) * radius * rng.uniform(0.4, 1.1)
            cv2.line(mask, _pixel(joint), _pixel(end), 1, width)
            joint = end
            angle += rng.uniform(-0.9, 0.9)


def blob(
    side: int, middle: Array, radius: float, stretch: float, waves: float, rng: Generator, turn: float | None = None
) -> Mask:
    """A round outline with low waves, stretched along one direction."""
    angles = np.linspace(0, 2 * np.pi, 80, endpoint=False)
    radii = np.full_like(angles, radius)
    for order in range(2, 6):
        radii += radius * waves * rng.normal() / np.sqrt(order - 1) * np.cos(order * angles + rng.uniform(0, FULL_TURN))
    turn = rng.uniform(0, FULL_TURN) if turn is None else turn
    turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    ends = np.c_[radii * np.cos(angles) * np.exp(stretch / 2), radii * np.sin(angles) * np.exp(-stretch / 2)] @ turned
    return within(side, ends + middle)


def within(side: int, outline: Array) -> Mask:
    """What lies in an outline (row, col), shape (side, side)."""
    mask = np.zeros((side, side), np.uint8)
    cv2.fillPoly(mask, [np.round(outline[:, ::-1] * 8).astype(np.int32)], 1, shift=3)
    return mask > 0


def direction(angle: float) -> Array:
    """The step (row, col) of one pixel at an angle."""
    return np.array([np.sin(angle), np.cos(angle)])


def smooth_shape(side: int, drawings: Sequence[Example], size: float, rng: Generator) -> Mask:
    """A blob or the outline of a drawing, about `size` pixels across, in the middle of (side, side)."""
    if rng.random() < 0.5:
        angles = np.linspace(0, 2 * np.pi, 160, endpoint=False)
        radii = _waves(angles, 8, 0.4, (0.8, 1.6), rng)
        radii = np.clip(radii, 0.3, 2) * size / 2
        stretch = np.exp(rng.uniform(-0.6, 0.6))
        turn = rng.uniform(0, FULL_TURN)
        turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        mask = np.zeros((side, side), np.uint8)
        _fill(mask, np.c_[radii * np.cos(angles) * stretch, radii * np.sin(angles) / stretch] @ turned + side / 2)
        return mask > 0
    drawn = drawings[rng.integers(len(drawings))].mask
    height, width = drawn.shape
    scale = size / max(height, width)
    turn = rng.uniform(-3.1, 3.1)
    matrix = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0]]) * scale
    matrix[:, 2] = side / 2 - matrix[:, :2] @ [width / 2, height / 2]
    return cv2.warpAffine(drawn.astype(np.float32), matrix, (side, side)) > 0.5


def limbs(side: int, rng: Generator) -> tuple[Mask, list[Mask]]:
    """Limbs that meet, such as fingers: the outline of all, and the bones in them."""
    flesh, bones = np.zeros((side, side), np.uint8), []
    root = rng.uniform(0.4, 0.6, 2) * side
    usual = rng.uniform(0.05, 0.11) * side
    count = rng.integers(1, 6)
    first = rng.uniform(0, FULL_TURN)
    for number in range(count):
        angle = first + number * rng.uniform(0.3, 0.8)
        joint = root + direction(angle) * side * rng.uniform(0.02, 0.1)
        width = usual * rng.uniform(0.7, 1.2)
        for _ in range(rng.integers(1, 5)):
            end = joint + direction(angle) * (width * rng.uniform(1.5, 4.5))
            cv2.line(flesh, _pixel(joint), _pixel(end), 1, max(int(width * rng.uniform(1.5, 2.6)), 3))
            bone = np.zeros((side, side), np.uint8)
            cv2.line(bone, _pixel(joint), _pixel(end), 1, max(int(width * rng.uniform(0.5, 0.9)), 2))
            for knob in (joint, end):
                cv2.circle(bone, _pixel(knob), max(int(width * rng.uniform(0.35, 0.6)), 1), 1, -1)
            bones.append(bone > 0)
            joint = end + direction(angle) * width * rng.uniform(0.1, 0.9)
            angle += rng.normal(0, 0.2)
            width *= rng.uniform(0.75, 1)
    return cv2.morphologyEx(flesh, cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8)) > 0, bones


def moved(mask: Mask, rows: float, cols: float) -> Mask:
    """A mask moved by so many pixels."""
    matrix = np.array([[1, 0, cols], [0, 1, rows]], np.float32)
    return cv2.warpAffine(mask.astype(np.uint8), matrix, mask.shape[::-1]) > 0


def _waves(angles: Array, orders: int, height: float, decay: tuple[float, float], rng: Generator) -> Array:
    """Radii around 1 with waves, the more of them around the outline, the lower."""
    radii = np.ones_like(angles)
    for order in range(2, rng.integers(3, orders)):
        radii += (
            rng.normal() * height / order ** rng.uniform(*decay) * np.cos(order * angles + rng.uniform(0, FULL_TURN))
        )
    return radii


def _fill(mask: Pixels, corners: Array) -> None:
    """Fill a polygon with corners (col, row)."""
    cv2.fillPoly(mask, [np.round(corners).astype(np.int32)], 1)


def _pixel(place: Array) -> tuple[int, int]:
    """A place (row, col) as OpenCV wants it."""
    return int(place[1]), int(place[0])
