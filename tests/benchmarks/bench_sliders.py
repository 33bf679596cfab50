"""How far the sliders decide: F between the contours at both ends of each, from one circle in an object.

1 would mean that a slider changes nothing; run with ``-s`` to see the figures.
"""

import sys
from dataclasses import replace

import pytest
from scipy.spatial import cKDTree
from skimage import data

from cpm_core import PRESETS, circle, segment
from cpm_core.contours.contour import sampled

SHAPE = PRESETS["shape"]
ENDS = {
    "reach": ({"reach": 0.0}, {"reach": 300.0}),
    "weakest_edge": ({"weakest_edge": 0.0}, {"weakest_edge": 0.95}),
    "beta": ({"beta": 0.1}, {"beta": 2.0}),
    "w1/w2": ({"w1": 0.05 * SHAPE.w2}, {"w1": 0.99 * SHAPE.w2}),
    "annealing": ({"annealing": 0.9}, {"annealing": 1.0}),
}
STARTS = {"coins": ((40.0, 200.0), 10.0), "camera": ((150.0, 200.0), 12.0), "cell": ((350.0, 340.0), 30.0)}


def agreement(one, other):
    """F of two results within 1.5 px."""
    points = [sampled(contours) for contours in (one, other)]
    if not all(map(len, points)):
        return 0.0
    near = [(cKDTree(b).query(a)[0] <= 1.5).mean() for a, b in (points, points[::-1])]
    return 2.0 * near[0] * near[1] / max(sum(near), 1e-12)


@pytest.mark.parametrize("image", STARTS)
def test_both_ends_of_each_slider(benchmark, timed, image):
    values = getattr(data, image)().astype(float)
    center, radius = STARTS[image]
    if not timed:  # the surroundings of the start are enough to try it
        values = values[int(center[0]) - 40 : int(center[0]) + 40, int(center[1]) - 40 : int(center[1]) + 40]
        center = (40.0, 40.0)
    start = circle(center, radius)

    def agreements():
        ends = {} if not timed else ENDS
        runs = {name: [segment(values, start, replace(SHAPE, **end)) for end in pair] for name, pair in ends.items()}
        return {name: agreement(one.contours, other.contours) for name, (one, other) in runs.items()}

    found = benchmark.pedantic(agreements)
    benchmark.extra_info.update(found)
    sys.stdout.write(" ".join(["\n", image, *(f"{name} {f:.2f}" for name, f in found.items()), "\n"]))
