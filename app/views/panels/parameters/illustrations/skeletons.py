"""Illustrations of what a skeleton is of, and of its pruning."""

from __future__ import annotations

from app.views.panels.parameters.illustrations.sketch import CONTOUR, HEIGHT, LOST, MARK, WIDTH, Sketch, ease


def polarity(sketch: Sketch, value: float, t: float) -> None:
    """A dark and a light bar on gray; a bar that counts has its center line."""
    sketch.block(0, 0, WIDTH, HEIGHT, 0.45)
    for y, gray, counts in ((14.0, 0.1, value <= 0.0), (42.0, 0.95, value >= 0.0)):
        sketch.block(14, y, 100, 16, gray)
        if counts:
            sketch.line([(22, y + 8), (22 + 84 * ease(t, 0.1, 0.7), y + 8)], CONTOUR, 2.6)
    x = 64.0 + 40.0 * max(-1.0, min(1.0, value))
    sketch.line([(24, 67), (104, 67)], LOST, 1.0)
    sketch.particle(x, 67, MARK, 2.6)


def max_width(sketch: Sketch, value: float, t: float) -> None:
    """Bars of 6, 15, 35 and 80 px; those up to the value have a center line, at 0 all have."""
    for x, width in ((16.0, 6.0), (38.0, 15.0), (70.0, 35.0), (106.0, 80.0)):
        across = 3.0 + 0.3 * width
        sketch.block(x - across / 2, 8, across, 46, 0.3, LOST)
        kept = value == 0.0 or width <= value
        grown = 12 + 38 * ease(t, 0.1, 0.6) if kept else 50
        sketch.line([(x, 12), (x, grown)], CONTOUR, 2.4, ink=1.0 if kept else 1.0 - ease(t, 0.25, 0.6))
    right = 8.0 + (WIDTH - 16.0) * max(0.0, min(1.0, value / 100.0))
    sketch.line([(8, 65), (WIDTH - 8, 65)], LOST, 1.0)
    sketch.line([(8, 65), (right, 65)], MARK, 2.4)


def pruning(sketch: Sketch, value: float, t: float) -> None:
    """A bar with bumps of 0.7, 2.5, 5 and 9 px; the branch into a bump goes if this sticks out less than the value."""
    sketch.line([(8, 50), (120, 50)], LOST, 1.2)
    sketch.line([(12, 36), (116, 36)], CONTOUR, 2.6)
    left = 8.0
    for x, height in ((24.0, 0.7), (48.0, 2.5), (76.0, 5.0), (104.0, 9.0)):
        up = 22.0 - 1.7 * height
        sketch.line([(left, 22), (x - 7, 22), (x, up), (x + 7, 22)], LOST, 1.2)
        ink = 1.0 if height > value else 1.0 - ease(t, 0.25, 0.6)
        sketch.line([(x, 36), (x, up + 3)], CONTOUR, 2.0, ink=ink)
        left = x + 7
    sketch.line([(left, 22), (120, 22)], LOST, 1.2)
    right = 8.0 + (WIDTH - 16.0) * max(0.0, min(1.0, value / 10.0))
    sketch.line([(8, 65), (WIDTH - 8, 65)], LOST, 1.0)
    sketch.line([(8, 65), (right, 65)], MARK, 2.4)
