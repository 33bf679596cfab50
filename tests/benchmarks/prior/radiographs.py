"""Made-up radiographs: long bones with thick walls, in chains with narrow joints, and short bones in a group."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from cpm_core.numerics.types import Array, Mask, Pixels, Single
from tests.benchmarks.prior.pictures import Example, largest_part
from tests.benchmarks.prior.shapes import FULL_TURN, direction, within
from tests.benchmarks.prior.textures import blurred, log_uniform, noise, texture

_MIN_AREA = 120
"""Pixels of the smallest object, and of the least flesh beside bones that may be pointed at."""

_LIMB_SHARE = 0.35
"""How often flesh whose end is sharp is the object, with the bones in it, rather than one of these."""


@dataclass(frozen=True, eq=False)
class _Chain:
    """Bones in a row, as in a finger or a limb.

    Attributes
    ----------
    bones : list of ndarray of bool
        The bones.
    axis : ndarray of shape (N, 2)
        Points along the middle of all of them (row, col), from the root to the tip.
    width : float
        Half the width of the first bone [px].
    """

    bones: list[Mask]
    axis: Array
    width: float


def radiograph(rng: Generator, side: int = 192) -> Example:
    """One of several bones in flesh, each of which adds to what absorbs; or flesh and bones, pointed at in flesh."""
    while True:
        chains = _chains(side, rng)
        bones = [bone for chain in chains for bone in chain.bones]
        if rng.random() < 0.5:
            bones += _short_bones(side, rng)
        bones = [bone for bone in bones if bone.sum() >= _MIN_AREA]
        if not bones:
            continue
        flesh, is_sharp = _flesh(chains, bones, rng)
        image = _exposed(bones, flesh, rng)
        if is_sharp and rng.random() < _LIMB_SHARE:
            everything = np.any(bones, axis=0)
            limb = largest_part((flesh > 0) | everything)
            beside = limb & ~(cv2.dilate(everything.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0)
            if beside.sum() >= _MIN_AREA and limb.mean() < 0.8:
                return Example(image, limb, beside)
        hidden = np.sum(bones, axis=0) > 1
        fitting = [bone for bone in bones if bone.mean() < 0.5 and (bone & hidden).sum() < 0.3 * bone.sum()]
        if fitting:
            return Example(image, fitting[rng.integers(len(fitting))])


def _chains(side: int, rng: Generator) -> list[_Chain]:
    """One to five chains of long bones beside one another, such as fingers, or one or two bones of a limb."""
    count = rng.integers(1, 6)
    width = log_uniform(0.025, 0.12, rng) * side
    ahead = rng.uniform(0, FULL_TURN)
    across = ahead + np.pi / 2
    spread = rng.uniform(-0.02, 0.15)
    growing = rng.random() < 0.4
    chains = []
    for number in range(count):
        place = rng.uniform(0.4, 0.6, 2) * side - 0.5 * side * rng.uniform(0.3, 1) * direction(ahead)
        place = place + (number - (count - 1) / 2) * width * rng.uniform(3.2, 4.5) * direction(across)
        angle = ahead + (number - (count - 1) / 2) * spread
        wide, long = width * rng.uniform(0.85, 1.15), width * rng.uniform(5, 14)
        bones, axis, root = [], [place], wide
        for _ in range(rng.integers(1, 5)):
            if growing and rng.random() < 0.7:
                cap, plate = wide * rng.uniform(0.4, 0.9), wide * rng.uniform(0.1, 0.35)
                bones.append(_end_cap(side, place, angle, cap, wide * rng.uniform(1.1, 1.6), rng))
                place = place + (cap + plate) * direction(angle)
            bones.append(_long_bone(side, place, angle, long, wide, rng))
            gap = rng.uniform(-0.12, 0.5) * wide
            place = place + (long + gap) * direction(angle)
            axis.append(place)
            angle += rng.normal(0, 0.12)
            wide, long = wide * rng.uniform(0.75, 1), max(long * rng.uniform(0.55, 0.85), 2.5 * wide)
        chains.append(_Chain(bones, np.array(axis), root))
    return chains


def _end_cap(side: int, start: Array, angle: float, length: float, half: float, rng: Generator) -> Mask:
    """The end of a bone that still grows, which a thin dark line parts from the shaft: wide, short, rounded."""
    angles = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    power = rng.uniform(0.4, 1)
    along, across = (np.sign(each) * np.abs(each) ** power for each in (np.cos(angles), np.sin(angles)))
    middle = start + length / 2 * direction(angle)
    turned = length / 2 * along[:, None] * direction(angle) + half * across[:, None] * direction(angle + np.pi / 2)
    return within(side, middle + turned)


def _flesh(chains: list[_Chain], bones: list[Mask], rng: Generator) -> tuple[Single, bool]:
    """How thick the flesh is, and whether it ends sharply: a haze around bones, or limbs and a palm between them."""
    side = len(bones[0])
    everything = np.any(bones, axis=0)
    kind = rng.random()
    if kind < 0.15:
        return np.ones((side, side), np.float32), False
    if kind < 0.4:
        reach = side * rng.uniform(0.03, 0.14)
        return np.clip(1 - _distance(~everything) / reach, 0, 1) ** rng.uniform(0.3, 1), False
    thick = np.zeros((side, side), np.float32)
    around = rng.uniform(1.6, 3.2)
    for chain in chains:
        line = np.ones((side, side), np.uint8)
        cv2.polylines(line, [np.round(chain.axis[:, ::-1]).astype(np.int32)], isClosed=False, color=0)
        thick = np.maximum(thick, _rounded(_distance(line > 0) / (around * chain.width)))
    if rng.random() < 0.6:
        ends = np.concatenate([chain.axis[: rng.integers(1, 3)] for chain in chains])
        corners = np.concatenate([ends, *(np.argwhere(bone).astype(float) for bone in bones if bone.mean() < 0.01)])
        palm = np.ones((side, side), np.uint8)
        cv2.fillConvexPoly(palm, cv2.convexHull(np.round(corners[:, ::-1]).astype(np.int32)), 0)
        reach = around * chains[0].width * rng.uniform(0.8, 2)
        thick = np.maximum(thick, rng.uniform(0.9, 1.6) * _rounded(_distance(palm > 0) / reach))
    return thick, True


def _distance(mask: Mask) -> Single:
    """Distance of each pixel of a mask from the others."""
    return cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 5)


def _rounded(distance: Single) -> Single:
    """Thickness of a round body, 1 in its middle, at shares of its radius from there."""
    return np.sqrt(1 - np.minimum(distance, 1) ** 2)


def _long_bone(side: int, start: Array, angle: float, length: float, width: float, rng: Generator) -> Mask:
    """A shaft that is narrow in its middle, a little bent, with round ends, one of them wider."""
    along = np.linspace(0, 1, 48)
    ends, reach = rng.uniform(1.15, 2.2, 2), rng.uniform(0.18, 0.5)
    near = [np.clip(1 - each / reach, 0, 1) ** 1.5 for each in (along, 1 - along)]
    half = width * (1 + (ends[0] - 1) * near[0] + (ends[1] - 1) * near[1])
    # a round end: the width falls to 0 within half of it
    rest = np.minimum(along, 1 - along) * length
    cap = np.clip(rest / (rng.uniform(0.3, 0.8) * width), 0, 1)
    half = half * np.sqrt(1 - (1 - cap) ** 2)
    sides = half * (1 + rng.normal(0, 0.08, (2, 1)) * np.sin(np.pi * along) + 0.04 * rng.normal(size=(2, 1)))
    bend = length * rng.normal(0, 0.03) * np.sin(np.pi * along)
    middle = start + (along * length)[:, None] * direction(angle) + bend[:, None] * direction(angle + np.pi / 2)
    out = direction(angle + np.pi / 2)
    outline = np.r_[middle + sides[0][:, None] * out, (middle - sides[1][:, None] * out)[::-1]]
    return within(side, outline)


def _short_bones(side: int, rng: Generator) -> list[Mask]:
    """Rounded bones that lie close together or over one another, such as those of a wrist."""
    middle, size = rng.uniform(0.2, 0.8, 2) * side, side * rng.uniform(0.05, 0.12)
    angles = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    bones = []
    for _ in range(rng.integers(3, 9)):
        radii = size * rng.uniform(0.6, 1.1) * np.ones_like(angles)
        for order in range(2, 5):
            radii += size * 0.1 * rng.normal() * np.cos(order * angles + rng.uniform(0, FULL_TURN))
        place = middle + rng.normal(0, 1.6 * size, 2)
        bones.append(within(side, place + radii[:, None] * np.c_[np.sin(angles), np.cos(angles)]))
    return bones


def _exposed(bones: list[Mask], flesh: Single, rng: Generator) -> Pixels:
    """Gray levels of an exposure, brighter where more is absorbed, in an image of one channel."""
    side = len(bones[0])
    flesh = blurred(flesh, rng.uniform(0.5, 2)) * rng.uniform(0.2, 2)
    absorbed = flesh + texture(side, rng) * rng.uniform(0, 0.08) + noise(side, side / 2, rng) * rng.uniform(0, 0.15)
    amount, wall, grain = rng.uniform(0.3, 1.3), rng.uniform(0.08, 0.35), rng.uniform(0.02, 0.2)
    rim_share = rng.uniform(0.2, 0.8)
    for bone in bones:
        absorbed = absorbed + amount * rng.uniform(0.85, 1.15) * _absorbing(bone, wall, rim_share, grain, rng)
    image = blurred(absorbed.astype(np.float32), rng.uniform(0.4, 1.4))
    image = image + rng.normal(0, rng.uniform(0, 0.08), image.shape)
    darkest, brightest = np.percentile(image, (0.3, 99.7))
    shown = np.clip((image - darkest) / (brightest - darkest + 1e-6), 0, 1) ** np.exp(rng.normal(0, 0.35))
    return (shown * 255).astype(np.uint8)[..., None]


def _absorbing(bone: Mask, wall: float, rim_share: float, grain: float, rng: Generator) -> NDArray[Any]:
    """What a bone absorbs: more in its wall, which fades where the bone is wide, and beams in its marrow."""
    depth = _distance(bone)
    thickness = max(float(depth.max()) * wall, 1.0)
    rim = np.exp(-(((depth - thickness) / thickness) ** 2))
    uneven = np.clip(0.9 + 0.35 * noise(len(bone), max(depth.max() * 3, 4), rng), 0.2, 1.4)
    beams = grain * noise(len(bone), rng.uniform(1.5, 4), rng)
    # the wall of a shaft is thick, that of its ends like paper: they fade into what lies around them
    size = blurred(np.where(bone, cv2.dilate(depth, np.ones((9, 9), np.uint8)), 0).astype(np.float32), 4)
    fade = 1 - rng.uniform(0, 0.7) * np.clip(size / (size.max() + 1e-6) * 1.5 - 0.5, 0, 1)
    edge = np.clip(depth / rng.uniform(1, 4), 0, 1)
    return edge * fade * ((1 - rim_share) + rim_share * rim * uneven + beams) * bone
