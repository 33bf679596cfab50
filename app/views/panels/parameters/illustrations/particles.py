"""Illustrations of the motion of particles: damping, weights, annealing, time step, spacing."""

from __future__ import annotations

import math
from functools import lru_cache

from app.views.panels.parameters.illustrations.sketch import EDGE, MARK, PARTICLE, REST, WIDTH, Sketch, ease

_FRAMES = 160


def damping(sketch: Sketch, value: float, t: float) -> None:
    """A ball slides down to a shallow groove, where friction may stop it, or passes on to the deep one."""
    path = _slide(round(value, 3))
    here = min(int(t * 1.15 * _FRAMES), _FRAMES)
    sketch.curve(lambda x: _height(x) + 3.6, EDGE, 1.8)
    for age in range(1, 9):
        x = path[max(0, here - 3 * age)]
        sketch.particle(x, _height(x), PARTICLE, 2.0, 0.4 - 0.045 * age)
    at_rest = abs(path[here] - path[max(0, here - 8)]) < 0.3 and here > 8
    sketch.particle(path[here], _height(path[here]), REST if at_rest else PARTICLE, 3.8)


def _height(x: float) -> float:
    """Height of the hillside with two grooves."""
    first = 7.0 * math.exp(-(((x - 52.0) / 9.0) ** 2))
    second = 18.0 * math.exp(-(((x - 94.0) / 11.0) ** 2))
    return 14.0 + 0.19 * x + first + second - 30.0 * math.exp(-(((x - 122.0) / 9.0) ** 2))


@lru_cache(maxsize=8)
def _slide(beta: float) -> tuple[float, ...]:
    """Positions of the ball during six seconds, from its equation of motion."""
    x, speed, dt, places = 10.0, 0.0, 0.0125, []
    for step in range(3 * _FRAMES + 1):
        if step % 3 == 0:
            places.append(x)
        slope = (_height(x + 0.5) - _height(x - 0.5)) * 165.0
        speed = (speed + dt * slope) / (1.0 + dt * 2.6 * beta)
        x = min(max(x + dt * speed, 6.0), WIDTH - 6.0)
    return tuple(places)


def ratio(sketch: Sketch, value: float, t: float) -> None:
    """Particles on an edge push each other along it and into a bay, as far as repulsion reaches against attraction."""
    sketch.line([_along(s) for s in range(0, 197, 2)], EDGE, 1.8)
    reach = 150.0 * value * (1.0 - math.exp(-4.0 * t))
    count = 11
    for n in range(count):
        s = 5.0 + reach * n / (count - 1)
        x, y = _along(s)
        sketch.particle(x, y, PARTICLE if t < 0.9 else REST)


def _along(s: float) -> tuple[float, float]:
    """Point at arc length s of an edge with a deep bay."""
    if s < 44:
        return 6.0 + s, 16.0
    if s < 80:
        return 50.0, 16.0 + (s - 44.0)
    if s < 80 + 9 * math.pi:
        angle = (s - 80.0) / 9.0
        return 59.0 - 9.0 * math.cos(angle), 52.0 + 9.0 * math.sin(angle)
    rise = s - 80 - 9 * math.pi
    return (68.0, 52.0 - rise) if rise < 36 else (68.0 + rise - 36.0, 16.0)


def pull(sketch: Sketch, value: float, t: float) -> None:
    """Particles on both sides of an edge are attracted by it, faster with a larger weight."""
    sketch.line([(64, 6), (64, 66)], EDGE, 2.4)
    left = math.exp(-1.9 * value * t)
    for index, y in enumerate((16.0, 36.0, 56.0)):
        far = (50.0 - 9.0 * index) * left
        side = 1.0 if index == 1 else -1.0
        x = 64.0 + side * far
        if far > 12.0:
            sketch.arrow(x - side * 6.0, y, -side * min(7.0 * value + 2.0, far - 8.0), MARK)
        sketch.particle(x, y, REST if far < 2.0 else PARTICLE)


def annealing(sketch: Sketch, value: float, t: float) -> None:
    """Gaps are filled one after the other while the insertion range shrinks."""
    gaps = (11.0, 12.0, 13.0, 14.0, 15.0, 16.0, 17.0)
    step = int(80 * t)
    x, starts = 12.0, []
    for gap in gaps:
        starts.append((x, gap))
        x += gap
    sketch.line([(6, 30), (WIDTH - 6, 30)], EDGE, 1.8)
    for index, (start, gap) in enumerate(starts):
        sketch.particle(start, 30, REST)
        filled_at = 8 * (index + 1)
        if step >= filled_at and 18.0 * value**filled_at >= gap - 10.0:
            sketch.particle(start + gap / 2, 30, PARTICLE, 3.2 * ease(step, filled_at - 1, filled_at + 4))
    sketch.particle(x, 30, REST)
    span = 18.0 * value**step * 5.0
    sketch.line([(12, 54), (102, 54)], EDGE, 1.0, ink=0.5)
    sketch.line([(12, 54), (12 + span, 54)], MARK, 4.0)


def time_step(sketch: Sketch, value: float, t: float) -> None:
    """A particle moves to the edge in steps; long ones reach it sooner and overshoot."""
    sketch.line([(88, 8), (88, 64)], EDGE, 2.4)
    stride, x, places = 34.0 * value, 12.0, [12.0]
    for _ in range(int(16 * t)):
        x += stride if x < 88.0 else -stride
        stride *= 0.97 if x < 80 else 0.8
        places.append(x)
    for place in places[:-1]:
        sketch.particle(place, 36, PARTICLE, 1.8, 0.45)
    sketch.line([(place, 36) for place in places] if len(places) > 1 else [(12, 36), (12, 36)], PARTICLE, 0.8, ink=0.4)
    sketch.particle(places[-1], 36, PARTICLE, 3.6)


def d_min(sketch: Sketch, value: float, t: float) -> None:
    """Particles along a wavy edge at this distance; the contour through fewer of them is coarser."""

    def wave(x: float) -> float:
        return 34.0 + 13.0 * math.sin(x / 9.5) + 6.0 * math.cos(x / 4.9)

    spacing = max(5.0 * value, 2.5)
    sketch.curve(wave, EDGE, 1.4, ink=0.6)
    count = int((WIDTH - 14.0) / spacing) + 1
    shown = [7.0 + spacing * n for n in range(max(2, min(count, math.ceil(count * t * 1.25))))]
    shown = [x for x in shown if x <= WIDTH - 6.0]
    sketch.line([(x, wave(x)) for x in shown], REST, 1.2)
    for x in shown:
        sketch.particle(x, wave(x), PARTICLE, 2.6)


def d_max(sketch: Sketch, value: float, t: float) -> None:
    """Two particles move apart; within the insertion range, a new one appears between them."""
    pixel = 8.0
    gap = 8.0 + 96.0 * math.sin(math.pi * t) ** 2
    most = pixel * (2.0 + value)
    left, right = 64.0 - gap / 2, 64.0 + gap / 2
    sketch.line([(4, 28), (WIDTH - 4, 28)], EDGE, 1.8)
    sketch.particle(left, 28, REST)
    sketch.particle(right, 28, REST)
    if 2.0 * pixel < gap <= most:
        sketch.particle(64, 28, PARTICLE, 3.6)
    shown = min(most, WIDTH - 8.0)
    sketch.bracket(64 - shown / 2, 64 + shown / 2, 54)
