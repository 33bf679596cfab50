"""A result with all that contours in files can have: names, colours, holes, an object in a hole, open ends, a unit."""

import numpy as np

from cpm_core import Contour, Result
from cpm_core.contours.contour import Bridge


def around(row, col, radius, count=80):
    angle = 2 * np.pi * np.arange(count) / count
    return np.stack([row + radius * np.sin(angle), col + radius * np.cos(angle)], axis=1)


CELL = Contour(around(30.2, 35.1, 25.3), closed=True, strength=12.5, name="cell", color="#e69f00")
HOLE = Contour(around(30.2, 35.1, 15.3)[::-1], closed=True, strength=9.0)
CORE = Contour(around(30.2, 35.1, 5.3, 20), closed=True, strength=7.0, name="Kern β", color="#0072B2")
FIBRE = Contour(np.array([[5.25, 70.0], [20.0, 72.5], [50.75, 68.0]]), False, 3.0, (True, False), name="fibre")
DOT = Contour(np.array([[55.0, 80.5]]), False, 1.0)
BRIDGE = Bridge(FIBRE.points[:2], 15.0, 0.5)
RESULT = Result(
    particles=np.zeros((7, 2)),
    contours=(CELL, FIBRE, HOLE, CORE, DOT),
    surface=None,
    steps=123,
    converged=True,
    stop_reason="at rest",
    shape=(60, 90),
    spacing=(0.5, 0.25),
    unit="µm",
    source="cells & more.png",
    bridges=(BRIDGE,),
)

LINE = Contour(np.array([[1.0, 2.0], [3.25, 4.0], [5.0, 60.0]]), closed=False, strength=3.0)
SQUARE = Contour(np.array([[10.0, 20.0], [10.0, 40.5], [30.125, 40.5], [30.125, 20.0]]), closed=True, strength=12.5)
LINE_AND_SQUARE = Result(
    particles=np.zeros((0, 2)),
    contours=(LINE, SQUARE),
    surface=None,
    steps=1,
    converged=True,
    stop_reason="at rest",
    shape=(50, 80),
    spacing=(1.0, 1.0),
    unit=None,
    source="a.png",
)
"""An open and a closed contour in an image without a unit."""
