"""Illustrations of the selection of contours: gaps, strength, contrast, length."""

from __future__ import annotations

import math
from itertools import pairwise

from app.views.panels.parameters.illustrations.sketch import CONTOUR, EDGE, LOST, MARK, WIDTH, Sketch, ease


def reach(sketch: Sketch, value: float, t: float) -> None:
    """An object with others connected to it; particles creep from it along their edges as far as the value."""
    way = [(52.0, 36.0), (70.0, 30.0), (88.0, 40.0), (104.0, 28.0), (120.0, 34.0)]
    sketch.line(way, LOST, 1.4)
    sketch.ring(96, 48, 10, 8, LOST, 1.4)
    sketch.ring(34, 34, 18, 18, CONTOUR, 2.0)
    sketch.particle(34, 34, radius=2.4)
    share = min(1.0, value / 300.0) * ease(t, 0.1, 0.7)
    end = 52.0 + share * (120.0 - 52.0)
    points = [point for point in way if point[0] <= end]
    for (x, y), (far_x, far_y) in pairwise(way):
        if x < end < far_x:
            points.append((end, y + (far_y - y) * (end - x) / (far_x - x)))
    if len(points) > 1:
        sketch.line(points, MARK, 2.4)
    if value >= 300.0:
        sketch.ring(96, 48, 10, 8, MARK, 2.0, ink=ease(t, 0.6, 0.9))
    _bar(sketch, value / 300.0)


def weakest_edge(sketch: Sketch, value: float, t: float) -> None:
    """An object, and weaker edges beside it; those below the value are not reached."""
    sketch.ring(28, 32, 18, 18, CONTOUR, 3.0)
    sketch.particle(28, 32, radius=2.4)
    for x, strength in ((62.0, 0.8), (86.0, 0.45), (110.0, 0.2)):
        sketch.ring(x, 32, 9, 14, LOST, 0.6 + 2.4 * strength, ink=0.6)
        sketch.ring(x, 32, 9, 14, CONTOUR, 0.6 + 2.4 * strength, ink=_ink(strength >= value, t))
    _bar(sketch, value / 0.95)


def max_gap(sketch: Sketch, value: float, t: float) -> None:
    """Three contours with gaps of 5, 20 and 45 px; gaps up to the value are bridged."""
    for y, gap in ((16.0, 5.0), (36.0, 20.0), (56.0, 45.0)):
        left, right = 64.0 - 0.75 * gap, 64.0 + 0.75 * gap
        sketch.line([(6, y), (left, y)], CONTOUR, 2.0)
        sketch.line([(right, y), (WIDTH - 6, y)], CONTOUR, 2.0)
        if gap <= value:
            grown = left + (right - left) * ease(t, 0.15, 0.6)
            sketch.line([(left, y), (grown, y)], "#ffffff", 1.8, dashed=True)
    if value > 0:
        half = 0.75 * min(value, 76.0)
        sketch.bracket(64.0 - half, 64.0 + half, 68.0)


def min_strength(sketch: Sketch, value: float, t: float) -> None:
    """Contours of edges of different strength; the weak ones disappear."""
    for x, strength in ((18.0, 3.0), (46.0, 12.0), (76.0, 28.0), (108.0, 55.0)):
        ink = _ink(strength >= value, t)
        sketch.ring(x, 34, 11, 15, EDGE, 0.5 + 0.09 * strength, ink=0.25 + 0.75 * strength / 60.0)
        sketch.ring(x, 34, 11, 15, CONTOUR, 1.8, ink=ink)
    _bar(sketch, value / 60.0)


def sure_edge(sketch: Sketch, value: float, t: float) -> None:
    """A strong contour with a weak branch, which is kept, and isolated contours, which need a sure edge."""
    sketch.line([(8, 22), (40, 14), (66, 22)], CONTOUR, 3.0)
    sketch.line([(66, 22), (92, 30), (120, 22)], CONTOUR, 1.0)
    for x, strength in ((18.0, 0.06), (46.0, 0.2), (76.0, 0.35), (108.0, 0.52)):
        ink = _ink(strength >= value, t)
        sketch.line([(x - 10, 50), (x, 44), (x + 10, 48)], LOST, 0.8 + 3 * strength, ink=0.6)
        sketch.line([(x - 10, 50), (x, 44), (x + 10, 48)], CONTOUR, 0.8 + 3 * strength, ink=ink)
    _bar(sketch, value / 0.6)


def min_contrast(sketch: Sketch, value: float, t: float) -> None:
    """Edges between regions of high, medium and no contrast; those of texture disappear."""
    for x, other, contrast in ((6.0, 0.85, 0.85), (47.0, 0.45, 0.5), (88.0, 0.2, 0.12)):
        sketch.block(x, 8, 17, 46, 0.15)
        sketch.block(x + 17, 8, 17, 46, other)
        for n in range(6):
            for side in (0.0, 17.0):
                speck = 0.5 if contrast < 0.2 else 0.28 if contrast < 0.6 else 0.2
                sketch.block(x + side + 3 + 5 * (n % 3), 13 + 7 * n, 3, 3, speck if side == 0 else other + speck / 3)
        sketch.line([(x + 17, 8), (x + 17, 54)], CONTOUR, 2.4, ink=_ink(contrast >= value, t))
    _bar(sketch, value / 0.9)


def min_length(sketch: Sketch, value: float, t: float) -> None:
    """Contours of 12, 40, 90 and 190 px; the short ones disappear."""
    for x, length in ((12.0, 12.0), (30.0, 40.0), (56.0, 90.0), (98.0, 190.0)):
        radius = 0.8 * length / (2.0 * math.pi)
        sketch.ring(x, 32, radius, radius, LOST, 1.0, ink=0.6)
        sketch.ring(x, 32, radius, radius, CONTOUR, 2.0, ink=_ink(length >= value, t))
    _bar(sketch, value / 200.0)


def _ink(kept: bool, t: float) -> float:
    """Opacity of a contour: those that are not kept fade out."""
    return 1.0 if kept else 1.0 - ease(t, 0.25, 0.6)


def _bar(sketch: Sketch, share: float) -> None:
    """The value as a bar below the picture."""
    x = 8.0 + (WIDTH - 16.0) * max(0.0, min(1.0, share))
    sketch.line([(8, 65), (WIDTH - 8, 65)], LOST, 1.0)
    sketch.line([(8, 65), (x, 65)], MARK, 2.4)
