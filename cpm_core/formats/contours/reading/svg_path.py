"""Paths of SVG: the text of the attribute ``d`` as lines of vertices."""

from __future__ import annotations

import math
import re

import numpy as np

from cpm_core.formats.contours.reading.curves import bezier, ellipse
from cpm_core.numerics.types import Array

_NUMBER = re.compile(r"[\s,]*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)")
_FLAG = re.compile(r"[\s,]*([01])")
_COMMAND = re.compile(r"[\s,]*([MmLlHhVvCcSsQqTtAaZz])")
_COUNTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7}


class _Pen:
    """Follows the commands of a path and collects its lines, each with whether it is closed."""

    def __init__(self) -> None:
        self.lines: list[tuple[list[Array], bool]] = []
        self.at = self._begin = np.zeros(2)
        self._control: tuple[str, Array] = ("", self.at)

    def draw(self, command: str, numbers: list[float]) -> None:
        """Carry out a command with its numbers."""
        kind = command.upper()
        base = self.at if command.islower() else np.zeros(2)
        before, control = self._control
        self._control = "", self.at
        if kind == "H":
            self._to(np.array([numbers[0] + base[0], self.at[1]]))
        elif kind == "V":
            self._to(np.array([self.at[0], numbers[0] + base[1]]))
        elif kind == "A":
            self._arc(numbers, base)
        else:
            corners = [corner + base for corner in np.reshape(numbers, (-1, 2))]
            if kind == "M":
                self.at = self._begin = corners[0]
                self.lines.append(([self.at], False))
            elif kind == "L":
                self._to(corners[0])
            else:
                if kind in ("S", "T"):  # the first control point is the last one, mirrored
                    alike = before == {"S": "C", "T": "Q"}[kind]
                    corners.insert(0, 2.0 * self.at - control if alike else self.at)
                curve = bezier(self.at, *corners)
                self._control = {"S": "C", "T": "Q"}.get(kind, kind), corners[-2]
                self._add(curve)

    def close(self) -> None:
        """Close the present line."""
        if self.lines:
            points, _ = self.lines[-1]
            self.lines[-1] = points, True
        self.at = self._begin
        self._control = "", self.at

    def _to(self, place: Array) -> None:
        self._add(place[None])

    def _add(self, places: Array) -> None:
        if not self.lines or self.lines[-1][1]:  # what follows a closed line begins where that did
            self.lines.append(([self.at], False))
        self.lines[-1][0].extend(places)
        self.at = places[-1]

    def _arc(self, numbers: list[float], base: Array) -> None:
        across, down, angle, large, sweep, x, y = numbers
        end = np.array([x, y]) + base
        half = 0.5 * (self.at - end)
        if not (across and down) or not half.any():
            self._to(end)
            return
        turn = math.radians(angle)
        axes = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
        radii = np.abs([across, down])
        local = axes @ half / radii  # half of the chord in a circle of radius one
        squared = float(local @ local)
        if squared > 1.0:
            radii, local, squared = radii * math.sqrt(squared), local / math.sqrt(squared), 1.0
        away = math.sqrt(max(0.0, 1.0 / squared - 1.0)) * (1.0 if bool(large) != bool(sweep) else -1.0)
        center = away * np.array([local[1], -local[0]])
        first, last = local - center, -local - center
        start = math.atan2(first[1], first[0])
        swept = (math.atan2(last[1], last[0]) - start) % (2.0 * math.pi)
        swept = swept if sweep else swept - 2.0 * math.pi
        middle = axes.T @ (center * radii) + 0.5 * (self.at + end)
        curve = ellipse(middle, radii[0] * axes[0], radii[1] * axes[1], start, swept)[1:]
        curve[-1] = end
        self._add(curve)


def lines_of(text: str) -> list[tuple[Array, bool]]:
    """The lines of a path as vertices (x, y), shape (K, 2) each, and whether each is closed.

    What follows an error in the text is left out, as programs that draw it do.
    """
    pen, at, command = _Pen(), 0, ""
    while at < len(text):
        found = _COMMAND.match(text, at)
        if found:
            at, command = found.end(), found[1]
            if command in "Zz":
                pen.close()
                continue
        numbers, at = _numbers(text, at, command)
        if not numbers:
            break
        pen.draw(command, numbers)
        command = {"M": "L", "m": "l"}.get(command, command)
    return [(np.array(points), closed) for points, closed in pen.lines]


def _numbers(text: str, at: int, command: str) -> tuple[list[float], int]:
    """The numbers of one command from a place of a text on, and where they end; none where they are not whole."""
    numbers: list[float] = []
    kind = command.upper()
    for index in range(_COUNTS.get(kind, 0)):
        found = (_FLAG if kind == "A" and index in (3, 4) else _NUMBER).match(text, at)
        if found is None:
            return [], len(text)
        numbers.append(float(found[1]))
        at = found.end()
    return numbers, at
