"""Illustrations of the parameters of edge map and field: smoothing, gamma, scales, floor, exponent, border."""

from __future__ import annotations

import math

from app.views.panels.parameters.illustrations.sketch import (
    CONTOUR,
    EDGE,
    LOST,
    MARK,
    PARTICLE,
    WIDTH,
    Point,
    Sketch,
    ease,
)

_ROUGH = (3, -5, 4, 1, -6, 5, -2, 6, -4, 2, -3, 5, -6, 3, -1, 4, -5, 2, 6, -3, -4, 5, 1, -6, 4, -2, 3, -5, 6, -1)
"""Noise of the profile."""


def smoothing(sketch: Sketch, value: float, t: float) -> None:
    """A noisy profile across an object, and the profile smoothed by a Gaussian of this width."""
    step = (WIDTH - 12.0) / (2 * len(_ROUGH) - 1)
    count = 2 * len(_ROUGH)
    heights = [(20.0 if 20 <= n < 40 else 52.0) + 1.3 * _ROUGH[(7 * n) % len(_ROUGH)] for n in range(count)]
    sketch.line([(6 + step * n, y) for n, y in enumerate(heights)], LOST, 1.1)
    sigma = max(1e-3, 0.9 * value * ease(t, 0.05, 0.7))
    reach = int(3 * sigma) + 1
    weights = [math.exp(-0.5 * (k / sigma) ** 2) for k in range(-reach, reach + 1)]
    total = sum(weights)
    smooth = [
        sum(w * heights[min(max(n + k, 0), count - 1)] for k, w in zip(range(-reach, reach + 1), weights, strict=True))
        / total
        for n in range(count)
    ]
    sketch.line([(6 + step * n, y) for n, y in enumerate(smooth)], PARTICLE, 2.0)


def gamma(sketch: Sketch, value: float, t: float) -> None:
    """Gray levels before and after: the same step among dark and among bright ones, and how high each becomes."""
    exponent = 1.0 + (value - 1.0) * ease(t, 0.05, 0.7)

    def shown(x: float) -> float:
        height: float = max((x - 6.0) / (WIDTH - 12.0), 0.0) ** exponent
        return 64.0 - 56.0 * height

    sketch.line([(6, 64), (WIDTH - 6, 8)], LOST, 1.1)
    sketch.curve(shown, CONTOUR, 2.0, low=6.0, high=WIDTH - 6.0)
    for low, high in ((16.0, 32.0), (WIDTH - 32.0, WIDTH - 16.0)):
        sketch.line([(low, shown(low)), (high, shown(low)), (high, shown(high))], MARK, 1.2, dashed=True)
        sketch.particle(high, shown(high), PARTICLE, 2.4)


def scales(sketch: Sketch, value: float, t: float) -> None:
    """The image at half, a quarter, an eighth of its size; the run goes from the smallest to the full size."""
    count = max(1, round(value))
    size, x = 56.0, 5.0
    now = count - 1 - min(int(t * count), count - 1)
    for scale in range(count):
        bright = scale == now
        sketch.block(x, 64.0 - size, size, size, 0.2 if bright else 0.11, CONTOUR if bright else LOST)
        ink = 1.0 if bright else 0.45
        middle_x, middle_y, radius = x + size / 2, 64.0 - size / 2, 0.32 * size
        sketch.ring(middle_x, middle_y, radius, radius, EDGE, 1.2, ink=ink)
        if bright:
            for n in range(max(3, int(radius * 0.9))):
                angle = 2 * math.pi * n / max(3, int(radius * 0.9))
                sketch.particle(
                    middle_x + radius * math.cos(angle),
                    middle_y + radius * math.sin(angle),
                    PARTICLE,
                    min(2.2, size / 9),
                )
        x += size + 4.0
        size /= 2.0


def exponent(sketch: Sketch, value: float, t: float) -> None:
    """The force of an edge over the distance from it, and a particle that follows the arrow of its size."""

    def force(x: float) -> float:
        size: float = (1.0 + 3.0 * max(x - 14.0, 0.0) / (WIDTH - 20.0)) ** -value
        return size

    sketch.line([(14, 8), (14, 64)], EDGE, 2.4)
    sketch.curve(lambda x: 64.0 - 54.0 * force(x), CONTOUR, 2.0, low=14.0, high=WIDTH - 6.0)
    x = WIDTH - 10.0 - (WIDTH - 40.0) * ease(t, 0.1, 0.9)
    sketch.line([(x, 64.0), (x, 64.0 - 54.0 * force(x))], MARK, 1.2, dashed=True)
    sketch.particle(x, 64.0 - 54.0 * force(x), PARTICLE, 2.8)


def edge_floor(sketch: Sketch, value: float, t: float) -> None:
    """Edge strength along a line: peaks below the floor give no charges."""
    peaks = ((20.0, 0.12), (40.0, 0.95), (60.0, 0.3), (80.0, 0.55), (100.0, 0.2), (114.0, 0.75))
    floor = value * ease(t, 0.1, 0.6)

    def height(x: float) -> float:
        return 64.0 - 54.0 * sum(h * math.exp(-(((x - at) / 4.0) ** 2)) for at, h in peaks)

    sketch.curve(height, LOST, 1.4)
    for at, peak in peaks:
        if peak >= floor:
            sketch.curve(height, CONTOUR, 2.0, low=at - 6.0, high=at + 6.0)
            sketch.particle(at, 64.0 - 54.0 * peak - 4.0, PARTICLE, 2.4)
    y = 64.0 - 54.0 * floor
    sketch.line([(4, y), (WIDTH - 4, y)], MARK, 1.2, dashed=True)


def max_border(sketch: Sketch, value: float, t: float) -> None:
    """An image with a bright border: a border up to this width gives no edge."""
    rim = 5.0
    sketch.block(30, 4, 68, 64, 0.75)
    sketch.block(30 + rim, 4 + rim, 68 - 2 * rim, 64 - 2 * rim, 0.16)
    sketch.ring(64, 36, 15, 14, CONTOUR)
    searched = 64.0 * value * ease(t, 0.1, 0.7)
    if searched < rim:
        sketch.line(_box(rim), CONTOUR, 1.6)
    if searched > 0.5:
        sketch.line(_box(searched), MARK, 1.2, dashed=True)


def _box(inset: float) -> list[Point]:
    """Outline of the image, so far inside."""
    left, top, right, bottom = 30 + inset, 4 + inset, 98 - inset, 68 - inset
    return [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)]
