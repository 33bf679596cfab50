"""How much the sliders change: F between the contours at both ends of each, from one circle in an object.

Run ``python -m tests.benchmarks.sliders``; 1 would mean that a slider changes nothing.
"""

from dataclasses import replace

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


def main():
    for image, (center, radius) in STARTS.items():
        values, start = getattr(data, image)().astype(float), circle(center, radius)
        for name, ends in ENDS.items():
            one, other = (segment(values, start, replace(SHAPE, **end)).contours for end in ends)
            print(f"{image} {name} {agreement(one, other):.2f}")


if __name__ == "__main__":
    main()
