"""Synthetic scenes like medical images and photographs: those of Fig. 11 to 13."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.model.starts import circle, gradient_threshold, uniform_grid
from cpm_core.numerics.types import Array
from cpm_core.parameters import PRESETS, Parameters
from docs.gallery.outlines import (
    Rings,
    blended,
    coverage,
    curve,
    ellipse,
    limb,
    rings,
    round_ring,
    stroke,
    union,
)
from docs.gallery.scenes import Scene, Size, blurred, closed, grain, paint, texture

Bone = tuple[tuple[float, float], tuple[float, float], float]

AUTOMATIC = PRESETS["automatic"]
"""Parameters of section 5.2, on which those of the automatic starts are based."""

_TEXTURED = Parameters(smoothing=2.0, edge_floor=0.3, min_length=60.0)
"""Parameters that suppress the weak edges of texture."""

_SHEET = (200, 190)
"""Size of the images of Fig. 12."""


def _ramp(size: Size, down: float, right: float) -> Array:
    """Uneven light: gray levels that rise by `down` and `right` from one image border to the opposite one."""
    row, col = (np.arange(n) / (n - 1) - 0.5 for n in size)
    return down * row[:, None] + right * col[None, :]


def _automatic(
    values: Array, truth: tuple[Contour, ...], smoothing: float, strength: float, length: float, grid: float = 0.0
) -> Scene:
    """Return a scene started where the gradient is strong, or on a grid of that spacing [px] if one is given."""
    seeds = uniform_grid(values.shape, grid) if grid else gradient_threshold(values, smoothing=smoothing)
    parameters = replace(AUTOMATIC, smoothing=smoothing, min_strength=strength, min_length=length)
    return Scene(values, truth, seeds, parameters)


def textures() -> dict[str, Scene]:
    """Fig. 11: a vessel tree, and texture in the background or on the object."""
    return {
        "vessel tree": angiogram(),
        "cell in a cloudy medium": cell_in_haze(),
        "leaf on gravel": leaf_on_gravel(),
        "spotted fish": spotted_fish(),
    }


def medical() -> dict[str, Scene]:
    """Fig. 12: two starts on strong gradients, two uniform ones."""
    return {
        "cells; start on gradients": cells(),
        "chromosomes; start on gradients": chromosomes(),
        "hand; uniform start": radiograph(),
        "head; uniform start": slice_of_a_head(),
    }


def natural() -> dict[str, Scene]:
    """Fig. 13: shaded and textured scenes, started on strong gradients."""
    return {"pebbles on sand": pebbles(), "hills and a lake": hills(), "pears on cloth": pears()}


def angiogram() -> Scene:
    """Draw a vessel tree, dark on a noisy background."""
    size = (150, 170)
    tree = (
        limb((133, 60), (98, 72), 8.0, 7.0),
        limb((98, 72), (68, 66), 6.5, 5.5),
        limb((68, 66), (41, 84), 5.5, 4.5),
        limb((41, 84), (17, 78), 4.5, 3.0),
        limb((41, 84), (29, 112), 4.0, 3.0),
        limb((29, 112), (17, 136), 3.5, 2.5),
        limb((98, 72), (80, 108), 5.5, 4.5),
        limb((80, 108), (62, 128), 4.5, 3.5),
        limb((62, 128), (54, 152), 3.5, 2.5),
        limb((80, 108), (98, 138), 4.0, 3.0),
        limb((98, 138), (120, 148), 3.5, 2.5),
        limb((68, 66), (48, 38), 4.5, 3.5),
        limb((48, 38), (22, 24), 3.5, 2.5),
    )
    outline = rings(blended(2.0, *tree), size)
    values = paint(size, 165.0, (outline, -95.0)) + _ramp(size, 20.0, -30.0)
    values = blurred(values, 0.8) + texture(size, 9.0, 6.0, 11) + grain(size, 14.0, 12)
    return Scene(values, closed(outline), circle((110.0, 68.0), 11.0), Parameters(smoothing=2.0))


def leaf_on_gravel() -> Scene:
    """Draw a plain object on a textured background."""
    size = (150, 170)
    outline = curve((76, 84), lambda angle: 46.0 * (1.0 + 0.28 * np.cos(2 * angle) + 0.07 * np.cos(9 * angle)), 0.8)
    inside = coverage(outline, size)
    gravel = 95.0 + texture(size, 1.6, 16.0, 21) + texture(size, 6.0, 8.0, 22)
    values = (1.0 - inside) * gravel + inside * (190.0 + _ramp(size, 20.0, 10.0))
    return Scene(blurred(values, 0.7), closed(outline), circle((76.0, 90.0), 20.0), _TEXTURED)


def spotted_fish() -> Scene:
    """Draw a textured object on a plain background."""
    size = (150, 170)
    body = blended(12.0, limb((76, 50), (76, 92), 30.0, 25.0), limb((76, 92), (76, 134), 22.0, 6.0))
    tail = union(limb((76, 130), (52, 150), 5.0, 8.0), limb((76, 130), (100, 150), 5.0, 8.0))
    fins = union(limb((52, 74), (30, 92), 7.0, 4.0), limb((100, 76), (120, 90), 6.0, 4.0))
    outline = rings(blended(8.0, body, tail, fins), size)
    inside = coverage(outline, size)
    values = 215.0 + _ramp(size, -20.0, 15.0) - inside * (110.0 + texture(size, 2.2, 15.0, 31))
    return Scene(blurred(values, 0.8), closed(outline), circle((76.0, 58.0), 46.0), _TEXTURED)


def cell_in_haze() -> Scene:
    """Draw a faint, blurred cell with its nucleus, in a cloudy medium."""
    size = (150, 170)
    cell = curve((76, 84), lambda angle: 46.0 + 6.0 * np.cos(2 * angle + 0.6) + 4.0 * np.cos(3 * angle - 0.5))
    nucleus = ellipse((70, 92), 14.0, 19.0, 0.4)
    values = paint(size, 70.0, (cell, 45.0), (nucleus, 60.0))
    values = blurred(values, 1.2) + texture(size, 14.0, 8.0, 41) + grain(size, 5.0, 42)
    return Scene(values, closed(cell, nucleus), circle((52.0, 56.0), 22.0), Parameters(smoothing=2.5))


def cells() -> Scene:
    """Cells with nuclei, started where the gradient is strong."""
    size, random = _SHEET, np.random.default_rng(7)
    outlines: list[Rings] = []
    layers = []
    for center in ((44, 44), (42, 98), (50, 150), (98, 36), (97, 92), (104, 148), (155, 48), (153, 102), (157, 156)):
        at = (center[0] + random.uniform(-4, 4), center[1] + random.uniform(-4, 4))
        shape = random.uniform(0.0, 2.0 * np.pi, 2)
        radius, dents = random.uniform(17.0, 20.0), random.uniform(0.04, 0.1, 2)
        cell = curve(at, _wavy(radius, dents, shape))
        nucleus = ellipse((at[0] + random.uniform(-3, 3), at[1] + random.uniform(-3, 3)), 5.5, 7.5, shape[0])
        outlines += [cell, nucleus]
        layers += [(cell, random.uniform(50.0, 80.0)), (nucleus, random.uniform(60.0, 80.0))]
    values = blurred(paint(size, 40.0, *layers), 0.9) + _ramp(size, 15.0, -12.0) + grain(size, 3.0, 71)
    return _automatic(values, closed(*outlines), 1.5, 6.0, 15.0)


def _wavy(radius: float, dents: Array, turns: Array) -> Callable[[Array], Array]:
    return lambda angle: (
        radius * (1 + dents[0] * np.cos(2 * angle + turns[0]) + dents[1] * np.cos(3 * angle + turns[1]))
    )


def chromosomes() -> Scene:
    """Dark, bent rods and crosses on a bright background, started where the gradient is strong."""
    size = _SHEET
    rods = [
        union(stroke([(31, 28), (49, 40), (67, 40)], 11.0), stroke([(31, 54), (49, 46), (67, 58)], 11.0)),
        stroke([(33, 92), (45, 104), (65, 106), (77, 98)], 12.0),
        union(stroke([(33, 140), (51, 148), (75, 142)], 11.0), stroke([(29, 160), (51, 154), (77, 162)], 11.0)),
        stroke([(101, 30), (117, 42), (123, 58)], 12.0),
        union(stroke([(105, 92), (125, 98), (145, 92)], 11.0), stroke([(101, 112), (125, 104), (149, 114)], 11.0)),
        stroke([(103, 142), (117, 150), (121, 166)], 12.0),
        stroke([(155, 30), (165, 46), (163, 66)], 12.0),
        stroke([(171, 96), (165, 112), (171, 130)], 12.0),
        union(stroke([(149, 148), (161, 154), (177, 150)], 10.0), stroke([(145, 168), (161, 160), (177, 170)], 10.0)),
    ]
    outlines = [rings(blended(2.0, rod), size) for rod in rods]
    values = paint(size, 205.0, *((outline, -130.0) for outline in outlines))
    values = blurred(values, 0.8) + _ramp(size, 10.0, 15.0) + grain(size, 4.0, 81)
    return _automatic(values, closed(*outlines), 1.2, 8.0, 15.0)


def _bones() -> list[Bone]:
    """Bones of a hand: five rays of three or four, each from one end to the other with its radius."""
    rays = (
        ((150, 72), (60, 32), 4.6, (0.0, 0.42, 0.70, 0.88, 1.04)),
        ((142, 92), (34, 74), 4.8, (0.0, 0.42, 0.70, 0.88, 1.03)),
        ((142, 110), (24, 110), 4.8, (0.0, 0.40, 0.70, 0.88, 1.02)),
        ((146, 126), (40, 146), 4.6, (0.0, 0.42, 0.70, 0.88, 1.03)),
        ((164, 76), (128, 26), 5.0, (0.0, 0.55, 0.98)),
    )
    bones = []
    for start, end, radius, parts in rays:
        a, along = np.array(start, dtype=float), np.array(end, dtype=float) - start
        length = float(np.hypot(*along))
        for low, high in pairwise(parts):
            ends = [a + along * (low + (radius + 1.6) / length), a + along * (high - (radius + 1.6) / length)]
            bones.append((tuple(ends[0]), tuple(ends[1]), radius - 1.2 * low))
    return bones


def radiograph() -> Scene:
    """Draw a hand, bones in flesh, started all over the image."""
    size = _SHEET
    fingers = [
        limb((140, 70), (58, 31), 12.5, 11.0),
        limb((138, 92), (32, 74), 12.5, 11.0),
        limb((138, 110), (22, 110), 12.5, 11.0),
        limb((142, 126), (38, 146), 12.5, 10.5),
        limb((164, 76), (126, 24), 13.0, 11.0),
    ]
    palm = (limb((142, 94), (166, 102), 36.0, 30.0), limb((166, 102), (178, 102), 26.0, 16.0))
    flesh = rings(blended(5.0, blended(14.0, *palm), *fingers), size)
    bones = [rings(limb(*bone), size) for bone in _bones()]
    layers = [(flesh, 55.0), *((bone, 85.0) for bone in bones)]
    values = blurred(paint(size, 25.0, *layers), 0.8) + _ramp(size, 12.0, 6.0) + grain(size, 2.0, 91)
    return _automatic(values, closed(flesh, *bones), 1.2, 5.0, 15.0, grid=6.0)


def slice_of_a_head() -> Scene:
    """Skull, brain and ventricles, started all over the image."""
    size = _SHEET
    scalp, skull = ellipse((100, 95), 82.0, 68.0), ellipse((100, 95), 74.0, 60.0)
    brain = curve((100, 95), lambda angle: 52.0 + 1.6 * np.cos(14 * angle) + 1.0 * np.cos(9 * angle), 1.22)
    ventricles = [
        rings(blended(3.0, stroke([(77, 82), (95, 88), (111, 80)], 9.0)), size),
        rings(blended(3.0, stroke([(77, 108), (95, 102), (111, 110)], 9.0)), size),
    ]
    lesion = ellipse((131, 118), 7.0, 10.0, 0.5)
    layers = ((scalp, 150.0), (skull, -120.0), (brain, 80.0), *((v, -65.0) for v in ventricles), (lesion, 60.0))
    values = blurred(paint(size, 15.0, *layers), 0.8) + grain(size, 4.0, 101)
    return _automatic(values, closed(scalp, skull, brain, *ventricles, lesion), 1.5, 6.0, 20.0, grid=6.0)


def pebbles() -> Scene:
    """Mottled stones on sand."""
    size, random = (160, 200), np.random.default_rng(17)
    values = 175.0 + texture(size, 1.2, 6.0, 111) + texture(size, 12.0, 6.0, 112)
    outlines = []
    for row, col, high, wide in (
        (44, 46, 24, 31), (40, 112, 20, 28), (46, 168, 25, 19),
        (108, 38, 24, 22), (106, 100, 27, 30), (116, 164, 28, 24),
    ):  # fmt: skip
        stone = curve((row, col), _wavy(wide, np.array([0.0, 0.05]), random.uniform(0, 6, 2)), high / wide, 0.3)
        inside = coverage(stone, size)
        down, right = np.ogrid[: size[0], : size[1]]
        light = -0.9 * (down - row) - 0.5 * (right - col)
        own = random.uniform(55, 95) + 0.6 * light + texture(size, 2.0, 5.0, 113 + col)
        values = (1.0 - inside) * values + inside * own
        outlines.append(stone)
    return _automatic(blurred(values, 0.6), closed(*outlines), 2.0, 9.0, 30.0)


def hills() -> Scene:
    """Sun, sky, two ridges and a lake: boundaries that run from one image border to another."""
    size = (160, 200)
    col = np.linspace(-0.5, size[1] - 0.5, 401)
    far = 72.0 - 20.0 * np.exp(-(((col - 52) / 26) ** 2)) - 7.0 * np.sin(col / 31.0)
    near = 108.0 - 17.0 * np.exp(-(((col - 156) / 30) ** 2)) + 5.0 * np.sin(col / 17.0)
    lake = 134.0 + 0.0 * col
    sun = round_ring((32, 140), 14.0)
    lines = [np.stack([line, col], axis=1) for line in (far, near, lake)]
    below = [coverage((np.array([*line, (size[0] + 1.0, col[-1]), (size[0] + 1.0, col[0])]),), size) for line in lines]
    values = 205.0 + _ramp(size, 30.0, 0.0) + 45.0 * coverage(sun, size)
    surfaces = (
        140.0 + texture(size, 4.0, 4.0, 121),
        80.0 + texture(size, 1.5, 7.0, 122),
        165.0 + texture(size, (0.8, 9.0), 5.0, 123),
    )
    for inside, surface in zip(below, surfaces, strict=True):
        values = (1.0 - inside) * values + inside * surface
    truth = (*(Contour(line, closed=False) for line in lines), *closed(sun))
    return _automatic(blurred(values, 0.6), truth, 2.0, 5.0, 30.0)


def pears() -> Scene:
    """Two shaded fruits on a woven cloth."""
    size = (160, 200)
    down, right = np.mgrid[: size[0], : size[1]]
    weave = 7.0 * np.sin(2.0 * np.pi * down / 7.0) * np.sin(2.0 * np.pi * right / 7.0)
    values = 80.0 + weave + texture(size, 10.0, 5.0, 131) + _ramp(size, 20.0, 10.0)
    fruits = [
        blended(16.0, limb((104, 62), (106, 66), 31.0), limb((72, 60), (50, 54), 17.0, 13.0)),
        blended(16.0, limb((110, 142), (108, 146), 27.0), limb((80, 146), (62, 154), 15.0, 11.0)),
    ]
    outlines = [rings(fruit, size) for fruit in fruits]
    for fruit, outline in zip(fruits, outlines, strict=True):
        depth = np.clip(-fruit(np.stack([down, right], axis=-1).astype(float)), 0.0, None)
        own = 150.0 + 2.2 * depth - 0.25 * (right - 100) + texture(size, 1.5, 3.0, 132)
        inside = coverage(outline, size)
        values = (1.0 - inside) * values + inside * own
    return _automatic(blurred(values, 0.6), closed(*outlines), 2.0, 9.0, 30.0)
