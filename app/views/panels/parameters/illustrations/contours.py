"""Illustrations of the selection of contours: gaps, strength, contrast, length."""

from __future__ import annotations

import math

from app.views.panels.parameters.illustrations.sketch import CONTOUR, EDGE, LOST, MARK, WIDTH, Sketch, ease


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
